//! Which readings are left out of a fit, judged on residuals of a robust fit and never on raw lengths.

use crate::identify::model::problem::Problem;
use crate::readings::NOISE_CLASSES;
use crate::statistics::{median, robust_sigma};

/// A reading this many robust sigmas from its neighbours' trend is left out of a sweep.
const SWEEP_LIMIT: f64 = 8.0;
/// A static pose this many robust sigmas from the model is left out: only readings of another ball or a lost beam are so
/// far off; an arm whose physics is not all modelled has poses at seven sigmas that are no outliers.
const POSE_LIMIT: f64 = 20.0;
/// Neighbours on each side that make the trend of a sweep.
const NEIGHBOURS: usize = 3;

/// Rows that are kept, by test: they have a reading and are no gross outlier.
pub fn kept_rows(problem: &Problem, residual_mm: &[Vec<f64>]) -> Vec<Vec<bool>> {
    let poses: Vec<bool> = problem.tests.iter().map(|test| test.motion.time_s.is_none()).collect();
    let class: Vec<usize> = problem.session.tests.iter().map(|test| test.reading.noise_class()).collect();
    let pose_sigma = |wanted: usize| {
        let of_class = (0..poses.len()).filter(|&test| poses[test] && class[test] == wanted);
        robust_sigma(of_class.flat_map(|test| &residual_mm[test]).copied())
    };
    let limits: Vec<f64> = (0..NOISE_CLASSES).map(|wanted| POSE_LIMIT * pose_sigma(wanted)).collect();
    let tests = residual_mm.iter().enumerate();
    tests
        .map(|(test, residual)| {
            if problem.session.tests[test].reading.is_gap() {
                vec![true; residual.len()]
            } else if poses[test] {
                within(residual, limits[class[test]])
            } else {
                // steps of the recorder are no outliers
                let digit_mm = problem.session.tests[test].last_digit_mm().unwrap_or(LAST_DIGIT_MM);
                near_trend(residual, digit_mm)
            }
        })
        .collect()
}

fn within(residual: &[f64], limit: f64) -> Vec<bool> {
    residual.iter().map(|value| value.is_finite() && (limit == 0.0 || value.abs() <= limit)).collect()
}

/// Keeps the rows of a sweep, but for isolated ones that lie far off on the same side of both the rows before and after.
///
/// `digit_mm` is the last digit of the recording, mm. A step or a spike that decays over several rows lies near the rows on one of its sides and so is kept.
///
/// Rows without a reading are passed over: positions may be written more often than readings.
fn near_trend(residual: &[f64], digit_mm: f64) -> Vec<bool> {
    let finite: Vec<f64> = residual.iter().copied().filter(|value| value.is_finite()).collect();
    let mut near = near_trend_of_readings(&finite, digit_mm).into_iter();
    residual.iter().map(|value| value.is_finite() && near.next().unwrap_or(false)).collect()
}

fn near_trend_of_readings(residual: &[f64], digit_mm: f64) -> Vec<bool> {
    let off: Vec<f64> = (0..residual.len())
        .map(|row| {
            let before: Vec<f64> = residual[..row].iter().rev().take(NEIGHBOURS).copied().collect();
            let after: Vec<f64> = residual[row + 1..].iter().take(NEIGHBOURS).copied().collect();
            let (before, after) = (side_distance(residual[row], &before), side_distance(residual[row], &after));
            let sides = match (before, after) {
                (Some(before), Some(after)) => [before, after],
                (Some(one), None) | (None, Some(one)) => [one; 2],
                (None, None) => return 0.0,
            };
            if sides[0] * sides[1] > 0.0 { sides[0].abs().min(sides[1].abs()) } else { 0.0 }
        })
        .collect();
    let steps = residual.windows(2).map(|pair| pair[1] - pair[0]);
    // the difference of two readings has √2 times the white noise of one
    let sigma = (robust_sigma(steps) / std::f64::consts::SQRT_2).max(0.5 * digit_mm);
    off.iter().map(|off| *off <= SWEEP_LIMIT * sigma).collect()
}

/// Distance of a reading from the rows on one side: from their median, or from the line through the nearest two where that
/// is much nearer, so that the start of a decaying spike belongs to what follows it.
fn side_distance(value: f64, nearest_first: &[f64]) -> Option<f64> {
    let from_median = value - median(nearest_first.iter().copied())?;
    let from_line = match nearest_first {
        [first, second, ..] => value - (2.0 * first - second),
        _ => f64::NAN,
    };
    Some(if from_line.abs() < 0.5 * from_median.abs() { from_line } else { from_median })
}

/// The last digit of a recording that has more of them than are counted, mm: gauges read to 0.1 µm.
const LAST_DIGIT_MM: f64 = 1e-4;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spike_is_left_out_and_a_slope_is_not() {
        let mut residual: Vec<f64> = (0..200).map(|k| 1e-3 * f64::from(k) + 1e-4 * f64::from(k % 3)).collect();
        residual[100] += 0.5;
        residual[50] = f64::NAN;
        // a step with a decaying spike, as after a reversal
        for (since, value) in residual[120..].iter_mut().enumerate() {
            *value += 0.1 + 0.1 * (-(since as f64) / 8.0).exp();
        }
        let kept = near_trend(&residual, LAST_DIGIT_MM);
        let left_out: Vec<usize> = (0..200).filter(|&row| !kept[row]).collect();
        assert_eq!(left_out, [50, 100]);
    }

    #[test]
    fn rows_without_a_reading_are_passed_over() {
        // noise of some 0.5 µm
        let noise = |k: usize| 1e-4 * ((k * 7919) % 11) as f64;
        let every_second: Vec<f64> = (0..200).map(|k| if k % 2 == 0 { noise(k) } else { f64::NAN }).collect();
        assert_eq!(near_trend(&every_second, LAST_DIGIT_MM).iter().filter(|kept| **kept).count(), 100);
    }

    #[test]
    fn steps_of_a_recorder_are_kept_and_a_spike_is_not() {
        // a gauge that shows whole µm: most rows repeat
        let mut residual: Vec<f64> = (0..200).map(|k| if k % 17 == 3 { 1e-3 } else { 0.0 }).collect();
        residual[100] = 0.05;
        let left_out = |digit_mm| near_trend(&residual, digit_mm).iter().filter(|kept| !**kept).count();
        assert_eq!(left_out(1e-3), 1);
        assert!(left_out(LAST_DIGIT_MM) > 5);
    }
}
