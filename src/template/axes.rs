//! Axes of a data sheet in the frame R.

use nalgebra::Vector3;

use super::figures::GAUGE_MM;
use super::inclined::Inclined;
use super::sizes::{Frame, Sizes};
use crate::machine::{Axis, AxisKind, Machine, SpindleSide, letter_axis};

/// What a file from a template must say of itself.
const CAVEATS: [&str; 2] = [
    "made from a data sheet: travels, distances, places and ranges of axes are as given unless called ASSUMED here, the rest is a template",
    "bodies are simple solids without column, covers, door or tool changer; add what stands in the way and compare every clearance with your machine",
];

/// The machine without its bodies.
pub fn machine(sizes: &Sizes, frame: &Frame) -> Machine {
    let code = &sizes.code;
    let axes =
        code.axis_names().enumerate().map(|(place, name)| axis(sizes, frame, name, !code.carries_workpiece(place)));
    let plain = Machine::plain(sizes.name.clone(), sizes.code.clone(), sizes.directions, axes.collect());
    let caveats = CAVEATS.map(str::to_string).into_iter().chain(sizes.assumed()).collect();
    let link = code.tool_side.last().cloned().unwrap_or_else(|| "b".into());
    let up = Vector3::z();
    let spindle = Some(SpindleSide { link, nose: up * GAUGE_MM, direction: up, gauge_length_mm: GAUGE_MM });
    Machine { caveats, spindle, ..plain }
}

fn axis(sizes: &Sizes, frame: &Frame, name: &str, is_on_tool_side: bool) -> Axis {
    // codes of these machines have letters alone
    let (kind, usual) = letter_axis(name).unwrap_or((AxisKind::Rotary, Vector3::z()));
    let direction = sizes.inclined_axis(name).map_or(usual, Inclined::direction);
    let half = |travel: f64| (-0.5 * travel, 0.5 * travel);
    let range = match name {
        "X" => half(sizes.travels[0]),
        "Y" => half(sizes.travels[1]),
        "Z" => frame.z_range,
        turning => sizes.range_of(turning),
    };
    let height = match (name, is_on_tool_side) {
        ("A" | "B", true) => frame.head_tilt,
        ("A" | "B", false) => frame.table_tilt,
        // where an inclined axis crosses it: there neither moves as the other one turns a little
        ("C", true) if sizes.turning_on_head().iter().any(|other| sizes.inclined_axis(other).is_some()) => {
            frame.head_tilt
        }
        ("C", false) if sizes.turning_on_table().iter().any(|other| sizes.inclined_axis(other).is_some()) => {
            frame.table_tilt
        }
        _ => 0.0,
    };
    Axis {
        name: name.to_string(),
        kind,
        direction,
        origin: Vector3::new(0.0, 0.0, height),
        range: Some((kind.from_file_unit(range.0), kind.from_file_unit(range.1))),
        reversed: false,
        location_errors: [0.0; 6],
        component_errors: Vec::new(),
    }
}
