//! Vibration of fixed frequency. Errors of fixed order per turn are in `harmonics`.
//!
//! `E = a cos 2πft + b sin 2πft`; t counts from the start of each recording (`clock: test`) or of the session. With `wander`
//! a and b are polynomials over each recording: a source that breathes, or whose phase is not kept. With `every` as well they
//! are cubic splines with knots every so many seconds: one that breathes many times in a recording.

use super::candidates::{CandidateFamily, Observations, Refined, none, with_number};
use super::context::Profile;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, every_component,
    plain_measure, word,
};
use super::showing_test::{ShowingTest, ShownBy};
use super::unknown::cubic;
use super::{Context, EffectError};
use crate::chain::sines_and_cosines;
use crate::machine::{Effect, Machine, Outlet, ParameterValue, Place};
use std::f64::consts::TAU;

/// Vibration of an axis or of the spindle ball.
pub static VIBRATION: Kind = Kind {
    name: "vibration",
    driver: Driver::Time,
    formula: "E = a cos 2 pi f t + b sin 2 pi f t",
    size_meaning: "amplitude",
    cause: "pump, fan, hydraulic unit or a resonance of axis or spindle",
    remedy: "find the source of that frequency, or of a multiple of the rate of the readings plus or minus it, by switching units off, isolate or damp it, damp the control loop",
    titles: &[("spindle-ball", "Vibration at the spindle ball"), ("", "Vibration of {place}")],
    measures: Some("amplitude"),
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::BothWays },
    unseen: Unseen::Never,
    unmoved: &[],
    form_error: 0.015,
    needs_runs: true,
    signature: Signature::Oscillation,
    candidates: vibrations,
    candidates_of_poses: none,
    documented: Documented {
        place: "axis, `spindle-ball`, `pivot`",
        components: "all",
        functions: "`cos`, `sin` of 2πft, with `wander` `cos-uK`, `sin-uK`: times the Legendre polynomial K over each recording; with `every` as well `cos-kK`, `sin-kK`: times the cubic B-spline centred at (K − 1) · `every` s",
        parameters: "`frequency`, `clock` (session, test), `wander`, `every`",
        unit: "um, arcsec",
    },
    parameters: &[
        Parameter::number("frequency", ParameterUnit::Plain, DefaultValue::Required, (1e-4, 1e5), "frequency, Hz"),
        Parameter::word(
            "clock",
            &["test", "session"],
            DefaultValue::Absent,
            "whether phase counts from the session's beginning (default) or from each recording's",
        ),
        Parameter::number(
            "wander",
            ParameterUnit::Plain,
            DefaultValue::Number(0.0),
            (0.0, MOST_WANDER),
            "degree of the polynomials (Legendre, over each recording) that a and b follow; with 'every' the number of knots, less one",
        ),
        Parameter::number(
            "every",
            ParameterUnit::Plain,
            DefaultValue::Absent,
            (0.1, 1e4),
            "a and b are cubic splines with knots every so many seconds, the first one before each recording begins, and constant beyond the last but one",
        ),
    ],
    check: wander_is_whole,
    outlets: |machine, place| match place {
        Place::Axis(axis) => every_component(machine, axis),
        Place::SpindleBall => (0..3).map(Outlet::SpindleBall).collect(),
        Place::Pivot => (0..3).map(Outlet::Pivot).collect(),
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions: |effect| {
        let times = if effect.number("every").is_some() { 'k' } else { 'u' };
        let name = |wave: &str, index: usize| match (index, times) {
            (0, 'u') => wave.to_string(),
            _ => format!("{wave}-{times}{index}"),
        };
        (0..=wander(effect)).flat_map(|index| [name("cos", index), name("sin", index)]).collect()
    },
    profiles,
};

/// Highest degree of polynomials, and most knots of splines less one.
const MOST_DEGREE: f64 = 8.0;
const MOST_WANDER: f64 = 100.0;

fn wander_is_whole(_machine: &Machine, effect: &Effect) -> Result<(), String> {
    let degree = effect.number("wander").unwrap_or(0.0);
    if degree.fract() != 0.0 {
        return Err(format!("'wander' is {degree}; it is a whole number"));
    }
    match effect.number("every") {
        Some(_) if degree < 3.0 => {
            Err("'every' places knots; 'wander' says how many there are, less one, and is 3 at least".into())
        }
        None if degree > MOST_DEGREE => Err(format!(
            "polynomials of degree {degree}; they go to {MOST_DEGREE}, and 'every' makes them splines of so many knots, less one"
        )),
        _ => Ok(()),
    }
}

/// Highest index of the functions that the amplitudes follow.
fn wander(effect: &Effect) -> usize {
    match effect.parameter("wander") {
        Some(ParameterValue::Number(degree)) => degree.clamp(0.0, MOST_WANDER) as usize,
        _ => 0,
    }
}

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let omega = TAU * VIBRATION.number(context, effect, "frequency");
    let by_test = word(effect, "clock") == Some("test");
    let since =
        |test: usize, row: usize| context.session_time_s(test, row) - context.session().tests[test].started_at_s;
    let time = |test: usize, row: usize| if by_test { since(test, row) } else { context.session_time_s(test, row) };
    let (mut sines, mut cosines) = (Profile::new(), Profile::new());
    for test in 0..context.tests() {
        let angles: Vec<f64> = (0..context.motion(test).rows()).map(|row| omega * time(test, row)).collect();
        let (sine, cosine) = sines_and_cosines(&angles);
        sines.push(sine);
        cosines.push(cosine);
    }
    let waves = [cosines, sines];
    let times = |wave: &Profile, factor: &Profile| -> Profile {
        let rows = |(wave, factor): (&Vec<f64>, &Vec<f64>)| wave.iter().zip(factor).map(|(a, b)| a * b).collect();
        wave.iter().zip(factor).map(rows).collect()
    };
    let envelopes = match effect.number("every") {
        Some(every) => splines(context, since, every, wander(effect)),
        None => polynomials(context, since, wander(effect)),
    };
    Ok(envelopes.iter().flat_map(|envelope| waves.each_ref().map(|wave| times(wave, envelope))).collect())
}

/// Legendre polynomials over each recording by their recursion; `since` are seconds since a recording began.
fn polynomials(context: &Context, since: impl Fn(usize, usize) -> f64, degree: usize) -> Vec<Profile> {
    let u = context.profile(|test, row| {
        let end = since(test, context.motion(test).rows().saturating_sub(1));
        if end > 0.0 { 2.0 * since(test, row) / end - 1.0 } else { 0.0 }
    });
    let mut list = vec![context.profile(|_, _| 1.0)];
    let mut last = context.profile(|_, _| 0.0);
    for degree in 0..degree {
        let n = degree as f64;
        let now = &list[degree];
        let next = context
            .profile(|test, row| ((2.0 * n + 1.0) * u[test][row] * now[test][row] - n * last[test][row]) / (n + 1.0));
        last = now.clone();
        list.push(next);
    }
    list
}

/// Cubic B-splines centred at `every · (k − 1)` seconds after each recording began, k = 0 … `wander`.
fn splines(context: &Context, since: impl Fn(usize, usize) -> f64, every: f64, wander: usize) -> Vec<Profile> {
    // the sum of all is one up to the last knot but one
    let beyond = wander.saturating_sub(2) as f64;
    let at = context.profile(|test, row| (since(test, row) / every).min(beyond));
    (0..=wander).map(|k| context.profile(|test, row| cubic(at[test][row] + 1.0 - k as f64))).collect()
}

/// Vibrations of the spindle ball, along each direction and in all, and of every axis, at lines of the spectrum.
fn vibrations(seen: &Observations) -> Vec<CandidateFamily> {
    if seen.lines_hz.is_empty() {
        return Vec::new();
    }
    let axes = 0..seen.machine().axes.len();
    let ball = (0..3).map(|k| (Place::SpindleBall, vec![Outlet::SpindleBall(k)], 2));
    // what swings along an axis is likelier that axis than a ball that could swing anywhere; one that moves before one at rest
    let joints = axes.map(|axis| {
        let rank = if seen.context.moves(axis) { 0 } else { 1 };
        (Place::Axis(axis), vec![Outlet::own(seen.machine(), axis)], rank)
    });
    let all = std::iter::once((Place::SpindleBall, (0..3).map(Outlet::SpindleBall).collect(), 2));
    let vibrating = |(place, outlets, rank): (Place, Vec<Outlet>, usize)| {
        let clocked = |hz: &f64| {
            with_number(VIBRATION.name, place, "frequency", *hz).with("clock", ParameterValue::Word("test".into()))
        };
        let family = CandidateFamily::new(VIBRATION.name, place, outlets, 10.0).fast().ranked(rank);
        let frequency = Refined::number("frequency", (0.02, 1e3), 0.004);
        let family = family.over(seen.lines_hz.iter().map(clocked).collect()).refine(vec![frequency]);
        family.by_test((0..seen.context.tests()).collect())
    };
    ball.chain(joints).chain(all).map(vibrating).collect()
}
