//! Vibration of fixed frequency. Errors of fixed order per turn are in `harmonics`.
//!
//! `E = a cos 2πft + b sin 2πft`; t counts from the start of each recording (`clock: test`) or of the session. With `wander`
//! a and b are polynomials over each recording: a source that breathes, or whose phase is not kept.

use super::kind::{
    Default, Driver, Kind, Parameter, ParameterUnit, Profile, every_component, no_check, plain_measure, word,
};
use super::{Context, EffectError};
use crate::machine::{Effect, Outlet, ParameterValue, Place};
use std::f64::consts::TAU;

/// Vibration of an axis or of the spindle ball.
pub static VIBRATION: Kind = Kind {
    name: "vibration",
    driver: Driver::Time,
    formula: "E = a cos 2 pi f t + b sin 2 pi f t",
    size_meaning: "amplitude",
    cause: "pump, fan, hydraulic unit or a resonance of axis or spindle",
    remedy: "find the source of that frequency, or of a multiple of the rate of the readings plus or minus it, by switching units off, isolate or damp it, damp the control loop",
    parameters: &[
        Parameter::number("frequency", ParameterUnit::Plain, Default::Required, (1e-4, 1e5), "frequency, Hz"),
        Parameter::word(
            "clock",
            &["test", "session"],
            Default::Absent,
            "whether phase counts from the session's beginning (default) or from each recording's",
        ),
        Parameter::number(
            "wander",
            ParameterUnit::Plain,
            Default::Number(0.0),
            (0.0, MOST_WANDER),
            "degree of the polynomials (Legendre, over each recording) that a and b follow",
        ),
    ],
    check: no_check,
    outlets: |machine, place| match place {
        Place::Axis(axis) => every_component(machine, axis),
        Place::SpindleBall => (0..3).map(Outlet::SpindleBall).collect(),
        Place::Pivot => (0..3).map(Outlet::Pivot).collect(),
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions: |effect| {
        let name = |wave: &str, degree| if degree == 0 { wave.to_string() } else { format!("{wave}-u{degree}") };
        (0..=wander(effect)).flat_map(|degree| [name("cos", degree), name("sin", degree)]).collect()
    },
    profiles,
};

/// Highest degree of wander.
const MOST_WANDER: f64 = 8.0;

/// Degree of the polynomials that the amplitudes follow.
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
    let mut profiles = vec![
        context.profile(|test, row| (omega * time(test, row)).cos()),
        context.profile(|test, row| (omega * time(test, row)).sin()),
    ];
    // Legendre polynomials over each recording by their recursion
    let u = context.profile(|test, row| {
        let end = since(test, context.motion(test).rows().saturating_sub(1));
        if end > 0.0 { 2.0 * since(test, row) / end - 1.0 } else { 0.0 }
    });
    let times = |a: &Profile, factor: &dyn Fn(usize, usize) -> f64| -> Profile {
        let rows = |(test, a): (usize, &Vec<f64>)| a.iter().enumerate().map(|(row, a)| a * factor(test, row)).collect();
        a.iter().enumerate().map(rows).collect()
    };
    let (mut last, mut now) = (context.profile(|_, _| 0.0), context.profile(|_, _| 1.0));
    for degree in 0..wander(effect) {
        let n = degree as f64;
        let next = context
            .profile(|test, row| ((2.0 * n + 1.0) * u[test][row] * now[test][row] - n * last[test][row]) / (n + 1.0));
        (last, now) = (now, next);
        let waves =
            [times(&profiles[0], &|test, row| now[test][row]), times(&profiles[1], &|test, row| now[test][row])];
        profiles.extend(waves);
    }
    Ok(profiles)
}
