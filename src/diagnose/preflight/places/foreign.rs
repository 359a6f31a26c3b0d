//! Recordings that do not belong to the others of their session. Whether they do is for others to judge.

use super::ball_places::End;
use super::misplaced::names;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::SESSION;
use crate::diagnose::preflight::suspicion::Suspicion;
use crate::session::Session;

/// Spread of the balls of a test that does not belong to the others, mm, where they were set up anew: cups are set to some tenths.
pub(super) const FOREIGN_MM: f64 = 0.5;

/// One test, or one with its repeats, with balls of its own, beside others from the same pivot. Physics could do that only by a ball that
/// jumps away and exactly back, for the first or last tests by one jump. The balls lie as near to their places as others of the session, or anywhere that a cup is put.
pub(crate) fn foreign(session: &Session, tests: &[usize]) -> Vec<Suspicion> {
    let Some(&first) = tests.first() else { return Vec::new() };
    let pivot = &session.tests[first].pivot;
    if !(0..session.tests.len()).any(|test| session.tests[test].pivot == *pivot && !tests.contains(&test)) {
        return Vec::new();
    }
    let names = names(session, tests);
    let (belong, one) = if tests.len() > 1 { ("do not belong", "files") } else { ("does not belong", "a file") };
    let says = format!(
        "{} {belong} to the other tests: {one} of another session or machine, or the balls were mounted anew; name the right file, or \
         state 'setup: second' of the balls",
        names.join(", ")
    );
    let with_balls = |spread_mm: Option<f64>| {
        let mut undone = session.clone();
        for &test in tests {
            for end in [End::Pivot, End::Spindle] {
                end.mount_anew(&mut undone.tests[test], "not of the others".into(), spread_mm);
            }
        }
        let found = Suspicion::new(FaultKind::ForeignFile, SESSION, names.clone(), says.clone(), undone);
        Suspicion { is_found: spread_mm.is_some(), ..found }
    };
    [None, Some(FOREIGN_MM)].map(with_balls).to_vec()
}
