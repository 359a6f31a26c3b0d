//! Sessions whose readings are held the other way round, in another unit or from another zero. Which mistake was made is for others to judge.
//!
//! A gauge shows how much longer the bar is than calibrated. Files hold that deviation or the whole length; whoever converts one
//! into the other may take the wrong sign or unit, and whoever zeroes the gauge at the start of a run moves its zero.

use super::data_fault::{RECORDER, listed};
use super::places::misplaced::names;
use super::suspicion::{OFTEN, RARELY, SOMETIMES, Suspicion};
use crate::session::{LengthColumn, Session, Zero};

pub(crate) const READING_SIGN: &str = "reading-sign";
pub(crate) const READING_ZERO: &str = "reading-zero";

/// Factors that a conversion may have left on the deviations, with words.
const FACTORS: [(f64, &str); 5] = [
    (-1.0, "have the wrong sign: turn it"),
    (10.0, "are ten times too large: look at their unit"),
    (0.1, "are a tenth of what they should be: look at their unit"),
    (25.4, "are 25.4 times too large: they were converted from inches twice, or are in mm where inches are due"),
    (1.0 / 25.4, "are 25.4 times too small: they are in inches"),
];

/// Deviations of all tests, and of some groups of them, with a factor undone.
pub(crate) fn scaled(session: &Session, groups: &[Vec<usize>]) -> Vec<Suspicion> {
    let with_bar = |tests: &[usize]| tests.iter().all(|&test| session.tests[test].bar_length_mm.is_some());
    let every: Vec<usize> = (0..session.tests.len()).collect();
    let all = std::iter::once(&every).chain(groups.iter().filter(|group| group.len() < every.len()));
    let mut list = Vec::new();
    for tests in all.filter(|tests| !tests.is_empty() && with_bar(tests)) {
        let is_all = tests.len() == every.len();
        let names: Vec<String> = match is_all {
            true => Vec::new(),
            false => self::names(session, tests),
        };
        // a factor common to all changes every error and no residual in its proportion: only a sign can be told
        let factors = FACTORS.iter().filter(|(factor, _)| *factor < 0.0 || !is_all);
        list.extend(factors.map(|&(factor, words)| Suspicion {
            effect: if factor < 0.0 { READING_SIGN } else { "unit" },
            place: RECORDER.into(),
            components: vec!["length".into()],
            tests: names.clone(),
            says: format!("the deviations from the bar's length in {} {words}", listed(&names)),
            shift_ms: None,
            diminished: factor.max(1.0),
            weight: if is_all { OFTEN } else { SOMETIMES },
            undone: with_deviations(session, tests, factor.recip()),
        }));
    }
    list
}

/// The session with the deviations of some tests multiplied.
fn with_deviations(session: &Session, tests: &[usize], factor: f64) -> Session {
    let mut undone = session.clone();
    for &test in tests {
        let test = &mut undone.tests[test];
        let (Some(bar_mm), Some(recording)) = (test.bar_length_mm, &mut test.recording) else { continue };
        recording.length_mm.iter_mut().for_each(|length| *length = bar_mm + factor * (*length - bar_mm));
    }
    undone
}

/// Groups of tests in which the gauge was zeroed for itself.
pub(crate) fn zeroed(session: &Session, groups: &[Vec<usize>]) -> Vec<Suspicion> {
    let of = |tests: &Vec<usize>| {
        let names = names(session, tests);
        let mut undone = session.clone();
        for &test in tests {
            undone.tests[test].bar_setup = Some("zeroed for itself".into());
            undone.tests[test].zero = Zero::Free;
        }
        let says = format!(
            "the gauge had a zero of its own in {}: state 'bar_setup' and 'zero: free' there, and zero it once a session",
            listed(&names)
        );
        Suspicion { weight: RARELY, ..Suspicion::new(READING_ZERO, "bar", names, says, undone) }
    };
    groups.iter().filter(|group| group.len() < session.tests.len()).map(of).collect()
}

/// The session with all deviations turned, where its files hold deviations: a sign that nothing else tells.
pub(crate) fn turned(session: &Session) -> Option<Session> {
    let every: Vec<usize> = (0..session.tests.len()).collect();
    let are_deviations = session.tests.iter().all(|test| {
        let column = test.recording.as_ref().map(|recording| recording.column);
        test.bar_length_mm.is_some() && column.is_some_and(LengthColumn::is_deviation)
    });
    are_deviations.then(|| with_deviations(session, &every, -1.0))
}
