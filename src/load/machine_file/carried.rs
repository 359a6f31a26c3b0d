//! The `carried:` list of a machine file: branches that load the machine without lying between workpiece and tool.

use nalgebra::Vector3;
use serde::Deserialize;

use crate::load::checked_text::document::{Document, Step};
use crate::load::checked_text::limits::AXES;
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::quantity::{finite, unit_vector};
use crate::machine::{CarriedBranch, CarriedJoint};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CarriedFile {
    name: String,
    on: String,
    joints: Vec<JointFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct JointFile {
    name: String,
    direction: [f64; 3],
    origin: Option<[f64; 3]>,
    #[serde(default)]
    reversed: bool,
}

/// Reads the branches of a machine with these axes and further link names.
pub(super) fn carried(
    document: &Document,
    raw: &[CarriedFile],
    axes: &[String],
    links: &[(String, Option<usize>)],
) -> Result<Vec<CarriedBranch>, LoadError> {
    let mut taken: Vec<&str> = ["b", "w", "t"].into_iter().collect();
    taken.extend(axes.iter().map(String::as_str));
    taken.extend(links.iter().map(|(name, _)| name.as_str()));
    let mut branches = Vec::with_capacity(raw.len());
    for (index, file) in raw.iter().enumerate() {
        let at = |key| [Step::Key("carried"), Step::Index(index), Step::Key(key)];
        let on = axes.iter().position(|axis| *axis == file.on);
        if on.is_none() && file.on != "b" {
            let message = format!("'{}' hangs on '{}'; allowed are b and {}", file.name, file.on, axes.join(" "));
            return Err(document.refuse(&at("on"), message));
        }
        if file.joints.is_empty() {
            let message = format!("'{}' has no joints; name at least one, or leave the branch out", file.name);
            return Err(document.refuse(&at("joints"), message));
        }
        if let Some(message) = AXES.exceeded(file.joints.len()) {
            return Err(document.refuse(&at("joints"), message));
        }
        let mut joints = Vec::with_capacity(file.joints.len());
        for joint in &file.joints {
            if taken.contains(&joint.name.as_str()) {
                let message =
                    format!("joint name '{}' is taken; each joint and link has a name of its own", joint.name);
                return Err(document.refuse(&at("joints"), message));
            }
            taken.push(&joint.name);
            let direction = unit_vector(document, &at("joints"), "direction", joint.direction)?;
            for value in joint.origin.unwrap_or_default() {
                finite(document, &at("joints"), value)?;
            }
            let origin = joint.origin.map(Vector3::from);
            joints.push(CarriedJoint { name: joint.name.clone(), direction, origin, reversed: joint.reversed });
        }
        branches.push(CarriedBranch { name: file.name.clone(), on, joints });
    }
    Ok(branches)
}
