//! What a machine or session file says, as terminal text and as JSON. Poses and medians come computed.

use std::fmt::Write as _;

use nalgebra::Vector3;
use serde::Serialize;

use crate::chain::{Pose, View};
use crate::machine::{Axis, AxisKind, Component, Directions, DirectionsUnstated, ErrorName, Machine};
use crate::report::wording::linear_axes::{LinearAxesJson, linear_axes_json};
use crate::report::wording::meetings::{BodyPairs, BodyPairsJson, body_pairs_json, body_pairs_text};
use crate::report::wording::number::position;
use crate::report::wording::table::Table;

/// A link's transforms: bed from link, mm.
#[derive(Debug, Clone)]
pub struct LinkPose {
    pub name: String,
    pub nominal: Pose,
    /// With the location and component errors of the file.
    pub with_errors: Pose,
}

/// Transforms of all links at one set of positions (mm, rad, by axis index).
#[derive(Debug, Clone)]
pub struct Placement {
    pub positions: Vec<f64>,
    pub links: Vec<LinkPose>,
}

/// The sense of every axis in words, by axis index.
#[derive(Debug, Clone)]
pub struct Senses {
    pub as_read: Vec<String>,
    /// What it would be under `iso841`, where the file states no sense; else empty.
    pub else_iso841: Vec<String>,
}

/// What a session holds.
#[derive(Debug, Clone, Serialize)]
pub struct SessionCheck {
    pub name: String,
    pub tests: Vec<TestCheck>,
    pub pivots: Vec<String>,
    pub spindle_balls: Vec<String>,
    pub bars: Vec<String>,
}

/// One test of a session.
#[derive(Debug, Clone, Serialize)]
pub struct TestCheck {
    pub name: String,
    pub rows: usize,
    pub readings: usize,
    /// Axis index, lowest and highest position (mm or rad).
    #[serde(skip)]
    pub moving: Vec<(usize, f64, f64)>,
    pub bar_length_mm: Option<f64>,
    /// Median of reading minus the length that the machine file predicts, mm.
    pub median_off_mm: Option<f64>,
}

/// `fiveaxis check --json`.
#[derive(Debug, Clone, Serialize)]
pub struct CheckJson {
    pub name: String,
    pub code: String,
    /// `iso841` or `carried` as stated; null where the file states neither, which reads as `carried`.
    pub directions: Option<&'static str>,
    pub axes: Vec<AxisJson>,
    /// What the linear axes are taken to be; null without linear axes.
    pub linear_axes: Option<LinearAxesJson>,
    /// Further link names with the axis that carries them, `b` for the bed.
    pub links: Vec<(String, String)>,
    /// The zero position, then the one asked for.
    pub placements: Vec<PlacementJson>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub session: Option<SessionCheck>,
    /// Pairs of bodies, where the file has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bodies: Option<BodyPairsJson>,
}

/// One axis.
#[derive(Debug, Clone, Serialize)]
pub struct AxisJson {
    pub name: String,
    /// `linear` or `rotary`.
    pub kind: &'static str,
    pub direction: [f64; 3],
    pub origin_mm: [f64; 3],
    /// In `position_unit`.
    pub range: Option<[f64; 2]>,
    /// `mm` or `deg`.
    pub position_unit: &'static str,
    pub reversed: bool,
    /// What a positive command does, in words.
    pub sense: String,
    /// What it would do under `iso841`, where the file states no sense.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sense_iso841: Option<String>,
    /// Location errors that the axis has, zero position included, with their values; others only when the file states them.
    pub location_errors: Vec<ErrorJson>,
    /// Names of component errors that the file states.
    pub component_errors: Vec<String>,
}

/// One location error.
#[derive(Debug, Clone, Serialize)]
pub struct ErrorJson {
    pub name: String,
    pub value: f64,
    /// `um` or `arcsec`.
    pub unit: &'static str,
}

/// Transforms at one set of positions.
#[derive(Debug, Clone, Serialize)]
pub struct PlacementJson {
    /// By axis name, mm or deg.
    pub positions: Vec<(String, f64)>,
    pub links: Vec<LinkJson>,
}

/// Rows of the 4 × 4 transform, bed from link, mm.
#[derive(Debug, Clone, Serialize)]
pub struct LinkJson {
    pub name: String,
    pub nominal: [[f64; 4]; 4],
    pub with_errors: [[f64; 4]; 4],
}

/// The JSON value of a check.
pub fn check_json(
    machine: &Machine,
    senses: &Senses,
    placements: &[Placement],
    session: Option<&SessionCheck>,
    bodies: Option<&BodyPairs>,
) -> CheckJson {
    let carrier = |axis: &Option<usize>| axis.map_or("b", |axis| &machine.axes[axis].name).to_string();
    CheckJson {
        name: machine.name.clone(),
        code: machine.code.to_string(),
        directions: machine.directions.map(Directions::name),
        axes: (0..machine.axes.len()).map(|axis| axis_json(machine, axis, senses)).collect(),
        linear_axes: linear_axes_json(machine),
        links: machine.link_names.iter().map(|(name, axis)| (name.clone(), carrier(axis))).collect(),
        placements: placements.iter().map(|placement| placement_json(machine, placement)).collect(),
        session: session.cloned(),
        bodies: bodies.map(|pairs| body_pairs_json(machine, pairs)),
    }
}

fn axis_json(machine: &Machine, index: usize, senses: &Senses) -> AxisJson {
    let axis = &machine.axes[index];
    AxisJson {
        name: axis.name.clone(),
        kind: kind_name(axis.kind),
        direction: axis.direction.into(),
        origin_mm: axis.origin.into(),
        range: axis.range.map(|(from, to)| [position(axis.kind, from), position(axis.kind, to)]),
        position_unit: axis.kind.position_unit(),
        reversed: axis.reversed,
        sense: senses.as_read.get(index).cloned().unwrap_or_default(),
        sense_iso841: senses.else_iso841.get(index).cloned(),
        location_errors: shown_errors(axis)
            .map(|component| ErrorJson {
                name: ErrorName::location(component, &axis.name).to_string(),
                value: component.measure().to_output(axis.location_errors[component.index()]),
                unit: component.measure().output_unit(),
            })
            .collect(),
        component_errors: component_names(axis),
    }
}

fn placement_json(machine: &Machine, placement: &Placement) -> PlacementJson {
    PlacementJson {
        positions: named_positions(machine, placement),
        links: placement
            .links
            .iter()
            .map(|link| LinkJson {
                name: link.name.clone(),
                nominal: rows(&link.nominal),
                with_errors: rows(&link.with_errors),
            })
            .collect(),
    }
}

/// Slots of an axis, its zero position and whatever else the file states.
fn shown_errors(axis: &Axis) -> impl Iterator<Item = Component> {
    let mut slots = axis.slots();
    slots.extend(axis.zero_position());
    Component::ALL.into_iter().filter(move |c| slots.contains(c) || axis.location_errors[c.index()] != 0.0)
}

fn component_names(axis: &Axis) -> Vec<String> {
    let name = |component| ErrorName::motion(component, &axis.name).to_string();
    axis.component_errors.iter().map(|error| name(error.component)).collect()
}

fn kind_name(kind: AxisKind) -> &'static str {
    match kind {
        AxisKind::Linear => "linear",
        AxisKind::Rotary => "rotary",
    }
}

fn named_positions(machine: &Machine, placement: &Placement) -> Vec<(String, f64)> {
    let axes = machine.axes.iter().zip(&placement.positions);
    axes.map(|(axis, &q)| (axis.name.clone(), position(axis.kind, q))).collect()
}

fn rows(pose: &Pose) -> [[f64; 4]; 4] {
    let row = |k: usize| {
        let r = &pose.rotation;
        [r[(k, 0)], r[(k, 1)], r[(k, 2)], pose.translation_mm[k]].map(without_minus_zero)
    };
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}

/// −0 is a zero to readers.
fn without_minus_zero(value: f64) -> f64 {
    value + 0.0
}

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
    let is_gauge = [("X", Component::EB), ("X", Component::EC), ("Y", Component::EA)];
    if axis.zero_position() == Some(component) {
        "zero position"
    } else if axis.kind == AxisKind::Linear && is_gauge.contains(&(axis.name.as_str(), component)) {
        "zero by the choice of R"
    } else {
        ""
    }
}

fn session_text(machine: &Machine, session: &SessionCheck) -> String {
    let mut out = format!("\nSession {}: {} tests\n", session.name, session.tests.len());
    let mut table = Table::new(&["test", "rows", "readings", "bar mm", "off mm", "moving"]);
    for test in &session.tests {
        let moving: Vec<String> = test
            .moving
            .iter()
            .map(|&(index, from, to)| {
                let axis = &machine.axes[index];
                let end = |value| axis.kind.to_file_unit(value);
                format!("{} {:.2} … {:.2} {}", axis.name, end(from), end(to), axis.kind.position_unit())
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
