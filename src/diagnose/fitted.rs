//! Least squares with priors where many columns act in one test alone: those are eliminated test by test. It whitens nothing.
//!
//! With `L` the columns of one test and `g` all others, the normal matrix has the blocks `N_LL` (one per test), `N_Lg` and
//! `N_gg`; what is left of the others is `N_gg − Σ N_gL N_LL⁻¹ N_Lg`. A vibration has a cosine and a sine in each of fifty
//! tests: the work then grows with the tests and not with their cube.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::stage::{Judgement, likeliest_prior};
use super::whitened::Products;

/// Columns that were fitted, all in units of their priors.
pub struct Fitted {
    /// Amplitudes of all columns.
    pub amplitudes: DVector<f64>,
    /// Fall of the weighted sum of squares.
    pub explained: f64,
    /// Columns that act in several tests.
    shared: Vec<usize>,
    /// Normal matrix of the shared columns with the others eliminated, and its factor.
    normal: DMatrix<f64>,
    factor: Cholesky<f64, Dyn>,
    /// By test: the columns that act in it alone.
    local: Vec<Option<Local>>,
    /// By test: the shared columns that it sees, as places among them.
    seen: Vec<Vec<usize>>,
}

/// Columns of one test.
struct Local {
    columns: Vec<usize>,
    factor: Cholesky<f64, Dyn>,
    /// Products with the shared columns that the test sees: own × seen.
    with_seen: DMatrix<f64>,
}

/// A candidate's columns in one test, what acts there alone eliminated.
struct Block {
    columns: Vec<usize>,
    gram: DMatrix<f64>,
    /// Products with the shared columns: shared × own.
    cross: DMatrix<f64>,
    z: DVector<f64>,
    test: usize,
}

impl Fitted {
    /// Fits columns; `local` tells those that act in one test alone.
    ///
    /// By test, `seen` lists the columns and `sums` the products of all pairs (row by row, lower triangle), those with the
    /// readings last. `beyond` is how far the first columns, all of them shared, are from their prior means already.
    pub fn new(local: &[bool], beyond: &[f64], seen: &[Vec<usize>], sums: &[Vec<f64>]) -> Fitted {
        let shared: Vec<usize> = (0..local.len()).filter(|&i| !local[i]).collect();
        let mut place = vec![0; local.len()];
        shared.iter().enumerate().for_each(|(at, &i)| place[i] = at);
        let mut normal: DMatrix<f64> = DMatrix::identity(shared.len(), shared.len());
        let mut right = DVector::zeros(shared.len());
        beyond.iter().enumerate().for_each(|(i, beyond)| right[place[i]] = -beyond);
        let (mut locals, mut all_seen, mut own_right) = (Vec::new(), Vec::new(), Vec::new());
        for (seen, sums) in seen.iter().zip(sums) {
            let width = seen.len() + 1;
            let product = |a: usize, b: usize| sums[a.max(b) * width + a.min(b)];
            let (own, others): (Vec<usize>, Vec<usize>) = (0..seen.len()).partition(|&a| local[seen[a]]);
            let places: Vec<usize> = others.iter().map(|&a| place[seen[a]]).collect();
            for (&a, &i) in others.iter().zip(&places) {
                right[i] += product(seen.len(), a);
                for (&b, &j) in others.iter().zip(&places) {
                    normal[(i, j)] += product(a, b);
                }
            }
            let readings = DVector::from_iterator(own.len(), own.iter().map(|&a| product(seen.len(), a)));
            locals.push((!own.is_empty()).then(|| {
                let gram = DMatrix::from_fn(own.len(), own.len(), |a, b| product(own[a], own[b]));
                let factor = definite(gram + DMatrix::identity(own.len(), own.len()));
                let with_seen = DMatrix::from_fn(own.len(), others.len(), |a, b| product(own[a], others[b]));
                let solved = factor.solve(&with_seen);
                let loss = with_seen.tr_mul(&solved);
                let right_loss = solved.tr_mul(&readings);
                for (a, &i) in places.iter().enumerate() {
                    right[i] -= right_loss[a];
                    places.iter().enumerate().for_each(|(b, &j)| normal[(i, j)] -= loss[(a, b)]);
                }
                Local { columns: own.iter().map(|&a| seen[a]).collect(), factor, with_seen }
            }));
            all_seen.push(places);
            own_right.push(readings);
        }
        let factor = definite(normal.clone());
        let solved = factor.solve(&right);
        let mut explained = right.dot(&solved);
        let mut amplitudes = DVector::zeros(local.len());
        shared.iter().zip(solved.iter()).for_each(|(&i, value)| amplitudes[i] = *value);
        for ((local, seen), readings) in locals.iter().zip(&all_seen).zip(&own_right) {
            let Some(local) = local else { continue };
            explained += readings.dot(&local.factor.solve(readings));
            let by_shared = DVector::from_iterator(seen.len(), seen.iter().map(|&place| solved[place]));
            let own = local.factor.solve(&(readings - &local.with_seen * by_shared));
            local.columns.iter().zip(own.iter()).for_each(|(&i, value)| amplitudes[i] = *value);
        }
        Fitted { amplitudes, explained, shared, normal, factor, local: locals, seen: all_seen }
    }

    /// Covariance of all amplitudes.
    pub fn covariance(&self) -> DMatrix<f64> {
        let count = self.amplitudes.len();
        let own = self.factor.inverse();
        // how all columns follow the shared ones
        let mut follow = DMatrix::zeros(count, self.shared.len());
        self.shared.iter().enumerate().for_each(|(place, &i)| follow[(i, place)] = 1.0);
        let mut alone = DMatrix::zeros(count, count);
        for (local, seen) in self.local.iter().zip(&self.seen) {
            let Some(local) = local else { continue };
            let solved = local.factor.solve(&local.with_seen);
            let inverse = local.factor.inverse();
            for (a, &i) in local.columns.iter().enumerate() {
                seen.iter().enumerate().for_each(|(b, &place)| follow[(i, place)] = -solved[(a, b)]);
                local.columns.iter().enumerate().for_each(|(b, &j)| alone[(i, j)] = inverse[(a, b)]);
            }
        }
        &follow * own * follow.transpose() + alone
    }

    /// Projected `G` and `z` of a block; `with_accepted` are its products with the columns behind the unknowns.
    pub fn projected(&self, products: &Products, with_accepted: &DMatrix<f64>) -> (DMatrix<f64>, DVector<f64>) {
        let (mut gram, mut z) = (products.gram.clone(), self.score(products, with_accepted));
        let mut cross = self.shared_rows(products, with_accepted);
        let raw_diagonal: Vec<f64> = (0..z.len()).map(|j| gram[(j, j)]).collect();
        for (local, seen) in self.local.iter().zip(&self.seen) {
            let Some(local) = local else { continue };
            let own = local.rows_of(with_accepted, products.cross.nrows());
            let solved = local.factor.solve(&own);
            gram -= own.tr_mul(&solved);
            let taken = local.with_seen.tr_mul(&solved);
            for (b, &place) in seen.iter().enumerate() {
                let mut row = cross.row_mut(place);
                row -= taken.row(b);
            }
        }
        gram -= cross.tr_mul(&self.factor.solve(&cross));
        for j in 0..z.len() {
            // what rounding leaves of a column that the fit explains wholly is nothing
            if gram[(j, j)] < 1e-9 * raw_diagonal[j] {
                gram.row_mut(j).fill(0.0);
                gram.column_mut(j).fill(0.0);
                z[j] = 0.0;
            }
        }
        (gram, z)
    }

    /// Products of a block with what the fit leaves of the readings.
    fn score(&self, products: &Products, with_accepted: &DMatrix<f64>) -> DVector<f64> {
        let (unknowns, accepted) = (products.cross.nrows(), with_accepted.nrows());
        let mut z = products.z.clone();
        z -= products.cross.tr_mul(&self.amplitudes.rows(0, unknowns));
        z -= with_accepted.tr_mul(&self.amplitudes.rows(unknowns, accepted));
        z
    }

    /// Products of a block with the shared columns.
    fn shared_rows(&self, products: &Products, with_accepted: &DMatrix<f64>) -> DMatrix<f64> {
        let unknowns = products.cross.nrows();
        let mut cross = DMatrix::zeros(self.shared.len(), products.z.len());
        for (place, &i) in self.shared.iter().enumerate() {
            let row = if i < unknowns { products.cross.row(i) } else { with_accepted.row(i - unknowns) };
            cross.row_mut(place).copy_from(&row);
        }
        cross
    }

    /// Judges a block whose columns act in one test each, `homes`, with amplitudes plausible up to `plausible` display units.
    ///
    /// With `E` the blocks of the tests with the prior and `C` their products with the shared columns, the projected matrix
    /// is `E − Cᵀ N⁻¹ C`; determinant and inverse follow from those of `E` and of `N − C E⁻¹ Cᵀ` (Woodbury).
    pub fn judge_by_test(
        &self,
        products: &Products,
        with_accepted: &DMatrix<f64>,
        homes: &[usize],
        plausible: f64,
    ) -> Judgement {
        let count = homes.len();
        let z = self.score(products, with_accepted);
        let cross = self.shared_rows(products, with_accepted);
        let blocks: Vec<Block> = (0..self.seen.len())
            .filter_map(|test| {
                let columns: Vec<usize> = (0..count).filter(|&j| homes[j] == test).collect();
                (!columns.is_empty()).then(|| self.block(test, columns, products, with_accepted, (&cross, &z)))
            })
            .collect();
        let log_normal = log_determinant(&self.factor);
        let solved = |tau: f64| {
            let mut normal = self.normal.clone();
            let mut u = DVector::zeros(self.shared.len());
            let (mut log_ratio, mut square) = (2.0 * count as f64 * tau.ln() - log_normal, 0.0);
            let mut parts = Vec::with_capacity(blocks.len());
            for block in &blocks {
                let own = block.columns.len();
                let factor = definite(&block.gram + DMatrix::identity(own, own) / (tau * tau));
                log_ratio += log_determinant(&factor);
                let x = factor.solve(&block.z);
                let follow = factor.solve(&block.cross.transpose());
                square += block.z.dot(&x);
                let seen = &self.seen[block.test];
                let taken = &block.cross * &follow;
                let pull = &block.cross * &x;
                for (a, &i) in seen.iter().enumerate() {
                    u[i] += pull[a];
                    seen.iter().enumerate().for_each(|(b, &j)| normal[(i, j)] -= taken[(a, b)]);
                }
                parts.push((x, follow));
            }
            let factor = definite(normal);
            let v = factor.solve(&u);
            log_ratio += log_determinant(&factor);
            square += u.dot(&v);
            (0.5 * (square - log_ratio), square, parts, v)
        };
        let tau = likeliest_prior(plausible, |tau| solved(tau).0);
        let (evidence, chi2, parts, v) = solved(tau);
        let mut amplitudes = vec![0.0; count];
        for (block, (x, follow)) in blocks.iter().zip(parts) {
            let seen = &self.seen[block.test];
            let by_shared = DVector::from_iterator(seen.len(), seen.iter().map(|&place| v[place]));
            let own = x + follow * by_shared;
            block.columns.iter().zip(own.iter()).for_each(|(&j, value)| amplitudes[j] = *value);
        }
        // one nat for having chosen τ from the data
        Judgement { log_evidence: evidence - 1.0, chi2, tau, amplitudes }
    }

    /// A candidate's columns in one test.
    fn block(
        &self,
        test: usize,
        columns: Vec<usize>,
        products: &Products,
        with_accepted: &DMatrix<f64>,
        (cross, z): (&DMatrix<f64>, &DVector<f64>),
    ) -> Block {
        let own = columns.len();
        let seen = &self.seen[test];
        let mut gram = DMatrix::from_fn(own, own, |a, b| products.gram[(columns[a], columns[b])]);
        let mut with_seen = DMatrix::from_fn(seen.len(), own, |a, b| cross[(seen[a], columns[b])]);
        if let Some(local) = &self.local[test] {
            let rows = local.rows_of(with_accepted, products.cross.nrows());
            let rows = DMatrix::from_fn(rows.nrows(), own, |a, b| rows[(a, columns[b])]);
            let solved = local.factor.solve(&rows);
            gram -= rows.tr_mul(&solved);
            with_seen -= local.with_seen.tr_mul(&solved);
        }
        let z = DVector::from_iterator(own, columns.iter().map(|&j| z[j]));
        Block { columns, gram, cross: with_seen, z, test }
    }
}

impl Local {
    /// The rows of these columns among the products with all accepted ones, which follow `unknowns` others.
    fn rows_of(&self, with_accepted: &DMatrix<f64>, unknowns: usize) -> DMatrix<f64> {
        DMatrix::from_fn(self.columns.len(), with_accepted.ncols(), |a, j| {
            with_accepted[(self.columns[a] - unknowns, j)]
        })
    }
}

fn log_determinant(factor: &Cholesky<f64, Dyn>) -> f64 {
    let lower = factor.l_dirty();
    2.0 * (0..lower.nrows()).map(|k| lower[(k, k)].ln()).sum::<f64>()
}

/// Factor of a matrix that its priors make definite: only values that are not finite can spoil it.
fn definite(matrix: DMatrix<f64>) -> Cholesky<f64, Dyn> {
    let count = matrix.nrows();
    Cholesky::new(matrix).unwrap_or_else(|| Cholesky::pack_dirty(DMatrix::identity(count, count)))
}
