//! Warmth that moving axes leave in a part: a node that friction heats and that cools between tests. Amplitudes are the effect's.

use super::{Context, Profile};
use crate::machine::AxisKind;

/// Speed at which a node's steady growth is stated: slides, mm/s.
const SLIDE_SPEED_MM_S: f64 = 1000.0 / 60.0;
/// Speed at which a node's steady growth is stated: rotary axes at one turn a minute, rad/s.
const ROTARY_SPEED_RAD_S: f64 = std::f64::consts::TAU / 60.0;

/// Axes whose friction heats a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    /// One axis.
    Axis(usize),
    /// Every slide, or every rotary axis, of the machine.
    All(AxisKind),
}

/// Warmth of a node with this time constant at every row, 1 where the source has run at its stated speed for long.
///
/// `τ dW/dt = |v| / v_stated − W`, summed over the axes of the source; cold when the session begins, and without heat
/// between tests, whose moves no recording shows. A node of a warmth has it at session time 0, and counts from there.
/// Friction that does not depend on speed gives heat in proportion to it.
pub(super) fn friction_heat(context: &Context, source: Source, tau_s: f64, warmth: f64) -> Profile {
    let axes = &context.machine().axes;
    let heating: Vec<(usize, f64)> = (0..axes.len())
        .filter(|&axis| match source {
            Source::Axis(one) => one == axis,
            Source::All(kind) => axes[axis].kind == kind,
        })
        .map(|axis| match axes[axis].kind {
            AxisKind::Linear => (axis, SLIDE_SPEED_MM_S),
            AxisKind::Rotary => (axis, ROTARY_SPEED_RAD_S),
        })
        .collect();
    let mut profile = vec![Vec::new(); context.tests()];
    let began_with = warmth;
    // at session time 0
    let (mut warmth, mut at_s) = (began_with, 0.0);
    for &test in context.order() {
        let motion = context.motion(test);
        let moving: Vec<(usize, f64)> =
            heating.iter().copied().filter(|(axis, _)| motion.moving.contains(axis)).collect();
        profile[test] = (0..motion.rows())
            .map(|row| {
                let now_s = context.session_time_s(test, row);
                // within a test its own clock: sessions without times of day begin every test anew
                let before_s = if row == 0 { at_s } else { context.session_time_s(test, row - 1) };
                let passed_s = (now_s - before_s).max(0.0);
                let travelled = |axis: usize| (motion.row(row)[axis] - motion.row(row - 1)[axis]).abs();
                let heat = match row {
                    0 => 0.0,
                    _ if passed_s <= 0.0 => 0.0,
                    _ => moving.iter().map(|&(axis, stated)| travelled(axis) / passed_s / stated).sum(),
                };
                let kept = (-passed_s / tau_s).exp();
                warmth = warmth * kept + heat * (1.0 - kept);
                at_s = now_s;
                warmth - began_with
            })
            .collect();
    }
    profile
}
