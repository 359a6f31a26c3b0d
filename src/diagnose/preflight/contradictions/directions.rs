//! Recordings that run against the direction that their names say: counter-clockwise (ccw) is increasing axis position.

use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::{DataFault, RECORDER, listed};
use crate::machine::AxisKind;
use crate::session::{Session, Test};

/// A sweep of one rotary axis whose name says a direction.
struct Run<'s> {
    axis: usize,
    test: &'s str,
    is_against: bool,
    rises: bool,
}

/// Sweeps of one rotary axis that run clockwise under the name ccw, or the other way round.
///
/// Where all sweeps of an axis do, in both directions, it may be counted backwards, or its column written from the wrong end, which is
/// the same on an arc that lies alike on both sides of zero and may fit on another one; where those of every axis do, the names may follow another convention.
pub(super) fn against_its_name(session: &Session) -> Option<DataFault> {
    let runs: Vec<Run> = session.tests.iter().filter_map(|test| run(session, test)).collect();
    let names: Vec<String> = runs.iter().filter(|run| run.is_against).map(|run| run.test.to_string()).collect();
    if names.is_empty() {
        return None;
    }
    let says = format!(
        "the positions of {} run against the direction in the name (ccw is increasing position): files of the two directions are exchanged, or the names are; put the right recording to each test, or rename the tests",
        listed(&names)
    );
    let exchanged = DataFault::seen(FaultKind::Direction, RECORDER, names, says);
    let (turned, others): (Vec<&Run>, Vec<&Run>) = runs.iter().partition(|run| is_turned(&runs, run.axis));
    if turned.is_empty() || others.iter().any(|run| run.is_against) {
        return Some(exchanged);
    }
    let mut axes: Vec<usize> = turned.iter().map(|run| run.axis).collect();
    axes.sort_unstable();
    axes.dedup();
    let backwards = counted_backwards(session, &axes);
    let from_other_end = from_other_end(session, &axes).into_rival();
    let fault = match others.is_empty() {
        true => DataFault { rivals: vec![backwards.into_rival(), from_other_end], ..exchanged },
        false => DataFault { rivals: vec![exchanged.into_rival(), from_other_end], ..backwards },
    };
    Some(fault.shared_evenly())
}

/// Whether the sweeps of an axis go both ways and all of them against their names.
fn is_turned(runs: &[Run], axis: usize) -> bool {
    let own = || runs.iter().filter(|run| run.axis == axis);
    own().all(|run| run.is_against) && own().any(|run| run.rises) && own().any(|run| !run.rises)
}

/// The signs of columns turned in all recordings.
fn counted_backwards(session: &Session, axes: &[usize]) -> DataFault {
    let labels = labels(session, axes);
    let (names, is, columns) = match labels.len() {
        1 => (labels[0].clone(), "is", format!("column {}", labels[0])),
        _ => (labels.join(" and "), "are", format!("columns {}", labels.join(" and "))),
    };
    let says = format!(
        "{names} {is} counted backwards: all sweeps of {names} run against the direction in their names; turn the sign of {columns}, or set 'reversed: true'"
    );
    DataFault { components: labels, ..DataFault::seen(FaultKind::AxisSign, RECORDER, Vec::new(), says) }
}

fn labels(session: &Session, axes: &[usize]) -> Vec<String> {
    axes.iter().map(|&axis| session.machine.axes[axis].name.clone()).collect()
}

/// The columns written from the wrong end in all recordings.
fn from_other_end(session: &Session, axes: &[usize]) -> DataFault {
    let labels = labels(session, axes);
    let says = format!(
        "the column of {} is written from the wrong end in all its recordings, against the direction in their names: reverse the column",
        labels.join(" and of ")
    );
    DataFault { components: labels, ..DataFault::seen(FaultKind::AngleReversed, RECORDER, Vec::new(), says) }
}

/// What a test runs, where its name says a direction.
fn run<'s>(session: &Session, test: &'s Test) -> Option<Run<'s>> {
    let (says, (axis, rises)) = (says_rising(test)?, rises(session, test)?);
    Some(Run { axis, test: &test.name, is_against: says != rises, rises })
}

/// Whether the name of a test, or of its file where the test's says nothing, is one of rising positions.
fn says_rising(test: &Test) -> Option<bool> {
    let of = |name: &str| {
        let words: Vec<String> = name.split(|c: char| !c.is_alphanumeric()).map(str::to_lowercase).collect();
        let has = |word: &str| words.iter().any(|other| other == word);
        (has("cw") != has("ccw")).then(|| has("ccw"))
    };
    of(&test.name).or_else(|| of(test.recording_file.as_deref().unwrap_or_default()))
}

/// The one rotary axis that moves, and whether it rises all the way; `None` where it does not run one way.
fn rises(session: &Session, test: &Test) -> Option<(usize, bool)> {
    let recording = test.recording.as_ref().filter(|recording| recording.time_s().is_some())?;
    let is_rotary = |(axis, _): &(&usize, &Vec<f64>)| session.machine.axes[**axis].kind == AxisKind::Rotary;
    let moves = |column: &&Vec<f64>| column.windows(2).any(|pair| pair[0] != pair[1]);
    let columns = recording.axes.iter().zip(&recording.positions).filter(is_rotary);
    let mut turning = columns.filter(|(_, column)| moves(column));
    let (axis, column) = turning.next().filter(|_| turning.next().is_none())?;
    let rises = column.last() > column.first();
    column.windows(2).all(|pair| (pair[1] >= pair[0]) == rises || pair[1] == pair[0]).then_some((*axis, rises))
}
