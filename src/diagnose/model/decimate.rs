//! Averages neighbouring rows of a session, so that slow effects can be searched quickly. It changes no positions otherwise.

use std::ops::Range;
use std::sync::Arc;

use crate::session::{Clock, Recording, Session, Test};
use crate::statistics::{mean, noise_of_rows};

/// Rows of a trace that slow effects need.
const ROWS: usize = 150;

/// Rows of a trace that show a wrong sign, name or unit.
const FEW_ROWS: usize = 60;

/// The session with rows averaged in odd groups, and the groups by test; static poses and short traces stay as they are.
pub fn thin(session: &Session, kept: &[Vec<bool>]) -> (Session, Vec<Vec<Range<usize>>>) {
    let mut thinned = session.clone();
    let mut groups = Vec::new();
    for (test, kept) in thinned.tests.iter_mut().zip(kept) {
        let rows = kept.len();
        let timed = test.recording.as_ref().is_some_and(|recording| matches!(recording.clock, Clock::TimeS(_)));
        let size = if timed { odd(rows / ROWS) } else { 1 };
        let ranges: Vec<Range<usize>> = (0..rows).step_by(size).map(|from| from..(from + size).min(rows)).collect();
        if size > 1
            && let Some(recording) = &mut test.recording
        {
            average(recording, &ranges, kept);
        }
        groups.push(ranges);
    }
    (thinned, groups)
}

pub(crate) fn odd(size: usize) -> usize {
    if size < 3 { 1 } else { size - (size + 1) % 2 }
}

/// A session with the few rows of quick fits, and with all that were read: what moves between rows is made of all of them.
#[derive(Clone, Copy)]
pub(crate) struct Sampled<'s> {
    pub(crate) few_rows: &'s Session,
    pub(crate) all_rows: &'s Session,
}

/// The session with a few rows of every trace.
pub fn few_rows(session: &Session) -> Session {
    let mut few = session.clone();
    few.tests.iter_mut().filter_map(|test| test.recording.as_mut()).for_each(keep_few_rows);
    few
}

/// Of so many rows of a trace the few that are kept, each in the middle of a group, and the size of a group.
fn few_of(rows: usize) -> (usize, Vec<usize>) {
    let size = odd(rows / FEW_ROWS);
    (size, (size / 2..rows).step_by(size).collect())
}

/// Keeps a few rows of a trace as they were read: an averaged arc would lie inside the true one.
pub fn keep_few_rows(recording: &mut Recording) {
    let Clock::TimeS(time) = &recording.clock else { return };
    let (_, rows) = few_of(time.len());
    keep_rows(recording, &rows);
}

/// Keeps some rows of a recording as they were read.
fn keep_rows(recording: &mut Recording, rows: &[usize]) {
    let pick = |column: &[f64]| -> Vec<f64> { rows.iter().map(|&row| column[row]).collect() };
    recording.clock = match &recording.clock {
        Clock::TimeS(time) => Clock::TimeS(pick(time)),
        Clock::Pose(number) => Clock::Pose(pick(number)),
        Clock::Absent => Clock::Absent,
    };
    recording.positions = recording.positions.iter().map(|column| pick(column)).collect();
    recording.channels = recording.channels.iter().map(|(name, column)| (name.clone(), pick(column))).collect();
    recording.length_mm = pick(&recording.length_mm);
    recording.leading_texts = Arc::default();
}

/// The session with every so many-th row of its points and poses, and no other recording.
pub(crate) fn every_nth_sighting(session: &Session, step: usize) -> Session {
    let mut few = session.clone();
    for test in &mut few.tests {
        let rows: Vec<usize> = (0..test.rows()).step_by(step).collect();
        if !test.is_sighted() {
            test.recording = None;
        }
        test.recording.iter_mut().for_each(|recording| keep_rows(recording, &rows));
        if let Some(part) = test.reading.part_mut().filter(|part| !part.measured.is_empty()) {
            part.measured = Arc::new(rows.iter().filter_map(|&row| part.measured.get(row).copied()).collect());
        }
    }
    few
}

/// What each of the few rows lacks to the mean of the rows around it, by test, of values over all rows; nothing where poses are static.
pub(crate) fn to_means(session: &Session, values: &[Vec<f64>], kept: &[Vec<bool>]) -> Vec<Vec<f64>> {
    let of_test = |(test, (values, kept)): (&Test, (&Vec<f64>, &Vec<bool>))| {
        let is_timed = test.recording.as_ref().is_some_and(|recording| matches!(recording.clock, Clock::TimeS(_)));
        if !is_timed {
            return vec![0.0; values.len()];
        }
        let (size, rows) = few_of(values.len());
        let noise = noise_of_rows(values);
        let lacking = rows.into_iter().map(|row| {
            let around = row - size / 2..(row + size / 2 + 1).min(values.len());
            let lacks =
                mean(around.filter(|&row| kept[row]).map(|row| values[row])).unwrap_or(values[row]) - values[row];
            // a step within the group is no noise
            if lacks.abs() < MOST_NOISE * noise { lacks } else { 0.0 }
        });
        lacking.collect()
    };
    session.tests.iter().zip(values.iter().zip(kept)).map(of_test).collect()
}

/// Standard deviations of noise beyond which a row differs from its neighbours by something else.
const MOST_NOISE: f64 = 4.0;

/// Means over the rows of each group that take part; over all of them where none does.
fn average(recording: &mut Recording, groups: &[Range<usize>], kept: &[bool]) {
    let means = |column: &[f64]| -> Vec<f64> {
        groups
            .iter()
            .map(|group| {
                let some = group.clone().any(|row| kept[row]);
                let rows = group.clone().filter(|&row| kept[row] || !some);
                let (sum, count) = rows.fold((0.0, 0usize), |(sum, count), row| (sum + column[row], count + 1));
                sum / count.max(1) as f64
            })
            .collect()
    };
    // a thermometer may be read less often than the bar
    let means_read = |column: &[f64]| -> Vec<f64> {
        groups
            .iter()
            .map(|group| {
                let read = column[group.clone()].iter().copied().filter(|value| value.is_finite());
                mean(read).unwrap_or(f64::NAN)
            })
            .collect()
    };
    if let Clock::TimeS(time) = &recording.clock {
        recording.clock = Clock::TimeS(means(time));
    }
    recording.positions = recording.positions.iter().map(|column| means(column)).collect();
    recording.channels = recording.channels.iter().map(|(name, column)| (name.clone(), means_read(column))).collect();
    recording.length_mm = means(&recording.length_mm);
    recording.leading_texts = Arc::default();
}
