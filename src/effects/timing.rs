//! Errors proportional to speed or acceleration: lag of an axis, radius loss, late pairing of positions with readings.

use super::contract::{
    Driver, Kind, Notable, ShowingTest, ShownBy, Signature, Unseen, no_check, plain_measure, single_function,
};
use crate::machine::{AxisKind, Outlet, Place};

/// An axis that trails its command.
pub static SERVO_LAG: Kind = Kind {
    name: "servo-lag",
    driver: Driver::Speed,
    formula: "position = command - lag * speed; of every slide + slides * acceleration, what a lag that all have takes from a radius",
    size_meaning: "lag behind the command",
    cause: "position loop gains that differ between axes (servo mismatch)",
    remedy: "match the loop gains (Kv) and feed-forward of the axes that interpolate",
    titles: &[("", "{place} follows late")],
    measures: Some("behind the others"),
    notable: Notable { length: 1.0, angle: 1.0 },
    shown_by: ShownBy {
        arm: Some(ShowingTest::TwoSpeeds),
        rotary: Some(ShowingTest::Tangential),
        other: ShowingTest::Circles,
    },
    unseen: Unseen::Listed,
    unmoved: &[AxisKind::Rotary, AxisKind::Linear],
    form_error: 0.03,
    needs_runs: true,
    signature: Signature::Lag,
    parameters: &[],
    check: no_check,
    outlets: |_, place| match place.axis() {
        Some(axis) => vec![Outlet::Lag { axis }, Outlet::SlidesAcceleration { axis }],
        None => Vec::new(),
    },
    measure: plain_measure,
    functions: single_function,
    profiles: |context, _| Ok(vec![context.profile(|_, _| 1.0)]),
};

/// An axis that cuts corners or overshoots under acceleration.
pub static RADIUS_LOSS: Kind = Kind {
    name: "radius-loss",
    driver: Driver::Speed,
    formula: "position = command + s * acceleration",
    size_meaning: "deviation per acceleration",
    cause: "bandwidth of the position loop: radius falls with feed squared over radius, or grows with wrong feed-forward",
    remedy: "tune velocity and acceleration feed-forward, measure at the feed of use",
    titles: &[
        ("control", "All slides leave their path with acceleration"),
        ("", "{place} leaves its path with acceleration"),
    ],
    measures: None,
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::BothWays },
    unseen: Unseen::Never,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: true,
    signature: Signature::Radius,
    parameters: &[],
    check: no_check,
    outlets: |machine, place| match place {
        Place::Axis(axis) => vec![Outlet::Acceleration { axis }],
        // all slides alike, by the name of the first
        Place::Control => {
            let first = machine.axes.iter().position(|axis| axis.kind == AxisKind::Linear);
            first.map(|axis| Outlet::SlidesAcceleration { axis }).into_iter().collect()
        }
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions: single_function,
    profiles: |context, _| Ok(vec![context.profile(|_, _| 1.0)]),
};

/// Positions that are older than the readings beside them.
pub static TRIGGER_LATENCY: Kind = Kind {
    name: "trigger-latency",
    driver: Driver::Speed,
    formula: "position = recorded + delay * speed, every axis",
    size_meaning: "age of the positions, positive when too old",
    cause: "trigger or bus delay between control and instrument, filter delay of the instrument",
    remedy: "measure at two feeds and in both directions, set the delay in the recorder",
    titles: &[("", "Readings and positions are not of the same moment")],
    measures: None,
    notable: Notable { length: 5.0, angle: 5.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::TwoFeeds },
    unseen: Unseen::Listed,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: true,
    signature: Signature::Latency,
    parameters: &[],
    check: no_check,
    outlets: |_, place| if place == Place::Recorder { vec![Outlet::Delay] } else { Vec::new() },
    measure: plain_measure,
    functions: single_function,
    profiles: |context, _| Ok(vec![context.profile(|_, _| 1.0)]),
};
