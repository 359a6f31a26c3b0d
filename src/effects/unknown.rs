//! Terms without a physical form: a smooth curve or a table over a driver at a place. They describe, they do not explain.
//!
//! `unknown`: cubic B-splines `k1 … kn` on equal spacing between `from` and `to`. `table`: straight lines between values
//! at `knots`, constant beyond. The driver is the position of an axis (mm, deg), that position by direction of
//! motion, session time (s), seconds since the recording began, elevation of the bar (deg), speed (mm/s, deg/s) or acceleration.

use super::candidates::{CandidateFamily, Observations, beside_own, directions, motion, none, with_word};
use super::context::Profile;
use super::context::Travel;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, every_component,
    list, plain_measure, word,
};
use super::memory::STANDSTILL;
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::machine::{AxisKind, Effect, Machine, Outlet, ParameterValue, Place};

/// Drivers that no axis has.
const TIME: &str = "time";
const RUN: &str = "run";
const ELEVATION: &str = "elevation";

const DRIVER: Parameter = Parameter::word(
    "driver",
    &["position", "direction", TIME, RUN, ELEVATION, "speed", "acceleration"],
    DefaultValue::Absent,
    "what it depends on; position when not stated, direction: position times sign of motion, run: time since the recording began, elevation: of the bar above the level, deg",
);
const OF: Parameter = Parameter::word(
    "of",
    &[],
    DefaultValue::Absent,
    "axis whose position, direction or speed drives; the place when not stated",
);

/// A smooth curve of unknown form.
pub static UNKNOWN: Kind = Kind {
    name: "unknown",
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

fn driving_axis(machine: &Machine, effect: &Effect) -> Result<(), String> {
    let known = || machine.axis_names().join(" ");
    match word(effect, "of") {
        Some(name) if machine.axis_index(name).is_none() => {
            Err(format!("'of: {name}' names no axis; axes are {}", known()))
        }
        None if effect.place.axis().is_none() && !needs_no_axis(word(effect, "driver")) => {
            Err(format!("say 'of:' with the axis that drives it, one of {}", known()))
        }
        _ => Ok(()),
    }
}

/// Whether a driver is none of an axis.
fn needs_no_axis(driver: Option<&str>) -> bool {
    driver.is_some_and(|driver| [TIME, RUN, ELEVATION].contains(&driver))
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

fn over_driver(
    context: &Context,
    effect: &Effect,
    count: usize,
    function: impl Fn(usize, f64) -> f64,
) -> Result<Vec<Profile>, EffectError> {
    let machine = context.machine();
    let driver = word(effect, "driver").unwrap_or("position");
    let axis = match word(effect, "of") {
        Some(name) => machine.axis_index(name),
        None => effect.place.axis(),
    };
    let axis = match (axis, driver) {
        (axis, driver) if needs_no_axis(Some(driver)) => axis.unwrap_or(0),
        (Some(axis), _) => axis,
        (None, _) => {
            return Err(EffectError::NoAxis { effect: effect.kind.clone(), known: machine.axis_names().join(" ") });
        }
    };
    let in_file_unit = |value: f64| machine.axes[axis].kind.to_file_unit(value);
    let sign: Option<Profile> = (driver == "direction").then(|| {
        let advance = |state: &mut f64, travel: Travel| {
            if travel.distance.abs() > STANDSTILL {
                *state = travel.distance.signum();
            }
        };
        context.along(axis, 0.0, advance, |state| *state)
    });
    let elevations: Profile = match driver {
        ELEVATION => (0..context.tests()).map(|test| elevations_deg(context, test)).collect(),
        _ => Profile::new(),
    };
    let at = |test: usize, row: usize| match driver {
        TIME => context.session_time_s(test, row),
        RUN => context.session_time_s(test, row) - context.session().tests[test].started_at_s,
        ELEVATION => elevations[test][row],
        "speed" => in_file_unit(context.speed(test, row, axis)),
        "acceleration" => in_file_unit(context.acceleration(test, row, axis)),
        _ => in_file_unit(context.motion(test).row(row)[axis]),
    };
    let value = |k: usize, test: usize, row: usize| {
        function(k, at(test, row)) * sign.as_ref().map_or(1.0, |sign| sign[test][row])
    };
    Ok((0..count).map(|k| context.profile(|test, row| value(k, test, row))).collect())
}

/// Elevation of the bar above the level, row by row, deg.
fn elevations_deg(context: &Context, test: usize) -> Vec<f64> {
    context.bar_sines()[test].iter().map(|sine| sine.clamp(-1.0, 1.0).asin().to_degrees()).collect()
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

/// Heights of splines up to this are plausible, µm or arcsec.
const PLAUSIBLE: f64 = 30.0;

/// Splines of a free curve over an axis.
const SPLINES: f64 = 14.0;

/// Free curves over positions, for what has no form in the catalogue; of rotary axes also in single postures of the others.
fn free_curves(seen: &Observations) -> Vec<CandidateFamily> {
    let machine = seen.machine();
    let mut list = Vec::new();
    for (axis, ends) in seen.moving(AxisKind::Rotary) {
        let d = directions(machine, axis);
        let own = vec![Outlet::own(machine, axis)];
        let postures = postures(seen, axis);
        for outlets in [motion(axis, &d.across), motion(axis, &[d.along]), motion(axis, &d.tilts), own] {
            list.extend(["position", "direction"].map(|driver| curve(machine, axis, outlets.clone(), ends, driver)));
            for tests in &postures {
                let mut family = curve(machine, axis, outlets.clone(), ends, "position");
                family.grid.iter_mut().for_each(|effect| effect.tests = Some(tests.clone()));
                list.push(family);
            }
        }
    }
    for (axis, ends) in seen.moving(AxisKind::Linear) {
        let beside = beside_own(machine, axis).map(|component| motion(axis, &[component]));
        for outlets in beside.into_iter().chain([vec![Outlet::own(machine, axis)]]) {
            // the axis under test is a rotary one as a rule, slides follow it
            let slide = |driver| curve(machine, axis, outlets.clone(), ends, driver).ranked(1);
            list.extend(["position", "direction"].map(slide));
        }
    }
    list.extend(own_in_every_run(seen));
    list.extend(of_the_gauge(seen));
    list.extend(over_session(seen));
    list
}

/// Splines of a curve over the time of a session.
const SPLINES_OF_SESSION: f64 = 10.0;

/// Splines of a curve that an axis follows in one run.
const SPLINES_OF_RUN: f64 = 6.0;

/// Curves over the positions of an axis that are others in every run: what does not repeat.
fn own_in_every_run(seen: &Observations) -> Vec<CandidateFamily> {
    let machine = seen.machine();
    let of = |kind: AxisKind| seen.moving(kind).collect::<Vec<_>>();
    let mut list = Vec::new();
    for (axis, ends) in of(AxisKind::Rotary).into_iter().chain(of(AxisKind::Linear)) {
        let d = directions(machine, axis);
        let own = vec![Outlet::own(machine, axis)];
        let outlets = match machine.axes[axis].kind {
            AxisKind::Rotary => vec![own, motion(axis, &[d.along]), motion(axis, &d.across)],
            AxisKind::Linear => vec![own],
        };
        let rank = usize::from(machine.axes[axis].kind == AxisKind::Linear);
        list.extend(outlets.into_iter().map(|outlets| {
            let family = curve(machine, axis, outlets, ends, "position").by_test(seen.tests_moving(axis));
            let mut family = family.ranked(rank).only_as_rival();
            family.grid.iter_mut().for_each(|effect| effect.set("count", ParameterValue::Number(SPLINES_OF_RUN)));
            family
        }));
    }
    list
}

/// Curves over the positions of a rotary axis in the readings themselves, repeating or of every run its own: what gauge and cups do
/// as the bar turns in them.
fn of_the_gauge(seen: &Observations) -> Vec<CandidateFamily> {
    let machine = seen.machine();
    let of_axis = |(axis, ends): (usize, (f64, f64))| {
        let at_bar = |driver: &str, splines: f64| {
            let mut family = curve(machine, axis, vec![Outlet::Reading], ends, driver);
            family.place = Place::Bar;
            for effect in &mut family.grid {
                effect.place = Place::Bar;
                effect.set("of", ParameterValue::Word(machine.axes[axis].name.clone()));
                effect.set("count", ParameterValue::Number(splines));
            }
            family
        };
        let repeating = ["position", "direction"].map(|driver| at_bar(driver, SPLINES));
        let of_runs = at_bar("position", SPLINES_OF_RUN).by_test(seen.tests_moving(axis));
        repeating.into_iter().chain([of_runs])
    };
    let of_axes = seen.moving(AxisKind::Rotary).flat_map(of_axis);
    of_axes.chain(of_run_and_elevation(seen)).map(CandidateFamily::only_as_rival).collect()
}

/// Elevations of the bar over a session, deg, from which a curve over them is tried.
const LEAST_ELEVATIONS: f64 = 10.0;

/// Curves of the reading over the time since a recording began, and over the elevation of the bar.
fn of_run_and_elevation(seen: &Observations) -> Vec<CandidateFamily> {
    let context = seen.context;
    if !context.has_sweeps() || context.session().has_parts() {
        return Vec::new();
    }
    let tests = || 0..context.tests();
    let length_s = |test: usize| context.ends_at_s(test) - context.session().tests[test].started_at_s;
    let longest_s = tests().map(length_s).fold(0.0, f64::max);
    let elevations = tests().flat_map(|test| elevations_deg(context, test));
    let (low, high) = elevations.fold((f64::MAX, f64::MIN), |(low, high), at| (low.min(at), high.max(at)));
    let over = |driver: &str, ends: (f64, f64)| without_axis((Place::Bar, vec![Outlet::Reading]), driver, ends);
    let run = (longest_s > 0.0).then(|| over(RUN, (0.0, longest_s)));
    let elevation = (high - low > LEAST_ELEVATIONS).then(|| over(ELEVATION, (low, high)));
    run.into_iter().chain(elevation).collect()
}

/// Curves over the time of the session, where something may have moved or grown in a way that no form describes.
fn over_session(seen: &Observations) -> Vec<CandidateFamily> {
    let (machine, context) = (seen.machine(), seen.context);
    let begins_s = context.session().tests.iter().map(|test| test.started_at_s).fold(f64::MAX, f64::min);
    let ends_s = seen.latest_s();
    if ends_s <= begins_s {
        return Vec::new();
    }
    let over_time = |moved: (Place, Vec<Outlet>)| without_axis(moved, TIME, (begins_s, ends_s)).only_as_rival();
    let of_axis = |axis: usize| {
        let d = directions(machine, axis);
        let outlets = match machine.axes[axis].kind {
            AxisKind::Rotary => vec![motion(axis, &d.across), motion(axis, &[d.along])],
            AxisKind::Linear => vec![vec![Outlet::own(machine, axis)]],
        };
        outlets.into_iter().map(move |outlets| (Place::Axis(axis), outlets)).collect::<Vec<_>>()
    };
    let bar = (Place::Bar, vec![Outlet::Reading]);
    (0..machine.axes.len()).flat_map(of_axis).chain([bar]).map(over_time).collect()
}

/// Free curve over a driver that no axis has.
fn without_axis((place, outlets): (Place, Vec<Outlet>), driver: &str, (from, to): (f64, f64)) -> CandidateFamily {
    let effect = with_word(UNKNOWN.name, place, "driver", driver)
        .with("from", ParameterValue::Number(from))
        .with("to", ParameterValue::Number(to))
        .with("count", ParameterValue::Number(SPLINES_OF_SESSION));
    CandidateFamily::new(UNKNOWN.name, place, outlets, PLAUSIBLE).over(vec![effect])
}

/// Free curve over the positions of an axis.
fn curve(
    machine: &Machine,
    axis: usize,
    outlets: Vec<Outlet>,
    (from, to): (f64, f64),
    driver: &str,
) -> CandidateFamily {
    let (place, kind) = (Place::Axis(axis), machine.axes[axis].kind);
    let effect = with_word(UNKNOWN.name, place, "driver", driver)
        .with("from", ParameterValue::Number(kind.to_file_unit(from)))
        .with("to", ParameterValue::Number(kind.to_file_unit(to)))
        .with("count", ParameterValue::Number(SPLINES));
    CandidateFamily::new(UNKNOWN.name, place, outlets, PLAUSIBLE).over(vec![effect])
}

/// Positions of a standing rotary axis closer than this are one posture, rad.
const SAME_POSTURE_RAD: f64 = 0.02;

/// Tests that a posture needs: one alone has no repeat.
const POSTURE_TESTS: usize = 2;

/// Names of the tests of an axis in which another rotary axis stands where it stands in fewer than half of them: what a cable, a load or a
/// table of the control does to an axis may hang on where another one stands.
fn postures(seen: &Observations, axis: usize) -> Vec<Vec<String>> {
    let (context, session) = (seen.context, seen.context.session());
    let swept: Vec<usize> = (0..context.tests()).filter(|&test| context.motion(test).moving.contains(&axis)).collect();
    let mut list = Vec::new();
    for other in seen.axes(AxisKind::Rotary).filter(|&other| other != axis) {
        let mut groups: Vec<(f64, Vec<usize>)> = Vec::new();
        for &test in &swept {
            let motion = context.motion(test);
            if motion.moving.contains(&other) || motion.rows() == 0 {
                continue;
            }
            let at = motion.row(0)[other];
            match groups.iter_mut().find(|(place, _)| (place - at).abs() < SAME_POSTURE_RAD) {
                Some((_, tests)) => tests.push(test),
                None => groups.push((at, vec![test])),
            }
        }
        let few = groups.into_iter().map(|(_, tests)| tests);
        let few = few.filter(|tests| tests.len() >= POSTURE_TESTS && 2 * tests.len() < swept.len());
        for tests in few {
            let names = tests.iter().map(|&test| session.tests[test].name.clone()).collect();
            if !list.contains(&names) {
                list.push(names);
            }
        }
    }
    list
}
