//! Vibration of fixed frequency. Errors of fixed order per turn are in `harmonics`.
//!
//! `E = a cos 2πft + b sin 2πft`; t counts from the start of each recording (`clock: test`) or of the session.

use super::kind::{
    Default, Driver, Kind, Parameter, ParameterUnit, Profile, every_component, no_check, plain_measure, word,
};
use super::{Context, EffectError};
use crate::machine::{Effect, Outlet, Place};
use std::f64::consts::TAU;

/// Vibration of an axis or of the spindle ball.
pub static VIBRATION: Kind = Kind {
    name: "vibration",
    driver: Driver::Time,
    formula: "E = a cos 2 pi f t + b sin 2 pi f t",
    size_meaning: "amplitude",
    cause: "pump, fan, hydraulic unit or a resonance of axis or spindle",
    remedy: "find the source of that frequency by switching units off, isolate or damp it, damp the control loop",
    parameters: &[
        Parameter::number("frequency", ParameterUnit::Plain, Default::Required, (1e-4, 1e5), "frequency, Hz"),
        Parameter::word(
            "clock",
            &["test", "session"],
            Default::Absent,
            "whether phase counts from the session's beginning (default) or from each recording's",
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
    functions: |_| vec!["cos".into(), "sin".into()],
    profiles,
};

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let omega = TAU * VIBRATION.number(context, effect, "frequency");
    let by_test = word(effect, "clock") == Some("test");
    let time = |test: usize, row: usize| {
        context.session_time_s(test, row) - if by_test { context.session().tests[test].started_at_s } else { 0.0 }
    };
    Ok(vec![
        context.profile(|test, row| (omega * time(test, row)).cos()),
        context.profile(|test, row| (omega * time(test, row)).sin()),
    ])
}
