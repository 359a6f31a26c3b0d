//! Present values of a control's parameters against what the machine file says of them. They come read.

use crate::machine::AxisKind;
use crate::session::Session;

/// A pivot length is wrong by a unit from so many times its nominal length on: metres and µm are a thousand times off, inches 25 times.
const OTHER_UNIT: f64 = 20.0;
/// Nominal pivot lengths below this tell no unit, mm.
const LEAST_LENGTH_MM: f64 = 1.0;

/// A present pivot length in another unit than mm.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "{name} = {value} is far from the {nominal_mm} mm between axis {axis} and the spindle ball; values are in mm, convert it"
)]
pub struct OtherUnit {
    /// Name of the parameter as it was given.
    pub name: String,
    /// As it was given.
    pub value: f64,
    /// Between the axis and the spindle ball, mm.
    pub nominal_mm: f64,
    /// Name of the head's last axis.
    pub axis: String,
}

/// Refuses a present pivot length in another unit than mm: how far the ball is from the head's last axis is known.
pub fn refuse_other_units(present: &[(String, f64)], session: &Session) -> Result<(), OtherUnit> {
    let Some((name, value)) = present.iter().find(|(name, _)| name.ends_with("pivot-length")) else { return Ok(()) };
    let machine = &session.machine;
    let turns_the_tool =
        |&axis: &usize| !machine.carries_workpiece(axis) && machine.axes[axis].kind == AxisKind::Rotary;
    let last = (0..machine.axes.len()).rev().find(turns_the_tool);
    let Some((axis, test)) = last.zip(session.tests.first()) else { return Ok(()) };
    let nominal_mm = (machine.axes[axis].origin.z - test.spindle_ball.at.z).abs();
    let ratio = value.abs() / nominal_mm;
    match (1.0 / OTHER_UNIT..OTHER_UNIT).contains(&ratio) || nominal_mm < LEAST_LENGTH_MM {
        true => Ok(()),
        false => {
            Err(OtherUnit { name: name.clone(), value: *value, nominal_mm, axis: machine.axes[axis].name.clone() })
        }
    }
}
