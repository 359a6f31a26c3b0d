//! One stage of the search: data and fitted columns whitened by a noise model, candidates judged against them.
//!
//! With everything whitened, a candidate block B needs only `z = Bᵀ(I−P)y` and `G = Bᵀ(I−P)B`, P the projection on what
//! has been fitted (with its priors). Its evidence with amplitudes drawn from N(0, τ²) is exact for a linear model.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, SymmetricEigen};

use rayon::prelude::*;

use super::ground::{Column, Ground};
use crate::identify::{NoiseModel, Whitener};

/// Whitened session with what has been fitted so far.
pub struct Stage<'g, 'a> {
    pub ground: &'g Ground<'a>,
    whiteners: Vec<Whitener>,
    y: Vec<DVector<f64>>,
    /// Whitened columns that a test sees, and their places among all.
    base: Vec<DMatrix<f64>>,
    seen: Vec<Vec<usize>>,
    factor: Cholesky<f64, Dyn>,
    /// Prior sigma of the accepted columns, display units.
    accepted_prior: Vec<f64>,
    /// The fitted amplitudes: nuisance first, then accepted effects, all in units of their priors.
    pub amplitudes: DVector<f64>,
    /// Weighted sum of squares left after the fit.
    pub misfit: f64,
}

/// A column that has been accepted, with the prior sigma of its amplitude.
#[derive(Debug, Clone)]
pub struct Accepted {
    pub column: Column,
    pub prior: f64,
}

/// A candidate's standing.
#[derive(Debug, Clone)]
pub struct Judgement {
    /// Log of the evidence ratio for the block against nothing, shape grid not counted.
    pub log_evidence: f64,
    /// Fall of the weighted sum of squares at the best amplitudes.
    pub chi2: f64,
    /// Best amplitudes under the amplitude prior, display units.
    pub amplitudes: Vec<f64>,
    /// Prior sigma of the amplitudes that has the most evidence, display units.
    pub tau: f64,
    /// Projected information per column: amplitude a of column j alone has χ² = a²·G_jj.
    pub information: DMatrix<f64>,
}

impl<'g, 'a> Stage<'g, 'a> {
    /// Whitens the rows `kept` of the ground and fits nuisance and accepted columns.
    pub fn new(
        ground: &'g Ground<'a>,
        noise: &[NoiseModel],
        accepted: &[Accepted],
        kept: &[Vec<bool>],
    ) -> Stage<'g, 'a> {
        let nuisance = ground.problem.unknowns.len();
        let count = nuisance + accepted.len();
        let parts: Vec<_> = (0..ground.tests())
            .into_par_iter()
            .map(|test| {
                let whitener = Whitener::new(&noise[test], &kept[test]);
                let mut residual: Vec<f64> = ground.residual_mm[test].clone();
                whitener.apply(&mut residual);
                let mut seen = ground.problem.tests[test].columns.clone();
                seen.extend(
                    (0..accepted.len()).filter(|&k| !accepted[k].column.by_test[test].is_empty()).map(|k| nuisance + k),
                );
                let mut columns = DMatrix::zeros(residual.len(), seen.len());
                for (local, &k) in seen.iter().enumerate() {
                    let mut column = columns.column_mut(local);
                    if k < nuisance {
                        column.copy_from(&ground.nuisance[test].column(k));
                    } else {
                        let Accepted { column: accepted, prior } = &accepted[k - nuisance];
                        column.iter_mut().zip(&accepted.by_test[test]).for_each(|(to, from)| *to = from * prior);
                    }
                    whitener.apply(column.as_mut_slice());
                }
                let residual = DVector::from_vec(residual);
                let gram = columns.tr_mul(&columns);
                let right = columns.tr_mul(&residual);
                (whitener, residual, columns, seen, gram, right)
            })
            .collect();
        let mut normal: DMatrix<f64> = DMatrix::identity(count, count);
        let mut right = DVector::zeros(count);
        let mut total = 0.0;
        let (mut whiteners, mut y, mut base, mut all_seen) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (whitener, residual, columns, seen, gram, local) in parts {
            for (a, &i) in seen.iter().enumerate() {
                right[i] += local[a];
                for (b, &j) in seen.iter().enumerate() {
                    normal[(i, j)] += gram[(a, b)];
                }
            }
            total += residual.norm_squared();
            whiteners.push(whitener);
            y.push(residual);
            base.push(columns);
            all_seen.push(seen);
        }
        // the unit prior makes the matrix definite; only values that are not finite can spoil it
        let factor = Cholesky::new(normal).unwrap_or_else(|| unit_factor(count));
        let amplitudes = factor.solve(&right);
        let misfit = total - right.dot(&amplitudes);
        let accepted_prior = accepted.iter().map(|accepted| accepted.prior).collect();
        Stage { ground, whiteners, y, base, seen: all_seen, factor, accepted_prior, amplitudes, misfit }
    }

    /// Amplitude of an accepted column, display units.
    pub fn accepted(&self, index: usize) -> f64 {
        self.amplitudes[self.ground.problem.unknowns.len() + index] * self.accepted_prior[index]
    }

    /// Covariance of all fitted amplitudes: nuisance in units of the priors, accepted in display units.
    pub fn covariance(&self) -> DMatrix<f64> {
        let mut covariance = self.factor.inverse();
        let nuisance = self.ground.problem.unknowns.len();
        for (k, prior) in self.accepted_prior.iter().enumerate() {
            covariance.row_mut(nuisance + k).scale_mut(*prior);
            covariance.column_mut(nuisance + k).scale_mut(*prior);
        }
        covariance
    }

    /// Residuals left by nuisance and accepted columns, mm; NaN where there is no reading.
    pub fn residual_mm(&self, accepted: &[Accepted]) -> Vec<Vec<f64>> {
        let nuisance = self.ground.problem.unknowns.len();
        let fitted = self.amplitudes.rows(0, nuisance);
        (0..self.ground.tests())
            .map(|test| {
                let model = &self.ground.nuisance[test] * fitted;
                let mut residual: Vec<f64> =
                    self.ground.residual_mm[test].iter().zip(model.iter()).map(|(r, m)| r - m).collect();
                for (k, accepted) in accepted.iter().enumerate() {
                    let size = self.accepted(k);
                    for (value, column) in residual.iter_mut().zip(&accepted.column.by_test[test]) {
                        *value -= size * column;
                    }
                }
                residual
            })
            .collect()
    }

    /// Projected `G` and `z` of a block.
    pub fn project(&self, columns: &[Column]) -> (DMatrix<f64>, DVector<f64>) {
        let count = columns.len();
        let mut gram = DMatrix::zeros(count, count);
        let mut z = DVector::zeros(count);
        let mut cross = DMatrix::zeros(self.amplitudes.len(), count);
        for test in 0..self.ground.tests() {
            let present: Vec<usize> = (0..count).filter(|&j| !columns[j].by_test[test].is_empty()).collect();
            if present.is_empty() {
                continue;
            }
            let rows = self.y[test].len();
            let mut block = DMatrix::zeros(rows, present.len());
            for (local, &j) in present.iter().enumerate() {
                let mut column = block.column_mut(local);
                column.as_mut_slice().copy_from_slice(&columns[j].by_test[test]);
                self.whiteners[test].apply(column.as_mut_slice());
            }
            let local_gram = block.tr_mul(&block);
            let local_z = block.tr_mul(&self.y[test]);
            let local_cross = self.base[test].tr_mul(&block);
            for (local, &k) in self.seen[test].iter().enumerate() {
                for (a, &j) in present.iter().enumerate() {
                    cross[(k, j)] += local_cross[(local, a)];
                }
            }
            for (a, &j) in present.iter().enumerate() {
                z[j] += local_z[a];
                for (b, &k) in present.iter().enumerate() {
                    gram[(j, k)] += local_gram[(a, b)];
                }
            }
        }
        let solved = self.factor.solve(&cross);
        let raw_diagonal: Vec<f64> = (0..count).map(|j| gram[(j, j)]).collect();
        gram -= cross.tr_mul(&solved);
        z -= cross.tr_mul(&self.amplitudes);
        for j in 0..count {
            // what rounding leaves of a column that the fit explains wholly is nothing
            if gram[(j, j)] < 1e-9 * raw_diagonal[j] {
                gram.row_mut(j).fill(0.0);
                gram.column_mut(j).fill(0.0);
                z[j] = 0.0;
            }
        }
        (gram, z)
    }

    /// Judges a block whose amplitudes are plausible up to `plausible` display units.
    pub fn judge(&self, columns: &[Column], plausible: f64) -> Judgement {
        let (information, z) = self.project(columns);
        judge(information, z, plausible)
    }

    /// What is left of the data, whitened twice: its product with a column is the column's score.
    pub fn matched(&self) -> Vec<Vec<f64>> {
        (0..self.ground.tests())
            .map(|test| {
                let amplitudes =
                    DVector::from_iterator(self.seen[test].len(), self.seen[test].iter().map(|&k| self.amplitudes[k]));
                let mut left: Vec<f64> = (&self.y[test] - &self.base[test] * amplitudes).iter().copied().collect();
                self.whiteners[test].apply_transposed(&mut left);
                left
            })
            .collect()
    }
}

/// Factor of the unit matrix.
fn unit_factor(count: usize) -> Cholesky<f64, Dyn> {
    Cholesky::pack_dirty(DMatrix::identity(count, count))
}

/// Amplitude priors that are tried, display units: the one with the largest evidence counts.
const AMPLITUDE_PRIORS: [f64; 7] = [0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0];

/// Evidence of a block from its projected information and score, amplitudes being plausible up to `plausible`.
pub fn judge(information: DMatrix<f64>, z: DVector<f64>, plausible: f64) -> Judgement {
    let count = z.len();
    let eigen = SymmetricEigen::new(information.clone());
    let w = eigen.eigenvectors.tr_mul(&z);
    let evidence = |tau: f64| -> f64 {
        (0..count)
            .map(|k| {
                let lambda = eigen.eigenvalues[k].max(0.0);
                0.5 * (w[k] * w[k] / (lambda + 1.0 / (tau * tau)) - (1.0 + tau * tau * lambda).ln())
            })
            .sum()
    };
    let tau = AMPLITUDE_PRIORS
        .into_iter()
        .filter(|tau| *tau <= plausible)
        .max_by(|a, b| evidence(*a).total_cmp(&evidence(*b)))
        .unwrap_or(AMPLITUDE_PRIORS[0]);
    let mut amplitudes = DVector::zeros(count);
    let mut chi2 = 0.0;
    for k in 0..count {
        let lambda = eigen.eigenvalues[k].max(0.0);
        let precision = lambda + 1.0 / (tau * tau);
        let v = eigen.eigenvectors.column(k);
        amplitudes += v * (w[k] / precision);
        chi2 += w[k] * w[k] / precision;
    }
    // one nat for having chosen τ from the data
    let log_evidence = evidence(tau) - 1.0;
    Judgement { log_evidence, chi2, tau, amplitudes: amplitudes.iter().copied().collect(), information }
}
