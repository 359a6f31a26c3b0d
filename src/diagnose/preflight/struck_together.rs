//! Groups of tests that one mistake may strike together: recorded in one piece, written by one conversion, of one bar. It knows no mistake.

use super::places::exchanged::repeats;
use crate::session::{Session, Setups};

/// Groups of tests, by index, of a session; where several but not all have something in common.
pub(super) struct StruckTogether {
    /// Each of the tests that fit worst: of others alone the refits are not worth their time.
    pub(super) alone: Vec<Vec<usize>>,
    /// One run there and back of a program that was repeated, among the tests that fit worst: what a gauge records in one piece.
    pub(super) runs: Vec<Vec<usize>>,
    /// The programs of the tests that fit worst: each with its other directions and repeats.
    pub(super) programs: Vec<Vec<usize>>,
    /// Tests with the same columns: they come out of one conversion.
    pub(super) conversions: Vec<Vec<usize>>,
    /// Of these, the tests that go one way.
    pub(super) conversions_one_way: Vec<Vec<usize>>,
    /// Of all tests, those that go one way.
    pub(super) all_one_way: Vec<Vec<usize>>,
    /// Tests with the same bar.
    pub(super) bars: Vec<Vec<usize>>,
}

impl StruckTogether {
    /// Of a session, in which these tests fit worst.
    pub(super) fn of(session: &Session, worst: &[usize]) -> StruckTogether {
        let programs = worst_programs(session, worst);
        let conversions = conversions(session);
        StruckTogether {
            alone: worst.iter().map(|&test| vec![test]).collect(),
            runs: there_and_back(session, &programs, worst),
            programs,
            conversions_one_way: of_one_way(session, &conversions),
            conversions,
            all_one_way: of_one_way(session, &[all(session)]),
            bars: bars(session),
        }
    }

    /// What was recorded in one piece: tests alone, one run of a program, a program with all its runs.
    pub(super) fn pieces(&self) -> Vec<Vec<usize>> {
        distinct([&self.alone, &self.runs, &self.programs])
    }
}

/// All tests of a session.
pub(super) fn all(session: &Session) -> Vec<usize> {
    (0..session.tests.len()).collect()
}

/// Two of some tests, of different programs: what may have been put beside the others for both.
pub(super) fn of_two_programs(session: &Session, tests: &[usize]) -> Vec<Vec<usize>> {
    let pairs = tests.iter().enumerate().flat_map(|(k, &one)| tests[k + 1..].iter().map(move |&other| [one, other]));
    let of_two = pairs.filter(|&[one, other]| !session.tests[one].is_repeat_of(&session.tests[other]));
    of_two.map(|[one, other]| vec![one.min(other), one.max(other)]).collect()
}

/// Groups of tests, each once.
pub(super) fn distinct<const N: usize>(of: [&[Vec<usize>]; N]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for group in of.into_iter().flatten() {
        if !groups.contains(group) {
            groups.push(group.clone());
        }
    }
    groups
}

/// Whether a group has several tests of a session, but not all.
fn is_part(group: &[usize], session: &Session) -> bool {
    (2..session.tests.len()).contains(&group.len())
}

/// Of groups of tests, those that go one way: by the axis that turns round least, for slides that follow a rotary axis go there and back.
fn of_one_way(session: &Session, groups: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let goes = |column: &Vec<f64>| -> f64 {
        let (low, high) = column.iter().fold((f64::MAX, f64::MIN), |(low, high), q| (low.min(*q), high.max(*q)));
        let whole = column.last().zip(column.first()).map_or(0.0, |(last, first)| last - first);
        if high > low { whole / (high - low) } else { 0.0 }
    };
    let rises = |test: &usize| {
        let columns = session.tests[*test].recording.iter().flat_map(|recording| &recording.positions);
        let ways = columns.map(goes);
        ways.max_by(|one, other| one.abs().total_cmp(&other.abs())).is_some_and(|way| way > 0.0)
    };
    let ways = groups.iter().flat_map(|tests| {
        let (rising, falling): (Vec<usize>, Vec<usize>) = tests.iter().copied().partition(rises);
        [rising, falling]
    });
    ways.filter(|way| is_part(way, session)).collect()
}

fn conversions(session: &Session) -> Vec<Vec<usize>> {
    let moving = |test: usize| session.tests[test].recording.as_ref().map(|recording| &recording.axes);
    let with = |first: usize| -> Vec<usize> {
        (0..session.tests.len()).filter(|&test| moving(test) == moving(first)).collect()
    };
    let is_first = |first: &usize| (0..*first).all(|before| moving(before) != moving(*first));
    let firsts = (0..session.tests.len()).filter(is_first);
    firsts.map(with).filter(|group| is_part(group, session)).collect()
}

fn bars(session: &Session) -> Vec<Vec<usize>> {
    let bar_of = Setups::of(session).bar_of;
    let bars = 0..bar_of.iter().flatten().max().map_or(0, |last| last + 1);
    let with = |bar: usize| (0..bar_of.len()).filter(|&test| bar_of[test] == Some(bar)).collect::<Vec<usize>>();
    bars.map(with).filter(|group| is_part(group, session)).collect()
}

fn there_and_back(session: &Session, programs: &[Vec<usize>], worst: &[usize]) -> Vec<Vec<usize>> {
    let mut runs: Vec<Vec<usize>> = Vec::new();
    for program in programs.iter().filter(|program| program.len() > 2) {
        let mut ways = of_one_way(session, std::slice::from_ref(program));
        let start = |test: &usize| session.tests[*test].started_at_s;
        ways.iter_mut().for_each(|way| way.sort_by(|one, other| start(one).total_cmp(&start(other))));
        let [rising, falling] = &ways[..] else { continue };
        let pairs = rising.iter().zip(falling).map(|(&one, &other)| vec![one.min(other), one.max(other)]);
        runs.extend(pairs.filter(|pair| pair.iter().any(|test| worst.contains(test))));
    }
    runs
}

fn worst_programs(session: &Session, worst: &[usize]) -> Vec<Vec<usize>> {
    let programs: Vec<Vec<usize>> = worst.iter().map(|&test| repeats(session, test)).collect();
    distinct([&programs])
}
