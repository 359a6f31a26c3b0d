//! `fiveaxis plan`: a test plan for a machine: table, JSON, session file, setup sheet and NC programs.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use fiveaxis::load::{load_kit, load_machine_and_bodies, standard_kit};
use fiveaxis::plan::plan_with_advice;
use fiveaxis::report::meetings::{can_touch_note, meetings_json, touching_json};
use serde_json::json;

use super::directions::{DirectionsName, say};
use super::former_plan::former_files;
use super::output::{print_json, settle};
use super::plan_files::{Planned, planned_files};
use super::plan_json::as_json;
use super::plan_settings::settings;
use super::plan_text::print_plan;
use super::{Refusal, solids};

/// Arguments of `plan`.
#[derive(Args)]
pub struct Arguments {
    /// Machine file with bodies, mounts and spindle
    pub(super) machine: PathBuf,
    /// Kit file; the common 100 mm bar with extensions unless given
    #[arg(long)]
    pub(super) kit: Option<PathBuf>,
    /// Uncertainties to reach, positions and orientations, e.g. 4um,4arcsec
    #[arg(long, value_name = "LENGTH,ANGLE", allow_hyphen_values = true, conflicts_with = "minutes")]
    pub(super) sigma: Option<String>,
    /// Best plan in this time
    #[arg(long, allow_negative_numbers = true, conflicts_with = "method")]
    pub(super) minutes: Option<f64>,
    /// Least clearance of every sweep, mm
    #[arg(long, default_value_t = 5.0, allow_negative_numbers = true)]
    pub(super) margin: f64,
    /// Feed of the moving ball, mm/min
    #[arg(long, default_value_t = 500.0, allow_negative_numbers = true)]
    pub(super) feed: f64,
    /// Axis region kept out of use, e.g. X=-50..80 (repeatable)
    #[arg(long, value_name = "AXIS=FROM..TO", allow_hyphen_values = true)]
    pub(super) avoid: Vec<String>,
    /// A method of the thesis in place of the free choice
    #[arg(long, value_enum)]
    pub(super) method: Option<MethodName>,
    /// Most pivot setups; 1 looks for the one place that does it all
    #[arg(long, value_name = "COUNT", conflicts_with = "method", value_parser = clap::value_parser!(u8).range(1..=20))]
    pub(super) pivots: Option<u8>,
    /// Ways in which linear axes may follow a rotary axis, or none
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        default_value = "radial,tangential,axial",
        conflicts_with = "method"
    )]
    pub(super) follow: Vec<FollowName>,
    /// Planar circles too: the squareness of the linear axes is wanted as well
    #[arg(long, conflicts_with = "method")]
    pub(super) circles: bool,
    /// Run tests again with the spindle indexed by 180°, so that the spindle ball's own placement leaves the positions
    #[arg(long)]
    pub(super) index_spindle: bool,
    /// Write programs without the short moves along the bar that mark the runs in a capture
    #[arg(long)]
    pub(super) no_marks: bool,
    /// How the bars' zeros will be set: a free one leaves out what only absolute lengths tell
    #[arg(long, value_enum, default_value_t = ZeroName::Calibrated)]
    pub(super) zero: ZeroName,
    /// Sense of the axes where the machine file does not state it
    #[arg(long, value_enum)]
    pub(super) directions: Option<DirectionsName>,
    /// Folder for the session file, setup sheet and NC programs
    #[arg(long)]
    pub(super) out: Option<PathBuf>,
    /// JSON on standard output
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum MethodName {
    Chapter4,
    Chapter5,
    Chapter6,
    Chapter7,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum ZeroName {
    /// On a calibrator
    Calibrated,
    /// By hand: one unknown offset for every bar
    Free,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub(super) enum FollowName {
    None,
    Radial,
    Tangential,
    Axial,
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    let (mut machine, bodies) = load_machine_and_bodies(&arguments.machine)?;
    say(&mut machine, arguments.directions, &arguments.machine.display().to_string())?;
    if arguments.out.is_some() {
        machine.stated_directions().map_err(|why| format!("{}: {why}", arguments.machine.display()))?;
    }
    solids::require(&arguments.machine, &bodies)?;
    let world = solids::world(&arguments.machine, &machine, &bodies)?;
    let can_touch = world.meetings_by_one_axis(&machine);
    let kit = arguments.kit.as_deref().map_or_else(standard_kit, load_kit)?;
    let settings = settings(arguments, &machine)?;
    let former = match &arguments.out {
        Some(folder) => {
            settle(&folder.join("session.yaml"))?;
            former_files(folder, &arguments.machine)?
        }
        None => Vec::new(),
    };
    let plan = plan_with_advice(&machine, &bodies, &kit, &settings)?;
    if let Some(folder) = &arguments.out {
        let planned = Planned { machine: &machine, bodies: &bodies, kit: &kit, settings: &settings, plan: &plan };
        let mut output = planned_files(folder, &arguments.machine, &planned)?;
        output.replace(former);
        output.write(folder, std::slice::from_ref(&arguments.machine))?;
    }
    if arguments.json {
        let mut value = as_json(&plan, &machine);
        value["touching"] = json!(touching_json(&world.touching));
        value["can_touch"] = json!(meetings_json(&machine, &can_touch));
        return print_json(&value);
    }
    print_plan(&plan, &machine, &settings);
    if let Some(note) = can_touch_note(&machine, &can_touch) {
        println!("\n{note}");
    }
    Ok(())
}

/// Rounded to some digits, without a negative zero.
pub(super) fn round(value: f64, digits: i32) -> f64 {
    let scale = 10f64.powi(digits);
    (value * scale).round() / scale + 0.0
}
