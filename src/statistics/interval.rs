//! How far apart in time the readings of each test lie, compared with those of the other tests.

use super::robust::median;

/// Steps in which intervals are told apart, per factor of two: a clock's digits make no difference, and a correlation time
/// that is off by a twelfth at most costs nothing.
const STEPS_AN_OCTAVE: f64 = 4.0;

/// Intervals between readings over that of the middle one of the tests, by test; 1 where readings have no order in time.
pub fn relative_intervals(times_s: &[Option<&[f64]>]) -> Vec<f64> {
    let octaves = |time_s: &[f64]| {
        let interval_s = median(time_s.windows(2).map(|pair| pair[1] - pair[0]))?;
        (interval_s > 0.0).then(|| (STEPS_AN_OCTAVE * interval_s.log2()).round())
    };
    let steps: Vec<Option<f64>> = times_s.iter().map(|time_s| time_s.and_then(octaves)).collect();
    let mut sorted: Vec<f64> = steps.iter().copied().flatten().collect();
    sorted.sort_by(f64::total_cmp);
    let Some(middle) = sorted.get(sorted.len().saturating_sub(1) / 2).copied() else { return vec![1.0; steps.len()] };
    steps.iter().map(|step| step.map_or(1.0, |step| ((step - middle) / STEPS_AN_OCTAVE).exp2())).collect()
}
