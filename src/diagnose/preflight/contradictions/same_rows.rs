//! Readings that stand in two tests: two sweeps of a real gauge never agree over many rows, for each has its own noise.

use crate::diagnose::fault_kind::FaultKind;
use crate::statistics::noise_of_rows;
use std::collections::{BTreeMap, HashMap};
use std::hash::{DefaultHasher, Hash, Hasher};

use crate::diagnose::preflight::data_fault::{DataFault, RECORDER, SESSION, listed};
use crate::session::{Ball, Session, Test};

/// Rows that are compared as one piece, and different readings in it: two sweeps with readings of 0.1 µm and as much noise
/// agree in so many rows less than once in 10¹⁰ pairs.
const PIECE: usize = 24;
const DIFFERENT: usize = 6;

/// Pieces kept of a session: beyond, only a share of them is.
const MOST_PIECES: usize = 500_000;

/// Share of the pieces of the shorter recording that another has too, from which one is a copy.
const COPIED: f64 = 0.5;

/// Third differences below this are computed and not read, mm: gauges read to 0.1 µm at best.
const COMPUTED_MM: f64 = 2e-5;

/// Tests that hold readings of one another.
pub(super) fn copied(session: &Session) -> Option<DataFault> {
    let lengths: Vec<Vec<f64>> = session.tests.iter().map(readings).collect();
    let rows: usize = lengths.iter().map(Vec::len).sum();
    let one_in = 1 + (rows / MOST_PIECES) as u64;
    let mut first: HashMap<u64, usize> = HashMap::new();
    let mut shared: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    let mut pieces = vec![0usize; lengths.len()];
    for (test, lengths) in lengths.iter().enumerate() {
        for hash in lengths.windows(PIECE).filter_map(hash_of).filter(|hash| hash % one_in == 0) {
            pieces[test] += 1;
            match first.get(&hash) {
                Some(&other) if other != test => *shared.entry((other, test)).or_default() += 1,
                Some(_) => {}
                None => drop(first.insert(hash, test)),
            }
        }
    }
    let is_copy = |&(&(one, other), &count): &(&(usize, usize), &usize)| {
        let least = pieces[one].min(pieces[other]).max(1);
        count as f64 >= COPIED * least as f64
            && (is_read(&lengths[other]) || !predicts_the_same(&session.tests[one], &session.tests[other]))
    };
    let mut tests: Vec<usize> = Vec::new();
    for (&(one, other), _) in shared.iter().filter(is_copy) {
        tests.extend([one, other]);
    }
    tests.sort_unstable();
    tests.dedup();
    let mut names: Vec<String> = tests.iter().map(|&test| session.tests[test].stated_name().to_string()).collect();
    names.dedup();
    let file = |test: usize| session.tests[test].recording_file.as_deref();
    let is_one_file = tests.windows(2).all(|pair| file(pair[0]) == file(pair[1]));
    let what = match is_one_file {
        true => "name one recording",
        false => "hold the same readings, row by row: a recording was copied",
    };
    let says = format!(
        "{} {what}; give each test its own recording, and list a recording once: counted twice it would seem more certain than it is",
        listed(&names)
    );
    (!tests.is_empty()).then(|| DataFault::seen(FaultKind::SameRecording, SESSION, names, says))
}

/// A recording whose second half is its first: a file that was added to itself; or in which every row stands twice.
pub(super) fn appended(session: &Session) -> Option<DataFault> {
    let (test, how) = session.tests.iter().find_map(|test| {
        let lengths = readings(test);
        let (first, second) = lengths.split_at(lengths.len() / 2);
        if first.len() >= PIECE && first == second && is_read(first) {
            return Some((
                test,
                "the second half holds the readings of its first half, row by row: the file was added to itself",
            ));
        }
        // of sweeps the reading may stay where a row is added: there a gauge that stuck says it
        let is_doubled = test.reading.part().is_some() && lengths.len() >= 2 * PIECE && lengths.len().is_multiple_of(2);
        let once: Vec<f64> = lengths.iter().step_by(2).copied().collect();
        let stands_twice = is_doubled && lengths.chunks(2).all(|pair| pair[0] == pair[1]) && is_read(&once);
        stands_twice
            .then_some((test, "every row stands there twice: so the readings would seem more certain than they are"))
    })?;
    let name = test.stated_name().to_string();
    let says = format!("recording of {name}: {how}; keep each row once");
    Some(DataFault::seen(FaultKind::DoubledRows, RECORDER, vec![name], says))
}

fn readings(test: &Test) -> Vec<f64> {
    let lengths = test.recording.iter().flat_map(|recording| &recording.length_mm);
    lengths.copied().filter(|length| length.is_finite()).collect()
}

/// Hash of a piece, the same forwards and backwards; `None` where hardly anything changes in it.
fn hash_of(piece: &[f64]) -> Option<u64> {
    let bits: Vec<u64> = piece.iter().map(|length| length.to_bits()).collect();
    let mut different = bits.clone();
    different.sort_unstable();
    different.dedup();
    if different.len() < DIFFERENT {
        return None;
    }
    let backwards: Vec<u64> = bits.iter().rev().copied().collect();
    let mut hasher = DefaultHasher::new();
    bits.min(backwards).hash(&mut hasher);
    Some(hasher.finish())
}

/// Whether lengths carry noise.
pub(crate) fn is_read(lengths: &[f64]) -> bool {
    noise_of_rows(lengths) > COMPUTED_MM
}

/// Whether computed lengths of two tests agree because their balls and bars do.
fn predicts_the_same(one: &Test, other: &Test) -> bool {
    let same = |a: &Ball, b: &Ball| a.link == b.link && a.at == b.at && a.indexed_about == b.indexed_about;
    same(&one.pivot, &other.pivot) && same(&one.spindle_ball, &other.spindle_ball)
}
