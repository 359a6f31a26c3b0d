//! Positions that scatter from row to row as no axis moves, and do not show in the readings: the even motion of the axis takes
//! their place. It knows times, positions and readings of one axis that moves alone, no geometry.
//!
//! Through the positions about a row a parabola in time is laid, `q̂`, and through all readings of the recording one smooth function of it, `f(q̂)`.
//! If the axis had been at `q`, a reading would be off from that by `x = (q − q̂)·f'(q̂)`. Readings follow by the share `β = Σ x (L − f) / Σ x²`:
//! all of it where the axis moved so, by steps, by a ripple or evenly; none where its position was read wrongly. A position with noise flattens
//! what is fitted over it (errors in variables: Fuller, Measurement Error Models, 1987).

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, DVector};

use super::recording::{Recording, Scatter};
use super::test::Test;
use crate::machine::{AxisKind, Machine};
use crate::statistics::{Local, noise_of_rows, parabolas, rms, robust_sigma, third_differences};

/// Time before and after a row over which a motion is even, s: about what an axis takes to its speed.
const EVEN_S: f64 = 0.5;
/// Share of the scatter that readings follow, with three of its standard deviations, below which it is noise: nearer to none than
/// to all.
const HALF_FOLLOWED: f64 = 0.5;
/// Third differences of positions, of the steps from row to row, up to which positions are even.
const LEAST_OF_STEP: f64 = 0.1;
/// Standard deviations of the readings beyond which a row does not count: a spike of the gauge.
const MOST_SIGMAS: f64 = 4.0;
/// Orders per turn of the smooth function of a turning axis: the form of a bearing and a surface.
const ORDERS: usize = 12;
/// Degree of the smooth function of an axis that makes no whole turn.
const DEGREE: usize = 8;
/// Fewest rows for each coefficient of it.
const ROWS_OF_COEFFICIENT: usize = 10;
/// Stretches of a recording whose scatter gives the standard deviation of the share: neighbouring rows are not independent.
const STRETCHES: usize = 20;

/// Puts the even motion in the place of positions that scatter without the readings following. Tests of one file decide together.
pub(crate) fn even_out(tests: &mut [Test], machine: &Machine) {
    for first in 0..tests.len() {
        let file = &tests[first].recording_file;
        let is_of_file = |test: &Test| file.is_some() && test.recording_file == *file;
        if !tests[..first].iter().any(is_of_file) {
            let group: Vec<usize> = (first..tests.len()).filter(|&k| k == first || is_of_file(&tests[k])).collect();
            even_out_file(tests, &group, machine);
        }
    }
}

fn even_out_file(tests: &mut [Test], group: &[usize], machine: &Machine) {
    let Some(motion) = tests[group[0]].recording.as_ref().and_then(|recording| even_motion(recording, machine)) else {
        return;
    };
    let recordings = group.iter().filter_map(|&test| tests[test].recording.as_ref());
    let stretches: Vec<Stretch> = recordings.flat_map(|recording| stretches(&recording.length_mm, &motion)).collect();
    if !are_noise(&stretches) {
        return;
    }
    for &test in group {
        let Some(recording) = &mut tests[test].recording else { continue };
        let mut off = Vec::new();
        for (position, (even, turned)) in
            recording.positions[motion.column].iter_mut().zip(motion.even.iter().zip(&motion.turned))
        {
            if let Some(even) = even {
                let whole = *position - turned;
                off.push(turned - even.value);
                *position = even.value + whole;
            }
        }
        recording.scatter = Some(Scatter { axis: recording.axes[motion.column], by: rms(off.into_iter()) });
    }
}

/// The motion of the column that alone moves.
struct EvenMotion {
    column: usize,
    turns: bool,
    /// Positions without whole turns between rows.
    turned: Vec<f64>,
    /// None for rows with too few about them.
    even: Vec<Option<Local>>,
}

/// The motion of the column that alone moves, where its positions scatter.
fn even_motion(recording: &Recording, machine: &Machine) -> Option<EvenMotion> {
    let time_s = recording.time_s()?;
    let moves = |column: &usize| recording.positions[*column].windows(2).any(|pair| pair[0] != pair[1]);
    let mut moving = (0..recording.positions.len()).filter(moves);
    let (Some(column), None) = (moving.next(), moving.next()) else { return None };
    let mut turned = recording.positions[column].clone();
    let turns = machine.axes[recording.axes[column]].kind == AxisKind::Rotary;
    if turns {
        unwrap(&mut turned);
    }
    // most rows of a commanded path leave nothing
    let steps = robust_sigma(turned.windows(2).map(|pair| pair[1] - pair[0]));
    if robust_sigma(third_differences(&turned)) <= LEAST_OF_STEP * steps {
        return None;
    }
    let even = parabolas(time_s, &turned, EVEN_S);
    Some(EvenMotion { column, turns, turned, even })
}

/// Takes whole turns out of the steps from row to row: positions may be counted from 0 to 360°.
fn unwrap(positions: &mut [f64]) {
    for row in 1..positions.len() {
        let step = positions[row] - positions[row - 1];
        if step.abs() > PI {
            positions[row] -= TAU * (step / TAU).round();
        }
    }
}

/// What readings say of the scatter over a stretch of a recording; `x` in units of the readings' noise.
#[derive(Debug, Clone, Copy, Default)]
struct Stretch {
    /// `Σ x (L − f)`.
    products: f64,
    /// `Σ x²`.
    squares: f64,
    rows: usize,
}

/// Whether the scatter would show above the noise of the readings, and does not.
fn are_noise(stretches: &[Stretch]) -> bool {
    let squares: f64 = stretches.iter().map(|stretch| stretch.squares).sum();
    let would_show = squares > stretches.iter().map(|stretch| stretch.rows as f64).sum();
    let followed = stretches.iter().map(|stretch| stretch.products).sum::<f64>() / squares;
    let off = stretches.iter().map(|stretch| (stretch.products - followed * stretch.squares).powi(2));
    would_show && followed + 3.0 * off.sum::<f64>().sqrt() / squares < HALF_FOLLOWED
}

/// Sums by stretch; none where rows are too few.
fn stretches(lengths_mm: &[f64], motion: &EvenMotion) -> Vec<Stretch> {
    let row = |row: usize| {
        let even = motion.even.get(row).copied().flatten()?;
        lengths_mm[row].is_finite().then_some((even.value, motion.turned[row] - even.value, lengths_mm[row]))
    };
    let rows: Vec<(f64, f64, f64)> = (0..lengths_mm.len()).filter_map(row).collect();
    let Some(smooth) = Smooth::of(&rows, motion.turns) else { return Vec::new() };
    let left_mm: Vec<f64> = rows.iter().map(|&(even, _, length)| length - smooth.value(even)).collect();
    let noise_mm = noise_of_rows(&left_mm);
    let most_mm = MOST_SIGMAS * robust_sigma(left_mm.iter().copied());
    let of_stretch = |(rows, left_mm): (&[(f64, f64, f64)], &[f64])| {
        let counted = rows.iter().zip(left_mm).filter(|(_, left)| left.abs() < most_mm);
        counted.fold(Stretch::default(), |sum, (&(even, off, _), left)| {
            let x = off * smooth.slope(even) / noise_mm;
            Stretch { products: sum.products + x * left / noise_mm, squares: sum.squares + x * x, rows: sum.rows + 1 }
        })
    };
    let of_rows = rows.len().div_ceil(STRETCHES).max(1);
    rows.chunks(of_rows).zip(left_mm.chunks(of_rows)).map(of_stretch).collect()
}

/// A smooth function of positions: Fourier's to an order per turn, or a polynomial where there is no whole turn.
struct Smooth {
    /// Middle and half of the travel; `None`: whole turns.
    travel: Option<(f64, f64)>,
    coefficients: DVector<f64>,
}

impl Smooth {
    /// Through lengths over even positions.
    fn of(rows: &[(f64, f64, f64)], turns: bool) -> Option<Smooth> {
        let ends = |(low, high): (f64, f64), row: &(f64, f64, f64)| (low.min(row.0), high.max(row.0));
        let (low, high) = rows.iter().fold((f64::INFINITY, f64::NEG_INFINITY), ends);
        let travel = (!(turns && high - low > TAU)).then_some((0.5 * (low + high), 0.5 * (high - low)));
        let count = if travel.is_some() { 1 + DEGREE } else { 1 + 2 * ORDERS };
        let mut smooth = Smooth { travel, coefficients: DVector::zeros(count) };
        if rows.len() < ROWS_OF_COEFFICIENT * count || high <= low {
            return None;
        }
        let (mut normal, mut right) = (DMatrix::zeros(count, count), DVector::zeros(count));
        for &(even, _, length) in rows {
            let terms = smooth.terms(even, false);
            normal.ger(1.0, &terms, &terms, 1.0);
            right.axpy(length, &terms, 1.0);
        }
        smooth.coefficients = normal.cholesky()?.solve(&right);
        Some(smooth)
    }

    fn value(&self, position: f64) -> f64 {
        self.coefficients.dot(&self.terms(position, false))
    }

    fn slope(&self, position: f64) -> f64 {
        self.coefficients.dot(&self.terms(position, true))
    }

    /// The functions at a position, or their slopes.
    fn terms(&self, position: f64, of_slope: bool) -> DVector<f64> {
        let term = |k: usize| match self.travel {
            // Chebyshev's polynomials, whose normal matrix is well conditioned: T = cos k acos z
            Some((middle, half)) => {
                let angle = ((position - middle) / half).clamp(-1.0, 1.0).acos();
                let order = k as f64;
                match of_slope {
                    false => (order * angle).cos(),
                    true => order * (order * angle).sin() / angle.sin().max(f64::EPSILON) / half,
                }
            }
            None => {
                let order = k.div_ceil(2) as f64;
                let (sine, cosine) = (order * position).sin_cos();
                match (k % 2 == 1, of_slope) {
                    (true, false) => sine,
                    (false, false) => cosine,
                    (true, true) => order * cosine,
                    (false, true) => -order * sine,
                }
            }
        };
        DVector::from_fn(self.coefficients.len(), |k, _| term(k))
    }
}
