//! What a curve without a physical form may depend on: position, direction, time, elevation, speed or acceleration. It has no curves.

use super::context::{Profile, Travel};
use super::contract::{DefaultValue, Parameter, word};
use super::memory::STANDSTILL;
use super::{Context, EffectError};
use crate::machine::{Effect, Machine};

/// Drivers that no axis has.
pub(super) const TIME: &str = "time";
pub(super) const RUN: &str = "run";
pub(super) const ELEVATION: &str = "elevation";

/// What a curve depends on.
pub(super) const DRIVER: Parameter = Parameter::word(
    "driver",
    &["position", "direction", TIME, RUN, ELEVATION, "speed", "acceleration"],
    DefaultValue::Absent,
    "what it depends on; position when not stated, direction: position times sign of motion, run: time since the recording began, elevation: of the bar above the level, deg",
);
/// Whose position, direction or speed that is.
pub(super) const OF: Parameter = Parameter::word(
    "of",
    &[],
    DefaultValue::Absent,
    "axis whose position, direction or speed drives; the place when not stated",
);

/// Whether an effect says which axis drives it, where its driver is one of an axis.
pub(super) fn driving_axis(machine: &Machine, effect: &Effect) -> Result<(), String> {
    let known = || machine.axis_names().join(" ");
    match word(effect, "of") {
        Some(name) if machine.axis_index(name).is_none() => {
            Err(format!("'of: {name}' names no axis; axes are {}", known()))
        }
        None if effect.place.axis().is_none() && !needs_no_axis(word(effect, "driver")) => {
            Err(format!("say 'of:' with the axis that drives it, one of {}", known()))
        }
        _ => Ok(()),
    }
}

/// Whether a driver is none of an axis.
fn needs_no_axis(driver: Option<&str>) -> bool {
    driver.is_some_and(|driver| [TIME, RUN, ELEVATION].contains(&driver))
}

/// Functions of an effect's driver, row by row: `function` of a number of them and a value of the driver.
pub(super) fn over_driver(
    context: &Context,
    effect: &Effect,
    count: usize,
    function: impl Fn(usize, f64) -> f64,
) -> Result<Vec<Profile>, EffectError> {
    let machine = context.machine();
    let driver = word(effect, "driver").unwrap_or("position");
    let axis = match word(effect, "of") {
        Some(name) => machine.axis_index(name),
        None => effect.place.axis(),
    };
    let axis = match (axis, driver) {
        (axis, driver) if needs_no_axis(Some(driver)) => axis.unwrap_or(0),
        (Some(axis), _) => axis,
        (None, _) => {
            return Err(EffectError::NoAxis { effect: effect.kind.clone(), known: machine.axis_names().join(" ") });
        }
    };
    let in_file_unit = |value: f64| machine.axes[axis].kind.to_file_unit(value);
    let sign: Option<Profile> = (driver == "direction").then(|| {
        let advance = |state: &mut f64, travel: Travel| {
            if travel.distance.abs() > STANDSTILL {
                *state = travel.distance.signum();
            }
        };
        context.along(axis, 0.0, advance, |state| *state)
    });
    let elevations: Profile = match driver {
        ELEVATION => (0..context.tests()).map(|test| elevations_deg(context, test)).collect(),
        _ => Profile::new(),
    };
    let at = |test: usize, row: usize| match driver {
        TIME => context.session_time_s(test, row),
        RUN => context.session_time_s(test, row) - context.session().tests[test].started_at_s,
        ELEVATION => elevations[test][row],
        "speed" => in_file_unit(context.speed(test, row, axis)),
        "acceleration" => in_file_unit(context.acceleration(test, row, axis)),
        _ => in_file_unit(context.motion(test).row(row)[axis]),
    };
    let value = |k: usize, test: usize, row: usize| {
        function(k, at(test, row)) * sign.as_ref().map_or(1.0, |sign| sign[test][row])
    };
    Ok((0..count).map(|k| context.profile(|test, row| value(k, test, row))).collect())
}

/// Elevation of the bar above the level, row by row, deg.
pub(super) fn elevations_deg(context: &Context, test: usize) -> Vec<f64> {
    context.bar_sines()[test].iter().map(|sine| sine.clamp(-1.0, 1.0).asin().to_degrees()).collect()
}
