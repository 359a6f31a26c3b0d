//! An axis that stands elsewhere from a moment on: a reference lost, an encoder that lost counts, a clamp or a key that gave way.
//! Balls that slip are in `slip`; what differs in every test is in `repeatability`.
//!
//! `E = s [1 − c (1 − e^(−(t − t0)/τ))]` from t0 on, zero before: the share c goes back with τ.

use super::candidates::{CandidateFamily, Observations, PLAUSIBLE_OF_ARMS, Refined, with_number};
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, of_any_axis,
    plain_measure, single_function,
};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError, Profile};
use crate::machine::{Effect, Machine, Outlet, ParameterValue, Place};

/// Shift of an axis.
pub static AXIS_SHIFT: Kind = Kind {
    name: "axis-shift",
    driver: Driver::Event,
    formula: "E = s [1 - c (1 - e^(-(t-t0)/tau))] from t0 on",
    size_meaning: "displacement",
    cause: "an encoder that lost counts, a reference or offset that was changed, a clamp, key or bearing that gave way, a collision, coolant that struck a slide or ceased",
    remedy: "reference the axis anew and repeat the tests after it, or treat them as a setup of their own",
    titles: &[("", "{place} stands elsewhere from a moment on ({moving})")],
    measures: Some(""),
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::RepeatAtEnd },
    unseen: Unseen::Never,
    unmoved: &[],
    form_error: 0.08,
    needs_runs: true,
    signature: Signature::Jump,
    candidates: shifts,
    candidates_of_poses: shifts_of_joints,
    documented: Documented {
        place: "any axis",
        components: "all",
        functions: "`1 − c (1 − e^(−(t−t0)/τ))` from t0 on",
        parameters: "`time` t0, `return_share` c, `return_time` τ (s); for poses without times `pose`, the number of the first one after it",
        unit: "um, arcsec",
    },
    parameters: &[
        Parameter::number(
            "time",
            ParameterUnit::Plain,
            DefaultValue::Absent,
            (-1e9, 1e9),
            "session time of the shift, s",
        ),
        Parameter::number(
            "pose",
            ParameterUnit::Plain,
            DefaultValue::Absent,
            (-1e9, 1e9),
            "instead of time, for recordings without times: number of the pose from which on it stands elsewhere",
        ),
        Parameter::number(
            "return_share",
            ParameterUnit::Plain,
            DefaultValue::Number(0.0),
            (0.0, 1.0),
            "share of the shift that goes back",
        ),
        Parameter::number(
            "return_time",
            ParameterUnit::Plain,
            DefaultValue::Number(30.0),
            (1e-3, 1e7),
            "time constant with which it goes back, s",
        ),
    ],
    check: one_moment,
    outlets: of_any_axis,
    measure: plain_measure,
    functions: single_function,
    profiles,
};

fn one_moment(_: &Machine, effect: &Effect) -> Result<(), String> {
    match (effect.number("time"), effect.number("pose")) {
        (Some(_), None) | (None, Some(_)) => Ok(()),
        (None, None) => Err("it needs 'time', or 'pose' for recordings without times".into()),
        (Some(_), Some(_)) => Err("'time' and 'pose' do not go together".into()),
    }
}

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    if let Some(first) = effect.number("pose") {
        let timed = context.session().tests.iter().zip(0..).find(|(_, test)| context.motion(*test).time_s.is_some());
        if let Some((test, _)) = timed {
            let (effect, test) = (effect.kind.clone(), test.name.clone());
            return Err(EffectError::PoseOfTimes { effect, test });
        }
        return Ok(vec![context.profile(|test, row| f64::from(u8::from(context.pose_number(test, row) >= first)))]);
    }
    let number = |name| AXIS_SHIFT.number(context, effect, name);
    let (time, share, back_s) = (number("time"), number("return_share"), number("return_time"));
    Ok(vec![context.profile_in(
        |test| context.ends_at_s(test) >= time,
        |test, row| {
            let since = context.session_time_s(test, row) - time;
            match since < 0.0 {
                true => 0.0,
                false if share == 0.0 => 1.0,
                false => 1.0 - share * (1.0 - (-since / back_s).exp()),
            }
        },
    )])
}

/// Seconds before a test at which it is tried beside the jumps of the readings.
const JUST_BEFORE_S: f64 = 1e-6;
/// What goes back, tried where the residual jumps: from none the refinement finds none.
const RETURN_SHARE: f64 = 0.9;
const RETURN_S: f64 = 60.0;
/// Displacements up to this are plausible, µm or arcsec.
const PLAUSIBLE: f64 = 30.0;
/// Log odds against it beside a ball that slips: axes are held by their loops.
const LOG_ODDS_AGAINST: f64 = 5.0;

fn shifts(seen: &Observations) -> Vec<CandidateFamily> {
    let mut grid_of = Vec::new();
    for (index, &test) in seen.context.order().iter().enumerate() {
        let before = (index > 0).then(|| seen.context.session().tests[test].started_at_s - JUST_BEFORE_S);
        let jumps = seen.jumps_s[test].iter().copied();
        grid_of.extend(before.into_iter().chain(jumps.clone()).map(|time| (time, 0.0)));
        grid_of.extend(jumps.take(1).map(|time| (time, RETURN_SHARE)));
    }
    let shape = vec![
        Refined::number("time", (0.0, seen.latest_s()), 3.0),
        Refined::number("return_share", (0.0, 1.0), 0.3),
        Refined::number("return_time", (0.5, 2000.0), 10.0),
    ];
    let machine = seen.machine();
    let of_axis = |axis: usize| {
        let place = Place::Axis(axis);
        let at = |&(time, share): &(f64, f64)| {
            let effect = with_number(AXIS_SHIFT.name, place, "time", time);
            match share > 0.0 {
                true => effect
                    .with("return_share", ParameterValue::Number(share))
                    .with("return_time", ParameterValue::Number(RETURN_S)),
                false => effect,
            }
        };
        CandidateFamily::new(AXIS_SHIFT.name, place, vec![Outlet::own(machine, axis)], PLAUSIBLE)
            .over(grid_of.iter().map(at).collect())
            .refine(shape.clone())
            .rare(LOG_ODDS_AGAINST)
            .ranked(1)
    };
    if grid_of.is_empty() {
        return Vec::new();
    }
    (0..machine.axes.len()).map(of_axis).collect()
}

/// Places among the poses at which a shift is tried: one between two of them keeps most of its gain at the nearer one.
const PLACES: usize = 40;

/// Joints that stand elsewhere from a pose on.
fn shifts_of_joints(seen: &Observations) -> Vec<CandidateFamily> {
    let context = seen.context;
    let poses = (0..context.tests()).flat_map(|test| (0..context.motion(test).rows()).map(move |row| (test, row)));
    let numbers = poses.map(|(test, row)| context.pose_number(test, row));
    let (first, last) = numbers.fold((f64::MAX, f64::MIN), |(first, last), at| (first.min(at), last.max(at)));
    let step = (last - first) / PLACES as f64;
    // between two numbers of poses
    let from = |place: usize| (first + step * place as f64).round() - 0.5;
    let grid: Vec<f64> = (1..PLACES).map(from).filter(|from| (first..last).contains(from)).collect();
    let of_axis = |axis: usize| {
        let at = |from: &f64| with_number(AXIS_SHIFT.name, Place::Axis(axis), "pose", *from);
        let own = vec![Outlet::own(seen.machine(), axis)];
        CandidateFamily::new(AXIS_SHIFT.name, Place::Axis(axis), own, PLAUSIBLE_OF_ARMS)
            .over(grid.iter().map(at).collect())
            .refine(vec![Refined::number("pose", (first, last), 0.5 * step)])
            .rare(LOG_ODDS_AGAINST)
            .ranked(1)
    };
    let axes = 0..seen.machine().axes.len();
    axes.filter(|&axis| context.travelled(axis).is_some()).map(of_axis).collect()
}
