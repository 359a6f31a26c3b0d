//! One stage of the search: data and fitted columns whitened by a noise model, candidates judged against them.
//!
//! With everything whitened, a candidate block B needs only `z = Bᵀ(I−P)y` and `G = Bᵀ(I−P)B`, P the projection on what
//! has been fitted (with its priors). Its evidence with amplitudes drawn from N(0, τ²) is exact for a linear model.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, SymmetricEigen};

use super::ground::{Column, Ground};
use crate::identify::{NoiseModel, Whitener};

/// Whitened session with what has been fitted so far.
pub struct Stage<'g, 'a> {
    pub ground: &'g Ground<'a>,
    pub noise: Vec<NoiseModel>,
    whiteners: Vec<Whitener>,
    y: Vec<DVector<f64>>,
    base: Vec<DMatrix<f64>>,
    factor: Cholesky<f64, Dyn>,
    /// `A⁻¹ Jᵀ y`: the fitted amplitudes, nuisance first (in units of the priors), then accepted effects.
    pub amplitudes: DVector<f64>,
    /// Weighted sum of squares left after the fit.
    pub misfit: f64,
}

/// Prior standard deviation of an accepted effect's amplitude, display units: wide.
const ACCEPTED_PRIOR: f64 = 300.0;

/// A candidate's standing.
#[derive(Debug, Clone)]
pub struct Judgement {
    /// Log of the evidence ratio for the block against nothing, shape grid not counted.
    pub log_evidence: f64,
    /// Fall of the weighted sum of squares at the best amplitudes.
    pub chi2: f64,
    /// Best amplitudes under the amplitude prior, display units.
    pub amplitudes: Vec<f64>,
    /// Covariance of the amplitudes.
    pub covariance: DMatrix<f64>,
    /// Projected information per column: amplitude a of column j alone has χ² = a²·G_jj.
    pub information: DMatrix<f64>,
}

impl<'g, 'a> Stage<'g, 'a> {
    /// Whitens the ground and fits nuisance and accepted columns. `kept` overrides the ground's rows.
    pub fn new(ground: &'g Ground<'a>, noise: &[NoiseModel], accepted: &[Column], kept: &[Vec<bool>]) -> Stage<'g, 'a> {
        let count = ground.problem.unknowns.len() + accepted.len();
        let mut whiteners = Vec::new();
        let mut y = Vec::new();
        let mut base = Vec::new();
        let mut normal: DMatrix<f64> = DMatrix::identity(count, count);
        let mut right = DVector::zeros(count);
        let mut total = 0.0;
        for test in 0..ground.tests() {
            let whitener = Whitener::new(&noise[test], &kept[test]);
            let mut residual: Vec<f64> = ground.residual_mm[test].clone();
            whitener.apply(&mut residual);
            let rows = residual.len();
            let mut columns = DMatrix::zeros(rows, count);
            let nuisance = ground.problem.unknowns.len();
            columns.columns_mut(0, nuisance).copy_from(&ground.nuisance[test]);
            for (k, column) in accepted.iter().enumerate() {
                if !column.by_test[test].is_empty() {
                    for (row, value) in column.by_test[test].iter().enumerate() {
                        columns[(row, nuisance + k)] = value * ACCEPTED_PRIOR;
                    }
                }
            }
            for mut column in columns.column_iter_mut() {
                if column.iter().any(|value| *value != 0.0) {
                    whitener.apply(column.as_mut_slice());
                }
            }
            let residual = DVector::from_vec(residual);
            normal += columns.tr_mul(&columns);
            right += columns.tr_mul(&residual);
            total += residual.norm_squared();
            whiteners.push(whitener);
            y.push(residual);
            base.push(columns);
        }
        let factor = Cholesky::new(normal).unwrap_or_else(|| {
            // the unit prior makes the matrix definite; only values that are not finite can spoil it
            Cholesky::new_with_substitute(DMatrix::identity(count, count), 1.0).expect("unit matrix")
        });
        let amplitudes = factor.solve(&right);
        let misfit = total - right.dot(&amplitudes);
        Stage { ground, noise: noise.to_vec(), whiteners, y, base, factor, amplitudes, misfit }
    }

    /// Amplitude and sigma of an accepted column, display units.
    pub fn accepted(&self, index: usize) -> (f64, f64) {
        let k = self.ground.problem.unknowns.len() + index;
        let mut unit = DVector::zeros(self.amplitudes.len());
        unit[k] = 1.0;
        let variance = self.factor.solve(&unit)[k];
        (self.amplitudes[k] * ACCEPTED_PRIOR, variance.sqrt() * ACCEPTED_PRIOR)
    }

    /// Covariance of all fitted amplitudes: nuisance in units of the priors, accepted in display units.
    pub fn covariance(&self) -> DMatrix<f64> {
        let mut covariance = self.factor.inverse();
        let nuisance = self.ground.problem.unknowns.len();
        for k in nuisance..covariance.nrows() {
            covariance.row_mut(k).scale_mut(ACCEPTED_PRIOR);
            covariance.column_mut(k).scale_mut(ACCEPTED_PRIOR);
        }
        covariance
    }

    /// Residuals left by nuisance and accepted columns, mm; NaN where there is no reading.
    pub fn residual_mm(&self, accepted: &[Column]) -> Vec<Vec<f64>> {
        let nuisance = self.ground.problem.unknowns.len();
        let fitted = self.amplitudes.rows(0, nuisance);
        (0..self.ground.tests())
            .map(|test| {
                let model = &self.ground.nuisance[test] * fitted;
                let mut residual: Vec<f64> =
                    self.ground.residual_mm[test].iter().zip(model.iter()).map(|(r, m)| r - m).collect();
                for (k, column) in accepted.iter().enumerate() {
                    let size = self.amplitudes[nuisance + k] * ACCEPTED_PRIOR;
                    for (value, column) in residual.iter_mut().zip(&column.by_test[test]) {
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
            for (a, &j) in present.iter().enumerate() {
                z[j] += local_z[a];
                for (b, &k) in present.iter().enumerate() {
                    gram[(j, k)] += local_gram[(a, b)];
                }
                let mut target = cross.column_mut(j);
                target += local_cross.column(a);
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

    /// Judges a block.
    pub fn judge(&self, columns: &[Column]) -> Judgement {
        let (information, z) = self.project(columns);
        judge(information, z)
    }
}

/// Amplitude priors that are tried, display units: the one with the largest evidence counts.
const AMPLITUDE_PRIORS: [f64; 7] = [0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0];

/// Evidence of a block from its projected information and score.
pub fn judge(information: DMatrix<f64>, z: DVector<f64>) -> Judgement {
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
    let tau = AMPLITUDE_PRIORS.into_iter().max_by(|a, b| evidence(*a).total_cmp(&evidence(*b))).unwrap_or(1.0);
    let mut amplitudes = DVector::zeros(count);
    let mut covariance = DMatrix::zeros(count, count);
    let mut chi2 = 0.0;
    for k in 0..count {
        let lambda = eigen.eigenvalues[k].max(0.0);
        let precision = lambda + 1.0 / (tau * tau);
        let v = eigen.eigenvectors.column(k);
        amplitudes += v * (w[k] / precision);
        covariance += v * v.transpose() / precision;
        chi2 += w[k] * w[k] / precision;
    }
    // one nat for having chosen τ from the data
    let log_evidence = evidence(tau) - 1.0;
    Judgement { log_evidence, chi2, amplitudes: amplitudes.iter().copied().collect(), covariance, information }
}
