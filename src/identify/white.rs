//! Gauss–Newton for white noise, sample by sample or from compressed sweeps; no outliers and no noise model.
//!
//! Minimises `Σ_tests Σ_i (y_i − L_i − d)²/σ² + Σ ((x − prior)/σ_prior)²`; an infinite prior sigma means no prior.

use crate::statistics::{Factor, ROW_STEP, add_products, weighted_products};
use nalgebra::{DMatrix, Vector3};

use super::compressed::{SweepBasis, SweepStatistics};
use crate::chain::{Bar, Column, Geometry, Poses};
use crate::identify::model::error::FitError;
use crate::identify::model::problem::Problem;

/// What a test contributes to a white-noise fit.
#[derive(Debug, Clone)]
pub enum Evidence {
    /// Every reading, mm, with its pose.
    Samples { poses: Poses, reading_mm: Vec<f64> },
    /// Statistics of a sweep of one axis, equivalent to its samples.
    Sweep { basis: SweepBasis, statistics: SweepStatistics },
}

/// Solution of a white-noise fit.
#[derive(Debug, Clone)]
pub struct WhiteFit {
    /// Values of the unknowns, mm and rad.
    pub values: Vec<f64>,
    /// `JᵀJ/σ²` with priors, the inverse of the covariance.
    pub information: DMatrix<f64>,
    /// Weighted sum of squares, priors included, before the last step.
    pub cost: f64,
    /// Evaluations of the model.
    pub evaluations: usize,
}

impl WhiteFit {
    /// Covariance of the values; `None` when rounding spoils the inverse.
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        nalgebra::Cholesky::new(self.information.clone()).map(|factor| factor.inverse())
    }
}

/// Evaluations after which a fit is given up.
const MAX_EVALUATIONS: usize = 40;
/// The distance left to the minimum that ends a fit, in sigmas, foretold from the ratio of the last two steps. Residuals
/// are small and convergence nearly quadratic, so that what is really left is some thousand times less.
const DISTANCE_SIGMAS: f64 = 1e-4;
/// Rows worked on at a time: with 32 columns they stay in the second cache.
const BLOCK_ROWS: usize = 256;

impl Evidence {
    /// Readings of a test's rows where `kept` holds and a reading exists.
    pub fn samples(problem: &Problem, test: usize, kept: &[bool]) -> Evidence {
        let prepared = &problem.tests[test];
        let rows: Vec<usize> = (0..prepared.motion.rows())
            .filter(|&row| kept.get(row).copied().unwrap_or(true) && prepared.reading_mm[row].is_finite())
            .collect();
        let columns = (0..prepared.motion.axis_count)
            .map(|axis| rows.iter().map(|&row| prepared.motion.row(row)[axis]).collect());
        let poses = Poses::from_columns(columns).with_sines(problem.chain);
        Evidence::Samples { poses, reading_mm: rows.iter().map(|&row| prepared.reading_mm[row]).collect() }
    }

    /// The same evidence with a sweep of one axis compressed; other tests stay as they are.
    pub fn compressed(self, problem: &Problem, test: usize, values: &[f64]) -> Evidence {
        let Evidence::Samples { poses, reading_mm } = &self else { return self };
        let (pivot, spindle, _) = problem.setup_of(test, values);
        let links = problem.tests[test].links;
        let geometry = problem.geometry(values);
        match SweepBasis::of(&geometry, (links.0, &pivot), (links.1, &spindle), poses) {
            Some(basis) => Evidence::Sweep { statistics: basis.compress(reading_mm), basis },
            None => self,
        }
    }

    /// The same positions with other readings: tests draw many by it.
    pub fn with_readings(&self, reading_mm: &[f64]) -> Evidence {
        match self {
            Evidence::Samples { poses, .. } => {
                Evidence::Samples { poses: poses.clone(), reading_mm: reading_mm.to_vec() }
            }
            Evidence::Sweep { basis, .. } => {
                Evidence::Sweep { basis: basis.clone(), statistics: basis.compress(reading_mm) }
            }
        }
    }

    /// Nodes of a compressed sweep, 0 for samples.
    fn node_count(&self) -> usize {
        match self {
            Evidence::Samples { .. } => 0,
            Evidence::Sweep { basis, .. } => basis.node_count(),
        }
    }

    fn poses(&self) -> &Poses {
        match self {
            Evidence::Samples { poses, .. } => poses,
            Evidence::Sweep { basis, .. } => &basis.nodes,
        }
    }
}

/// Fits the unknowns of a problem to evidence with white noise of `noise_mm` per test, starting from the prior means.
///
/// Constant errors only: component errors and effects are refused ([`Problem::is_constant`]). Benches and tests alone fit by it.
pub fn fit_white(problem: &Problem, evidence: &[Evidence], noise_mm: &[f64]) -> Result<WhiteFit, FitError> {
    if let Some(test) = (0..evidence.len()).find(|&test| !problem.is_constant(test)) {
        return Err(FitError::NotConstant { test: problem.session.tests[test].name.clone() });
    }
    if problem.asked < problem.unknowns.len() {
        return Err(FitError::LinearAxes);
    }
    let mut equations = Equations::new(problem, evidence, noise_mm);
    let mut values: Vec<f64> = problem.unknowns.iter().map(|unknown| unknown.prior_mean).collect();
    equations.evaluate(&values);
    let (mut cost, mut last_decrement) = (equations.cost, 0.0);
    let mut evaluations = 1;
    while evaluations < MAX_EVALUATIONS {
        let factor = Factor::of(&equations.information, values.len())
            .map_err(|index| FitError::Undetermined { unknown: problem.unknowns[index].label.clone() })?;
        let step = factor.solve(&equations.gradient);
        // length of the step in sigmas; Gauss–Newton shortens it by a constant ratio or better
        let decrement = step.iter().zip(&equations.gradient).map(|(s, g)| s * g).sum::<f64>().max(0.0).sqrt();
        let ratio = if last_decrement > 0.0 { decrement / last_decrement } else { 1.0 };
        let start = values.clone();
        let mut share = 1.0;
        for (value, (start, step)) in values.iter_mut().zip(start.iter().zip(&step)) {
            *value = start + step;
        }
        if decrement * ratio.min(1.0) < DISTANCE_SIGMAS && (ratio < 0.5 || decrement < DISTANCE_SIGMAS) {
            return Ok(WhiteFit { values, information: equations.information_matrix(), cost, evaluations });
        }
        equations.evaluate(&values);
        evaluations += 1;
        while (equations.cost.is_nan() || equations.cost > cost * (1.0 + 1e-9) + 1e-9) && evaluations < MAX_EVALUATIONS
        {
            share *= 0.5;
            for (value, (start, step)) in values.iter_mut().zip(start.iter().zip(&step)) {
                *value = start + share * step;
            }
            equations.evaluate(&values);
            evaluations += 1;
        }
        cost = equations.cost;
        last_decrement = if share == 1.0 { decrement } else { 0.0 };
    }
    Err(FitError::NoConvergence)
}

/// Normal equations of a problem, evaluated again and again in the same memory.
struct Equations<'a> {
    problem: &'a Problem<'a>,
    evidence: &'a [Evidence],
    noise_mm: &'a [f64],
    /// By test: columns of the length, by unknown.
    columns: Vec<TestColumns>,
    /// Lower triangle, unknowns × unknowns.
    information: Vec<f64>,
    gradient: Vec<f64>,
    cost: f64,
    block: Vec<f64>,
    lengths: Vec<f64>,
    sums: Vec<f64>,
    scratch: Vec<f64>,
}

struct TestColumns {
    length: Vec<Column>,
    /// Unknowns of `length`, then the one of the bar's reading if it is unknown.
    unknowns: Vec<usize>,
}

impl TestColumns {
    fn of(problem: &Problem, test: usize) -> TestColumns {
        let mut columns = TestColumns { length: Vec::new(), unknowns: Vec::new() };
        let mut bar = None;
        for &index in &problem.tests[test].columns {
            match problem.column(test, index) {
                Some(column) => {
                    columns.length.push(column);
                    columns.unknowns.push(index);
                }
                None => bar = Some(index),
            }
        }
        columns.unknowns.extend(bar);
        columns
    }
}

impl<'a> Equations<'a> {
    fn new(problem: &'a Problem<'a>, evidence: &'a [Evidence], noise_mm: &'a [f64]) -> Equations<'a> {
        let columns: Vec<TestColumns> = (0..evidence.len()).map(|test| TestColumns::of(problem, test)).collect();
        let widest = columns.iter().map(|columns| columns.unknowns.len() + 1).max().unwrap_or(0);
        let longest = evidence.iter().map(|evidence| evidence.poses().rows()).max().unwrap_or(0).min(BLOCK_ROWS);
        let count = problem.unknowns.len();
        let most_nodes = evidence.iter().map(Evidence::node_count).max().unwrap_or(0);
        let stride = widest.next_multiple_of(ROW_STEP);
        Equations {
            problem,
            evidence,
            noise_mm,
            columns,
            information: vec![0.0; count * count],
            gradient: vec![0.0; count],
            cost: 0.0,
            block: vec![0.0; widest * longest],
            lengths: vec![0.0; longest],
            sums: vec![0.0; widest * widest],
            scratch: vec![0.0; (2 * most_nodes + widest) * stride],
        }
    }

    fn information_matrix(&self) -> DMatrix<f64> {
        let count = self.gradient.len();
        DMatrix::from_fn(count, count, |i, j| self.information[i.max(j) * count + i.min(j)])
    }

    /// Information, gradient and cost at `values`.
    fn evaluate(&mut self, values: &[f64]) {
        self.information.fill(0.0);
        self.gradient.fill(0.0);
        self.cost = 0.0;
        let count = values.len();
        for (k, unknown) in self.problem.unknowns.iter().enumerate() {
            let weight = unknown.prior_sigma.powi(-2);
            let off = values[k] - unknown.prior_mean;
            self.information[k * count + k] = weight;
            self.gradient[k] = -weight * off;
            self.cost += weight * off * off;
        }
        let geometry = self.problem.geometry(values);
        for test in 0..self.evidence.len() {
            let (pivot, spindle, offset_mm) = self.problem.setup_of(test, values);
            self.sum_test(&geometry, test, &pivot, &spindle, offset_mm);
            self.spread(test);
        }
    }

    /// Products of the columns and of the residual of one test, into `sums`.
    fn sum_test(
        &mut self,
        geometry: &Geometry,
        test: usize,
        pivot: &Vector3<f64>,
        spindle: &Vector3<f64>,
        offset_mm: f64,
    ) {
        let width = self.columns[test].unknowns.len() + 1;
        self.sums[..width * width].fill(0.0);
        let evidence = &self.evidence[test];
        let links = self.problem.tests[test].links;
        let bar = geometry.bar((links.0, pivot), (links.1, spindle), evidence.poses());
        match evidence {
            Evidence::Samples { reading_mm, .. } => self.sum_samples(geometry, &bar, test, reading_mm, offset_mm),
            Evidence::Sweep { basis, statistics } => {
                self.sum_sweep(geometry, &bar, test, basis, statistics, offset_mm);
            }
        }
    }

    fn sum_samples(&mut self, geometry: &Geometry, bar: &Bar, test: usize, reading_mm: &[f64], offset_mm: f64) {
        let columns = &self.columns[test];
        let derivatives = bar.derivatives(geometry, &columns.length);
        let (lengths_wide, width) = (columns.length.len(), columns.unknowns.len() + 1);
        let mut start = 0;
        while start < reading_mm.len() {
            let rows = (reading_mm.len() - start).min(BLOCK_ROWS);
            let block = &mut self.block[..rows * width];
            let lengths = &mut self.lengths[..rows];
            derivatives.evaluate(start..start + rows, lengths, &mut block[..rows * lengths_wide]);
            block[rows * lengths_wide..].fill(1.0);
            let residual = &mut block[rows * (width - 1)..];
            for ((residual, reading), length) in residual.iter_mut().zip(&reading_mm[start..]).zip(&*lengths) {
                *residual = reading - length - offset_mm;
            }
            add_products(block, rows, width, &mut self.sums);
            start += rows;
        }
    }

    fn sum_sweep(
        &mut self,
        geometry: &Geometry,
        bar: &Bar,
        test: usize,
        basis: &SweepBasis,
        statistics: &SweepStatistics,
        offset_mm: f64,
    ) {
        let columns = &self.columns[test];
        let (length_columns, width) = (columns.length.len(), columns.unknowns.len() + 1);
        let nodes = basis.node_count();
        let values = &mut self.lengths[..nodes];
        let block = &mut self.block[..nodes * width];
        bar.derivatives(geometry, &columns.length).evaluate(0..nodes, values, &mut block[..nodes * length_columns]);
        block[nodes * length_columns..].fill(1.0);
        let stride = width.next_multiple_of(ROW_STEP);
        // J row by row, the model's values counted from the base as the last column
        let (rows, scratch) = self.scratch.split_at_mut(nodes * stride);
        for (m, row) in rows.chunks_exact_mut(stride).enumerate() {
            for (a, entry) in row[..width - 1].iter_mut().enumerate() {
                *entry = block[a * nodes + m];
            }
            row[width - 1] = values[m] + offset_mm - statistics.base_mm;
        }
        let (weighted, products) = scratch.split_at_mut(nodes * stride);
        let products = &mut products[..width * stride];
        weighted_products(rows, stride, &basis.weight, weighted, products);
        // residual products: fᵀJ − vᵀWJ, and Σy² − 2fᵀv + vᵀWv
        let projected =
            |a: usize| -> f64 { rows.chunks_exact(stride).zip(&statistics.projected).map(|(row, f)| row[a] * f).sum() };
        for a in 0..width - 1 {
            self.sums[a * width..=a * width + a].copy_from_slice(&products[a * stride..=a * stride + a]);
            self.sums[(width - 1) * width + a] = projected(a) - products[(width - 1) * stride + a];
        }
        let last = width - 1;
        self.sums[width * width - 1] = statistics.squares - 2.0 * projected(last) + products[last * stride + last];
    }

    /// Adds the sums of a test to the equations of all unknowns.
    fn spread(&mut self, test: usize) {
        let unknowns = &self.columns[test].unknowns;
        let (width, count) = (unknowns.len() + 1, self.gradient.len());
        let weight = self.noise_mm[test].powi(-2);
        for (a, &i) in unknowns.iter().enumerate() {
            for (b, &j) in unknowns[..=a].iter().enumerate() {
                self.information[i.max(j) * count + i.min(j)] += weight * self.sums[a * width + b];
            }
            self.gradient[i] += weight * self.sums[(width - 1) * width + a];
        }
        self.cost += weight * self.sums[width * width - 1];
    }
}
