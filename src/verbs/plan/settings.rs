//! What the options of `plan` ask for, and which of them are refused. It plans nothing.

use fiveaxis::machine::{AxisKind, Machine};
use fiveaxis::plan::{Avoid, Coupled, Goal, Method, Settings, free_parts};
use fiveaxis::session::{FREE_PIVOT_LENGTH_MM, Follow, Zero};
use fiveaxis::units::{Measure, parse_quantity, rounded, shown};

use super::arguments::{Arguments, FollowName, MethodName, ZeroName};
use crate::verbs::Refusal;

/// Settings of the options.
pub fn settings(arguments: &Arguments, machine: &Machine) -> Result<Settings, Refusal> {
    let mut settings = Settings::default();
    if let Some(text) = &arguments.sigma {
        let (length, angle) = text
            .split_once(',')
            .ok_or_else(|| format!("--sigma '{text}' has one value; write both, e.g. --sigma 4um,4arcsec"))?;
        let quantity = |text: &str, measure: Measure| {
            let value = parse_quantity(text, measure).map_err(|why| format!("--sigma: {why}"))?;
            let output = measure.to_output(value);
            // no ball bar shows less, no machine is worse
            match (1e-3..=1e6).contains(&output) {
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
    if let Some(axis) = (0..machine.axes.len()).find(|&axis| free_parts(machine, axis, &settings.avoid).is_empty()) {
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
    settings.uncertainty.zero = match arguments.zero {
        ZeroName::Calibrated => Zero::Calibrated,
        ZeroName::Free => Zero::Free,
    };
    settings.index_spindle = arguments.index_spindle;
    if arguments.pivot_length {
        if machine.spindle_axis().is_none() {
            return Err(format!(
                "--pivot-length: no rotary axis of {} carries the spindle; leave the option out",
                machine.code
            )
            .into());
        }
        settings.uncertainty.spread.pivot_length_mm = FREE_PIVOT_LENGTH_MM;
    }
    settings.marks = !arguments.no_marks;
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
    let in_unit = |q: f64| rounded(entry.kind.to_file_unit(q), 3);
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
