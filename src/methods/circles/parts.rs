//! Least squares on circle deviations: the centred path, and the parts that make it up. Knows angles and lengths only.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::{DMatrix, DVector};

use super::deviations::CircleRun;
use crate::statistics::mean;

/// Deviations about the least-squares circle.
pub struct Centred {
    /// Radius of the least-squares circle minus nominal radius, mm.
    pub radius_mm: f64,
    /// Deviations from it, mm.
    pub deviation_mm: Vec<f64>,
}

impl Centred {
    /// Largest minus smallest deviation, mm.
    pub fn width_mm(&self) -> f64 {
        let low = self.deviation_mm.iter().copied().fold(f64::INFINITY, f64::min);
        let high = self.deviation_mm.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        high - low
    }
}

/// Paths about their common least-squares circle, `δ − r − a·cos φ − b·sin φ`.
pub fn centred(runs: &[CircleRun]) -> Centred {
    let samples: Vec<(f64, f64)> = samples(runs).map(|(angle, deviation, _)| (angle, deviation)).collect();
    let row = |angle: f64| [1.0, angle.cos(), angle.sin()];
    let solution = least_squares(samples.iter().map(|&(angle, deviation)| (row(angle).to_vec(), deviation)), 3)
        .unwrap_or_else(|| DVector::zeros(3));
    let deviation_mm = samples
        .iter()
        .map(|&(angle, deviation)| deviation - row(angle).iter().zip(solution.iter()).map(|(a, b)| a * b).sum::<f64>())
        .collect();
    Centred { radius_mm: solution[0], deviation_mm }
}

/// Parts of a path.
pub struct Parts {
    pub centre_mm: [f64; 2],
    pub radius_mm: f64,
    /// m₁ − m₂.
    pub scale_mismatch: f64,
    /// γ, rad.
    pub angle_rad: f64,
    pub ends: Vec<End>,
    /// Root mean square of what is left, all readings, mm.
    pub rms_mm: f64,
}

/// Reversal at one end of an axis.
pub struct End {
    /// 0 or 1: first or second axis of the plane.
    pub axis: usize,
    /// At the axis's positive end.
    pub positive: bool,
    /// Outward step, mm.
    pub step_mm: f64,
    /// Largest deviation just after the reversal, mm.
    pub spike_mm: f64,
}

/// Readings this far on both sides of a reversal are needed to see its step, rad.
const SIDE_RAD: f64 = 16.0 * TAU / 360.0;
/// After a reversal an axis may stick, slip and swing: these readings do not take part in the fit, rad.
const AFTER_REVERSAL_RAD: f64 = 12.0 * TAU / 360.0;
/// A reading on the reversal itself belongs to neither side: positions are printed to 1e-5 mm, rad.
const ON_REVERSAL_RAD: f64 = 1e-4;
/// Parts that are not reversals.
const SMOOTH_PARTS: usize = 5;

/// Fits the parts; `None` when the arc is too short to tell them apart.
pub fn fit_parts(runs: &[CircleRun]) -> Option<Parts> {
    let ends: Vec<usize> = (0..4).filter(|&quadrant| passes(runs, quadrant)).collect();
    let columns = SMOOTH_PARTS + ends.len();
    let row = |angle: f64, sign: f64| {
        let mut row = vec![1.0, angle.cos(), angle.sin(), (2.0 * angle).cos(), (2.0 * angle).sin()];
        row.extend(ends.iter().map(|&quadrant| {
            let opposite = (quadrant + 2) % 4;
            // an end that the arc does not pass: the axis lags there by as much as at the end that it does
            let beyond = if ends.contains(&opposite) { 0.0 } else { step(opposite, angle, sign) };
            step(quadrant, angle, sign) + beyond
        }));
        row
    };
    let undisturbed = samples(runs).filter(|&(angle, _, sign)| {
        ends.iter().all(|&quadrant| since_reversal(quadrant, angle, sign) > AFTER_REVERSAL_RAD)
    });
    let solution = least_squares(undisturbed.map(|(angle, deviation, sign)| (row(angle, sign), deviation)), columns)?;
    let residual = |(angle, deviation, sign): (f64, f64, f64)| {
        deviation - row(angle, sign).iter().zip(solution.iter()).map(|(a, b)| a * b).sum::<f64>()
    };
    let squares: Vec<f64> = samples(runs).map(|sample| residual(sample).powi(2)).collect();
    let spike = |quadrant: usize| {
        samples(runs)
            .filter(|&(angle, _, sign)| {
                (ON_REVERSAL_RAD..=AFTER_REVERSAL_RAD).contains(&since_reversal(quadrant, angle, sign))
            })
            .map(residual)
            .fold(0.0, |largest: f64, value| if value.abs() > largest.abs() { value } else { largest })
    };
    let radius_mm = runs[0].radius_mm;
    Some(Parts {
        radius_mm: solution[0],
        centre_mm: [solution[1], solution[2]],
        scale_mismatch: 2.0 * solution[3] / radius_mm,
        angle_rad: -2.0 * solution[4] / radius_mm,
        ends: ends
            .iter()
            .enumerate()
            .map(|(index, &quadrant)| End {
                axis: quadrant % 2,
                positive: quadrant < 2,
                step_mm: solution[SMOOTH_PARTS + index],
                spike_mm: spike(quadrant),
            })
            .collect(),
        rms_mm: mean(squares.iter().copied()).unwrap_or(f64::NAN).sqrt(),
    })
}

/// Angle, deviation and direction of travel of every reading.
fn samples(runs: &[CircleRun]) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
    runs.iter().flat_map(|run| {
        run.angle_rad.iter().zip(&run.deviation_mm).map(|(&angle, &deviation)| (angle, deviation, run.direction.sign()))
    })
}

/// Angle from an axis's end: quadrant 0 is +first, 1 +second, 2 −first, 3 −second; −π to π.
fn from_end(quadrant: usize, angle: f64) -> f64 {
    let turn = (angle - quadrant as f64 * FRAC_PI_2).rem_euclid(TAU);
    if turn > TAU / 2.0 { turn - TAU } else { turn }
}

/// How far the path has run since the reversal at an end, 0 to 2π.
fn since_reversal(quadrant: usize, angle: f64, sign: f64) -> f64 {
    (sign * from_end(quadrant, angle)).rem_euclid(TAU)
}

/// Path of an axis with lost motion 1 that reverses at an end: −½ before, +½ after, fading with its share in the radius.
fn step(quadrant: usize, angle: f64, sign: f64) -> f64 {
    let from_end = from_end(quadrant, angle);
    0.5 * (sign * from_end).signum() * from_end.cos().max(0.0)
}

/// True when a run has readings on both sides of an end.
fn passes(runs: &[CircleRun], quadrant: usize) -> bool {
    runs.iter().any(|run| {
        let near = |side: f64| {
            run.angle_rad.iter().any(|&angle| {
                let from_end = side * from_end(quadrant, angle);
                from_end > 0.5 * SIDE_RAD && from_end < 1.5 * SIDE_RAD
            })
        };
        near(1.0) && near(-1.0)
    })
}

/// Solves the normal equations; `None` when they are singular.
fn least_squares(rows: impl Iterator<Item = (Vec<f64>, f64)>, columns: usize) -> Option<DVector<f64>> {
    let mut normal = DMatrix::zeros(columns, columns);
    let mut right = DVector::zeros(columns);
    for (row, value) in rows {
        let row = DVector::from_vec(row);
        normal.ger(1.0, &row, &row, 1.0);
        right.axpy(value, &row, 1.0);
    }
    let scale = normal.diagonal().max();
    let factor = normal.cholesky()?;
    // a pivot that cancels to rounding says that two parts cannot be told apart
    let smallest = factor.l_dirty().diagonal().iter().map(|pivot| pivot * pivot).fold(f64::INFINITY, f64::min);
    (smallest > 1e-9 * scale).then(|| factor.solve(&right))
}
