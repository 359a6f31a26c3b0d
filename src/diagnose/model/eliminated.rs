//! Least squares with priors where many columns act in one test alone: those are eliminated test by test. It whitens nothing.
//!
//! With `L` the columns of one test and `g` all others, the normal matrix has the blocks `N_LL` (one per test), `N_Lg` and
//! `N_gg`; what is left of the others is `N_gg − Σ N_gL N_LL⁻¹ N_Lg`. A vibration has a cosine and a sine in each of fifty
//! tests: the work then grows with the tests and not with their cube.

use crate::statistics::{BlockEvidence, likeliest_prior, log_determinant};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, SymmetricEigen};

use super::linear_model::CrossProducts;
use super::whitened::Products;

/// Columns that were fitted, all in units of their priors.
#[derive(Clone)]
pub struct EliminatedNormal {
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
    /// By test: the shared columns behind the unknowns that act there.
    shared_in: Vec<Vec<usize>>,
    /// Number of unknowns of the fit: the first columns.
    unknowns: usize,
}

/// Columns of one test.
#[derive(Clone)]
struct Local {
    columns: Vec<usize>,
    factor: Cholesky<f64, Dyn>,
    /// Products with the shared columns that the test sees: own × seen.
    with_seen: DMatrix<f64>,
    basis: Basis,
}

/// The columns of one test mixed so that their matrix with the prior, `N_LL = Q Λ Qᵀ`, is one: `Q Λ^-1/2`. What they take off a
/// product is then the product of two products. Directions that the readings hardly show take nothing and are left out.
#[derive(Clone)]
struct Basis {
    /// Columns × directions.
    mix: DMatrix<f64>,
    /// Products with the shared columns that the test sees: directions × seen.
    with_seen: DMatrix<f64>,
    /// What was fitted, in these directions.
    amplitudes: DVector<f64>,
}

/// Information of a direction, in units of its prior's, below which it is left out.
const HARDLY_SHOWN: f64 = 1e-6;

impl Basis {
    fn new(gram: &DMatrix<f64>, with_seen: &DMatrix<f64>) -> Basis {
        let eigen = SymmetricEigen::new(gram.clone());
        let shown: Vec<usize> = (0..gram.nrows()).filter(|&k| eigen.eigenvalues[k] > HARDLY_SHOWN).collect();
        let mix = DMatrix::from_fn(gram.nrows(), shown.len(), |a, k| {
            eigen.eigenvectors[(a, shown[k])] / (eigen.eigenvalues[shown[k]] + 1.0).sqrt()
        });
        let with_seen = mix.transpose() * with_seen;
        Basis { mix, with_seen, amplitudes: DVector::zeros(shown.len()) }
    }

    /// Takes amplitudes of the columns: `mixᵀ N_LL` is the inverse of `mix`.
    fn set(&mut self, gram: &DMatrix<f64>, own: &DVector<f64>) {
        self.amplitudes = self.mix.transpose() * (gram * own + own);
    }
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

impl EliminatedNormal {
    /// Fits columns; `is_local` tells those that act in one test alone.
    ///
    /// By test, `seen` lists the columns and `sums` the products of all pairs (row by row, lower triangle), those with the
    /// readings last. `beyond` is how far the first columns, all of them shared, are from their prior means already.
    pub fn new(is_local: &[bool], beyond: &[f64], seen: &[Vec<usize>], sums: &[Vec<f64>]) -> EliminatedNormal {
        let shared: Vec<usize> = (0..is_local.len()).filter(|&i| !is_local[i]).collect();
        let mut place = vec![0; is_local.len()];
        shared.iter().enumerate().for_each(|(at, &i)| place[i] = at);
        let mut normal: DMatrix<f64> = DMatrix::identity(shared.len(), shared.len());
        let mut right = DVector::zeros(shared.len());
        beyond.iter().enumerate().for_each(|(i, beyond)| right[place[i]] = -beyond);
        let (mut locals, mut all_seen, mut own_right) = (Vec::new(), Vec::new(), Vec::new());
        for (seen, sums) in seen.iter().zip(sums) {
            let width = seen.len() + 1;
            let product = |a: usize, b: usize| sums[a.max(b) * width + a.min(b)];
            let (own, others): (Vec<usize>, Vec<usize>) = (0..seen.len()).partition(|&a| is_local[seen[a]]);
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
                let factor = definite(&gram + DMatrix::identity(own.len(), own.len()));
                let with_seen = DMatrix::from_fn(own.len(), others.len(), |a, b| product(own[a], others[b]));
                let solved = factor.solve(&with_seen);
                let loss = with_seen.tr_mul(&solved);
                let right_loss = solved.tr_mul(&readings);
                for (a, &i) in places.iter().enumerate() {
                    right[i] -= right_loss[a];
                    places.iter().enumerate().for_each(|(b, &j)| normal[(i, j)] -= loss[(a, b)]);
                }
                let basis = Basis::new(&gram, &with_seen);
                let columns = own.iter().map(|&a| seen[a]).collect();
                (Local { columns, factor, with_seen, basis }, gram)
            }));
            all_seen.push(places);
            own_right.push(readings);
        }
        let factor = definite(normal.clone());
        let solved = factor.solve(&right);
        let mut explained = right.dot(&solved);
        let mut amplitudes = DVector::zeros(is_local.len());
        shared.iter().zip(solved.iter()).for_each(|(&i, value)| amplitudes[i] = *value);
        for ((local, seen), readings) in locals.iter_mut().zip(&all_seen).zip(&own_right) {
            let Some((local, gram)) = local else { continue };
            explained += readings.dot(&local.factor.solve(readings));
            let by_shared = DVector::from_iterator(seen.len(), seen.iter().map(|&place| solved[place]));
            let own = local.factor.solve(&(readings - &local.with_seen * by_shared));
            local.columns.iter().zip(own.iter()).for_each(|(&i, value)| amplitudes[i] = *value);
            local.basis.set(gram, &own);
        }
        let unknowns = beyond.len();
        let local = locals.into_iter().map(|local| local.map(|(local, _)| local)).collect();
        let shared_in =
            seen.iter().map(|seen| seen.iter().filter(|&&i| i >= unknowns && !is_local[i]).copied().collect());
        let shared_in = shared_in.collect();
        EliminatedNormal { amplitudes, explained, shared, normal, factor, local, seen: all_seen, shared_in, unknowns }
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

    /// Columns of a test as products are taken with them: the shared ones behind the unknowns, then those of the test alone in
    /// the directions of their basis. `present` numbers the columns given, `rows` numbers each, behind the unknowns.
    pub fn as_it_has_them(&self, test: usize, present: &[usize], columns: &[f64], rows: usize) -> Vec<f64> {
        let column = |i: usize| {
            let place = present.iter().position(|&k| k + self.unknowns == i);
            place.map(|place| &columns[place * rows..(place + 1) * rows])
        };
        let mut all: Vec<f64> = Vec::new();
        for &i in &self.shared_in[test] {
            all.extend(column(i).unwrap_or_default());
        }
        let Some(local) = &self.local[test] else { return all };
        let own: Vec<&[f64]> = local.columns.iter().filter_map(|&i| column(i)).collect();
        for direction in local.basis.mix.column_iter() {
            let mut mixed = vec![0.0; rows];
            for (column, share) in own.iter().zip(direction.iter()) {
                mixed.iter_mut().zip(*column).for_each(|(sum, value)| *sum += share * value);
            }
            all.extend(mixed);
        }
        all
    }

    /// Projected `G` and `z` of a block; `with_accepted` are its products with the columns behind the unknowns, by test.
    pub fn projected(&self, products: &Products, with_accepted: &[CrossProducts]) -> (DMatrix<f64>, DVector<f64>) {
        let (mut gram, mut z) = (products.gram(), self.score(products, with_accepted));
        let mut cross = self.shared_rows(products, with_accepted);
        let raw_diagonal: Vec<f64> = (0..z.len()).map(|j| gram[(j, j)]).collect();
        let all: Vec<usize> = (0..z.len()).collect();
        for (test, with_accepted) in with_accepted.iter().enumerate() {
            let Some(local) = &self.local[test] else { continue };
            let own = self.rows_of(test, with_accepted, &all);
            gram -= own.transpose() * &own;
            let taken = local.basis.with_seen.transpose() * &own;
            for (b, &place) in self.seen[test].iter().enumerate() {
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
    pub fn score(&self, products: &Products, with_accepted: &[CrossProducts]) -> DVector<f64> {
        let unknowns = products.cross.nrows();
        let mut z = products.z.clone();
        z -= products.cross.tr_mul(&self.amplitudes.rows(0, unknowns));
        for (test, with) in with_accepted.iter().enumerate() {
            let shared = self.shared_in[test].iter().map(|&i| self.amplitudes[i]);
            let own = self.local[test].iter().flat_map(|local| local.basis.amplitudes.iter().copied());
            for (a, amplitude) in shared.chain(own).enumerate().take(with.values.nrows()) {
                with.columns.iter().enumerate().for_each(|(b, &j)| z[j] -= amplitude * with.values[(a, b)]);
            }
        }
        z
    }

    /// Products of a block with the shared columns.
    fn shared_rows(&self, products: &Products, with_accepted: &[CrossProducts]) -> DMatrix<f64> {
        let unknowns = products.cross.nrows();
        let mut cross = DMatrix::zeros(self.shared.len(), products.z.len());
        let mut places = vec![None; self.amplitudes.len()];
        for (place, &i) in self.shared.iter().enumerate() {
            places[i] = Some(place);
            if i < unknowns {
                cross.row_mut(place).copy_from(&products.cross.row(i));
            }
        }
        for (with, shared) in with_accepted.iter().zip(&self.shared_in) {
            for (a, &i) in shared.iter().enumerate().take(with.values.nrows()) {
                let Some(place) = places[i] else { continue };
                with.columns.iter().enumerate().for_each(|(b, &j)| cross[(place, j)] += with.values[(a, b)]);
            }
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
        with_accepted: &[CrossProducts],
        homes: &[usize],
        plausible: f64,
    ) -> BlockEvidence {
        let count = homes.len();
        let z = self.score(products, with_accepted);
        let cross = self.shared_rows(products, with_accepted);
        let mut columns = vec![Vec::new(); self.seen.len()];
        homes.iter().enumerate().for_each(|(j, &home)| columns[home].push(j));
        let of_tests = columns.into_iter().enumerate().filter(|(_, columns)| !columns.is_empty());
        let blocks: Vec<Block> = of_tests
            .map(|(test, columns)| self.block(test, columns, products, &with_accepted[test], (&cross, &z)))
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
        BlockEvidence { log_evidence: evidence - 1.0, chi2, tau, amplitudes }
    }

    /// Products of some columns with those that act in a test alone: directions of their basis × columns.
    fn rows_of(&self, test: usize, with_accepted: &CrossProducts, columns: &[usize]) -> DMatrix<f64> {
        let first = self.shared_in[test].len();
        let directions = with_accepted.values.nrows().saturating_sub(first);
        let places: Vec<Option<usize>> = columns.iter().map(|j| with_accepted.columns.binary_search(j).ok()).collect();
        DMatrix::from_fn(directions, columns.len(), |a, b| {
            places[b].map_or(0.0, |b| with_accepted.values[(first + a, b)])
        })
    }

    /// A candidate's columns in one test.
    fn block(
        &self,
        test: usize,
        columns: Vec<usize>,
        products: &Products,
        with_accepted: &CrossProducts,
        (cross, z): (&DMatrix<f64>, &DVector<f64>),
    ) -> Block {
        let own = columns.len();
        let seen = &self.seen[test];
        let mut gram = products.gram_in(test, &columns);
        let mut with_seen = DMatrix::from_fn(seen.len(), own, |a, b| cross[(seen[a], columns[b])]);
        if let Some(local) = &self.local[test] {
            let rows = self.rows_of(test, with_accepted, &columns);
            gram -= rows.transpose() * &rows;
            with_seen -= local.basis.with_seen.transpose() * &rows;
        }
        let z = DVector::from_iterator(own, columns.iter().map(|&j| z[j]));
        Block { columns, gram, cross: with_seen, z, test }
    }
}

/// Factor of a matrix that its priors make definite: only values that are not finite can spoil it.
fn definite(matrix: DMatrix<f64>) -> Cholesky<f64, Dyn> {
    let count = matrix.nrows();
    Cholesky::new(matrix).unwrap_or_else(|| Cholesky::pack_dirty(DMatrix::identity(count, count)))
}
