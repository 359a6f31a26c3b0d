//! Robust and weighted Gauss–Newton over all tests of a problem; knows neither what unknowns mean nor where noise comes from.

use crate::statistics::{NoiseModel, Whitener, add_cross_products, add_products};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;

use crate::identify::model::problem::{Prediction, Problem};

/// How readings are weighted.
pub enum Weighting<'w> {
    /// Huber weights for a residual scale, mm: for the first rough fit.
    Huber { scale_mm: f64 },
    /// Every kept reading of a test through its noise model.
    Whitened { noise: &'w [NoiseModel], kept: &'w [Vec<bool>] },
}

/// Normal equations in units of the priors: `H = D(JᵀWJ)D`, so that the prior is the unit matrix.
pub struct Normal {
    /// Information from data, scaled by the prior sigmas.
    pub information: DMatrix<f64>,
    /// Gradient `D·JᵀW·residual`.
    pub gradient: DVector<f64>,
    /// Weighted sum of squares of the residuals (Huber: its loss).
    pub cost: f64,
}

/// A solution of the problem.
pub struct Solution {
    pub values: Vec<f64>,
    /// Data information at the solution, scaled by prior sigmas.
    pub information: DMatrix<f64>,
    /// Residuals at the solution, mm, by test.
    pub residual_mm: Vec<Vec<f64>>,
    /// False when the step limit was reached first.
    pub converged: bool,
}

impl Solution {
    /// Data information of the first unknowns with the others held where they are.
    pub fn information_of(&self, count: usize) -> DMatrix<f64> {
        self.information.view((0, 0), (count, count)).into_owned()
    }
}

/// Steps after which a fit is given up. Where only a wide prior holds a direction, the data bend the valley that leads to it
/// and damped steps are short: a hundred times as many as a determined fit takes.
const MAX_STEPS: usize = 300;
/// A step smaller than this share of every posterior sigma ends the iteration.
const STEP_TOLERANCE: f64 = 1e-3;
/// Size of a whole step in posterior sigmas above which it counts as its largest part: fifty tolerances. A fit goes on for a
/// step or two more where its parts are within the tolerance by then, never less.
const EXACT_BELOW: f64 = 50.0 * STEP_TOLERANCE;
/// Share of a step at which its bend is measured: short enough for a second derivative, long enough for rounding.
const BEND_SHARE_OF_STEP: f64 = 0.1;
/// Largest correction for the bend, of the step; beyond it higher orders count (Transtrum and Sethna: 0.75).
const MOST_BEND: f64 = 0.75;
/// Huber's constant: residuals beyond so many scales count linearly.
const HUBER: f64 = 1.5;

/// Minimises weighted residuals and priors from `start`. Public for tests that weight otherwise than a fit does.
pub fn minimise(problem: &Problem, start: &[f64], weighting: &Weighting) -> Solution {
    minimise_until(problem, start, weighting, Until { least_gain: 0.0, steps: MAX_STEPS })
}

/// How far a descent is taken.
#[derive(Debug, Clone, Copy)]
pub struct Until {
    /// Share of the cost that an undamped step must gain, or the descent ends with it.
    pub least_gain: f64,
    /// Most steps with either kind of damping.
    pub steps: usize,
}

/// As [`minimise`], but only so far: where the size of the residuals alone is asked for. Huber's weights change with the
/// residuals, so that the last steps are many and short.
pub fn minimise_until(problem: &Problem, start: &[f64], weighting: &Weighting, until: Until) -> Solution {
    let solution = descend(problem, start, (weighting, Damping::ByData), until);
    match solution.converged {
        true => solution,
        false => descend(problem, &solution.values, (weighting, Damping::ByPriors), until),
    }
}

/// What shortens a step that failed.
#[derive(Clone, Copy, PartialEq)]
enum Damping {
    /// Every unknown by what the data say of it (Marquardt): sure from far off, short where the data bend a valley along which
    /// only priors hold.
    ByData,
    /// Every unknown by its prior (Levenberg): along such a valley a step keeps its length.
    ByPriors,
}

fn descend(problem: &Problem, start: &[f64], (weighting, kind): (&Weighting, Damping), until: Until) -> Solution {
    let mut values = start.to_vec();
    let (mut normal, mut residual_mm) = normal_equations(problem, &values, weighting);
    let mut cost = normal.cost + prior_cost(problem, &values);
    let mut damping = 0.0;
    let mut converged = false;
    for _ in 0..until.steps {
        let Some(step) = step(problem, &values, &normal, (damping, kind)) else {
            damping = (damping * 10.0f64).max(1e-3);
            continue;
        };
        let relative = step.relative;
        let by = if damping > 0.0 { bent(problem, &values, step, weighting) } else { step.by };
        let trial: Vec<f64> = values.iter().zip(by.iter()).map(|(value, by)| value + by).collect();
        let (next, next_residual) = normal_equations(problem, &trial, weighting);
        let next_cost = next.cost + prior_cost(problem, &trial);
        // rounding of the sum must not reject the last, tiny steps
        if next_cost <= cost * (1.0 + 1e-12) + 1e-12 {
            let is_little = damping == 0.0 && cost - next_cost < until.least_gain * cost;
            (values, normal, residual_mm, cost) = (trial, next, next_residual, next_cost);
            // a damped step is short wherever it stands: what counts is how far the minimum is without
            let left = if damping == 0.0 { relative } else { undamped_step(problem, &values, &normal) };
            damping = if damping < 1e-9 { 0.0 } else { damping * 0.1 };
            if is_little || left < STEP_TOLERANCE {
                converged = true;
                break;
            }
        } else if damping > 1e12 || relative < STEP_TOLERANCE {
            converged = relative < STEP_TOLERANCE;
            break;
        } else {
            damping = (damping * 10.0).max(1e-3);
        }
    }
    Solution { values, information: normal.information, residual_mm, converged }
}

/// Largest size of the undamped step in posterior sigmas; infinite when the equations are not solvable.
fn undamped_step(problem: &Problem, values: &[f64], normal: &Normal) -> f64 {
    step(problem, values, normal, (0.0, Damping::ByData)).map_or(f64::INFINITY, |step| step.relative)
}

/// A Gauss–Newton step.
struct Step {
    /// By how much each unknown moves, in its own unit.
    by: DVector<f64>,
    /// The largest move in posterior sigmas, or a bound of it above [`EXACT_BELOW`].
    relative: f64,
    /// Factor of the damped equations.
    factor: Cholesky<f64, Dyn>,
}

/// The step from some values; `None` when the equations are not solvable.
fn step(problem: &Problem, values: &[f64], normal: &Normal, (damping, kind): (f64, Damping)) -> Option<Step> {
    let count = values.len();
    let factor = factor(normal, (damping, kind))?;
    let mut right = normal.gradient.clone();
    for (k, unknown) in problem.unknowns.iter().enumerate() {
        right[k] -= (values[k] - unknown.prior_mean) / unknown.prior_sigma;
    }
    let scaled = factor.solve(&right);
    // no unknown moves by more sigmas than the whole step (Cauchy and Schwarz); far off the minimum that says enough, and
    // spares as much work as the factor takes
    let whole = scaled.dot(&right).max(0.0).sqrt();
    let relative = if whole > EXACT_BELOW {
        whole
    } else {
        let variance = inverse_diagonal(&factor, count);
        (0..count).map(|k| scaled[k].abs() / variance[k].sqrt()).fold(0.0, f64::max)
    };
    let by = in_own_units(problem, &scaled);
    by.iter().all(|value| value.is_finite()).then_some(Step { by, relative, factor })
}

/// Moves in prior sigmas as moves in the unit of each unknown.
fn in_own_units(problem: &Problem, scaled: &DVector<f64>) -> DVector<f64> {
    let moves = scaled.iter().zip(&problem.unknowns).map(|(scaled, unknown)| scaled * unknown.prior_sigma);
    DVector::from_iterator(scaled.len(), moves)
}

/// Factor of the damped equations; `None` when they are not solvable.
fn factor(normal: &Normal, (damping, kind): (f64, Damping)) -> Option<Cholesky<f64, Dyn>> {
    let mut matrix = normal.information.clone();
    for k in 0..matrix.nrows() {
        let by = if kind == Damping::ByData { 1.0 + matrix[(k, k)] } else { 1.0 };
        matrix[(k, k)] += 1.0 + damping * by;
    }
    Cholesky::new(matrix)
}

/// A damped step with its first correction for the bend of the valley that it follows ("geodesic acceleration"; Transtrum and
/// Sethna, Improvements to the Levenberg–Marquardt algorithm, arXiv 1201.5885): the predictions' second derivative along the
/// step, by a difference. The step itself where the correction is not small beside it.
fn bent(problem: &Problem, values: &[f64], step: Step, weighting: &Weighting) -> DVector<f64> {
    let Step { by, factor, .. } = step;
    let ahead: Vec<f64> = values.iter().zip(by.iter()).map(|(value, by)| value + BEND_SHARE_OF_STEP * by).collect();
    let (here, there) = (problem.geometry(values), problem.geometry(&ahead));
    let parts: Vec<Vec<f64>> = (0..problem.tests.len())
        .into_par_iter()
        .map(|test| {
            let columns = &problem.tests[test].columns;
            let mut prediction = problem.predict(test, &here, values);
            let residual_there = problem.predict(test, &there, &ahead).residual_mm;
            let along = DVector::from_iterator(columns.len(), columns.iter().map(|&index| by[index]));
            let straight = &prediction.jacobian * along;
            let mut second = DVector::zeros(straight.len());
            for row in 0..straight.len() {
                let change = prediction.residual_mm[row] - residual_there[row];
                let value = 2.0 * (change - BEND_SHARE_OF_STEP * straight[row]) / BEND_SHARE_OF_STEP.powi(2);
                second[row] = if value.is_finite() { value } else { 0.0 };
            }
            let last = columns.len();
            prediction.jacobian = prediction.jacobian.insert_column(last, 0.0);
            prediction.jacobian.set_column(last, &second);
            weigh(&mut prediction, test, weighting);
            let rows = prediction.jacobian.nrows();
            let (jacobian, second) = prediction.jacobian.as_slice().split_at(rows * last);
            let mut gradient = vec![0.0; last];
            add_cross_products(jacobian, second, rows, &mut gradient);
            gradient
        })
        .collect();
    let mut right = DVector::zeros(values.len());
    for (gradient, test) in parts.iter().zip(&problem.tests) {
        for (value, &index) in gradient.iter().zip(&test.columns) {
            right[index] -= value * problem.unknowns[index].prior_sigma;
        }
    }
    let acceleration = in_own_units(problem, &factor.solve(&right));
    let sigma = |k: usize| problem.unknowns[k].prior_sigma;
    let size = |v: &DVector<f64>| (0..values.len()).map(|k| (v[k] / sigma(k)).powi(2)).sum::<f64>().sqrt();
    let is_small = 2.0 * size(&acceleration) <= MOST_BEND * size(&by);
    if is_small && acceleration.iter().all(|value| value.is_finite()) { by + 0.5 * acceleration } else { by }
}

/// Diagonal of the inverse of a factored matrix `L·Lᵀ`: squared lengths of the columns of `L⁻¹`, a sixth of the work of the
/// whole inverse.
fn inverse_diagonal(factor: &Cholesky<f64, Dyn>, count: usize) -> Vec<f64> {
    let lower = factor.l_dirty();
    let mut column = vec![0.0; count];
    (0..count)
        .map(|k| {
            column[k..].fill(0.0);
            column[k] = 1.0;
            let mut square = 0.0;
            for j in k..count {
                let entries = &lower.as_slice()[j * count..(j + 1) * count];
                let value = column[j] / entries[j];
                square += value * value;
                column[j + 1..].iter_mut().zip(&entries[j + 1..]).for_each(|(off, entry)| *off -= entry * value);
            }
            square.max(f64::MIN_POSITIVE)
        })
        .collect()
}

fn prior_cost(problem: &Problem, values: &[f64]) -> f64 {
    problem
        .unknowns
        .iter()
        .zip(values)
        .map(|(unknown, value)| ((value - unknown.prior_mean) / unknown.prior_sigma).powi(2))
        .sum()
}

/// Normal equations and residuals at `values`, tests in parallel, summed in order so that results repeat exactly.
pub fn normal_equations(problem: &Problem, values: &[f64], weighting: &Weighting) -> (Normal, Vec<Vec<f64>>) {
    let geometry = problem.geometry(values);
    let parts: Vec<_> = (0..problem.tests.len())
        .into_par_iter()
        .map(|test| {
            let mut prediction = problem.predict(test, &geometry, values);
            let residual = prediction.residual_mm.clone();
            let cost = weigh(&mut prediction, test, weighting);
            let (rows, columns) = prediction.jacobian.shape();
            let mut information = vec![0.0; columns * columns];
            add_products(prediction.jacobian.as_slice(), rows, columns, &mut information);
            let mut gradient = vec![0.0; columns];
            add_cross_products(prediction.jacobian.as_slice(), &prediction.residual_mm, rows, &mut gradient);
            (information, gradient, cost, residual)
        })
        .collect();
    let count = problem.unknowns.len();
    let mut normal = Normal { information: DMatrix::zeros(count, count), gradient: DVector::zeros(count), cost: 0.0 };
    let mut residuals = Vec::with_capacity(parts.len());
    for ((information, gradient, cost, residual), test) in parts.into_iter().zip(&problem.tests) {
        let count = test.columns.len();
        for (row, &i) in test.columns.iter().enumerate() {
            let scale = problem.unknowns[i].prior_sigma;
            normal.gradient[i] += gradient[row] * scale;
            for (column, &j) in test.columns.iter().enumerate() {
                let product = information[row.max(column) * count + row.min(column)];
                normal.information[(i, j)] += product * scale * problem.unknowns[j].prior_sigma;
            }
        }
        normal.cost += cost;
        residuals.push(residual);
    }
    (normal, residuals)
}

/// Residuals at `values`, mm, by test.
pub fn residual_mm(problem: &Problem, values: &[f64]) -> Vec<Vec<f64>> {
    let geometry = problem.geometry(values);
    (0..problem.tests.len()).into_par_iter().map(|test| problem.residual_mm(test, &geometry, values)).collect()
}

/// Weights residual and Jacobian in place (rows without a reading become zero); returns the loss.
fn weigh(prediction: &mut Prediction, test: usize, weighting: &Weighting) -> f64 {
    match weighting {
        Weighting::Huber { scale_mm } => {
            let mut loss = 0.0;
            let mut factor_of = |residual: &f64| {
                let size = residual.abs() / scale_mm;
                let weight = if !size.is_finite() {
                    return 0.0;
                } else if size <= HUBER {
                    loss += size * size;
                    1.0f64
                } else {
                    loss += HUBER * (2.0 * size - HUBER);
                    HUBER / size
                };
                weight.sqrt() / scale_mm
            };
            let factors: Vec<f64> = prediction.residual_mm.iter().map(&mut factor_of).collect();
            for (residual, factor) in prediction.residual_mm.iter_mut().zip(&factors) {
                *residual = if *factor > 0.0 { *residual * factor } else { 0.0 };
            }
            for column in prediction.jacobian.as_mut_slice().chunks_exact_mut(factors.len().max(1)) {
                column.iter_mut().zip(&factors).for_each(|(value, factor)| *value *= factor);
            }
            loss
        }
        Weighting::Whitened { noise, kept } => {
            let whitener = Whitener::new(&noise[test], &kept[test]);
            whitener.apply(&mut prediction.residual_mm);
            for mut column in prediction.jacobian.column_iter_mut() {
                whitener.apply(column.as_mut_slice());
            }
            prediction.residual_mm.iter().map(|value| value * value).sum()
        }
    }
}
