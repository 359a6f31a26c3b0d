//! How a test runs and what the control reads on the way, in an operator's words. It computes nothing.

use std::fmt::Write as _;

use super::sheet::Sheet;
use crate::machine::{AxisKind, Machine};
use crate::nc::{Coordinates, ball_speed};
use crate::plan::{OFF_LIMIT, PlannedTest};
use crate::report::wording::markup::escape;
use crate::session::Marks;

/// Rows of the table.
pub(super) fn rows(sheet: &Sheet, index: usize, planned: &PlannedTest) -> Vec<(&'static str, String)> {
    let sweep = &planned.sweep;
    let (one, other) = &sweep.pair;
    let mut rows = vec![
        (
            "sweep",
            format!(
                "{} {}° to {}° and back",
                crate::report::words::what_moves(planned, sheet.machine),
                sweep.from_deg,
                sweep.to_deg
            ),
        ),
        ("feed", format!("{}, {:.1} minutes for both directions", ball_speed(planned), planned.minutes)),
        ("run-in", run_in(planned)),
        ("arc ends at", ends(sheet.machine, planned)),
    ];
    if let Some(marks) = planned.test.marks {
        rows.push(("marks", marked(marks)));
    }
    if planned.run.len() > 4 {
        rows.push(("travel", travel(sheet.machine, planned)));
    }
    rows.push(("way to the start", way(sheet.machine, planned)));
    rows.push(("least clearance", format!("{:.1} mm, {one} – {other}", sweep.clearance_mm)));
    if let Some(programs) = sheet.programs.get(index).filter(|programs| !programs.is_empty()) {
        rows.push(("program", programs.join(", ")));
    }
    rows.push((
        "save as",
        format!("{}.csv, both directions in one piece; import makes the recordings of it", planned.test.name),
    ));
    let recordings = planned.both_ways().map(|test| format!("{}.csv", test.name));
    rows.push(("recordings", recordings.join(", ")));
    rows
}

/// How far outside the arc the run begins: in the unit of the axis that moves fastest.
fn run_in(planned: &PlannedTest) -> String {
    let run_in = planned.test.overshoot.unwrap_or(0.0);
    match planned.is_coupled() {
        false => format!("{run_in}° before and after the arc"),
        true => {
            format!(
                "on along the same curve by {run_in} mm or {run_in}°, whichever is reached first, before and after the arc"
            )
        }
    }
}

/// Moves along the bar that the operator sees and must not cut from the recording.
fn marked(marks: Marks) -> String {
    let way = if marks.move_mm > 0.0 { "longer" } else { "shorter" };
    format!(
        "the bar gets {way} by {} mm and back before and after each direction; record through, import finds the run by them",
        marks.move_mm.abs()
    )
}

/// What ends the arc at either side.
fn ends(machine: &Machine, planned: &PlannedTest) -> String {
    let sweep = &planned.sweep;
    if sweep.to_deg - sweep.from_deg >= 360.0 {
        return "a full turn".into();
    }
    let axis = &machine.axes[planned.axis];
    let range_deg = axis.range.map(|(low, high)| [low.to_degrees(), high.to_degrees()]);
    let run_in = planned.test.overshoot.unwrap_or(0.0);
    let words = |side: usize, deg: f64| match &sweep.ends[side] {
        Some((one, other)) => format!("{one} – {other}"),
        // whole degrees
        None if axis.kind == AxisKind::Rotary
            && range_deg.is_some_and(|range| (range[side] - deg).abs() < run_in + OFF_LIMIT + 1.0) =>
        {
            format!("the range of {}, run-in and {OFF_LIMIT}° kept off", axis.name)
        }
        None if planned.is_coupled() => "an axis's range or the turn looked for, nothing in the way".into(),
        None => "the turn looked for, nothing in the way".into(),
    };
    let (from, to) = (sweep.from_deg, sweep.to_deg);
    match (words(0, from), words(1, to)) {
        (one, other) if one == other => format!("{from}° and {to}°: {one}"),
        (one, other) => format!("{from}°: {one}; {to}°: {other}"),
    }
}

/// From where to where every axis goes in a run of several axes, run-in included.
fn travel(machine: &Machine, planned: &PlannedTest) -> String {
    let coordinates = Coordinates::of(machine);
    let range = |k: usize| {
        let ends =
            planned.run.iter().fold((f64::MAX, f64::MIN), |(low, high), row| (low.min(row[k]), high.max(row[k])));
        (coordinates.reading(machine, k, ends.0), coordinates.reading(machine, k, ends.1))
    };
    let moving = (0..machine.axes.len()).map(|k| (k, range(k))).filter(|(_, (low, high))| high - low > 1e-6);
    let words: Vec<String> =
        moving.map(|(k, (low, high))| format!("{} {low:.3} to {high:.3}", machine.axes[k].name)).collect();
    words.join(", ")
}

/// The checked way from park, one axis after the other.
fn way(machine: &Machine, planned: &PlannedTest) -> String {
    let coordinates = Coordinates::of(machine);
    let stands =
        |axis: usize, q: f64| format!("{} {}", machine.axes[axis].name, four(coordinates.reading(machine, axis, q)));
    let approach = &planned.approach;
    let legs: Vec<String> = approach.legs.iter().map(|leg| stands(leg.axis, leg.to)).collect();
    let aside: Vec<String> = approach.asides().map(|leg| stands(leg.axis, leg.to)).collect();
    let aside = if aside.is_empty() { String::new() } else { format!("{} and back; ", aside.join(", ")) };
    match legs.len() {
        0 => format!("{aside}the run starts at park"),
        _ => format!("{aside}{}, one after the other; back the same way", legs.join(", ")),
    }
}

/// What the control reads: at park, where everything is mounted, and at the corners of the run.
pub(super) fn places(out: &mut String, sheet: &Sheet, planned: &PlannedTest) {
    let machine = sheet.machine;
    let coordinates = Coordinates::of(machine);
    let [before, begin, .., end, after] = planned.run.as_slice() else { return };
    let columns: [(&str, &[f64]); 5] = [
        ("park: mount here", &planned.approach.park),
        ("start of the run-in: bar on", before),
        ("arc begins", begin),
        ("arc ends", end),
        ("end of the run-out", after),
    ];
    let kind = match coordinates {
        Coordinates::Machine(_) => "machine coordinates",
        Coordinates::Work => "work coordinates",
    };
    let _ = write!(
        out,
        "<h3>The control reads ({kind}, ccw; cw is the same backwards)</h3><table class=\"places wide\"><tr><th>axis</th>"
    );
    columns.iter().for_each(|(what, _)| out.push_str(&format!("<th>{what}</th>")));
    out.push_str("</tr>");
    // in the order in which they go to park
    for &axis in &planned.approach.park_order {
        let _ = write!(
            out,
            "<tr><th>{}, {}</th>",
            escape(&machine.axes[axis].name),
            machine.axes[axis].kind.position_unit()
        );
        for (_, row) in columns {
            let _ = write!(out, "<td>{}</td>", four(coordinates.reading(machine, axis, row[axis])));
        }
        out.push_str("</tr>");
    }
    out.push_str("</table>");
}

/// Four decimals, no minus sign before a zero.
fn four(value: f64) -> String {
    format!("{:.4}", (value * 1e4).round() * 1e-4 + 0.0)
}
