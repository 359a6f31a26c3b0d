//! A plan as text for a terminal.

use std::fmt::Write as _;

use crate::machine::{AxisKind, Machine};
use crate::nc::without_machine_zero;
use crate::plan::{Plan, PlannedTest, Settings};
use crate::report::wording::words::{approach_in_words, what_moves};
use crate::units::{Measure, rounded};

/// Tests, forecasts and trade-off curve, each line with its end.
pub fn plan_text(plan: &Plan, machine: &Machine, settings: &Settings) -> String {
    let mut out = String::new();
    add_size(&mut out, plan, machine);
    let mut last = None;
    for planned in &plan.tests {
        let pivot = &planned.test.pivot;
        if last != Some(pivot.at) {
            let p = pivot.at;
            let _ = writeln!(
                out,
                "\npivot on {} ({}), ball at ({:.3}, {:.3}, {:.3}), {:.1} mm above it",
                planned.mount, pivot.link, p.x, p.y, p.z, planned.height_mm
            );
            last = Some(pivot.at);
        }
        add_test(&mut out, planned, machine, settings);
    }
    add_errors(&mut out, plan, machine, settings);
    add_curve(&mut out, plan);
    add_remarks(&mut out, plan, machine, settings);
    out
}

/// How many tests and setups, how long they take, and whether they are for a machine yet.
fn add_size(out: &mut String, plan: &Plan, machine: &Machine) {
    let _ = writeln!(out, "{} {}", machine.name, machine.code);
    let _ = writeln!(
        out,
        "{} tests in both directions, {} pivot setup{}, {:.0} minutes; {} reachable setups considered",
        plan.tests.len(),
        plan.pivot_setups,
        if plan.pivot_setups == 1 { "" } else { "s" },
        plan.minutes,
        plan.considered
    );
    if let Some(one) = plan.one_pivot.filter(|_| plan.pivot_setups > 1) {
        let _ = writeln!(
            out,
            "from one pivot setup alone (--pivots 1): {} of {} errors in {:.0} minutes",
            one.determined,
            plan.errors.len(),
            one.minutes
        );
    }
    if let Err(why) = machine.stated_directions() {
        let _ = writeln!(out, "nothing here is for a machine yet: {why}");
    }
}

/// One test: bar, sweep and clearance, where its ball and the other axes stand, and the way to it.
fn add_test(out: &mut String, planned: &PlannedTest, machine: &Machine, settings: &Settings) {
    let test = &planned.test;
    let stands: Vec<String> = machine
        .axes
        .iter()
        .zip(&test.positions)
        .filter_map(|(axis, q)| Some(format!("{} {}", axis.name, rounded(axis.kind.to_file_unit((*q)?), 4))))
        .collect();
    let s = test.spindle_ball.at;
    let _ = writeln!(
        out,
        "  {:<20} bar {:>5} mm  {} {:>6} … {:<6}°  h {:>8.3} mm  clear {:>6.2} mm ({} – {})",
        test.name,
        test.bar_length_mm.map_or("–".into(), |length| length.to_string()),
        what_moves(planned, machine),
        planned.sweep.from_deg,
        planned.sweep.to_deg,
        planned.h_mm,
        planned.sweep.clearance_mm,
        planned.sweep.pair.0,
        planned.sweep.pair.1
    );
    let index = if test.spindle_ball.indexed_about.is_some() { ", spindle indexed by 180°" } else { "" };
    let _ = writeln!(
        out,
        "               spindle ball at ({:.3}, {:.3}, {:.3}){index}; {}",
        s.x,
        s.y,
        s.z,
        stands.join(" ")
    );
    let _ = writeln!(out, "               {}", approach_in_words(planned, machine));
    if let Some(feed) = test.feed_mm_per_min.filter(|feed| *feed < settings.feed_mm_per_min) {
        let _ =
            writeln!(out, "               at {feed} mm/min: faster, a control would not keep its feed over the arc");
    }
}

/// What each error will be known to, and why one is not determined.
fn add_errors(out: &mut String, plan: &Plan, machine: &Machine, settings: &Settings) {
    let _ = writeln!(out, "\n{:<8} {:>12} {:>14}  ", "error", "sigma", "to spindle ball");
    for error in &plan.errors {
        let measure = if error.is_angle { Measure::Angle } else { Measure::Length };
        let state = if error.determined { "" } else { "UNDETERMINED " };
        let _ = writeln!(
            out,
            "{:<8} {:>8.2} {:<6} {:>8.2} {:<6} {state}{}",
            error.name,
            measure.to_output(error.sigma),
            measure.output_unit(),
            measure.to_output(error.sigma_relative),
            measure.output_unit(),
            error.reason
        );
    }
    for axis in machine.inclined_table_axes() {
        let _ = writeln!(
            out,
            "{} is inclined: its errors are counted across its line, for a shift along it and a turn about it change no length; 'identify' tells them together.",
            machine.axes[axis].name
        );
    }
    if let Some(axis) = machine.spindle_axis().map(|axis| &machine.axes[axis].name) {
        let _ = match settings.uncertainty.spread.pivot_length_mm > 0.0 {
            true => writeln!(
                out,
                "E.0S is the place of the spindle from the line of {axis} on, with all axes at zero: the pivot length, to the spindle ball less the ball's own length; of an inclined axis the part across it."
            ),
            false => writeln!(
                out,
                "The pivot length, from the line of {axis} to the spindle, is taken as the machine file has it; --pivot-length plans tests that determine it."
            ),
        };
    }
}

/// The worst uncertainties after one test, after two, and so on.
fn add_curve(out: &mut String, plan: &Plan) {
    let _ = writeln!(out, "\ntests  minutes  pivots  worst position  worst orientation");
    for point in &plan.curve {
        let _ = writeln!(
            out,
            "{:>5}  {:>7.0}  {:>6}  {:>11.2} um  {:>11.2} arcsec",
            point.tests,
            point.minutes,
            point.pivot_setups,
            Measure::Length.to_output(point.position_mm),
            Measure::Angle.to_output(point.orientation_rad)
        );
    }
}

/// What is not reached, what would help, and what the machine file leaves open.
fn add_remarks(out: &mut String, plan: &Plan, machine: &Machine, settings: &Settings) {
    if !plan.goal_reached {
        let goal = &settings.goal;
        let _ = writeln!(
            out,
            "\nNot everything reaches {:.2} um and {:.2} arcsec; the table says what and why.",
            Measure::Length.to_output(goal.position_mm),
            Measure::Angle.to_output(goal.orientation_rad)
        );
    }
    for advice in &plan.advice {
        let _ = writeln!(out, "  {advice}");
    }
    if settings.index_spindle && plan.tests.iter().all(|test| test.test.spindle_ball.indexed_about.is_none()) {
        let _ = writeln!(
            out,
            "\nNo test is worth running again with the spindle indexed: its ball must be on the tool axis and matter."
        );
    }
    let missing = without_machine_zero(machine);
    if !missing.is_empty() {
        let _ = writeln!(
            out,
            "\nmachine_zero is stated for some axes but not for {}: no program uses it, all positions are in work coordinates.",
            missing.join(" ")
        );
    }
    let rotary = machine.axes.iter().filter(|axis| axis.kind == AxisKind::Rotary).count();
    if rotary == 0 {
        let _ = writeln!(out, "The machine has no rotary axis.");
    }
}
