//! Sweeps that were run over another arc than the session states, where recordings have no positions of their own. Whether they were
//! is for others to judge.

use super::exchanged::repeats;
use super::misplaced::names;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::{SESSION, listed};
use crate::diagnose::preflight::quick_fit::refit;
use crate::diagnose::preflight::readings::figures::Linearised;
use crate::diagnose::preflight::suspicion::{Detail, Suspicion};
use crate::diagnose::selection::shapes::judged_shape::PARAMETER_COST;
use crate::machine::AxisKind;
use crate::session::{Clock, Path, Session};

/// Angles by which a whole arc is thought to lie elsewhere at first, deg: counted from −180 or from 0.
const STARTS: [f64; 3] = [0.0, 180.0, -180.0];

/// Rounds in which the ends of an arc are fitted.
const ROUNDS: usize = 5;

/// Change of an end by which derivatives are found, and below which a fit has settled, deg.
const SMALL_DEG: f64 = 0.05;

/// Ends that are nearer than this are those stated, deg: rows are some tenths of a degree apart.
const LEAST_DEG: f64 = 0.7;

/// Sweeps of each rotary axis with other ends: in all tests without positions, and in those of one program.
pub(crate) fn other_arcs(session: &Session) -> Vec<Suspicion> {
    let rotary = session.machine.axes_of(AxisKind::Rotary);
    rotary
        .flat_map(|axis| groups(session, axis).into_iter().map(move |tests| (axis, tests)))
        .flat_map(|(axis, tests)| {
            STARTS.into_iter().filter_map(move |start| with_other_ends(session, axis, &tests, start))
        })
        .collect()
}

/// Tests that sweep an axis without positions of their own: all, and each program.
fn groups(session: &Session, axis: usize) -> Vec<Vec<usize>> {
    let sweeps = |test: &usize| {
        let test = &session.tests[*test];
        let is_without = test.recording.as_ref().is_some_and(|recording| recording.clock == Clock::Absent);
        is_without && matches!(test.path, Some(Path::Sweep { axis: swept, .. }) if swept == axis)
    };
    let every: Vec<usize> = (0..session.tests.len()).filter(sweeps).collect();
    let mut groups = vec![every.clone()];
    for &test in &every {
        let program: Vec<usize> = repeats(session, test).into_iter().filter(sweeps).collect();
        if !groups.contains(&program) {
            groups.push(program);
        }
    }
    groups.retain(|group| !group.is_empty());
    groups
}

/// The session with the lower and upper ends of some sweeps moved by so many degrees.
fn moved(session: &Session, tests: &[usize], [lower, upper]: [f64; 2]) -> Session {
    let mut moved = session.clone();
    for &test in tests {
        if let Some(Path::Sweep { from, to, .. }) = &mut moved.tests[test].path {
            let (low, high) = if from < to { (from, to) } else { (to, from) };
            (*low, *high) = (*low + lower, *high + upper);
        }
    }
    moved
}

/// The session with the ends of some sweeps where they fit best, from a start on.
fn with_other_ends(session: &Session, axis: usize, tests: &[usize], start: f64) -> Option<Suspicion> {
    let mut ends = [start; 2];
    for _ in 0..ROUNDS {
        let now = moved(session, tests, ends);
        let linearised = Linearised::of(&now, &refit(&now, None)?)?;
        let figure = |by: [f64; 2]| {
            linearised.figure_of(&moved(session, tests, [ends[0] + by[0], ends[1] + by[1]]), tests, SMALL_DEG)
        };
        let sizes = linearised.fitted(&[figure([SMALL_DEG, 0.0])?, figure([0.0, SMALL_DEG])?])?;
        let by = [sizes[0].value, sizes[1].value].map(|by| by.clamp(-MOST_STEP, MOST_STEP));
        ends = [ends[0] + by[0], ends[1] + by[1]];
        if by.iter().all(|by| by.abs() < SMALL_DEG) {
            break;
        }
    }
    let undone = moved(session, tests, ends);
    let of = |session: &Session| match session.tests[tests[0]].path {
        Some(Path::Sweep { from, to, .. }) => Some((from, to)),
        _ => None,
    };
    let (stated, found) = (of(session)?, of(&undone)?);
    if ends.iter().all(|end| end.abs() < LEAST_DEG) || (found.1 - found.0) * (stated.1 - stated.0) <= 0.0 {
        return None;
    }
    let names = names(session, tests);
    let name = &session.machine.axes[axis].name;
    let says = format!(
        "the recordings of {} have no positions and fit a sweep of {name} from about {:.1} to {:.1} and not from {} to {}: state the sweep \
         that was run, or export positions as well",
        listed(&names),
        found.0,
        found.1,
        stated.0,
        stated.1
    );
    let mut suspicion = Suspicion::new(FaultKind::Arc, SESSION, names, says, undone);
    suspicion.components = vec![name.clone()];
    suspicion.detail = Detail::sizes(&[found.0, found.1], 0.1);
    suspicion.log_figures = -2.0 * PARAMETER_COST;
    Some(suspicion)
}

/// Largest step of an end in one round, deg.
const MOST_STEP: f64 = 20.0;
