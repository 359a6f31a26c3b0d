//! Recordings that stand in each other's tests: pairs, and whole rows of files moved by one. Whether they do is for others to judge.

use crate::chain::{Chain, Geometry};
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::SESSION;
use crate::diagnose::preflight::suspicion::{Detail, Suspicion};
use crate::session::{Motion, Session, Test};

/// Pairs that are tried by a refit.
const MOST_PAIRS: usize = 12;

/// A session in which some tests have each other's recordings: `from[k]` is the test whose recording test k gets.
fn with_recordings(session: &Session, from: &[usize], says: String) -> Suspicion {
    let mut undone = session.clone();
    let mut tests = Vec::new();
    for (index, &other) in from.iter().enumerate().filter(|(index, other)| index != *other) {
        undone.tests[index].recording = session.tests[other].recording.clone();
        tests.push(session.tests[index].name.clone());
    }
    Suspicion::new(FaultKind::FilesExchanged, SESSION, tests, says, undone)
}

fn exchanged(session: &Session, one: usize, other: usize) -> Suspicion {
    let mut from: Vec<usize> = (0..session.tests.len()).collect();
    from.swap(one, other);
    let names = (&session.tests[one].name, &session.tests[other].name);
    let says = format!("the recordings of {} and {} are exchanged: swap the files of these tests", names.0, names.1);
    with_recordings(session, &from, says)
}

/// Whether two recordings may have changed places: the same columns in both, and other balls, bars or standing axes.
fn may_be_exchanged(session: &Session, one: usize, other: usize) -> bool {
    let (Some(a), Some(b)) = (&session.tests[one].recording, &session.tests[other].recording) else { return false };
    let bars = [one, other].map(|test| session.tests[test].bar_length_mm);
    a.axes == b.axes && bars[0] == bars[1] && !session.tests[one].is_repeat_of(&session.tests[other])
}

/// Pairs with one of the tests that fit worst.
pub(crate) fn with_worst(session: &Session, worst: &[usize]) -> Vec<Suspicion> {
    let chain = Chain::of(&session.machine);
    let geometry = Geometry::nominal(&chain);
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (place, &one) in worst.iter().enumerate() {
        let others = (0..session.tests.len()).filter(|other| !worst[..=place].contains(other));
        for other in others.filter(|&other| may_be_exchanged(session, one, other)) {
            pairs.extend(gain_mm(session, &geometry, one, other).map(|gain| (gain, one, other)));
        }
    }
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
    pairs.into_iter().take(MOST_PAIRS).map(|(_, one, other)| exchanged(session, one, other)).collect()
}

/// Whole programs exchanged with those of the tests that fit worst: all directions and repeats of one setup with those of
/// another, in the order of the session.
pub(crate) fn programs(session: &Session, groups: &[Vec<usize>]) -> Vec<Suspicion> {
    let mut list = Vec::new();
    let mut tried: Vec<(usize, usize)> = Vec::new();
    for own in groups.iter().filter(|own| own.len() > 1) {
        for first in (0..session.tests.len()).filter(|first| !own.contains(first)) {
            let other = repeats(session, first);
            let key = (own[0].min(first), own[0].max(first));
            let fits =
                other.first() == Some(&first) && other.len() == own.len() && may_be_exchanged(session, own[0], first);
            if !fits || tried.contains(&key) || list.len() >= MOST_PAIRS {
                continue;
            }
            tried.push(key);
            let mut from: Vec<usize> = (0..session.tests.len()).collect();
            own.iter().zip(&other).for_each(|(&one, &other)| from.swap(one, other));
            let says = format!(
                "the recordings of {} and {} are exchanged, each with its repeats: swap the files of these tests",
                session.tests[own[0]].name, session.tests[first].name
            );
            list.push(with_recordings(session, &from, says));
        }
    }
    list
}

/// A test with its other directions and repeats: those of the same setup.
pub(crate) fn repeats(session: &Session, test: usize) -> Vec<usize> {
    (0..session.tests.len()).filter(|&other| session.tests[test].is_repeat_of(&session.tests[other])).collect()
}

/// What an exchange takes off the misfit of two tests by the nominal machine, mm.
fn gain_mm(session: &Session, geometry: &Geometry, one: usize, other: usize) -> Option<f64> {
    let miss = |test: usize, recording: usize| miss_mm(session, geometry, &session.tests[test], recording);
    Some(miss(one, one)?.hypot(miss(other, other)?) - miss(one, other)?.hypot(miss(other, one)?))
}

/// Pairs that fit each other's tests better by the nominal machine, and all files moved by one test.
pub(crate) fn by_nominal(session: &Session) -> Vec<Suspicion> {
    let chain = Chain::of(&session.machine);
    let geometry = Geometry::nominal(&chain);
    let count = session.tests.len();
    if count > MOST_TESTS {
        return Vec::new();
    }
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for one in 0..count {
        for other in one + 1..count {
            if may_be_exchanged(session, one, other) {
                pairs.extend(gain_mm(session, &geometry, one, other).map(|gain| (gain, one, other)));
            }
        }
    }
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
    let better = pairs.into_iter().filter(|(gain, ..)| *gain > 0.0).take(MOST_PAIRS);
    let mut list: Vec<Suspicion> = better.map(|(_, one, other)| exchanged(session, one, other)).collect();
    list.extend(moved_by_one(session));
    list
}

/// Sessions with more tests than this are not searched for pairs: their number grows with the square.
const MOST_TESTS: usize = 200;

/// Every test with the recording of the next one, or of the one before.
fn moved_by_one(session: &Session) -> Vec<Suspicion> {
    let count = session.tests.len();
    if count < 3 {
        return Vec::new();
    }
    let moved = |by: usize, words: &'static str| {
        let from: Vec<usize> = (0..count).map(|test| (test + by) % count).collect();
        let says = format!("every test has the recording of the one {words} it: move the files by one test");
        let mut suspicion = with_recordings(session, &from, says);
        (suspicion.tests, suspicion.detail) = (Vec::new(), Detail::Way(words));
        suspicion
    };
    vec![moved(1, "before"), moved(count - 1, "after")]
}

/// Root mean square of a recording minus what the nominal machine reads in a test, mm; `None` where it cannot belong there.
fn miss_mm(session: &Session, geometry: &Geometry, test: &Test, recording: usize) -> Option<f64> {
    let mut test = test.clone();
    test.recording = session.tests[recording].recording.clone();
    let motion = Motion::of(session, geometry.chain(), &test).ok()?;
    let links = test.links(geometry.chain()).ok()?;
    let (mut sum, mut count) = (0.0, 0usize);
    for (row, length) in test.recording.as_ref()?.length_mm.iter().enumerate().filter(|(_, l)| l.is_finite()) {
        let miss = length - test.bar_error_mm - test.bar(geometry, links, motion.row(row)).norm();
        (sum, count) = (sum + miss * miss, count + 1);
    }
    (count > 0).then(|| (sum / count as f64).sqrt())
}
