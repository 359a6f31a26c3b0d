//! What is known after some tests: the covariance of errors and setup quantities, updated test by test. First order, no files.

use nalgebra::{DMatrix, DVector};

use super::block::{BLOCK_ROWS, Block, LOOSE, Nuisance, Part};
use super::unknowns::Unknowns;

/// Covariance of all unknowns after some tests.
#[derive(Debug, Clone)]
pub struct Posterior {
    covariance: DMatrix<f64>,
    /// Variances before any test, by column of the covariance.
    priors: Vec<f64>,
    /// Columns of pivots and bars, whose priors count as such in a fit.
    is_fitted_setup: Vec<bool>,
    /// Setup quantities with their hash and first column: a few dozen at most, so a hash compares faster than a table finds.
    places: Vec<(u64, Nuisance, usize)>,
    /// Bits of their hashes: most quantities that are asked for are new, and one look tells.
    seen: u64,
    wanted: usize,
    setup_factor: f64,
}

impl Posterior {
    /// Before any test.
    pub fn before(unknowns: &Unknowns) -> Posterior {
        let mut covariance = DMatrix::from_diagonal(&DVector::from_column_slice(&unknowns.prior_variance));
        for own_line in &unknowns.along_own_lines {
            // shifts have one prior, and turns have: what is left is the part across the line
            for &(one, of_one) in own_line {
                for &(other, of_other) in own_line {
                    covariance[(one, other)] -= of_one * of_other * unknowns.prior_variance[one];
                }
            }
        }
        let priors = unknowns.prior_variance.clone();
        let is_fitted_setup = vec![false; priors.len()];
        Posterior {
            covariance,
            priors,
            is_fitted_setup,
            places: Vec::new(),
            seen: 0,
            wanted: unknowns.wanted,
            setup_factor: 1.0,
        }
    }

    /// Before any test, with pivots and bars that count as unknown: so that no plan rests on how well they are known.
    pub fn before_with_loose_setups(unknowns: &Unknowns) -> Posterior {
        Posterior { setup_factor: LOOSE, ..Posterior::before(unknowns) }
    }

    fn prior(&self, nuisance: &Nuisance, variance: f64) -> f64 {
        if nuisance.is_fitted() { variance * self.setup_factor } else { variance }
    }

    /// Variances of the wanted errors, mm² and rad².
    pub fn variances(&self) -> Vec<f64> {
        (0..self.wanted).map(|k| self.covariance[(k, k)]).collect()
    }

    /// Covariance of two errors.
    pub fn covariance(&self, one: usize, other: usize) -> f64 {
        self.covariance[(one, other)]
    }

    /// Share of an error's variance that stems from the priors of the wanted errors, pivots and bars, 0 to 1:
    /// `Σ_j C_kj²/P_j / C_kk`; the rest comes from the noise of the data.
    pub fn prior_share(&self, error: usize) -> f64 {
        let from = |column: usize| self.covariance[(error, column)].powi(2) / self.priors[column];
        let counts = |column: &usize| *column < self.wanted || self.is_fitted_setup[*column];
        let all: f64 = (0..self.priors.len()).filter(counts).map(from).sum();
        (all / self.covariance[(error, error)]).clamp(0.0, 1.0)
    }

    /// True when a test used this setup quantity.
    pub(crate) fn knows(&self, part: &Part) -> bool {
        self.place_of(part).is_some()
    }

    /// First column of a setup quantity that a test used.
    fn place_of(&self, part: &Part) -> Option<usize> {
        if self.seen & bit(part.hash) == 0 {
            return None;
        }
        let is_it = |(hash, of, _): &&(u64, Nuisance, usize)| *hash == part.hash && *of == part.of;
        self.places.iter().find(is_it).map(|(.., place)| *place)
    }

    /// Variances of the wanted errors if this test were added: `P_kk − |L⁻¹·(H·P)_k|²` with `L·Lᵀ = H·P·Hᵀ + R`.
    pub fn variances_with(&self, block: &Block) -> Vec<f64> {
        let (rows, errors) = block.errors.shape();
        // columns of the covariance that the rows touch, as runs: first, derivatives
        let mut touched: Vec<(usize, &DMatrix<f64>)> = vec![(0, &block.errors)];
        let mut s = [[0.0; BLOCK_ROWS]; BLOCK_ROWS];
        (0..rows).for_each(|row| s[row][row] = block.row_variance);
        for part in &block.nuisances {
            match self.place_of(part) {
                Some(place) => touched.push((place, &part.columns)),
                None => add_spread(&mut s, &part.columns, self.prior(&part.of, part.variance)),
            }
        }
        // P Hᵀ, a stretch for every row, over the columns touched
        let count: usize = touched.iter().map(|(_, columns)| columns.ncols()).sum();
        let mut ph = vec![0.0; rows * count];
        let mut start = 0;
        for (place, columns) in &touched {
            let width = columns.ncols();
            for (other_place, other) in &touched {
                for (k, derivative) in other.column_iter().enumerate() {
                    let source = self.covariance.column(other_place + k);
                    let source = &source.as_slice()[*place..place + width];
                    for (row, value) in derivative.iter().enumerate().filter(|(_, value)| **value != 0.0) {
                        let target = &mut ph[row * count + start..row * count + start + width];
                        target.iter_mut().zip(source).for_each(|(to, from)| *to += value * from);
                    }
                }
            }
            start += width;
        }
        let mut start = 0;
        for (_, columns) in &touched {
            for (k, derivative) in columns.column_iter().enumerate() {
                for (row, value) in derivative.iter().enumerate() {
                    (0..=row).for_each(|other| s[row][other] += value * ph[other * count + start + k]);
                }
            }
            start += columns.ncols();
        }
        if !cholesky(&mut s, rows) {
            return self.variances();
        }
        debug_assert!(self.wanted <= errors);
        (0..self.wanted)
            .map(|k| {
                let mut solved = [0.0; BLOCK_ROWS];
                let mut told = 0.0;
                for row in 0..rows {
                    let before: f64 = (0..row).map(|other| s[row][other] * solved[other]).sum();
                    solved[row] = (ph[row * count + k] - before) / s[row][row];
                    told += solved[row] * solved[row];
                }
                self.covariance[(k, k)] - told
            })
            .collect()
    }

    /// Adds a test.
    pub fn add(&mut self, block: &Block) {
        self.make_room(block);
        // P Hᵀ over the columns that the block touches
        let errors = block.errors.ncols();
        let mut ph = self.covariance.columns(0, errors) * block.errors.transpose();
        let places: Vec<(usize, &DMatrix<f64>)> =
            block.nuisances.iter().filter_map(|part| Some((self.place_of(part)?, &part.columns))).collect();
        for (place, columns) in &places {
            ph.gemm(1.0, &self.covariance.columns(*place, columns.ncols()), &columns.transpose(), 1.0);
        }
        let rows = block.errors.nrows();
        let mut s = DMatrix::identity(rows, rows) * block.row_variance;
        s.gemm(1.0, &block.errors, &ph.rows(0, errors), 1.0);
        for (place, columns) in &places {
            s.gemm(1.0, columns, &ph.rows(*place, columns.ncols()), 1.0);
        }
        // P − P Hᵀ (L Lᵀ)⁻¹ H P as a square, so that it stays symmetric
        let Some(factor) = s.cholesky() else { return };
        let Some(half) = factor.l_dirty().solve_lower_triangular(&ph.transpose()) else { return };
        let half = half.transpose();
        for column in 0..self.covariance.ncols() {
            let mut target = self.covariance.column_mut(column);
            half.column_iter().for_each(|half| target.axpy(-half[column], &half, 1.0));
        }
    }

    /// Columns for the setup quantities of a block that no test used yet.
    fn make_room(&mut self, block: &Block) {
        let old = self.covariance.nrows();
        let mut size = old;
        for part in &block.nuisances {
            if self.knows(part) {
                continue;
            }
            let (prior, width) = (self.prior(&part.of, part.variance), part.columns.ncols());
            self.priors.extend((0..width).map(|_| prior));
            self.is_fitted_setup.extend((0..width).map(|_| part.of.is_fitted()));
            self.places.push((part.hash, part.of.clone(), size));
            self.seen |= bit(part.hash);
            size += width;
        }
        if size > old {
            self.covariance.resize_mut(size, size, 0.0);
            (old..size).for_each(|k| self.covariance[(k, k)] = self.priors[k]);
        }
    }
}

/// One bit for a hash.
fn bit(hash: u64) -> u64 {
    1 << (hash & 63)
}

/// Adds `variance·C·Cᵀ` to the lower triangle of a matrix.
fn add_spread(s: &mut [[f64; BLOCK_ROWS]; BLOCK_ROWS], columns: &DMatrix<f64>, variance: f64) {
    for column in columns.column_iter() {
        for (row, value) in column.iter().enumerate() {
            (0..=row).for_each(|other| s[row][other] += variance * value * column[other]);
        }
    }
}

/// Replaces the lower triangle of a matrix by its Cholesky factor; false where it is not positive definite.
fn cholesky(s: &mut [[f64; BLOCK_ROWS]; BLOCK_ROWS], rows: usize) -> bool {
    for row in 0..rows {
        for column in 0..=row {
            let before: f64 = (0..column).map(|k| s[row][k] * s[column][k]).sum();
            let rest = s[row][column] - before;
            if row > column {
                s[row][column] = rest / s[column][column];
            } else if rest > 0.0 {
                s[row][row] = rest.sqrt();
            } else {
                return false;
            }
        }
    }
    true
}
