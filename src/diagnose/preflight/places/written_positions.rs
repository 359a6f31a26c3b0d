//! Standing positions of an axis that were written in another unit or with the other sign, wherever it stands. Whether they were is for others to judge.

use super::misplaced::names;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::{SESSION, listed};
use crate::diagnose::preflight::suspicion::{Detail, SOMETIMES, Suspicion};
use crate::machine::AxisKind;
use crate::session::{Session, Test};

/// What a written position must be multiplied by, and the words for it.
const OF_SLIDES: [(f64, &str); 3] = [(25.4, "in inches"), (10.0, "in cm"), (-1.0, "with the other sign")];
const OF_ROTARY: [(f64, &str); 2] = [(180.0 / std::f64::consts::PI, "in radians"), (-1.0, "with the other sign")];

/// Positions of each axis that are written otherwise, in all tests in which it stands and in each of these programs.
pub(crate) fn positions_written_otherwise(session: &Session, programs: &[Vec<usize>]) -> Vec<Suspicion> {
    let mut list = Vec::new();
    for axes in axes_together(session) {
        let stands = |test: &usize| axes.iter().any(|&axis| stands_beside_zero(&session.tests[*test], axis));
        let everywhere: Vec<usize> = (0..session.tests.len()).filter(stands).collect();
        let mut groups = vec![everywhere];
        groups.extend(programs.iter().map(|tests| tests.iter().copied().filter(stands).collect()));
        groups.retain(|tests: &Vec<usize>| !tests.is_empty());
        groups.dedup();
        let ways = match session.machine.axes[axes[0]].kind {
            AxisKind::Linear => &OF_SLIDES[..],
            AxisKind::Rotary => &OF_ROTARY[..],
        };
        for tests in &groups {
            list.extend(ways.iter().filter_map(|way| written_otherwise(session, &axes, tests, *way)));
        }
    }
    list
}

/// Every axis that stands somewhere beside zero, and all of one kind together: one hand wrote them.
fn axes_together(session: &Session) -> Vec<Vec<usize>> {
    let stands = |axis: &usize| session.tests.iter().any(|test| stands_beside_zero(test, *axis));
    let of_kind = |kind: AxisKind| -> Vec<usize> { session.machine.axes_of(kind).filter(stands).collect() };
    let (linear, rotary) = (of_kind(AxisKind::Linear), of_kind(AxisKind::Rotary));
    let each = linear.iter().chain(&rotary).map(|&axis| vec![axis]);
    each.chain([&linear, &rotary].into_iter().filter(|axes| axes.len() > 1).cloned()).collect()
}

fn stands_beside_zero(test: &Test, axis: usize) -> bool {
    let moves = test.recording.as_ref().is_none_or(|recording| recording.axes.contains(&axis));
    !moves && test.positions[axis].is_some_and(|at| at != 0.0)
}

/// The session with the positions of some axes multiplied in some tests; `None` where one could not stand there.
fn written_otherwise(
    session: &Session,
    axes: &[usize],
    tests: &[usize],
    (factor, words): (f64, &'static str),
) -> Option<Suspicion> {
    let mut undone = session.clone();
    for (&test, &axis) in tests.iter().flat_map(|test| axes.iter().map(move |axis| (test, axis))) {
        if !stands_beside_zero(&session.tests[test], axis) {
            continue;
        }
        let at = undone.tests[test].positions[axis].as_mut()?;
        *at *= factor;
        if session.machine.axes[axis].range.is_some_and(|(from, to)| *at < from || *at > to) {
            return None;
        }
    }
    let named: Vec<String> = axes.iter().map(|&axis| session.machine.axes[axis].name.clone()).collect();
    let kind = if factor < 0.0 { FaultKind::StandingAxis } else { FaultKind::Unit };
    let says = format!(
        "{} in 'positions' of {}: written {words}; write them in {}{}",
        named.join(" "),
        listed(&names(session, tests)),
        session.machine.axes[axes[0]].kind.position_unit(),
        if factor < 0.0 { " with their signs turned" } else { "" }
    );
    let mut found = Suspicion::new(kind, SESSION, names(session, tests), says, undone);
    (found.components, found.detail, found.weight) = (named, Detail::Way(words), SOMETIMES);
    Some(found)
}
