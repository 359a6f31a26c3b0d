//! Candidates of a turning part that displacement sensors look at. It judges nothing.

use super::family::{CandidateFamily, list_of};
use super::motions::{directions, motion, travelled};
use crate::diagnose::model::linear_model::LinearModel;
use crate::effects::{IMBALANCE, SURFACE_FORM};
use crate::machine::{AxisKind, Effect, Outlet, Place};
use crate::readings::Kind;
use std::f64::consts::TAU;

/// Orders of the form of a surface: few, some, many.
const FORM_ORDERS: [usize; 3] = [3, 6, 12];
/// Sizes up to this are plausible, µm or arcsec: a large rotor is soft and rough beside a machine tool.
const PLAUSIBLE: f64 = 300.0;
/// Ratio of the fastest to the slowest test from which what grows with speed may show.
const SPEEDS: f64 = 1.3;

/// Imbalance and form of what an axis carries, in sessions with displacement sensors.
pub(super) fn under_sensors(model: &LinearModel, axis: usize, list: &mut Vec<CandidateFamily>) {
    let is_displacement = |part: &crate::readings::Part| part.kind == Kind::Displacement;
    let tests = &model.context.session().tests;
    let is_seen = tests.iter().any(|test| test.reading.part().is_some_and(is_displacement));
    let machine = model.context.machine();
    let turns = travelled(model, axis).is_some_and(|(from, to)| to - from > TAU);
    if !is_seen || !turns || machine.axes[axis].kind != AxisKind::Rotary {
        return;
    }
    let place = Place::Axis(axis);
    let up_to = |most: usize| {
        let orders = (2..=most).map(|order| order as f64).collect();
        Effect::new(SURFACE_FORM.name, place).with("orders", list_of(orders))
    };
    list.push(
        CandidateFamily::new(SURFACE_FORM.name, place, vec![Outlet::Reading], PLAUSIBLE)
            .over(FORM_ORDERS.map(up_to).to_vec()),
    );
    let speeds = mean_speeds(model, axis);
    let (slowest, fastest) = speeds.iter().fold((f64::MAX, 0.0_f64), |(low, high), v| (low.min(*v), high.max(*v)));
    if fastest > SPEEDS * slowest {
        let across = motion(axis, &directions(machine, axis).across);
        list.push(CandidateFamily::new(IMBALANCE.name, place, across, PLAUSIBLE).fast());
    }
}

/// Mean speed of an axis in every test in which it moves in time, rad/s.
fn mean_speeds(model: &LinearModel, axis: usize) -> Vec<f64> {
    let of = |test: usize| {
        let motion = model.context.motion(test);
        let time = motion.time_s.as_ref()?;
        let last = motion.rows().checked_sub(1)?;
        let (passed, turned) = (time[last] - time[0], motion.row(last)[axis] - motion.row(0)[axis]);
        (passed > 0.0 && turned != 0.0).then(|| turned.abs() / passed)
    };
    (0..model.tests()).filter_map(of).collect()
}
