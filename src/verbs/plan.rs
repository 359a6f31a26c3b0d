//! `fiveaxis plan`: a test plan for a machine: table, JSON, session file, setup sheet and NC programs.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use fiveaxis::chain::Chain;
use fiveaxis::collision::World;
use fiveaxis::load::{load_kit, load_machine_and_bodies, standard_kit};
use fiveaxis::machine::{AxisKind, Machine};
use fiveaxis::nc::without_machine_zero;
use fiveaxis::plan::{Avoid, Coupled, Goal, Method, Plan, PlannedTest, Settings, free_parts, plan_with_advice};
use fiveaxis::report::{approach_in_words, what_moves};
use fiveaxis::session::{Follow, Path as TestPath};
use fiveaxis::units::{Measure, parse_quantity, shown};
use serde_json::{Map, Value, json};

use super::clearance::touching_note;
use super::former_plan::former_files;
use super::plan_files::{Planned, planned_files};
use super::{Refusal, solids};

/// Arguments of `plan`.
#[derive(Args)]
pub struct Arguments {
    /// Machine file with bodies, mounts and spindle
    machine: PathBuf,
    /// Kit file; the common 100 mm bar with extensions unless given
    #[arg(long)]
    kit: Option<PathBuf>,
    /// Uncertainties to reach, positions and orientations, e.g. 4um,4arcsec
    #[arg(long, value_name = "LENGTH,ANGLE", allow_hyphen_values = true, conflicts_with = "minutes")]
    sigma: Option<String>,
    /// Best plan in this time
    #[arg(long, allow_negative_numbers = true, conflicts_with = "method")]
    minutes: Option<f64>,
    /// Least clearance of every sweep, mm
    #[arg(long, default_value_t = 5.0, allow_negative_numbers = true)]
    margin: f64,
    /// Feed of the moving ball, mm/min
    #[arg(long, default_value_t = 500.0, allow_negative_numbers = true)]
    feed: f64,
    /// Axis region kept out of use, e.g. X=-50..80 (repeatable)
    #[arg(long, value_name = "AXIS=FROM..TO", allow_hyphen_values = true)]
    avoid: Vec<String>,
    /// A method of the thesis in place of the free choice
    #[arg(long, value_enum)]
    method: Option<MethodName>,
    /// Most pivot setups; 1 looks for the one place that does it all
    #[arg(long, value_name = "COUNT", conflicts_with = "method", value_parser = clap::value_parser!(u8).range(1..=20))]
    pivots: Option<u8>,
    /// Ways in which linear axes may follow a rotary axis, or none
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        default_value = "radial,tangential,axial",
        conflicts_with = "method"
    )]
    follow: Vec<FollowName>,
    /// Planar circles too: the squareness of the linear axes is wanted as well
    #[arg(long, conflicts_with = "method")]
    circles: bool,
    /// Run tests again with the spindle indexed by 180°, so that the spindle ball's own placement leaves the positions
    #[arg(long)]
    index_spindle: bool,
    /// Folder for the session file, setup sheet and NC programs
    #[arg(long)]
    out: Option<PathBuf>,
    /// JSON on standard output
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum MethodName {
    Chapter4,
    Chapter5,
    Chapter6,
    Chapter7,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum FollowName {
    None,
    Radial,
    Tangential,
    Axial,
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    let (machine, bodies) = load_machine_and_bodies(&arguments.machine)?;
    solids::require(&arguments.machine, &bodies)?;
    let kit = arguments.kit.as_deref().map_or_else(standard_kit, load_kit)?;
    let settings = settings(arguments, &machine)?;
    let former = match &arguments.out {
        Some(folder) => former_files(folder, &arguments.machine)?,
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
        println!("{}", as_json(&plan, &machine));
        return Ok(());
    }
    print_plan(&plan, &machine, &settings);
    if let Some(note) = touching_note(&World::new(&Chain::of(&machine), &bodies)?) {
        println!("\n{note}");
    }
    Ok(())
}

fn settings(arguments: &Arguments, machine: &Machine) -> Result<Settings, Refusal> {
    let mut settings = Settings::default();
    if let Some(text) = &arguments.sigma {
        let (length, angle) = text
            .split_once(',')
            .ok_or_else(|| format!("--sigma '{text}' has one value; write both, e.g. --sigma 4um,4arcsec"))?;
        let quantity = |text: &str, measure: Measure| {
            let value = parse_quantity(text, measure).map_err(|why| format!("--sigma: {why}"))?;
            let output = measure.to_output(value);
            // no ball bar shows less, no machine is worse
            match output >= 1e-3 && output <= 1e6 {
                true => Ok(value),
                false => {
                    Err(format!("--sigma {} is not between 0.001 and 1000000 {}", text.trim(), measure.output_unit()))
                }
            }
        };
        settings.goal = Goal {
            position_mm: quantity(length, Measure::Length)?,
            orientation_rad: quantity(angle, Measure::Angle)?,
            minutes: None,
        };
    }
    for (name, value, least, most, unit) in [
        ("--minutes", arguments.minutes.unwrap_or(30.0), 1.0, 1e4, "min"),
        ("--margin", arguments.margin, 0.0, 500.0, "mm"),
        ("--feed", arguments.feed, 1.0, 20_000.0, "mm/min"),
    ] {
        if !(value >= least && value <= most) {
            return Err(format!("{name} {} is not between {least} and {most} {unit}", shown(value)).into());
        }
    }
    settings.goal.minutes = arguments.minutes;
    settings.margin_mm = arguments.margin;
    settings.feed_mm_per_min = arguments.feed;
    settings.avoid = arguments.avoid.iter().map(|text| avoided(text, machine)).collect::<Result<Avoid, _>>()?;
    for axis in (0..machine.axes.len()).filter(|&axis| free_parts(machine, axis, &settings.avoid).is_empty()) {
        return Err(nothing_left(machine, axis).into());
    }
    let followed = |name: &FollowName| match name {
        FollowName::None => None,
        FollowName::Radial => Some(Follow::Radial),
        FollowName::Tangential => Some(Follow::Tangential),
        FollowName::Axial => Some(Follow::Axial),
    };
    settings.coupled = match arguments.method {
        Some(_) => Coupled::default(),
        None => Coupled { follow: arguments.follow.iter().filter_map(followed).collect(), circles: arguments.circles },
    };
    settings.index_spindle = arguments.index_spindle;
    if arguments.follow.contains(&FollowName::None) && arguments.follow.len() > 1 {
        return Err("--follow none stands alone; leave 'none' out to allow the others".into());
    }
    settings.pivots = arguments.pivots.map(usize::from);
    settings.method = arguments.method.map(|method| match method {
        MethodName::Chapter4 => Method::Chapter4,
        MethodName::Chapter5 => Method::Chapter5,
        MethodName::Chapter6 => Method::Chapter6,
        MethodName::Chapter7 => Method::Chapter7,
    });
    Ok(settings)
}

/// Regions that leave an axis no place to stand.
fn nothing_left(machine: &Machine, axis: usize) -> String {
    let entry = &machine.axes[axis];
    let unit = if entry.kind == AxisKind::Linear { " mm" } else { "°" };
    let in_unit = |q: f64| round(entry.kind.to_file_unit(q), 3);
    let range = entry.range.map(|(low, high)| format!(", {}…{}{unit}", in_unit(low), in_unit(high)));
    format!(
        "--avoid covers the whole range of {}{}: the axis has nowhere to stand; give the region that is worn only",
        entry.name,
        range.unwrap_or_default()
    )
}

fn avoided(text: &str, machine: &Machine) -> Result<(usize, f64, f64), Refusal> {
    let refuse = || {
        format!(
            "--avoid '{text}' is not understood; write AXIS=FROM..TO with the lower end first, e.g. X=-50..80 (axes: {})",
            machine.axis_names().join(" ")
        )
    };
    let (name, range) = text.split_once('=').ok_or_else(refuse)?;
    let (from, to) = range.split_once("..").ok_or_else(refuse)?;
    let axis = machine.axis_index(name.trim()).ok_or_else(refuse)?;
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    match (number(from), number(to)) {
        (Some(from), Some(to)) if from < to => {
            let kind = machine.axes[axis].kind;
            Ok((axis, kind.from_file_unit(from), kind.from_file_unit(to)))
        }
        _ => Err(refuse().into()),
    }
}

fn round(value: f64, digits: i32) -> f64 {
    let scale = 10f64.powi(digits);
    (value * scale).round() / scale + 0.0
}

/// A planned test as a session states it, one entry for each direction.
fn session_tests(planned: &PlannedTest, machine: &Machine) -> [Map<String, Value>; 2] {
    let test = &planned.test;
    let ball = |ball: &fiveaxis::session::Ball| json!({ "link": ball.link, "at": [ball.at.x, ball.at.y, ball.at.z] });
    let positions: Map<String, Value> = machine
        .axes
        .iter()
        .zip(&test.positions)
        .filter_map(|(axis, q)| Some((axis.name.clone(), json!(round(axis.kind.to_file_unit((*q)?), 5)))))
        .collect();
    let mut spindle_ball = ball(&test.spindle_ball);
    if let Some(about) = test.spindle_ball.indexed_about {
        spindle_ball["indexed_about"] = json!(["x", "y", "z"][about]);
    }
    planned.both_ways().map(|test| {
        let mut map = Map::new();
        let mut put = |key: &str, value: Value| map.insert(key.into(), value);
        put("recording", json!(format!("{}.csv", test.name)));
        put("name", json!(test.name));
        put("bar_length", json!(test.bar_length_mm));
        put("pivot", ball(&test.pivot));
        put("spindle_ball", spindle_ball.clone());
        put("positions", Value::Object(positions.clone()));
        put("feed", json!(test.feed_mm_per_min));
        put("overshoot", json!(test.overshoot));
        match &test.path {
            Some(TestPath::Sweep { axis, from, to, step, follow: Follow::None }) => {
                put("sweep", json!({ "axis": machine.axes[*axis].name, "from": from, "to": to, "step": step }));
            }
            Some(TestPath::Sweep { axis, from, to, step, follow }) => {
                let axis = &machine.axes[*axis].name;
                let follow = follow.name();
                put("sweep", json!({ "axis": axis, "from": from, "to": to, "step": step, "follow": follow }));
            }
            Some(TestPath::Circle { plane, radius_mm, from, to, step }) => {
                let plane = format!("{}{}", machine.axes[plane.first].name, machine.axes[plane.second].name);
                put("circle", json!({ "plane": plane, "radius": radius_mm, "from": from, "to": to, "step": step }));
            }
            None => {}
        }
        map
    })
}

fn as_json(plan: &Plan, machine: &Machine) -> Value {
    let mut tests = Vec::new();
    for planned in &plan.tests {
        for mut map in session_tests(planned, machine) {
            let sweep = &planned.sweep;
            map.insert("clearance_mm".into(), json!(round(sweep.clearance_mm, 3)));
            map.insert("nearest".into(), json!([sweep.pair.0, sweep.pair.1]));
            map.insert("minutes".into(), json!(round(planned.minutes * 0.5, 3)));
            map.insert("rho_mm".into(), json!(round(planned.rho_mm, 6)));
            map.insert("h_mm".into(), json!(round(planned.h_mm, 6)));
            map.insert("mount".into(), json!(planned.mount));
            map.insert("height_mm".into(), json!(planned.height_mm));
            let mounting = &planned.mounting;
            let arm_mm = mounting.arm.as_ref().map(|arm| round(arm.length_mm, 6));
            let mounted = json!({
                "bar_parts_mm": mounting.bar_parts_mm,
                "calibrator_mm": mounting.calibrator_mm,
                "nose_to_ball_mm": round(mounting.nose_to_ball_mm, 6),
                "arm_mm": arm_mm,
            });
            map.insert("mounting".into(), mounted);
            let ended: Vec<Value> = sweep
                .ends
                .iter()
                .map(|pair| pair.as_ref().map_or(json!("axis range"), |(a, b)| json!(format!("{a} – {b}"))))
                .collect();
            map.insert("sweep_ended_by".into(), json!(ended));
            let axis_name = |axis: usize| machine.axes[axis].name.clone();
            let in_file_unit = |axis: usize, q: f64| round(machine.axes[axis].kind.to_file_unit(q), 5);
            let park = planned.approach.park.iter().enumerate();
            let park: Map<String, Value> = park.map(|(k, &q)| (axis_name(k), json!(in_file_unit(k, q)))).collect();
            map.insert("park".into(), Value::Object(park));
            let legs = planned.approach.legs.iter();
            let legs: Vec<Value> =
                legs.map(|leg| json!([axis_name(leg.axis), in_file_unit(leg.axis, leg.to)])).collect();
            map.insert("approach".into(), json!(legs));
            tests.push(Value::Object(map));
        }
    }
    let errors: Map<String, Value> = plan
        .errors
        .iter()
        .map(|error| {
            let measure = if error.is_angle { Measure::Angle } else { Measure::Length };
            let value = json!({
                "determined": error.determined,
                "sigma": round(measure.to_output(error.sigma), 4),
                "sigma_relative": round(measure.to_output(error.sigma_relative), 4),
                "unit": measure.output_unit(),
                "visible": error.visible,
                "reason": error.reason,
            });
            (error.name.clone(), value)
        })
        .collect();
    let curve: Vec<Value> = plan
        .curve
        .iter()
        .map(|point| {
            json!({
                "tests": point.tests,
                "minutes": round(point.minutes, 2),
                "pivot_setups": point.pivot_setups,
                "worst_position_um": round(Measure::Length.to_output(point.position_mm), 3),
                "worst_orientation_arcsec": round(Measure::Angle.to_output(point.orientation_rad), 3),
            })
        })
        .collect();
    json!({
        "machine": machine.name,
        "tests": tests,
        "location_errors": errors,
        "minutes": round(plan.minutes, 2),
        "pivot_setups": plan.pivot_setups,
        "goal_reached": plan.goal_reached,
        "advice": plan.advice,
        "one_pivot": plan.one_pivot.map(|one| json!({ "determined": one.determined, "minutes": round(one.minutes, 2) })),
        "trade_off": curve,
        "considered": plan.considered,
        "without_machine_zero": without_machine_zero(machine),
    })
}

fn print_plan(plan: &Plan, machine: &Machine, settings: &Settings) {
    println!("{} {}", machine.name, machine.code);
    println!(
        "{} tests in both directions, {} pivot setups, {:.0} minutes; {} reachable setups considered",
        plan.tests.len(),
        plan.pivot_setups,
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
    let mut last = None;
    for planned in &plan.tests {
        let test = &planned.test;
        if last != Some(test.pivot.at) {
            let p = test.pivot.at;
            println!(
                "\npivot on {} ({}), ball at ({:.3}, {:.3}, {:.3}), {:.1} mm above it",
                planned.mount, test.pivot.link, p.x, p.y, p.z, planned.height_mm
            );
            last = Some(test.pivot.at);
        }
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
            test.bar_length_mm.unwrap_or(f64::NAN),
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
    }
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
