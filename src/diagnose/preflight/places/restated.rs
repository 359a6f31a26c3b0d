//! Sessions with one statement written otherwise that the nominal lengths allow as well: only errors of some µm tell which is true.
//!
//! A pivot at the same distance from the axis, a table that stood at another angle under it, an axis that turns about
//! another line through the ball: by the nominal machine no length changes.

use nalgebra::Vector3;

use super::ball_places::{End, NOMINAL_MM, Sights, misfit_mm, sights, written_otherwise};
use super::misplaced::{ball_words, names, told, told_sizes};
use super::standing::{groups, misfit_of_shift, stood_at};
use crate::chain::Chain;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::{SESSION, listed};
use crate::diagnose::preflight::quick_fit::nominal_mm;
use crate::diagnose::preflight::suspicion::{Detail, OFTEN, RARELY, SOMETIMES, Suspicion};
use crate::machine::AxisKind;
use crate::session::{Session, Setups};

/// Angles of a standing table that are tried: so many of a turn.
const ANGLES: i32 = 12;

/// Statements that are tried at most, those about the tests that fit worst first.
const MOST_STATEMENTS: usize = 48;

/// Statements that leave the nominal lengths as they are; those of the worst tests first.
pub(crate) fn restated(session: &Session, worst: &[usize]) -> Vec<Suspicion> {
    let chain = Chain::of(&session.machine);
    let setups = Setups::of(session);
    let mut list = directions(session);
    let mut of_tests: Vec<(bool, Suspicion)> = Vec::new();
    for (end, of) in [(End::Pivot, &setups.pivot_of), (End::Spindle, &setups.spindle_ball_of)] {
        for setup in 0..of.iter().copied().max().map_or(0, |most| most + 1) {
            let tests: Vec<usize> = (0..of.len()).filter(|&test| of[test] == setup).collect();
            let is_worst = tests.iter().any(|test| worst.contains(test));
            of_tests.extend(places(session, &chain, end, &tests).into_iter().map(|one| (is_worst, one)));
        }
    }
    for axis in session.machine.axes_of(AxisKind::Rotary) {
        for tests in groups(session, axis) {
            let is_worst = tests.iter().any(|test| worst.contains(test));
            of_tests.extend(angles(session, &chain, axis, &tests).into_iter().map(|one| (is_worst, one)));
        }
    }
    of_tests.sort_by_key(|(is_worst, _)| !is_worst);
    list.extend(of_tests.into_iter().map(|(_, one)| one));
    list.truncate(MOST_STATEMENTS);
    list
}

/// One ball with coordinates exchanged or signs turned.
fn places(session: &Session, chain: &Chain, end: End, tests: &[usize]) -> Vec<Suspicion> {
    let Some(ball) = tests.first().map(|&test| end.of(&session.tests[test])) else { return Vec::new() };
    let all: Sights =
        tests.iter().flat_map(|&test| sights(session, chain, &session.tests[test], end, &ball.link)).collect();
    let others = written_otherwise(&ball.at).into_iter().skip(1);
    others
        .filter(|(place, _)| misfit_mm(&all, place) < NOMINAL_MM)
        .map(|(place, words)| {
            let mut undone = session.clone();
            tests.iter().for_each(|&test| end.of_mut(&mut undone.tests[test]).at = place);
            let says = format!(
                "the {} stands at about {} by the lengths: {words}; correct its 'at' in {}",
                ball_words(end, ball),
                told(&place, &ball.at),
                listed(&names(session, tests))
            );
            let mut found = Suspicion::new(FaultKind::BallPlace, end.place(), names(session, tests), says, undone);
            let is_twice = words.contains("exchanged") && words.contains("turned");
            found.detail = told_sizes(&place, &ball.at);
            found.weight = if is_twice { RARELY } else { OFTEN };
            found
        })
        .collect()
}

/// A table that stood at another angle.
fn angles(session: &Session, chain: &Chain, axis: usize, tests: &[usize]) -> Vec<Suspicion> {
    let Some(miss) = misfit_of_shift(session, chain, axis, tests) else { return Vec::new() };
    let full = std::f64::consts::TAU;
    (1..ANGLES)
        .map(|k| full * f64::from(k) / f64::from(ANGLES))
        .map(|shift| if shift > 0.5 * full { shift - full } else { shift })
        .filter(|shift| miss(*shift) < NOMINAL_MM)
        .filter_map(|shift| stood_at(session, axis, tests, shift))
        .collect()
}

/// Rotary axes that turn about another direction than the machine file says, where the nominal lengths allow it.
fn directions(session: &Session) -> Vec<Suspicion> {
    let mut list = other_directions(session);
    list.retain(|one| nominal_mm(&one.undone).is_some_and(|left| left < NOMINAL_MM));
    list
}

/// Rotary axes that turn about another direction: a coordinate, or an inclined one with a sign turned.
pub(crate) fn other_directions(session: &Session) -> Vec<Suspicion> {
    let machine = &session.machine;
    let rotary = machine.axes_of(AxisKind::Rotary);
    let mut list = Vec::new();
    for axis in rotary {
        let stated = machine.axes[axis].direction;
        let coordinates = (0..3).map(|k| Vector3::ith(k, 1.0));
        let turned = (0..3).map(|k| {
            let mut turned = stated;
            turned[k] = -turned[k];
            turned
        });
        let mut tried: Vec<Vector3<f64>> = Vec::new();
        for direction in coordinates.chain(turned) {
            let is_stated = stated.dot(&direction).abs() > 1.0 - 1e-9;
            // along one line an axis may turn either way
            if is_stated || tried.iter().any(|other| other.dot(&direction) > 1.0 - 1e-9) {
                continue;
            }
            tried.push(direction);
            let mut undone = session.clone();
            undone.machine.axes[axis].direction = direction;
            let name = &machine.axes[axis].name;
            let says = format!(
                "{name} turns about {} by the lengths: correct 'direction' of {name} in the machine file",
                direction_words(&direction)
            );
            let mut found = Suspicion::new(FaultKind::AxisDirection, SESSION, Vec::new(), says, undone);
            found.components = vec![name.clone()];
            found.detail = Detail::sizes((direction / direction.amax()).as_slice(), 1e-3);
            found.weight = SOMETIMES;
            list.push(found);
        }
    }
    list
}

/// A direction as a letter, or as a machine file may write it.
fn direction_words(direction: &Vector3<f64>) -> String {
    match ["X", "Y", "Z"].into_iter().zip(direction.iter()).find(|(_, part)| part.abs() > 1.0 - 1e-9) {
        Some((letter, _)) => letter.to_string(),
        None => {
            let parts = direction.map(|part| 1e3 * part / direction.amax()).map(|part| part.round() / 1e3 + 0.0);
            format!("[{}, {}, {}]", parts.x, parts.y, parts.z)
        }
    }
}
