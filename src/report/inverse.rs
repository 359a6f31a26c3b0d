//! Axis positions for a tool pose, and tool poses, as tables and JSON.

use std::fmt::Write as _;

use nalgebra::Vector3;
use serde_json::{Map, Value, json};

use crate::inverse::{Inverse, Reach, Solution, Target, ToolPose};
use crate::machine::Machine;
use crate::report::wording::table::Table;
use crate::units::{ARCSEC_PER_RAD, UM_PER_MM};

/// A direction nearer to a singular one than this is told, rad: there the first axis turns by twenty for every one.
const NEAR_POLE: f64 = 0.05;

/// The solutions as a table.
pub fn inverse_text(machine: &Machine, inverse: &Inverse) -> String {
    let mut text = String::new();
    let mut header = vec!["solution".to_string()];
    header.extend(machine.axes.iter().map(|axis| format!("{} {}", axis.name, axis.kind.position_unit())));
    header.push("remark".into());
    let mut table = Table::new(&header.iter().map(String::as_str).collect::<Vec<&str>>());
    for (index, solution) in inverse.solutions.iter().enumerate() {
        let mut row = vec![(index + 1).to_string()];
        row.extend(machine.axes.iter().zip(&solution.positions).map(|(axis, &q)| place(axis.kind.to_file_unit(q))));
        row.push(remark(machine, solution));
        table.row(row);
    }
    text.push_str(&table.text());
    let _ = writeln!(text);
    let all = if inverse.is_complete { "all there are" } else { "found by a search: there may be more" };
    let _ = writeln!(text, "{} solutions, {all}", inverse.solutions.len());
    if let Some(reach) = &inverse.reach {
        text.push_str(&reach_text(machine, reach));
    }
    text
}

/// What is wrong with a solution, if anything.
fn remark(machine: &Machine, solution: &Solution) -> String {
    let mut remarks = Vec::new();
    for &index in &solution.outside {
        let axis = &machine.axes[index];
        let (from, to) = axis.range.unwrap_or_default();
        remarks.push(format!(
            "{} outside {} … {}",
            axis.name,
            short(axis.kind.to_file_unit(from)),
            short(axis.kind.to_file_unit(to))
        ));
    }
    if let Some(free) = solution.free {
        remarks.push(format!("{} free", machine.axes[free].name));
    }
    remarks.join(", ")
}

/// Directions that the rotary axes reach and the singular ones.
fn reach_text(machine: &Machine, reach: &Reach) -> String {
    let [first, second] = reach.axes.map(|axis| machine.axes[axis].name.as_str());
    let [low, high] = reach.angles_rad.map(|angle| format!("{:.4}", angle.to_degrees()));
    let mut text = format!(
        "{first} turns about ({}) in the workpiece; {first} and {second} point the tool {low} … {high} deg from it (their travel left out)\n",
        direction(&reach.about)
    );
    let poles: Vec<String> = reach.singular().iter().map(|pole| format!("({})", direction(pole))).collect();
    match poles.is_empty() {
        true => text.push_str("no singular direction\n"),
        false => {
            let _ = writeln!(text, "singular: {}, where {first} is free", poles.join(" and "));
        }
    }
    if reach.from_pole_rad < NEAR_POLE {
        let _ = writeln!(
            text,
            "the tool is {:.4} deg from {first}'s line: {first} turns {} per unit of direction",
            reach.from_pole_rad.to_degrees(),
            if reach.from_pole_rad > 0.0 {
                format!("{:.0}", reach.turn_per_direction())
            } else {
                "without bound".into()
            }
        );
    }
    text
}

/// The solutions as JSON.
pub fn inverse_json(machine: &Machine, target: &Target, inverse: &Inverse) -> Value {
    let solutions: Vec<Value> = inverse
        .solutions
        .iter()
        .map(|solution| {
            json!({
                "positions": positions(machine, &solution.positions),
                "outside": solution.outside.iter().map(|&axis| &machine.axes[axis].name).collect::<Vec<_>>(),
                "free": solution.free.map(|axis| &machine.axes[axis].name),
                "off_um": solution.off_mm * UM_PER_MM,
                "off_arcsec": solution.off_rad * ARCSEC_PER_RAD,
            })
        })
        .collect();
    let reach = inverse.reach.as_ref().map(|reach| {
        json!({
            "first_axis": machine.axes[reach.axes[0]].name,
            "second_axis": machine.axes[reach.axes[1]].name,
            "about": unsigned(&reach.about),
            "angles_deg": reach.angles_rad.map(f64::to_degrees),
            "singular": reach.singular().iter().map(|pole| json!(unsigned(pole))).collect::<Vec<_>>(),
            "from_singular_deg": reach.from_pole_rad.to_degrees(),
        })
    });
    json!({
        "machine": machine.name,
        "tip_mm": unsigned(&target.tip_mm),
        "tool_axis": unsigned(&target.axis),
        "solutions": solutions,
        "complete": inverse.is_complete,
        "reach": reach,
    })
}

/// Where the tool stands, in words.
pub fn pose_text(machine: &Machine, at: &[f64], pose: &ToolPose) -> String {
    let mut table = Table::new(&["axis", "position", "unit"]);
    for (axis, &q) in machine.axes.iter().zip(at) {
        table.row(vec![axis.name.clone(), place(axis.kind.to_file_unit(q)), axis.kind.position_unit().into()]);
    }
    let tip: Vec<String> = pose.tip_mm.iter().map(|&value| place(value)).collect();
    format!(
        "{}\ntip in the workpiece  {} mm\ntool axis             {}\n",
        table.text(),
        tip.join(", "),
        direction(&pose.axis)
    )
}

/// Where the tool stands, as JSON.
pub fn pose_json(machine: &Machine, at: &[f64], pose: &ToolPose) -> Value {
    json!({
        "machine": machine.name,
        "positions": positions(machine, at),
        "tip_mm": unsigned(&pose.tip_mm),
        "tool_axis": unsigned(&pose.axis),
        "tool_across": unsigned(&pose.across),
    })
}

/// Positions by axis name, mm and deg.
fn positions(machine: &Machine, at: &[f64]) -> Map<String, Value> {
    machine.axes.iter().zip(at).map(|(axis, &q)| (axis.name.clone(), json!(axis.kind.to_file_unit(q) + 0.0))).collect()
}

/// Six decimals, no minus before a zero.
fn place(value: f64) -> String {
    let text = format!("{value:.6}");
    if text.chars().all(|c| "-0.".contains(c)) { text.replace('-', "") } else { text }
}

/// The same without zeros at the end.
fn short(value: f64) -> String {
    place(value).trim_end_matches('0').trim_end_matches('.').to_string()
}

/// Coordinates in full, no minus before a zero.
fn unsigned(vector: &Vector3<f64>) -> [f64; 3] {
    [vector.x + 0.0, vector.y + 0.0, vector.z + 0.0]
}

fn direction(vector: &Vector3<f64>) -> String {
    let parts: Vec<String> = vector.iter().map(|&value| place(value)).collect();
    parts.join(", ")
}
