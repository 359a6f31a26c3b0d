//! Recordings that run against the direction that their names say: counter-clockwise (ccw) is increasing axis position.

use crate::diagnose::preflight::data_fault::{DataFault, RECORDER, listed};
use crate::machine::AxisKind;
use crate::session::{Session, Test};

/// Sweeps of one rotary axis that run clockwise under the name ccw, or the other way round.
pub(super) fn against_its_name(session: &Session) -> Option<DataFault> {
    let is_against = |test: &&Test| {
        let (Some(says), Some(rises)) = (says_rising(test), rises(session, test)) else { return false };
        says != rises
    };
    let names: Vec<String> = session.tests.iter().filter(is_against).map(|test| test.name.clone()).collect();
    let says = format!(
        "the positions of {} run against the direction in the name (ccw is increasing position): files of the two directions are exchanged, or the names are; put the right recording to each test, or rename the tests",
        listed(&names)
    );
    (!names.is_empty()).then(|| DataFault::seen("direction", RECORDER, names, says))
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

/// Whether the one rotary axis that moves rises all the way; `None` where it does not run one way.
fn rises(session: &Session, test: &Test) -> Option<bool> {
    let recording = test.recording.as_ref().filter(|recording| recording.time_s().is_some())?;
    let is_rotary = |(axis, _): &(&usize, &Vec<f64>)| session.machine.axes[**axis].kind == AxisKind::Rotary;
    let moves = |column: &&Vec<f64>| column.windows(2).any(|pair| pair[0] != pair[1]);
    let columns = recording.axes.iter().zip(&recording.positions).filter(is_rotary).map(|(_, column)| column);
    let mut turning = columns.filter(moves);
    let column = turning.next().filter(|_| turning.next().is_none())?;
    let rises = column.last() > column.first();
    column.windows(2).all(|pair| (pair[1] >= pair[0]) == rises || pair[1] == pair[0]).then_some(rises)
}
