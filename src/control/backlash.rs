//! Lost motion of axes as a control's backlash compensation takes it. What was found of it stands in the machine's effects.
//!
//! A control adds its value as the axis turns back. The effects hold half the width: the axis lags so much either way.
//!
//! Parameters by the makers' manuals (FANUC Series 0i-C and 30i-A parameters, No. 1851; HEIDENHAIN TNC 426/430 and iTNC 530
//! technical manuals, MP710, and MANUALplus 620's, MP_backLash; SINUMERIK 840D sl list manual, MD32450; LinuxCNC 2.9, INI file).

use super::parameters::Control;
use crate::effects::{Signature, is_a};
use crate::machine::{Effect, Machine, Outlet};

/// What one axis loses at a reversal.
#[derive(Debug, Clone, PartialEq)]
pub struct Backlash {
    /// Axis index.
    pub axis: usize,
    /// Name of the parameter as the control has it.
    pub parameter: String,
    /// To be added to its present value, mm or rad: the whole width. Positive where the axis lags.
    pub width: f64,
    /// Share of it that is wind-up, and the travel over which it turns round (mm or rad).
    pub windup_share: f64,
    pub take_up: f64,
}

/// Of all axes that lose motion.
pub fn backlash(control: Control, machine: &Machine) -> Vec<Backlash> {
    let of = |axis: usize| {
        let lost: Vec<(&Effect, f64)> = own_lost_motion(machine, axis).collect();
        let width = 2.0 * lag(machine, axis);
        let (most, _) = lost.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        let windup_share = most.number("windup_share").unwrap_or(0.0);
        let take_up = most.number("take_up").unwrap_or(0.0);
        (width != 0.0).then(|| Backlash {
            axis,
            parameter: parameter(control, machine, axis),
            width,
            windup_share,
            take_up,
        })
    };
    (0..machine.axes.len()).filter_map(of).collect()
}

/// Half width of an axis's lost motion, mm or rad.
pub(super) fn lag(machine: &Machine, axis: usize) -> f64 {
    own_lost_motion(machine, axis).map(|(_, half)| half).sum()
}

/// What turns a motion of an axis's own component into one along its command.
pub(super) fn own_sign(machine: &Machine, axis: usize) -> f64 {
    machine.motion_sign(axis) * machine.axes[axis].direction.sum().signum()
}

/// Lost motion along or about an axis itself, with half its width: positive where the carried part stays behind. The travels of
/// an effect are those of the carried part along the axis's direction, whichever way the axis counts.
fn own_lost_motion(machine: &Machine, axis: usize) -> impl Iterator<Item = (&Effect, f64)> {
    let own = Outlet::own(machine, axis);
    let along = machine.axes[axis].direction.sum().signum();
    let sign = if machine.axes[axis].coordinate_direction().is_some() { along } else { 1.0 };
    // what acts in some tests only is no property of the drive
    let lasting =
        machine.effects.iter().filter(|effect| effect.tests.is_none() && is_a(&effect.kind, Signature::Reversal));
    lasting.filter_map(move |effect| {
        let half: f64 = effect.sizes.iter().filter(|size| size.outlet == own).map(|size| sign * size.value).sum();
        (half != 0.0).then_some((effect, half))
    })
}

fn parameter(control: Control, machine: &Machine, axis: usize) -> String {
    let name = &machine.axes[axis].name;
    match control {
        Control::LinuxCnc => format!("BACKLASH of the joint of {name}"),
        Control::Heidenhain => format!("MP710 (iTNC 530), MP_backLash of {name}"),
        Control::Sinumerik => format!("MD32450 $MA_BACKLASH[0] of {name}"),
        Control::Fanuc => format!("No. 1851 of {name}"),
    }
}
