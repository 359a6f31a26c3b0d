//! `fiveaxis init --urdf`: a machine file with which a plan can be made, from a robot description as CAD tools export it.

use std::path::Path;

use fiveaxis::load::{LinkChoice, load_description};
use fiveaxis::machine::Directions;
use fiveaxis::template::{Made, Wishes, plannable};

use super::arguments::{Arguments, table_size};
use crate::verbs::Refusal;

/// Head of the file, and what a description makes.
pub(super) fn described(arguments: &Arguments, urdf: &Path) -> Result<(String, Made), Refusal> {
    let links = LinkChoice {
        root: arguments.root_link.clone(),
        workpiece: arguments.workpiece_link.clone(),
        tool: arguments.tool_link.clone(),
    };
    let (machine, bodies, [workpiece, tool]) = load_description(urdf, &links)?;
    let table = arguments.table.as_deref().map(table_size).transpose()?;
    let directions = arguments.directions.map_or(Directions::Carried, |said| said.directions());
    let wishes = Wishes { workpiece, tool, table, housing_mm: arguments.housing, directions };
    let mut made = plannable(&machine, &bodies, &wishes).map_err(|why| format!("{}: {why}", urdf.display()))?;
    if let Some(name) = &arguments.name {
        made.machine.name.clone_from(name);
    }
    let named = &made.machine;
    let joints: Vec<String> = (machine.axes.iter().zip(&named.axes))
        .map(|(joint, axis)| format!("{} is {}", axis.name, joint.name))
        .collect();
    let head = format!(
        "{} from {}, by fiveaxis init. R is the frame of the bed; {}.",
        named.name.replace(char::is_control, " "),
        urdf.file_name().map(|name| name.to_string_lossy().replace(char::is_control, " ")).unwrap_or_default(),
        joints.join(", ").replace(char::is_control, " ")
    );
    Ok((head, made))
}
