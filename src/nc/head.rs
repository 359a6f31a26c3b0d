//! The head of a program: which coordinates, offsets and lengths it counts on, as lines of plain text. It moves nothing.

use super::coordinates::Coordinates;
use super::dialect::Dialect;
use crate::machine::{AxisKind, Machine};
use crate::plan::{CupLooks, PlannedTest};
use crate::session::{Follow, Path};

/// What the operator must know before the first block of a test, one line each.
pub(super) fn test_head(
    machine: &Machine,
    planned: &PlannedTest,
    zero: &[String],
    dialect: Dialect,
    coordinates: &Coordinates,
) -> Vec<String> {
    let test = &planned.test;
    let mut lines = machine_lines(machine);
    let [there, back] = planned.both_ways();
    lines.push(format!("tests {} and {}", there.name, back.name));
    if let Some(marks) = test.marks {
        lines.push(format!(
            "before and after each direction the bar moves by {} mm along itself, marks for import, keep them in the recording",
            marks.move_mm
        ));
    }
    let parts: Vec<String> = planned.mounting.bar_parts_mm.iter().map(f64::to_string).collect();
    let parts = if parts.len() > 1 { format!(" = {}", parts.join(" + ")) } else { String::new() };
    lines.push(format!("ball bar {} mm{parts}, {}", test.bar_length_mm.unwrap_or(0.0), ball_speed(planned)));
    let known = (planned.placing.gauge_length_mm * 1e3).floor() / 1e3;
    let mut gauge = format!(
        "gauge length {:.3} mm from spindle nose to ball, known within {known} mm",
        planned.mounting.nose_to_ball_mm
    );
    if let Some(arm) = &planned.mounting.arm {
        let looks = match arm.cup {
            CupLooks::DownTheTool => "down the tool",
            CupLooks::Outward => "outward",
        };
        gauge.push_str(&format!(", ball {:.3} mm aside on the fixture, cup looks {looks}", arm.length_mm));
    }
    lines.push(gauge);
    if planned.mounting.arm.is_some() {
        lines.push(
            "the fixture's arm turns with the spindle: orient the spindle and lock it before anything is mounted"
                .into(),
        );
    }
    if let Some(Path::Sweep { axis, from, to, .. }) = &test.path
        && machine.axes[*axis].kind == AxisKind::Rotary
        && (to - from).abs() > 180.0
    {
        let name = &machine.axes[*axis].name;
        let arc_deg = (to - from).abs();
        lines.push(format!(
            "{name} turns by {arc_deg:.0} degrees and run-in in one block: a control that counts {name} modulo 360 must count on instead"
        ));
    }
    lines.extend(control_lines(machine, zero, dialect, coordinates));
    lines
}

/// The same for the run without the bar.
pub(super) fn dry_run_head(
    machine: &Machine,
    zero: &[String],
    dialect: Dialect,
    coordinates: &Coordinates,
) -> Vec<String> {
    let mut lines = machine_lines(machine);
    lines.extend(control_lines(machine, zero, dialect, coordinates));
    lines
}

/// Which machine, and what its file holds to be assumed.
fn machine_lines(machine: &Machine) -> Vec<String> {
    let caveats = machine.caveats.iter().map(|caveat| format!("assumed: {caveat}"));
    std::iter::once(format!("machine {}", machine.name)).chain(caveats).collect()
}

/// `500 mm/min at the ball`: whose speed the feed of a test is.
pub fn ball_speed(planned: &PlannedTest) -> String {
    let feed = planned.test.feed_mm_per_min.unwrap_or(0.0);
    match &planned.test.path {
        Some(Path::Sweep { follow: Follow::Axial, .. }) => {
            format!("{feed} mm/min of the ball about the turning axis, neither ball moves as seen from the other")
        }
        Some(Path::Sweep { follow: Follow::Radial | Follow::Tangential, .. }) => {
            format!("{feed} mm/min of one ball as seen from the other, linear axes may go faster")
        }
        _ => format!("{feed} mm/min at the ball"),
    }
}

/// What the control must be told or must have: tool, coordinates, words of the dialect.
fn control_lines(machine: &Machine, zero: &[String], dialect: Dialect, coordinates: &Coordinates) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    lines.push(match dialect {
        // no word switches it off but a tool call, which may change the tool
        Dialect::Heidenhain => "a tool of length 0 must be active: call it before the cup is mounted".into(),
        _ => "tool length off".into(),
    });
    let zeros = machine.axes.iter().zip(&machine.machine_zero);
    let stated: Vec<String> = zeros.filter_map(|(axis, zero)| Some(format!("{} {:.4}", axis.name, (*zero)?))).collect();
    match coordinates {
        Coordinates::Machine(_) => {
            lines.push(format!("positions in machine coordinates, machine_zero {}", stated.join(" ")))
        }
        Coordinates::Work => {
            lines.push("positions in work coordinates with zero at the zero of the machine file".into());
            let missing = without_machine_zero(machine);
            lines.push(match (stated.is_empty(), missing.is_empty()) {
                (true, _) => "the machine file states no machine_zero: set the work offset by hand".into(),
                (_, false) => format!(
                    "machine_zero is stated for {} but not for {}: it is NOT used",
                    stated.join(" "),
                    missing.join(" ")
                ),
                (_, true) => format!("work offset that must be active, from machine_zero: {}", stated.join(" ")),
            });
        }
    }
    lines.extend(zero.iter().map(|words| format!("zero of the machine file, all axes at 0: {words}")));
    match dialect {
        Dialect::Generic => {
            lines.push("G69 ends turned coordinates: take it out where the control has no such word".into());
        }
        Dialect::LinuxCnc => {
            lines.push("the work offset must not be turned: no word ends that, G10 L2 P0 R0 sets it so".into());
        }
        Dialect::Heidenhain | Dialect::Sinumerik => {
            lines.push("turned coordinates are switched off, a basic rotation of the offset must be zero".into());
        }
    }
    if let Some(directions) = machine.directions {
        lines.push(format!("sense of axes: {directions}, {}", directions.meaning()));
    }
    if dialect == Dialect::Generic {
        lines.push("G4 X is a dwell in seconds, change it where the control wants P".into());
        let axes: Vec<&str> =
            machine.axes.iter().filter(|axis| axis.kind == AxisKind::Rotary).map(|axis| axis.name.as_str()).collect();
        lines.push(format!(
            "F of a block with {0} alone is deg/min, of an arc with {0} mm/min along the arc",
            axes.join(" or ")
        ));
    }
    lines
}

/// Axes without `machine_zero` on a machine where others have one: none of it is used then.
pub fn without_machine_zero(machine: &Machine) -> Vec<&str> {
    let missing = machine.axes.iter().zip(&machine.machine_zero).filter(|(_, zero)| zero.is_none());
    let missing: Vec<&str> = missing.map(|(axis, _)| axis.name.as_str()).collect();
    if missing.len() == machine.axes.len() { Vec::new() } else { missing }
}
