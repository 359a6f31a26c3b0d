//! Displacement of a turning part that grows with the square of its speed: imbalance against the springs of bearing and frame. Resonance is not modelled.
//!
//! `E = (ω/ω₁)² (a cos q + b sin q)`, ω the speed of the axis over the turn about a row, ω₁ one turn a second: below its resonance a part
//! gives way to the centrifugal force m·e·ω² in proportion. Faster changes of the speed are those of the readings of the angle: the
//! part's inertia forbids them. What keeps its size at every speed is error motion.

use std::f64::consts::TAU;

use super::backlash::across;
use super::candidates::{CandidateFamily, Observations, directions, motion, none};
use super::context::Profile;
use super::contract::{Documented, Driver, Kind, Notable, Signature, Unseen, no_check, plain_measure};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::machine::{AxisKind, Effect, Place};

/// Imbalance of what a rotary axis carries.
pub static IMBALANCE: Kind = Kind {
    name: "imbalance",
    driver: Driver::Speed,
    formula: "E = (w/w1)^2 (a cos q + b sin q), w the speed, w1 one turn a second",
    size_meaning: "displacement at the highest speed of the session",
    cause: "mass off the line of the turning part",
    remedy: "balance the turning part, or keep its speed where the displacement does not matter",
    titles: &[("", "Imbalance of {place} ({moving})")],
    measures: Some("at the highest speed of the session"),
    notable: Notable { length: 1.0, angle: 2.0 },
    shown_by: ShownBy {
        arm: Some(ShowingTest::TwoSpeeds),
        rotary: Some(ShowingTest::TwoFeeds),
        other: ShowingTest::TwoFeeds,
    },
    unseen: Unseen::Never,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: true,
    signature: Signature::ErrorMotion,
    candidates: turning,
    candidates_of_poses: none,
    documented: Documented {
        place: "rotary axis",
        components: "all but own",
        functions: "`cos`, `sin` of q times the square of the speed over the turn about a row, in turns a second",
        parameters: "–",
        unit: "um, arcsec at one turn a second",
    },
    parameters: &[],
    check: no_check,
    outlets: |machine, place| match place {
        Place::Axis(axis) if machine.axes[axis].kind == AxisKind::Rotary => across(machine, place),
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions: |_| ["cos", "sin"].map(String::from).to_vec(),
    profiles,
};

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let Place::Axis(axis) = effect.place else { return Ok(Vec::new()) };
    let speeds: Vec<Vec<f64>> = (0..context.tests()).map(|test| speeds_of_turns(context, test, axis)).collect();
    let pull = |test: usize, row: usize| (speeds[test][row] / TAU).powi(2);
    let q = |test: usize, row: usize| context.motion(test).row(row)[axis];
    Ok(vec![
        context.profile(|test, row| pull(test, row) * q(test, row).cos()),
        context.profile(|test, row| pull(test, row) * q(test, row).sin()),
    ])
}

/// Speed of an axis over the turn about each row, or over what of it was recorded, rad/s; zero without times.
fn speeds_of_turns(context: &Context, test: usize, axis: usize) -> Vec<f64> {
    let motion = context.motion(test);
    let rows = motion.rows();
    let Some(time) = &motion.time_s else { return vec![0.0; rows] };
    let q = |row: usize| motion.row(row)[axis];
    let (mut first, mut last) = (0, 0);
    let of_row = |row: usize| {
        while first < row && (q(row) - q(first)).abs() > 0.5 * TAU {
            first += 1;
        }
        last = last.max(row);
        while last + 1 < rows && (q(last + 1) - q(row)).abs() <= 0.5 * TAU {
            last += 1;
        }
        let passed = time[last] - time[first];
        if passed > 0.0 { (q(last) - q(first)) / passed } else { 0.0 }
    };
    (0..rows).map(of_row).collect()
}

/// Sizes up to this are plausible, µm or arcsec: a large rotor is soft beside a machine tool.
const PLAUSIBLE: f64 = 3000.0;

/// Ratio of the fastest to the slowest test from which what grows with speed may show.
const LEAST_SPEED_RATIO: f64 = 1.3;

/// Imbalance of turning axes that displacement sensors look at, where tests have several speeds.
fn turning(seen: &Observations) -> Vec<CandidateFamily> {
    let has_speeds = |axis: &usize| {
        let speeds = mean_speeds(seen.context, *axis);
        let (slowest, fastest) = speeds.iter().fold((f64::MAX, 0.0_f64), |(low, high), v| (low.min(*v), high.max(*v)));
        fastest > LEAST_SPEED_RATIO * slowest
    };
    let of_axis = |axis: usize| {
        let across = motion(axis, &directions(seen.machine(), axis).across);
        CandidateFamily::new(IMBALANCE.name, Place::Axis(axis), across, PLAUSIBLE).fast()
    };
    seen.under_sensors().filter(has_speeds).map(of_axis).collect()
}

/// Mean speed of an axis in every test in which it moves in time, rad/s.
fn mean_speeds(context: &Context, axis: usize) -> Vec<f64> {
    let of = |test: usize| {
        let motion = context.motion(test);
        let time = motion.time_s.as_ref()?;
        let last = motion.rows().checked_sub(1)?;
        let (passed, turned) = (time[last] - time[0], motion.row(last)[axis] - motion.row(0)[axis]);
        (passed > 0.0 && turned != 0.0).then(|| turned.abs() / passed)
    };
    (0..context.tests()).filter_map(of).collect()
}
