//! A check as terminal text.

use std::fmt::Write as _;

use nalgebra::Vector3;

use super::facts::{
    Placement, Senses, SessionCheck, component_names, kind_name, named_positions, rows, shown_errors,
    without_minus_zero,
};
use crate::chain::View;
use crate::machine::{Axis, AxisKind, Component, DirectionsUnstated, ErrorName, Machine, is_by_choice_of_r};
use crate::report::wording::linear_axes::linear_axes_json;
use crate::report::wording::meetings::{BodyPairs, body_pairs_text};
use crate::report::wording::number::position;
use crate::report::wording::table::Table;

/// The terminal text of a check.
pub fn check_text(
    machine: &Machine,
    senses: &Senses,
    placements: &[Placement],
    session: Option<&SessionCheck>,
    bodies: Option<&BodyPairs>,
) -> String {
    let mut out = String::new();
    let _ = writeln!(out, "{}  {}", machine.name, machine.code);
    let _ = writeln!(out, "\nChain: {}\n", chain_words(machine));
    out.push_str(&axes_table(machine));
    out.push_str(&senses_text(machine, senses));
    out.push_str("\nLocation errors\n");
    out.push_str(&errors_table(machine));
    if let Some(budget) = linear_axes_json(machine) {
        let _ = writeln!(out, "  {}", budget.says);
    }
    for axis in machine.axes.iter().filter(|axis| !axis.component_errors.is_empty()) {
        let _ = writeln!(out, "  component errors of {}: {}", axis.name, component_names(axis).join(" "));
    }
    if let Some(session) = session {
        out.push_str(&session_text(machine, session));
    }
    if let Some(pairs) = bodies {
        out.push_str(&body_pairs_text(machine, pairs));
    }
    let has_errors = machine
        .axes
        .iter()
        .any(|axis| !axis.component_errors.is_empty() || axis.location_errors.iter().any(|&error| error != 0.0));
    for placement in placements {
        out.push_str(&placement_text(machine, placement, has_errors));
    }
    out
}

/// `workpiece – C – A – bed – Y – X – Z – tool`, with further link names in brackets.
fn chain_words(machine: &Machine) -> String {
    let further = |carrier: Option<usize>| -> String {
        let names: Vec<&str> =
            machine.link_names.iter().filter(|(_, axis)| *axis == carrier).map(|(name, _)| name.as_str()).collect();
        if names.is_empty() { String::new() } else { format!(" ({})", names.join(", ")) }
    };
    let name = |name: &String| format!("{name}{}", further(machine.axis_index(name)));
    let mut words = vec!["workpiece".to_string()];
    words.extend(machine.code.workpiece_side.iter().map(name));
    words.push(format!("bed{}", further(None)));
    words.extend(machine.code.tool_side.iter().map(name));
    words.push("tool".into());
    words.join(" – ")
}

/// Axes with their places and ranges.
fn axes_table(machine: &Machine) -> String {
    let mut table = Table::new(&["axis", "kind", "direction", "origin mm", "range", "unit"]);
    for axis in &machine.axes {
        let range = axis.range.map_or("unlimited".into(), |(from, to)| {
            format!("{} … {}", position(axis.kind, from), position(axis.kind, to))
        });
        table.row(vec![
            axis.name.clone(),
            kind_name(axis.kind).into(),
            triple(axis.direction.into(), 4),
            triple(axis.origin.into(), 3),
            range,
            axis.kind.position_unit().into(),
        ]);
    }
    table.text()
}

/// What a positive command does to each axis; both readings where the file states none.
fn senses_text(machine: &Machine, senses: &Senses) -> String {
    let mut out = String::new();
    let stated = match machine.directions {
        Some(directions) => directions.name(),
        None => "NOT stated, read as carried",
    };
    let reversed: Vec<&str> = machine.axes.iter().filter(|axis| axis.reversed).map(|axis| axis.name.as_str()).collect();
    let beside = if reversed.is_empty() { String::new() } else { format!("; reversed: {}", reversed.join(" ")) };
    let _ = writeln!(out, "\nSense of axes ({stated}{beside}), seen by who looks along {}", looking(machine));
    senses.as_read.iter().for_each(|words| {
        let _ = writeln!(out, "  {words}");
    });
    if !senses.else_iso841.is_empty() {
        out.push_str("with 'directions: iso841', the sense of most controls, it would be\n");
        let other = senses.else_iso841.iter().zip(&senses.as_read).filter(|(other, read)| other != read);
        other.for_each(|(words, _)| {
            let _ = writeln!(out, "  {words}");
        });
        let _ = writeln!(out, "{}", DirectionsUnstated);
    }
    out
}

/// Where the operator looks.
fn looking(machine: &Machine) -> String {
    let along = |direction: &Vector3<f64>| match direction.iter().position(|part| (part.abs() - 1.0).abs() < 1e-9) {
        Some(k) => format!("{}{}", if direction[k] > 0.0 { '+' } else { '-' }, ["x", "y", "z"][k]),
        None => triple((*direction).into(), 4),
    };
    let view = View::of(machine);
    format!("{} of R, {} to the right and {} up", along(&view.away), along(&view.right), along(&view.up))
}

/// Three numbers with at most `decimals` decimals.
fn triple(value: [f64; 3], decimals: i32) -> String {
    let scale = 10f64.powi(decimals);
    let short = value.map(|part| format!("{}", without_minus_zero((part * scale).round() / scale)));
    format!("({})", short.join(", "))
}

/// Location errors that the file states or might state.
fn errors_table(machine: &Machine) -> String {
    let mut table = Table::new(&["error", "value", "unit", "note"]);
    for axis in &machine.axes {
        for component in shown_errors(axis) {
            let value = component.measure().to_output(axis.location_errors[component.index()]);
            table.row(vec![
                ErrorName::location(component, &axis.name).to_string(),
                format!("{value:.2}"),
                component.measure().output_unit().into(),
                note(axis, component).into(),
            ]);
        }
    }
    table.text()
}

/// Why an error is usually not asked for.
fn note(axis: &Axis, component: Component) -> &'static str {
    if axis.zero_position() == Some(component) {
        "zero position"
    } else if axis.kind == AxisKind::Linear && is_by_choice_of_r(axis, component) {
        "zero by the choice of R"
    } else {
        ""
    }
}

/// Tests of a session, and what they are set up with.
fn session_text(machine: &Machine, session: &SessionCheck) -> String {
    let mut out = format!("\nSession {}: {} tests\n", session.name, session.tests.len());
    let mut table = Table::new(&["test", "rows", "readings", "bar mm", "off mm", "moving"]);
    for test in &session.tests {
        let moving: Vec<String> = test
            .moving
            .iter()
            .map(|moving| {
                let axis = &machine.axes[moving.axis];
                let end = |value| axis.kind.to_file_unit(value);
                format!(
                    "{} {:.2} … {:.2} {}",
                    axis.name,
                    end(moving.lowest),
                    end(moving.highest),
                    axis.kind.position_unit()
                )
            })
            .collect();
        table.row(vec![
            test.name.clone(),
            test.rows.to_string(),
            test.readings.to_string(),
            test.bar_length_mm.map_or("–".into(), |length| format!("{length:.4}")),
            test.median_off_mm.map_or("–".into(), |off| format!("{off:.4}")),
            moving.join(", "),
        ]);
    }
    out.push_str(&table.text());
    out.push_str("  off: median of reading minus the length that the machine file predicts\n");
    for (what, list) in
        [("Pivots", &session.pivots), ("Spindle balls", &session.spindle_balls), ("Bars", &session.bars)]
    {
        let _ = writeln!(out, "  {what}: {}", if list.is_empty() { "none".into() } else { list.join("; ") });
    }
    out
}

/// Transforms of all links at one set of positions.
fn placement_text(machine: &Machine, placement: &Placement, has_errors: bool) -> String {
    let positions: Vec<String> = named_positions(machine, placement)
        .into_iter()
        .filter(|(_, value)| *value != 0.0)
        .map(|(name, value)| format!("{name} = {value}"))
        .collect();
    let place = if positions.is_empty() { "the zero position".to_string() } else { positions.join(", ") };
    let what = if has_errors { "with the errors of the file" } else { "nominal" };
    let mut out = format!("\nTransforms bed from link at {place}, {what} (mm)\n");
    for link in &placement.links {
        let pose = if has_errors { &link.with_errors } else { &link.nominal };
        for (index, row) in rows(pose).iter().enumerate() {
            let name = if index == 0 { link.name.as_str() } else { "" };
            let [x, y, z, at] = row.map(|value| without_minus_zero((value * 1e9).round() / 1e9));
            let _ = writeln!(out, "  {name:<8}{x:13.9}{y:13.9}{z:13.9}{at:14.6}");
        }
    }
    out
}
