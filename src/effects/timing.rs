//! Errors proportional to speed or acceleration: lag of an axis, radius loss, late pairing of positions with readings.

use super::candidates::{CandidateFamily, Observations, none};
use super::contract::{Documented, Driver, Kind, Notable, Signature, Unseen, no_check, plain_measure, single_function};
use super::showing_test::{ShowingTest, ShownBy};
use crate::machine::{AxisKind, Effect, Outlet, Place};

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
    form_error: 0.01,
    needs_runs: true,
    signature: Signature::Lag,
    candidates: lags,
    candidates_of_poses: none,
    documented: Documented {
        place: "any axis",
        components: "`lag`; `slides`",
        functions: "position = command − lag · speed; all slides + slides · acceleration, the radius that a lag of all takes",
        parameters: "–",
        unit: "ms; ms^2",
    },
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
    candidates: losses,
    candidates_of_poses: none,
    documented: Documented {
        place: "any axis; `control`",
        components: "`acceleration`; `slides`",
        functions: "position = command + s · acceleration, of `control` all slides alike",
        parameters: "–",
        unit: "ms^2",
    },
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
    form_error: 0.01,
    needs_runs: true,
    signature: Signature::Latency,
    candidates: latencies,
    candidates_of_poses: none,
    documented: Documented {
        place: "`recorder`",
        components: "`delay`",
        functions: "position = recorded + delay · speed, all axes",
        parameters: "–",
        unit: "ms, positive when positions are too old",
    },
    parameters: &[],
    check: no_check,
    outlets: |_, place| if place == Place::Recorder { vec![Outlet::Delay] } else { Vec::new() },
    measure: plain_measure,
    functions: single_function,
    profiles: |context, _| Ok(vec![context.profile(|_, _| 1.0)]),
};

/// Largest lag of an axis beyond the others, ms: position loops of machine tools have gains of 1 m/(min·mm) and more, or lags of 60 ms
/// and less, and half of it is a drive that does not hold its axis.
const LONGEST_LAG_MS: f64 = 150.0;

/// Lag of an axis beyond that of the others; where slides move, also with the radius that a lag of all takes.
fn lags(seen: &Observations) -> Vec<CandidateFamily> {
    let axes = (0..seen.machine().axes.len()).filter(|&axis| seen.context.travelled(axis).is_some());
    let of_axis = |axis: usize| {
        let place = Place::Axis(axis);
        // without a second feed lost motion is the likelier one
        let new = |outlets, plausible| {
            CandidateFamily::new(SERVO_LAG.name, place, outlets, plausible).fast().ranked(1).at_most(LONGEST_LAG_MS)
        };
        let beyond = new(vec![Outlet::Lag { axis }], 50.0);
        let with_common = new(vec![Outlet::Lag { axis }, Outlet::SlidesAcceleration { axis }], 1e4);
        if seen.context.slides_move() { vec![beyond, with_common] } else { vec![beyond] }
    };
    axes.flat_map(of_axis).collect()
}

/// Log odds against a radius that all slides lose: circles of a control that was set up are round.
const LOST_BY_ALL: f64 = 4.0;

fn losses(seen: &Observations) -> Vec<CandidateFamily> {
    let new = |place, outlet| CandidateFamily::new(RADIUS_LOSS.name, place, vec![outlet], 1e4).fast();
    let of_slide = |(axis, _)| new(Place::Axis(axis), Outlet::Acceleration { axis });
    let first = seen.axes(AxisKind::Linear).next().filter(|_| seen.context.slides_move());
    let of_all = first.map(|axis| new(Place::Control, Outlet::SlidesAcceleration { axis }).rare(LOST_BY_ALL));
    seen.moving(AxisKind::Linear).map(of_slide).chain(of_all).collect()
}

/// Of all tests, and of each alone: lengths and positions that were paired with a shift of some tenths of a second or more.
fn latencies(seen: &Observations) -> Vec<CandidateFamily> {
    let new =
        |plausible| CandidateFamily::new(TRIGGER_LATENCY.name, Place::Recorder, vec![Outlet::Delay], plausible).fast();
    let tests = seen.context.order();
    let one_test = |test: &usize| {
        let mut effect = Effect::new(TRIGGER_LATENCY.name, Place::Recorder);
        effect.tests = Some(vec![seen.context.session().tests[*test].name.clone()]);
        effect
    };
    let shifted = (tests.len() > 1).then(|| new(3000.0).over(tests.iter().map(one_test).collect()));
    std::iter::once(new(200.0)).chain(shifted).collect()
}
