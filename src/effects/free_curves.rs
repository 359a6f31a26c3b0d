//! Free curves as candidates of a search: over which drivers, at which places, in which tests. What a curve is, `unknown` says.

use super::candidates::{CandidateFamily, Observations, beside_own, directions, motion, with_word};
use super::curve_driver::{ELEVATION, RUN, TIME, elevations_deg};
use crate::machine::{AxisKind, Machine, Outlet, ParameterValue, Place};

/// Name of the effect that is a free curve.
pub(super) const FREE_CURVE: &str = "unknown";

/// Heights of splines up to this are plausible, µm or arcsec.
const PLAUSIBLE: f64 = 30.0;

/// Splines of a free curve over an axis.
const SPLINES: f64 = 14.0;

/// Free curves over positions, for what has no form in the catalogue; of rotary axes also in single postures of the others.
pub(super) fn free_curves(seen: &Observations) -> Vec<CandidateFamily> {
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
    let effect = with_word(FREE_CURVE, place, "driver", driver)
        .with("from", ParameterValue::Number(from))
        .with("to", ParameterValue::Number(to))
        .with("count", ParameterValue::Number(SPLINES_OF_SESSION));
    CandidateFamily::new(FREE_CURVE, place, outlets, PLAUSIBLE).over(vec![effect])
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
    let effect = with_word(FREE_CURVE, place, "driver", driver)
        .with("from", ParameterValue::Number(kind.to_file_unit(from)))
        .with("to", ParameterValue::Number(kind.to_file_unit(to)))
        .with("count", ParameterValue::Number(SPLINES));
    CandidateFamily::new(FREE_CURVE, place, outlets, PLAUSIBLE).over(vec![effect])
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
