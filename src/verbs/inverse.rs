//! `fiveaxis inverse`: axis positions that bring the tool to a place and direction in the workpiece.

use std::path::PathBuf;

use clap::Args;
use fiveaxis::chain::Chain;
use fiveaxis::inverse::{Kinematics, Target, Tool};
use fiveaxis::load::{load_machine, positions_from_text};
use fiveaxis::machine::Machine;
use fiveaxis::report::inverse::{inverse_json, inverse_text, pose_json, pose_text};
use nalgebra::Vector3;

use super::Refusal;
use super::output::{print, print_json, settle};

/// Arguments of `inverse`.
#[derive(Args)]
#[command(
    after_help = "The workpiece's frame is R of the machine file, carried by the table. With errors in the machine file the positions are those of the erring machine; --nominal leaves them out.\nExample: fiveaxis inverse machines/hermle-c600u.yaml --tip 30,-20,15 --tool-axis 0.3,0.2,0.9"
)]
pub struct Arguments {
    /// Machine file (YAML or URDF)
    machine: PathBuf,
    /// Place of the tool tip in the workpiece, mm: x,y,z
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    tip: Option<String>,
    /// Direction from the tip into the spindle in the workpiece: i,j,k of any length
    #[arg(long, value_name = "I,J,K", allow_hyphen_values = true, requires = "tip")]
    tool_axis: Option<String>,
    /// Direction across the tool, for machines that can turn it (arms of six joints)
    #[arg(long, value_name = "I,J,K", allow_hyphen_values = true, requires = "tool_axis")]
    tool_across: Option<String>,
    /// Positions to be near to; a free axis keeps its own: "A=30,C=-45" (mm, deg)
    #[arg(long, allow_hyphen_values = true)]
    near: Option<String>,
    /// The other way round: where the tool stands at these positions, "X=10,A=30" (mm, deg)
    #[arg(long, allow_hyphen_values = true, conflicts_with_all = ["tip", "near"])]
    at: Option<String>,
    /// Length of the tool from the spindle's nose, mm; unless given the tip is where the spindle ball is
    #[arg(long, allow_hyphen_values = true)]
    tool_length: Option<f64>,
    /// Where the machine file states no spindle: the tip with all axes at zero, mm
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with = "tool_length")]
    tool_point: Option<String>,
    /// With tool-point: direction from the tip into the spindle with all axes at zero
    #[arg(long, value_name = "I,J,K", allow_hyphen_values = true, requires = "tool_point")]
    tool_direction: Option<String>,
    /// The machine without its errors
    #[arg(long)]
    nominal: bool,
    /// Print JSON instead of tables
    #[arg(long)]
    json: bool,
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    settle(&arguments.machine)?;
    let machine = load_machine(&arguments.machine)?;
    let chain = Chain::of(&machine);
    let tool = tool(arguments, &machine)?;
    let kinematics = match arguments.nominal {
        true => Kinematics::nominal(&machine, &chain, tool),
        false => Kinematics::actual(&machine, &chain, tool),
    };
    if let Some(at) = &arguments.at {
        let positions = positions_from_text(at, &machine)?;
        let pose = kinematics.pose(&positions);
        return match arguments.json {
            true => print_json(&pose_json(&machine, &positions, &pose)),
            false => print(&pose_text(&machine, &positions, &pose)),
        };
    }
    let (Some(tip), Some(axis)) = (&arguments.tip, &arguments.tool_axis) else {
        return Err(
            "say where the tool is to be, --tip 30,-20,15 --tool-axis 0,0,1, or where the axes are, --at \"X=10,A=30\""
                .into(),
        );
    };
    let across = arguments.tool_across.as_deref().map(|text| unit("--tool-across", text)).transpose()?;
    let axis = unit("--tool-axis", axis)?;
    if across.is_some_and(|across| across.dot(&axis).abs() > 1e-9) {
        return Err("--tool-across is not across --tool-axis; give a direction at right angles to it".into());
    }
    let target = Target { tip_mm: vector("--tip", tip)?, axis, across };
    let near = match &arguments.near {
        Some(near) => positions_from_text(near, &machine)?,
        None => vec![0.0; machine.axes.len()],
    };
    let inverse = kinematics.inverse(&target, &near)?;
    match arguments.json {
        true => print_json(&inverse_json(&machine, &target, &inverse)),
        false => print(&inverse_text(&machine, &inverse)),
    }
}

/// The tool of the options.
fn tool(arguments: &Arguments, machine: &Machine) -> Result<Tool, Refusal> {
    if let Some(point) = &arguments.tool_point {
        let axis = match &arguments.tool_direction {
            Some(direction) => unit("--tool-direction", direction)?,
            None => Vector3::z(),
        };
        return Ok(Tool::new(vector("--tool-point", point)?, axis));
    }
    tool_of(machine, arguments.tool_length)
}

/// The tool of a machine file.
pub fn tool_of(machine: &Machine, length_mm: Option<f64>) -> Result<Tool, Refusal> {
    if let Some(length) = length_mm.filter(|length| !(0.0..=10_000.0).contains(length)) {
        return Err(format!("a tool length of {length} mm is not between 0 and 10000 mm").into());
    }
    Tool::of(machine, length_mm).ok_or_else(|| {
        "which way the tool looks is not known: state 'spindle: {nose: [x, y, z], direction: [i, j, k]}' in the machine file, or for 'inverse' --tool-point and --tool-direction".into()
    })
}

/// Three numbers of an option.
pub fn vector(option: &str, text: &str) -> Result<Vector3<f64>, Refusal> {
    let numbers: Vec<f64> = text
        .split(',')
        .filter_map(|part| part.trim().parse::<f64>().ok().filter(|number| number.abs() <= 1e7))
        .collect();
    match numbers.as_slice() {
        [x, y, z] if text.split(',').count() == 3 => Ok(Vector3::new(*x, *y, *z)),
        _ => Err(format!("{option} '{text}' is not three numbers; write for example {option} 30,-20,15").into()),
    }
}

/// A direction of an option.
fn unit(option: &str, text: &str) -> Result<Vector3<f64>, Refusal> {
    vector(option, text)?
        .try_normalize(1e-9)
        .ok_or_else(|| format!("{option} '{text}' has no length; write for example {option} 0,0,1").into())
}
