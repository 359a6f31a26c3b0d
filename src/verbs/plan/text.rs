//! A plan as text for a terminal. It chooses nothing.

use fiveaxis::machine::{AxisKind, Machine};
use fiveaxis::nc::without_machine_zero;
use fiveaxis::plan::{Plan, PlannedTest, Settings};
use fiveaxis::report::{approach_in_words, what_moves};
use fiveaxis::units::Measure;

use super::rounding::round;

/// Prints tests, forecasts and trade-off curve.
pub fn print_plan(plan: &Plan, machine: &Machine, settings: &Settings) {
    print_size(plan, machine);
    let mut last = None;
    for planned in &plan.tests {
        let pivot = &planned.test.pivot;
        if last != Some(pivot.at) {
            let p = pivot.at;
            println!(
                "\npivot on {} ({}), ball at ({:.3}, {:.3}, {:.3}), {:.1} mm above it",
                planned.mount, pivot.link, p.x, p.y, p.z, planned.height_mm
            );
            last = Some(pivot.at);
        }
        print_test(planned, machine, settings);
    }
    print_errors(plan);
    print_curve(plan);
    print_remarks(plan, machine, settings);
}

/// How many tests and setups, how long they take, and whether they are for a machine yet.
fn print_size(plan: &Plan, machine: &Machine) {
    println!("{} {}", machine.name, machine.code);
    println!(
        "{} tests in both directions, {} pivot setup{}, {:.0} minutes; {} reachable setups considered",
        plan.tests.len(),
        plan.pivot_setups,
        if plan.pivot_setups == 1 { "" } else { "s" },
        plan.minutes,
        plan.considered
    );
    if let Some(one) = plan.one_pivot.filter(|_| plan.pivot_setups > 1) {
        println!(
            "from one pivot setup alone (--pivots 1): {} of {} errors in {:.0} minutes",
            one.determined,
            plan.errors.len(),
            one.minutes
        );
    }
    if let Err(why) = machine.stated_directions() {
        println!("nothing here is for a machine yet: {why}");
    }
}

/// One test: bar, sweep and clearance, where its ball and the other axes stand, and the way to it.
fn print_test(planned: &PlannedTest, machine: &Machine, settings: &Settings) {
    let test = &planned.test;
    let stands: Vec<String> = machine
        .axes
        .iter()
        .zip(&test.positions)
        .filter_map(|(axis, q)| Some(format!("{} {}", axis.name, round(axis.kind.to_file_unit((*q)?), 4))))
        .collect();
    let s = test.spindle_ball.at;
    println!(
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
    println!("               spindle ball at ({:.3}, {:.3}, {:.3}){index}; {}", s.x, s.y, s.z, stands.join(" "));
    println!("               {}", approach_in_words(planned, machine));
    if let Some(feed) = test.feed_mm_per_min.filter(|feed| *feed < settings.feed_mm_per_min) {
        println!("               at {feed} mm/min: faster, a control would not keep its feed over the arc");
    }
}

/// What each error will be known to, and why one is not determined.
fn print_errors(plan: &Plan) {
    println!("\n{:<8} {:>12} {:>14}  ", "error", "sigma", "to spindle ball");
    for error in &plan.errors {
        let measure = if error.is_angle { Measure::Angle } else { Measure::Length };
        let state = if error.determined { "" } else { "UNDETERMINED " };
        println!(
            "{:<8} {:>8.2} {:<6} {:>8.2} {:<6} {state}{}",
            error.name,
            measure.to_output(error.sigma),
            measure.output_unit(),
            measure.to_output(error.sigma_relative),
            measure.output_unit(),
            error.reason
        );
    }
}

/// The worst uncertainties after one test, after two, and so on.
fn print_curve(plan: &Plan) {
    println!("\ntests  minutes  pivots  worst position  worst orientation");
    for point in &plan.curve {
        println!(
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
fn print_remarks(plan: &Plan, machine: &Machine, settings: &Settings) {
    if !plan.goal_reached {
        let goal = &settings.goal;
        println!(
            "\nNot everything reaches {:.2} um and {:.2} arcsec; the table says what and why.",
            Measure::Length.to_output(goal.position_mm),
            Measure::Angle.to_output(goal.orientation_rad)
        );
    }
    for advice in &plan.advice {
        println!("  {advice}");
    }
    if settings.index_spindle && plan.tests.iter().all(|test| test.test.spindle_ball.indexed_about.is_none()) {
        println!(
            "\nNo test is worth running again with the spindle indexed: its ball must be on the tool axis and matter."
        );
    }
    let missing = without_machine_zero(machine);
    if !missing.is_empty() {
        println!(
            "\nmachine_zero is stated for some axes but not for {}: no program uses it, all positions are in work coordinates.",
            missing.join(" ")
        );
    }
    let rotary = machine.axes.iter().filter(|axis| axis.kind == AxisKind::Rotary).count();
    if rotary == 0 {
        println!("The machine has no rotary axis.");
    }
}
