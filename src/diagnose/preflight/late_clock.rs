//! Positions and lengths that were paired by different clocks.

use super::data_fault::RECORDER;
use super::suspicion::{Detail, RARELY, Suspicion};
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::model::decimate::{Sampled, keep_few_rows};
use crate::session::{Clock, Recording};

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
    let names: Vec<String> = if tests.len() == session.tests.len() {
        Vec::new()
    } else {
        tests.iter().map(|&test| session.tests[test].name.clone()).collect()
    };
    let says = shift_in_words(seconds, &names);
    let found = Suspicion::new(FaultKind::TimeShift, RECORDER, names, says, undone);
    let detail = Detail::sizes(&[seconds], 0.01);
    Suspicion { detail, shift_ms: Some(1e3 * seconds), is_found: true, weight: RARELY, ..found }
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
