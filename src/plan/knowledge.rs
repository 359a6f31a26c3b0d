//! What is known after some tests: the covariance of errors and setup quantities, updated test by test. First order, no files.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use nalgebra::{DMatrix, DVector};

use super::information::{Block, LOOSE, Nuisance, Unknowns};

/// Covariance of all unknowns after some tests.
#[derive(Debug, Clone)]
pub struct Knowledge {
    covariance: DMatrix<f64>,
    /// Variances before any test, by column of the covariance.
    priors: Vec<f64>,
    /// Columns of pivots and bars, whose priors count as such in a fit.
    is_fitted_setup: Vec<bool>,
    place_of: HashMap<Nuisance, usize, BuildHasherDefault<Mix>>,
    wanted: usize,
    setup_factor: f64,
}

impl Knowledge {
    /// Before any test.
    pub fn before(unknowns: &Unknowns) -> Knowledge {
        let covariance = DMatrix::from_diagonal(&DVector::from_column_slice(&unknowns.prior_variance));
        let priors = unknowns.prior_variance.clone();
        let is_fitted_setup = vec![false; priors.len()];
        let place_of = HashMap::default();
        Knowledge { covariance, priors, is_fitted_setup, place_of, wanted: unknowns.wanted, setup_factor: 1.0 }
    }

    /// Before any test, with pivots and bars that count as unknown: so that no plan rests on how well they are known.
    pub fn before_with_loose_setups(unknowns: &Unknowns) -> Knowledge {
        Knowledge { setup_factor: LOOSE, ..Knowledge::before(unknowns) }
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
    pub fn knows(&self, nuisance: &Nuisance) -> bool {
        self.place_of.contains_key(nuisance)
    }

    /// Variances of the wanted errors if this test were added.
    pub fn variances_with(&self, block: &Block) -> Vec<f64> {
        let Some((cross, weighted)) = self.gain(block) else { return self.variances() };
        (0..self.wanted).map(|k| self.covariance[(k, k)] - cross.row(k).dot(&weighted.row(k))).collect()
    }

    /// `P Hᵀ` of the wanted errors and the same times `S⁻¹`.
    fn gain(&self, block: &Block) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let rows = block.errors.nrows();
        // P Hᵀ over the columns that the block touches
        let mut ph = self.covariance.columns(0, block.errors.ncols()) * block.errors.transpose();
        let mut s = DMatrix::identity(rows, rows) * block.row_variance;
        for (nuisance, columns, variance) in &block.nuisances {
            match self.place_of.get(nuisance) {
                Some(&place) => ph += self.covariance.columns(place, columns.ncols()) * columns.transpose(),
                None => s += columns * columns.transpose() * self.prior(nuisance, *variance),
            }
        }
        s += &block.errors * ph.rows(0, block.errors.ncols());
        for (nuisance, columns, _) in &block.nuisances {
            if let Some(&place) = self.place_of.get(nuisance) {
                s += columns * ph.rows(place, columns.ncols());
            }
        }
        let factor = s.cholesky()?;
        let cross = ph.rows(0, self.wanted).into_owned();
        let weighted = factor.solve(&cross.transpose()).transpose();
        Some((cross, weighted))
    }

    /// Adds a test.
    pub fn add(&mut self, block: &Block) {
        self.make_room(block);
        // P Hᵀ over the columns that the block touches
        let errors = block.errors.ncols();
        let mut ph = self.covariance.columns(0, errors) * block.errors.transpose();
        for (nuisance, columns, _) in &block.nuisances {
            let place = self.place_of[nuisance];
            ph.gemm(1.0, &self.covariance.columns(place, columns.ncols()), &columns.transpose(), 1.0);
        }
        let rows = block.errors.nrows();
        let mut s = DMatrix::identity(rows, rows) * block.row_variance;
        s.gemm(1.0, &block.errors, &ph.rows(0, errors), 1.0);
        for (nuisance, columns, _) in &block.nuisances {
            s.gemm(1.0, columns, &ph.rows(self.place_of[nuisance], columns.ncols()), 1.0);
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
        for (nuisance, columns, variance) in &block.nuisances {
            if self.place_of.contains_key(nuisance) {
                continue;
            }
            let prior = self.prior(nuisance, *variance);
            self.priors.extend(columns.column_iter().map(|_| prior));
            self.is_fitted_setup.extend(columns.column_iter().map(|_| nuisance.is_fitted()));
            self.place_of.insert(nuisance.clone(), size);
            size += columns.ncols();
        }
        if size > old {
            self.covariance.resize_mut(size, size, 0.0);
            (old..size).for_each(|k| self.covariance[(k, k)] = self.priors[k]);
        }
    }
}

/// Hashes setup quantities: a few integers each, looked up for every candidate of every round.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Mix(u64);

impl Hasher for Mix {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks::<8>();
        words.iter().for_each(|word| self.write_u64(u64::from_le_bytes(*word)));
        if !rest.is_empty() {
            self.write_u64(rest.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte)));
        }
    }

    fn write_u64(&mut self, word: u64) {
        let mixed = (self.0.rotate_left(5) ^ word).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        // the table takes its bucket from the low bits
        self.0 = mixed ^ (mixed >> 32);
    }

    fn write_u8(&mut self, byte: u8) {
        self.write_u64(u64::from(byte));
    }

    fn write_usize(&mut self, word: usize) {
        self.write_u64(word as u64);
    }
}
