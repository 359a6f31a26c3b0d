//! How well a timing is known: what is left of the readings, the cost's curvature, and what both mean for axis positions.

use nalgebra::{DMatrix, DVector};

use super::capture::Averages;
use super::course::Course;
use super::likelihood::cost;

use super::timing::Timing;
use super::variables::{Candidate, VARIABLES, moved, units};
use crate::statistics::log_determinant;

/// Covariance of the variables in their units: twice the inverse of the cost's second derivatives, by differences whose
/// steps raise the cost by about one.
pub(super) fn covariance(course: &Course, data: &Averages, best: &Candidate) -> DMatrix<f64> {
    let units = units(course, data, best.timing.pace());
    let at = |x: &[f64; VARIABLES]| cost(course, data, &moved(course, &best.timing, &units, x), best.freedom);
    let here = at(&[0.0; VARIABLES]);
    let along = |k: usize, by: f64| -> [f64; VARIABLES] { std::array::from_fn(|i| if i == k { by } else { 0.0 }) };
    let rise = |k: usize, step: f64| 0.5 * (at(&along(k, step)) + at(&along(k, -step))) - here;
    let steps: Vec<f64> = (0..VARIABLES).map(|k| step_to_rise(|step| rise(k, step))).collect();
    let second = DMatrix::from_fn(VARIABLES, VARIABLES, |i, j| {
        let (a, b) = (steps[i], steps[j]);
        if i == j {
            return (at(&along(i, a)) - 2.0 * here + at(&along(i, -a))) / (a * a);
        }
        let both = |p: f64, q: f64| {
            let mut x = along(i, p * a);
            x[j] = q * b;
            at(&x)
        };
        (both(1.0, 1.0) - both(1.0, -1.0) - both(-1.0, 1.0) + both(-1.0, -1.0)) / (4.0 * a * b)
    });
    let curvature = 0.25 * (&second + second.transpose());
    // where rounding leaves it not positive, each variable by itself, and no better than its step
    let alone = |k: usize| curvature[(k, k)].max(1e-3 / (steps[k] * steps[k])).recip();
    curvature.clone().cholesky().map_or_else(
        || DMatrix::from_fn(VARIABLES, VARIABLES, |i, j| if i == j { alone(i) } else { 0.0 }),
        |factor| factor.inverse(),
    )
}

/// Least and greatest step of a difference, units of its variable, the first that is tried, and how many are.
const STEPS: [f64; 2] = [1e-4, 1.0];
const FIRST_STEP: f64 = 1e-2;
const MOST_STEPS: usize = 6;
/// Rises of the cost that are aimed at and that are enough, and the least that a next step is reckoned by.
const DUE: f64 = 1.5;
const ENOUGH: std::ops::Range<f64> = 0.7..2.6;
const LEAST_RISE: f64 = 1e-3;

/// A step that raises the cost by about one: near its least a cost is a parabola.
fn step_to_rise(rise: impl Fn(f64) -> f64) -> f64 {
    let mut step = FIRST_STEP;
    for _ in 0..MOST_STEPS {
        let rise = rise(step);
        if ENOUGH.contains(&rise) {
            break;
        }
        step = (step * (DUE / rise.max(LEAST_RISE)).sqrt()).clamp(STEPS[0], STEPS[1]);
    }
    step
}

/// Times in both arcs at which positions are compared.
fn times(course: &Course, timing: &Timing) -> Vec<f64> {
    const PLACES: usize = 12;
    (0..2)
        .flat_map(|direction| {
            (0..=PLACES).map(move |k| {
                let along = course.arc_s[0] + (course.arc_s[1] - course.arc_s[0]) * k as f64 / PLACES as f64;
                timing.time_at(direction, along, course.run_s)
            })
        })
        .collect()
}

/// Standard deviations of what is told of a capture.
pub(super) struct Known {
    /// Of the two starts, s, of the pace, and of the ramp's logarithm.
    pub sigma: [f64; 4],
    /// Of the path position of a reading, root mean square over both arcs, deg or mm.
    pub position_sigma: f64,
}

/// What candidates of one place tell together, about the first: by their likelihood, each over the volume in which it holds.
pub(super) fn known(course: &Course, data: &Averages, candidates: &[Candidate]) -> Known {
    let best = &candidates[0];
    let all: Vec<(f64, [f64; 5])> = candidates
        .iter()
        .map(|one| {
            let data = &data.with(one.wander);
            let covariance = covariance(course, data, one);
            let volume = covariance.clone().cholesky().map_or(0.0, |factor| log_determinant(&factor));
            (0.5 * (volume - one.cost), squares(course, data, (best, one), &covariance))
        })
        .collect();
    let most = all.iter().map(|(log_share, _)| *log_share).fold(f64::NEG_INFINITY, f64::max);
    let (mut whole, mut sums) = (0.0, [0.0; 5]);
    for (log_share, squares) in all {
        let share = (log_share - most).exp();
        whole += share;
        sums.iter_mut().zip(squares).for_each(|(sum, square)| *sum += share * square);
    }
    let [first, second, pace, ramp, position_sigma] = sums.map(|sum| (sum / whole).sqrt());
    Known { sigma: [first, second, pace, ramp], position_sigma }
}

/// Mean squares of what one candidate tells about the best: starts, pace, the ramp's logarithm, and positions.
fn squares(
    course: &Course,
    data: &Averages,
    (best, one): (&Candidate, &Candidate),
    covariance: &DMatrix<f64>,
) -> [f64; 5] {
    let units = units(course, data, one.timing.pace());
    let own = |k: usize| covariance[(k, k)].max(0.0) * units[k].powi(2);
    let start = |k: usize| own(k) + (one.timing.start_s[k] - best.timing.start_s[k]).powi(2);
    let pace = pace_variance(course, data, &one.timing, covariance) + (one.timing.pace() - best.timing.pace()).powi(2);
    let ramp = own(3) + (one.timing.ramp_s / best.timing.ramp_s).ln().powi(2);
    let position =
        position_variance(course, data, &one.timing, covariance) + apart(course, &best.timing, &one.timing).powi(2);
    [start(0), start(1), pace, ramp, position]
}

/// Variance of the pace.
fn pace_variance(course: &Course, data: &Averages, timing: &Timing, covariance: &DMatrix<f64>) -> f64 {
    let units = units(course, data, timing.pace());
    let step = 1e-4;
    let slope = DVector::from_fn(VARIABLES, |k, _| {
        let by = |sign: f64| std::array::from_fn(|i| if i == k { sign * step } else { 0.0 });
        let [up, down] = [1.0, -1.0].map(|sign| moved(course, timing, &units, &by(sign)).pace());
        (up - down) / (2.0 * step)
    });
    (slope.transpose() * covariance * &slope)[(0, 0)].max(0.0)
}

/// Mean variance of the path position over both arcs, deg² or mm².
fn position_variance(course: &Course, data: &Averages, timing: &Timing, covariance: &DMatrix<f64>) -> f64 {
    let units = units(course, data, timing.pace());
    let times = times(course, timing);
    let place = |timing: &Timing, time: f64| timing.place_s(time, course.run_s).0 * course.rate();
    let step = 1e-4;
    let mut sum = 0.0;
    for &time in &times {
        let slope = DVector::from_fn(VARIABLES, |k, _| {
            let by = |sign: f64| std::array::from_fn(|i| if i == k { sign * step } else { 0.0 });
            let [up, down] = [1.0, -1.0].map(|sign| place(&moved(course, timing, &units, &by(sign)), time));
            (up - down) / (2.0 * step)
        });
        sum += (slope.transpose() * covariance * &slope)[(0, 0)].max(0.0);
    }
    sum / times.len() as f64
}

/// Root mean square distance of two timings' positions over both arcs, deg or mm.
pub(super) fn apart(course: &Course, one: &Timing, other: &Timing) -> f64 {
    let times = times(course, one);
    let place = |timing: &Timing, time: f64| timing.place_s(time, course.run_s).0 * course.rate();
    let sum: f64 = times.iter().map(|&time| (place(one, time) - place(other, time)).powi(2)).sum();
    (sum / times.len() as f64).sqrt()
}
