//! Terms without a physical form: a smooth curve or a table over a driver at a place. They describe, they do not explain.
//!
//! `unknown`: cubic B-splines `k1 … kn` on equal spacing between `from` and `to`. `table`: straight lines between values
//! at `knots`, constant beyond. The driver is the position of an axis (mm, deg), that position by direction of
//! motion, session time (s), seconds since the recording began, elevation of the bar (deg), speed (mm/s, deg/s) or acceleration.

use super::candidates::none;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, every_component,
    list, plain_measure,
};
use super::curve_driver::{DRIVER, OF, driving_axis, over_driver};
use super::free_curves::{FREE_CURVE, free_curves};
use super::showing_test::{ShowingTest, ShownBy};
use crate::machine::{Effect, Machine, Outlet, Place};

/// A smooth curve of unknown form.
pub static UNKNOWN: Kind = Kind {
    name: FREE_CURVE,
    driver: Driver::Position,
    formula: "E = sum k_j B_j(driver), cubic B-splines",
    size_meaning: "height of a spline",
    cause: "unknown: no form of the catalogue fits",
    remedy: "look at the curve at that place, repeat the test over it, inspect what acts there",
    titles: &[("", "Something at {place} that no form of the catalogue fits ({moving})")],
    measures: Some("to each side of its mean"),
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy {
        arm: Some(ShowingTest::WholeRange),
        rotary: Some(ShowingTest::Radial),
        other: ShowingTest::Circles,
    },
    unseen: Unseen::AnyForm,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: false,
    signature: Signature::FreeCurve,
    candidates: free_curves,
    candidates_of_poses: none,
    documented: Documented {
        place: "axis, `pivot`, `spindle-ball`, `bar`",
        components: "all",
        functions: "cubic B-splines `kJ` between `from` and `to`",
        parameters: "`driver`, `of`, `from`, `to`, `count`",
        unit: "um, arcsec",
    },
    parameters: &[
        DRIVER,
        OF,
        Parameter::number(
            "from",
            ParameterUnit::Plain,
            DefaultValue::Required,
            (-1e9, 1e9),
            "lower end, in the driver's unit",
        ),
        Parameter::number(
            "to",
            ParameterUnit::Plain,
            DefaultValue::Required,
            (-1e9, 1e9),
            "upper end, in the driver's unit",
        ),
        Parameter::number("count", ParameterUnit::Plain, DefaultValue::Number(8.0), (4.0, 200.0), "number of splines"),
    ],
    check: ends_rise,
    outlets: anywhere,
    measure: plain_measure,
    functions: |effect| (1..=count(effect)).map(|k| format!("k{k}")).collect(),
    profiles: |context, effect| {
        let (from, to) = (UNKNOWN.number(context, effect, "from"), UNKNOWN.number(context, effect, "to"));
        let spacing = (to - from) / (count(effect) - 3) as f64;
        over_driver(context, effect, count(effect), |k, x| cubic((x - from) / spacing - k as f64 + 1.0))
    },
};

/// A curve given by values.
pub static TABLE: Kind = Kind {
    name: "table",
    driver: Driver::Position,
    formula: "E = straight lines between values at the knots",
    size_meaning: "value at a knot",
    cause: "a measured curve, or what is left where no form of the catalogue fits",
    remedy: "enter it as a compensation table after checking that it repeats",
    titles: &[("", "{place} follows a given table ({moving})")],
    measures: None,
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::BothWays },
    unseen: Unseen::Never,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: false,
    signature: Signature::Given,
    candidates: none,
    candidates_of_poses: none,
    documented: Documented {
        place: "axis, `pivot`, `spindle-ball`, `bar`",
        components: "all",
        functions: "straight lines between `kJ` at the knots, constant beyond",
        parameters: "`driver`, `of`, `knots`",
        unit: "um, arcsec",
    },
    parameters: &[
        DRIVER,
        OF,
        Parameter::list(
            "knots",
            ParameterUnit::Plain,
            DefaultValue::Required,
            (-1e9, 1e9),
            "rising, in the driver's unit",
        ),
    ],
    check: knots_rise,
    outlets: anywhere,
    measure: plain_measure,
    functions: |effect| (1..=list(effect, "knots").len()).map(|k| format!("k{k}")).collect(),
    profiles: |context, effect| {
        let knots = list(effect, "knots");
        over_driver(context, effect, knots.len(), |k, x| hat(knots, k, x))
    },
};

fn ends_rise(machine: &Machine, effect: &Effect) -> Result<(), String> {
    match (effect.number("from"), effect.number("to")) {
        (Some(from), Some(to)) if from < to => driving_axis(machine, effect),
        _ => Err("'from' is below 'to'".into()),
    }
}

fn knots_rise(machine: &Machine, effect: &Effect) -> Result<(), String> {
    let knots = list(effect, "knots");
    if knots.is_empty() || knots.windows(2).any(|pair| pair[0] >= pair[1]) {
        return Err("knots rise from one to the next, and there is at least one".into());
    }
    driving_axis(machine, effect)
}

fn count(effect: &Effect) -> usize {
    effect.number("count").map_or(8, |count| (count as usize).clamp(4, 200))
}

/// Every component of an axis, the balls and the reading.
fn anywhere(machine: &Machine, place: Place) -> Vec<Outlet> {
    match place {
        Place::Axis(axis) => every_component(machine, axis),
        Place::Pivot => (0..3).map(Outlet::Pivot).collect(),
        Place::SpindleBall => (0..3).map(Outlet::SpindleBall).collect(),
        Place::Bar => vec![Outlet::Reading],
        Place::Recorder | Place::Control => Vec::new(),
    }
}

/// Uniform cubic B-spline centred at 0 with support −2 … 2; 2/3 at its centre.
pub(super) fn cubic(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 {
        2.0 / 3.0 - x * x + x * x * x / 2.0
    } else if x < 2.0 {
        (2.0 - x).powi(3) / 6.0
    } else {
        0.0
    }
}

/// Hat function of knot k; the first and last one stay at one beyond the ends.
fn hat(knots: &[f64], k: usize, x: f64) -> f64 {
    let here = knots[k];
    let toward = if x < here { k.checked_sub(1) } else { Some(k + 1).filter(|&next| next < knots.len()) };
    match toward {
        None => 1.0,
        Some(other) => (1.0 - (x - here) / (knots[other] - here)).max(0.0),
    }
}
