//! Recordings that scatter far less than the others of their session: one gauge repeats alike in all of them.

use super::same_rows::is_read;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::{DataFault, RECORDER, listed};
use crate::diagnose::preflight::readings::steps::step_of_readings;
use crate::session::{Session, Test};
use crate::statistics::{OF_THIRD_DIFFERENCES, mean, median, third_differences};
use crate::units::MM_PER_INCH;
use std::ops::Range;

/// How many times less than the middle recording one scatters that was not read like it: noise differs from test to test by a
/// factor of two (one standard deviation), this is three of them.
const QUIETER: f64 = 8.0;

/// How near to an inch the ratio of two noises comes, as a factor: noise of some hundred rows is known to a tenth.
const NEAR_AN_INCH: f64 = 1.3;

/// Recordings that scatter too little.
pub(super) fn quiet(session: &Session) -> Option<DataFault> {
    let read = session.tests.iter().filter_map(|test| Some((test, scatter_mm(test)?)));
    let scatter: Vec<(&Test, f64)> = read.collect();
    let usual_mm = median(scatter.iter().map(|(_, mm)| *mm))?;
    // what scatters by less than a digit shows where the readings cross one, and not how they scatter
    if step_of_readings(session).is_some_and(|step_mm| step_mm > usual_mm) {
        return None;
    }
    let is_read = |test: &Test| test.recording.as_ref().is_some_and(|recording| is_read(&recording.length_mm));
    // a machine that shakes in most tests makes them louder than the others, but no gauge reads finer than it resolves
    let is_quiet = |(test, mm): &&(&Test, f64)| QUIETER * mm < usual_mm && !is_read(test);
    let (struck, others): (Vec<_>, Vec<_>) = scatter.iter().partition(is_quiet);
    if struck.is_empty() || !others.iter().any(|(test, _)| is_read(test)) {
        return None;
    }
    let names: Vec<String> = struck.iter().map(|(test, _)| test.name.clone()).collect();
    let own_mm = median(struck.iter().map(|(_, mm)| *mm))?;
    let ratio = usual_mm / own_mm;
    let is_inch = (1.0 / NEAR_AN_INCH..NEAR_AN_INCH).contains(&(ratio / MM_PER_INCH));
    let of = |kind, what: &str| {
        let says = format!(
            "readings of {} scatter by {:.3} µm from row to row where those of the others scatter by {:.2} µm: {what}",
            listed(&names),
            1e3 * own_mm,
            1e3 * usual_mm
        );
        let mut fault = DataFault::seen(kind, RECORDER, names.clone(), says);
        fault.components = vec!["length".into()];
        fault
    };
    let processed =
        of(FaultKind::ReadingsProcessed, "they were divided, averaged or computed; export them as the gauge took them");
    if !is_inch {
        return Some(processed);
    }
    // a mean over 25 rows scatters as little
    let mut inches = of(FaultKind::Unit, "their deviations are in inches, or were divided by 25.4; convert them to mm");
    inches.rivals = vec![processed.into_rival()];
    Some(inches.shared_evenly())
}

/// Scatter of deviations that were read but divided since, mm: computed ones scatter by their last digit, and gauges by more.
const DIVIDED_MM: Range<f64> = 2e-6..2e-5;

/// Deviations of all recordings that scatter less than any gauge, and more than computed ones.
pub(super) fn finer_than_a_gauge(session: &Session) -> Option<DataFault> {
    let is_deviation = |test: &Test| test.recording.as_ref().is_none_or(|recording| recording.column.is_deviation());
    let own_mm = median(session.tests.iter().filter_map(scatter_mm))?;
    let says = format!(
        "deviations scatter by {:.3} µm from row to row, where gauges resolve 0.1 µm: they are in inches or another unit, or were divided or \
         averaged; convert them to the unit of their column, or export them as the gauge took them",
        1e3 * own_mm
    );
    let mut fault = DataFault::seen(FaultKind::Unit, RECORDER, Vec::new(), says);
    fault.components = vec!["length".into()];
    (DIVIDED_MM.contains(&own_mm) && session.tests.iter().all(is_deviation)).then_some(fault)
}

/// Third differences from which a recording's noise is known: neighbours share readings, so that thirty say as much as ten that
/// share none, which know it to a fifth.
const LEAST_DIFFERENCES: usize = 30;

/// Noise from row to row of a recording in time, mm; `None` where no reading differs from the others, and where they are few.
fn scatter_mm(test: &Test) -> Option<f64> {
    let recording = test.recording.as_ref().filter(|recording| recording.time_s().is_some())?;
    let third = third_differences(&recording.length_mm);
    // the largest tenth may be gross; equal readings count, which a median would take for no noise
    let mut sizes: Vec<f64> = third.filter(|third| third.is_finite()).map(f64::abs).collect();
    if sizes.len() < LEAST_DIFFERENCES {
        return None;
    }
    sizes.sort_by(f64::total_cmp);
    sizes.truncate(9 * sizes.len() / 10);
    let mean = mean(sizes.into_iter()).filter(|mean| *mean > 0.0)?;
    Some(mean / (OF_SIZES * OF_THIRD_DIFFERENCES.sqrt()))
}

/// Mean size of the lower nine tenths of normal values of one.
const OF_SIZES: f64 = 0.6573;
