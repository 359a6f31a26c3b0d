//! Positions and lengths that were paired by different clocks, or row by row from different rows on.

use super::data_fault::{RECORDER, listed};
use super::places::misplaced::names;
use super::readings::figures::Linearised;
use super::suspicion::{Detail, RARELY, Suspicion};
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::model::decimate::{Sampled, keep_few_rows};
use crate::session::{Clock, Recording, Session};

/// Positions moved against the lengths by some seconds in some tests of the thinned session.
pub(crate) fn shifted(sampled: Sampled<'_>, tests: &[usize], seconds: f64) -> Suspicion {
    let Sampled { few_rows: thinned, all_rows: session } = sampled;
    let mut undone = thinned.clone();
    for &test in tests {
        undone.tests[test].recording = session.tests[test].recording.clone();
        if let Some(recording) = &mut undone.tests[test].recording {
            shift(recording, seconds);
            keep_few_rows(recording);
        }
    }
    let names = names_of_some(session, tests);
    let says = shift_in_words(seconds, &names);
    let found = Suspicion::new(FaultKind::TimeShift, RECORDER, names, says, undone);
    let detail = Detail::sizes(&[seconds], 0.01);
    Suspicion { detail, shift_ms: Some(1e3 * seconds), is_found: true, weight: RARELY, ..found }
}

/// Names of tests, none where they are all of a session.
fn names_of_some(session: &Session, tests: &[usize]) -> Vec<String> {
    if tests.len() == session.tests.len() { Vec::new() } else { names(session, tests) }
}

/// Rows by which lengths may stand beside their positions, at most: more is no slip of a table.
const MOST_ROWS_APART: f64 = 20.0;

/// Lengths of some groups of tests that stand some rows from their positions, as many as they want: a header counted as a row, a buffer that
/// held rows back. The readings tell how many.
pub(crate) fn rows_apart(sampled: Sampled<'_>, linearised: &Linearised, groups: &[Vec<usize>]) -> Vec<Suspicion> {
    let of = |tests: &Vec<usize>| {
        let one = [linearised.figure_of(&with_rows_apart(sampled, tests, 1), tests, 1.0)?];
        let rows = linearised.fitted(&one)?.first()?.value.round();
        let is_told = rows != 0.0 && rows.abs() <= MOST_ROWS_APART;
        is_told.then(|| {
            let all = sampled.all_rows;
            let names = names_of_some(all, tests);
            // what was read at a position of later rows stands too early
            let (count, way) = (rows.abs(), if rows > 0.0 { "earlier" } else { "later" });
            let says = format!(
                "lengths stand {count:.0} {} {way} than their positions in {}: pair each length with the position at which it was read",
                if count == 1.0 { "row" } else { "rows" },
                listed(&names)
            );
            let undone = with_rows_apart(sampled, tests, rows as isize);
            let found = Suspicion::new(FaultKind::TimeShift, RECORDER, names, says, undone);
            // of tests sampled alike it is a shift in time too
            let shift_ms = common_step_s(all, tests).map(|step_s| 1e3 * rows * step_s);
            Suspicion { detail: Detail::Way("rows"), shift_ms, is_found: true, weight: RARELY, ..found }
        })
    };
    groups.iter().filter_map(of).collect()
}

/// Whether the tests of a session were sampled at different steps of time: else a shift by rows is one in time.
pub(crate) fn is_sampled_unevenly(session: &Session) -> bool {
    common_step_s(session, &(0..session.tests.len()).collect::<Vec<_>>()).is_none()
}

/// Ratio of two sampling steps from which they are two.
const UNEVEN: f64 = 1.1;

/// Step of time at which tests were sampled, s; `None` where they have several, or no times.
fn common_step_s(session: &Session, tests: &[usize]) -> Option<f64> {
    let step_s = |&test: &usize| match &session.tests[test].recording.as_ref()?.clock {
        Clock::TimeS(time) => Some((time.last()? - time.first()?) / (time.len() as f64 - 1.0)),
        _ => None,
    };
    let steps: Vec<f64> = tests.iter().filter_map(step_s).filter(|step| step.is_finite()).collect();
    let (least, most) =
        steps.iter().fold((f64::MAX, 0.0f64), |(least, most), step| (least.min(*step), most.max(*step)));
    (most > 0.0 && most <= UNEVEN * least).then(|| steps.iter().sum::<f64>() / steps.len() as f64)
}

/// The thinned session with the positions of some tests taken from so many rows later.
fn with_rows_apart(sampled: Sampled<'_>, tests: &[usize], rows: isize) -> Session {
    let Sampled { few_rows: thinned, all_rows: session } = sampled;
    let mut undone = thinned.clone();
    for &test in tests {
        undone.tests[test].recording = session.tests[test].recording.clone();
        let Some(recording) = &mut undone.tests[test].recording else { continue };
        let columns = recording.positions.clone();
        for row in 0..recording.length_mm.len() {
            match row.checked_add_signed(rows).filter(|from| *from < recording.length_mm.len()) {
                Some(from) => {
                    let of = recording.positions.iter_mut().zip(&columns);
                    of.for_each(|(column, positions)| column[row] = positions[from]);
                }
                None => recording.length_mm[row] = f64::NAN,
            }
        }
        keep_few_rows(recording);
    }
    undone
}

/// A shift of all tests (no names) or some.
pub(crate) fn shift_in_words(seconds: f64, names: &[String]) -> String {
    let which = if names.is_empty() { "all tests".to_string() } else { names.join(", ") };
    format!("lengths and positions are {seconds:.2} s apart in {which}: pair them by one clock")
}

/// Positions as they are `seconds` later; rows beyond the recording lose their reading.
fn shift(recording: &mut Recording, seconds: f64) {
    let Clock::TimeS(time) = recording.clock.clone() else { return };
    let columns = recording.positions.clone();
    for row in 0..time.len() {
        let at = time[row] + seconds;
        let above = time.partition_point(|t| *t < at);
        if above == 0 || above == time.len() {
            recording.length_mm[row] = f64::NAN;
            continue;
        }
        for (column, from) in recording.positions.iter_mut().zip(&columns) {
            column[row] = between(&time, from, above, at);
        }
    }
}

/// Rows through which positions are read between rows: a chord across an arc of 100 mm is a µm short.
const ROWS_OF_THE_POLYNOMIAL: usize = 4;

/// Position at a time between rows `above - 1` and `above`, by the polynomial through the nearest rows (Lagrange).
pub(crate) fn between(time: &[f64], position: &[f64], above: usize, at: f64) -> f64 {
    let first = above.saturating_sub(ROWS_OF_THE_POLYNOMIAL / 2).min(time.len().saturating_sub(ROWS_OF_THE_POLYNOMIAL));
    let rows = first..(first + ROWS_OF_THE_POLYNOMIAL).min(time.len());
    let weight =
        |k: usize| -> f64 { rows.clone().filter(|&j| j != k).map(|j| (at - time[j]) / (time[k] - time[j])).product() };
    rows.clone().map(|k| weight(k) * position[k]).sum()
}
