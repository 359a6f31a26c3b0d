//! Readings that follow a smooth curve to their last digit, where a gauge's scatter: something drew them across a gap.

use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::{DataFault, RECORDER};
use crate::session::{Session, Test};
use crate::statistics::{OF_THIRD_DIFFERENCES, noise_of_rows, third_differences};

/// Rows that are looked at together.
const STRETCH: usize = 48;

/// By how much squares of rounding may exceed their mean in a stretch: they scatter by a third of it.
const ROUNDED: f64 = 2.0;

/// Logarithm to base ten of the chance that third differences of white noise three times as loud as rounding are as small as twice those of rounding in a
/// stretch, and its change per time that noise is louder: once in 1.3·10⁵ stretches at 3, in 2.1·10⁶ at 3.46 (simulated, 1.5·10⁸ each).
const LOG_CHANCE: f64 = -5.13;
const LOG_CHANCE_PER_TIME: f64 = -2.57;

/// Noise that is louder than rounding by less is not told from it.
const LOUDER: f64 = 3.0;

/// Chance from which a stretch was drawn, to base ten: a long session has some 3·10⁴ rows.
const LEAST_LOG_CHANCE: f64 = -7.5;

/// Variance of rounding to whole steps.
const OF_ROUNDING: f64 = 1.0 / 12.0;

/// A recording part of which was drawn.
pub(super) fn drawn(session: &Session) -> Option<DataFault> {
    session.tests.iter().find_map(|test| {
        let (from, to, noise_mm) = drawn_rows(test)?;
        let says = format!(
            "readings {} to {} of {} follow a smooth curve to the last digit, where others scatter by {:.2} µm: they were drawn across a \
             gap; export the readings as the gauge took them, or leave these rows without a reading",
            from + 1,
            to + 1,
            test.name,
            1e3 * noise_mm
        );
        Some(DataFault::seen(FaultKind::ReadingsProcessed, RECORDER, vec![test.name.clone()], says))
    })
}

/// First and last of the longest stretch of readings that scatter no more than by rounding, and the noise of the others, mm.
fn drawn_rows(test: &Test) -> Option<(usize, usize, f64)> {
    let recording = test.recording.as_ref().filter(|recording| recording.time_s().is_some())?;
    let lengths_mm = &recording.length_mm;
    let steps = lengths_mm.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 0.0);
    let step_mm = steps.fold(f64::INFINITY, f64::min);
    let limit = ROUNDED * OF_THIRD_DIFFERENCES * OF_ROUNDING * step_mm.powi(2);
    let squares: Vec<f64> = third_differences(lengths_mm).map(|third| third.powi(2)).collect();
    // a reading that is missing ends a stretch: no sum with it is small
    let is_smooth: Vec<bool> =
        squares.windows(STRETCH).map(|squares| squares.iter().sum::<f64>() <= STRETCH as f64 * limit).collect();
    let (from, count) = longest_run(&is_smooth, |smooth| smooth);
    let last = from + count + STRETCH + 1;
    let others_mm = [&lengths_mm[..from], lengths_mm.get(last + 1..).unwrap_or_default()].concat();
    let noise_mm = noise_of_rows(&others_mm);
    let louder = noise_mm / (OF_ROUNDING.sqrt() * step_mm);
    // rows beyond a stretch are as many chances less
    let stretches = (last + 1 - from) as f64 / STRETCH as f64;
    let log_chance = stretches * (LOG_CHANCE + LOG_CHANCE_PER_TIME * (louder - LOUDER));
    let is_drawn = count > 0 && louder > LOUDER && log_chance < LEAST_LOG_CHANCE;
    (others_mm.len() >= STRETCH && is_drawn).then_some((from, last, noise_mm))
}

/// Where the longest run of values begins for which something holds, and its length.
pub(super) fn longest_run<T: Copy>(values: &[T], holds: impl Fn(T) -> bool) -> (usize, usize) {
    let (mut best, mut from) = ((0, 0), 0);
    for (index, value) in values.iter().enumerate() {
        if !holds(*value) {
            from = index + 1;
        } else if index + 1 - from > best.1 {
            best = (from, index + 1 - from);
        }
    }
    best
}
