//! Error motion of a rotary axis that does not repeat from turn to turn: asynchronous error motion in the words of ISO 230-7.
//! What repeats with the position is in `harmonics`.
//!
//! `E = a_t cos n φ + b_t sin n φ`, φ the way of the axis since the run of test t began, n no whole number: the cage of a rolling
//! bearing turns 0.35 to 0.48 times per turn of the axis, its balls pass at odd multiples. The phase of a run is chance, so
//! every test has amplitudes of its own.

use super::backlash::across;
use super::candidates::{CandidateFamily, Observations, Refined, directions, motion, none, with_number};
use super::context::Profile;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, no_check,
    plain_measure,
};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::machine::{AxisKind, Effect, Outlet, Place};
use std::f64::consts::TAU;

/// Asynchronous error motion.
pub static ASYNCHRONOUS_ERROR_MOTION: Kind = Kind {
    name: "asynchronous-error-motion",
    driver: Driver::Time,
    formula: "E = a cos n phi + b sin n phi, phi the way since the run began, of each test its own a and b",
    size_meaning: "amplitude of a component, rms of the runs",
    cause: "cage or balls of a worn rolling bearing, balls of different size, a loose bearing ring",
    remedy: "repeat one sweep several times: the pattern moves on from run to run; inspect bearing and preload",
    titles: &[("", "Error motion of the axis of {place} that does not repeat ({moving})")],
    measures: Some("amplitude, rms of the runs"),
    notable: Notable { length: 1.0, angle: 2.0 },
    shown_by: ShownBy { arm: None, rotary: Some(ShowingTest::BothWays), other: ShowingTest::BothWays },
    unseen: Unseen::Never,
    unmoved: &[],
    form_error: 0.05,
    needs_runs: true,
    signature: Signature::Course,
    candidates: wobbles,
    candidates_of_poses: none,
    documented: Documented {
        place: "rotary axis",
        components: "all but own",
        functions: "`cos`, `sin` of n φ, φ the way since the run began",
        parameters: "`order` n per turn; `tests`: each test has sizes of its own",
        unit: "um, arcsec",
    },
    parameters: &[Parameter::number(
        "order",
        ParameterUnit::Plain,
        DefaultValue::Required,
        (1e-3, 1e3),
        "periods per turn",
    )],
    check: no_check,
    outlets: |machine, place| match place {
        Place::Axis(axis) if machine.axes[axis].kind == AxisKind::Rotary => across(machine, place),
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions: |_| vec!["cos".into(), "sin".into()],
    profiles,
};

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let Place::Axis(axis) = effect.place else { return Ok(Vec::new()) };
    let order = ASYNCHRONOUS_ERROR_MOTION.number(context, effect, "order");
    let turns = |test: usize| context.motion(test).moving.contains(&axis);
    let wave = |of: fn(f64) -> f64| {
        context.profile_in(turns, |test, row| {
            let motion = context.motion(test);
            of(order * (motion.row(row)[axis] - motion.row(0)[axis]).abs())
        })
    };
    Ok(vec![wave(f64::cos), wave(f64::sin)])
}

/// Periods within the arc that are tried: less than one, as a cage turns, and between whole numbers.
const PERIODS: [f64; 4] = [0.45, 1.45, 2.45, 3.45];
/// First step of the search for the order, in periods within the arc.
const STEP: f64 = 0.15;
/// Orders beyond these are no bearing's, per turn.
const ORDERS: (f64, f64) = (0.3, 40.0);
/// Amplitudes up to this are plausible, µm or arcsec.
const PLAUSIBLE: f64 = 3.0;
/// Log odds against it, as against any of the many ripples that were looked at: amplitudes of every test follow a gauge that drifts.
const LOG_ODDS_AGAINST: f64 = 15.0;

fn wobbles(seen: &Observations) -> Vec<CandidateFamily> {
    let of_axis = |(axis, (from, to)): (usize, (f64, f64))| {
        let place = Place::Axis(axis);
        // half a turn and less of a cage is a bow like any other
        let per_arc = (TAU / (to - from)).max(1.0);
        let grid =
            PERIODS.map(|periods| with_number(ASYNCHRONOUS_ERROR_MOTION.name, place, "order", periods * per_arc));
        let d = directions(seen.machine(), axis);
        [motion(axis, &d.across), motion(axis, &[d.along])].map(|outlets: Vec<Outlet>| {
            let family = CandidateFamily::new(ASYNCHRONOUS_ERROR_MOTION.name, place, outlets, PLAUSIBLE);
            let shape = vec![Refined::number("order", ORDERS, STEP * per_arc)];
            family.over(grid.to_vec()).refine(shape).rare(LOG_ODDS_AGAINST).by_test(seen.tests_moving(axis))
        })
    };
    seen.moving(AxisKind::Rotary).flat_map(of_axis).collect()
}
