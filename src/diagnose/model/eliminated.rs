//! Least squares with priors where many columns act in one test alone: those are eliminated test by test. It whitens nothing.
//!
//! With `L` the columns of one test and `g` all others, the normal matrix has the blocks `N_LL` (one per test), `N_Lg` and
//! `N_gg`; what is left of the others is `N_gg − Σ N_gL N_LL⁻¹ N_Lg`. A vibration has a cosine and a sine in each of fifty
//! tests: the work then grows with the tests and not with their cube.

use crate::statistics::{BlockEvidence, climbed, implausibility, log_determinant};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, SymmetricEigen};

use super::products::Products;

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
    /// Its diagonal before that: rounding goes by it.
    shared_squares: Vec<f64>,
    factor: Cholesky<f64, Dyn>,
    /// By test: the columns that act in it alone.
    local: Vec<Option<Local>>,
    /// By test: the shared columns that it sees, as places among them.
    seen: Vec<Vec<usize>>,
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
        Basis { mix, with_seen }
    }
}

/// A candidate's columns in one test, what acts there alone eliminated.
struct Block {
    columns: Vec<usize>,
    gram: DMatrix<f64>,
    /// The diagonal of that matrix before the elimination.
    squares: Vec<f64>,
    /// Products with the shared columns: shared × own.
    cross: DMatrix<f64>,
    z: DVector<f64>,
    test: usize,
}

impl Block {
    /// Factor of its matrix with amplitudes drawn from N(0, τ²).
    fn factor(&self, tau: f64) -> Cholesky<f64, Dyn> {
        let own = self.columns.len();
        definite(&(&self.gram + DMatrix::identity(own, own) / (tau * tau)), &self.squares, 1.0 / (tau * tau))
    }

    /// Its evidence without what it has in common with others.
    fn alone(&self, tau: f64) -> f64 {
        let factor = self.factor(tau);
        let log_ratio = 2.0 * self.columns.len() as f64 * tau.ln() + log_determinant(&factor);
        0.5 * (self.z.dot(&factor.solve(&self.z)) - log_ratio)
    }
}

/// Columns of single tests with a prior.
struct Solved {
    tau: f64,
    evidence: f64,
    /// Fall of the weighted sum of squares.
    chi2: f64,
    /// By block: amplitudes without the shared columns, and how they follow those.
    parts: Vec<(DVector<f64>, DMatrix<f64>)>,
    /// Amplitudes of the shared columns.
    v: DVector<f64>,
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
        let mut shared_squares = diagonal_of(&normal);
        for (seen, sums) in seen.iter().zip(sums) {
            let width = seen.len() + 1;
            let product = |a: usize, b: usize| sums[a.max(b) * width + a.min(b)];
            let (own, others): (Vec<usize>, Vec<usize>) = (0..seen.len()).partition(|&a| is_local[seen[a]]);
            let places: Vec<usize> = others.iter().map(|&a| place[seen[a]]).collect();
            for (&a, &i) in others.iter().zip(&places) {
                right[i] += product(seen.len(), a);
                shared_squares[i] += product(a, a);
                for (&b, &j) in others.iter().zip(&places) {
                    normal[(i, j)] += product(a, b);
                }
            }
            let readings = DVector::from_iterator(own.len(), own.iter().map(|&a| product(seen.len(), a)));
            locals.push((!own.is_empty()).then(|| {
                let gram = DMatrix::from_fn(own.len(), own.len(), |a, b| product(own[a], own[b]));
                let factor = definite(&(&gram + DMatrix::identity(own.len(), own.len())), &diagonal_of(&gram), 1.0);
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
                Local { columns, factor, with_seen, basis }
            }));
            all_seen.push(places);
            own_right.push(readings);
        }
        let factor = definite(&normal, &shared_squares, 1.0);
        let solved = factor.solve(&right);
        let mut explained = right.dot(&solved);
        let mut amplitudes = DVector::zeros(is_local.len());
        shared.iter().zip(solved.iter()).for_each(|(&i, value)| amplitudes[i] = *value);
        for ((local, seen), readings) in locals.iter().zip(&all_seen).zip(&own_right) {
            let Some(local) = local else { continue };
            explained += readings.dot(&local.factor.solve(readings));
            let by_shared = DVector::from_iterator(seen.len(), seen.iter().map(|&place| solved[place]));
            let own = local.factor.solve(&(readings - &local.with_seen * by_shared));
            local.columns.iter().zip(own.iter()).for_each(|(&i, value)| amplitudes[i] = *value);
        }
        EliminatedNormal {
            amplitudes,
            explained,
            shared,
            normal,
            shared_squares,
            factor,
            local: locals,
            seen: all_seen,
            unknowns: beyond.len(),
        }
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

    /// Projected `G` and `z` of a block; `with_accepted` are its products with the columns behind the unknowns: those × own.
    pub fn projected(&self, products: &Products, with_accepted: &DMatrix<f64>) -> (DMatrix<f64>, DVector<f64>) {
        let (mut gram, mut z) = (products.gram(), self.score(products, with_accepted));
        let mut cross = self.shared_rows(products, with_accepted);
        let raw_diagonal: Vec<f64> = (0..z.len()).map(|j| gram[(j, j)]).collect();
        let all: Vec<usize> = (0..z.len()).collect();
        for (local, seen) in self.local.iter().zip(&self.seen) {
            let Some(local) = local else { continue };
            let own = self.rows_of(local, with_accepted, &all);
            gram -= own.transpose() * &own;
            let taken = local.basis.with_seen.transpose() * &own;
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
    pub fn score(&self, products: &Products, with_accepted: &DMatrix<f64>) -> DVector<f64> {
        let accepted = self.amplitudes.len() - self.unknowns;
        let mut z = products.z.clone();
        z -= products.cross.tr_mul(&self.amplitudes.rows(0, self.unknowns));
        z -= with_accepted.tr_mul(&self.amplitudes.rows(self.unknowns, accepted));
        z
    }

    /// Products of a block with the shared columns.
    fn shared_rows(&self, products: &Products, with_accepted: &DMatrix<f64>) -> DMatrix<f64> {
        let mut cross = DMatrix::zeros(self.shared.len(), products.z.len());
        for (place, &i) in self.shared.iter().enumerate() {
            let mut row = cross.row_mut(place);
            match i.checked_sub(self.unknowns) {
                Some(accepted) => row.copy_from(&with_accepted.row(accepted)),
                None => row.copy_from(&products.cross.row(i)),
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
        with_accepted: &DMatrix<f64>,
        homes: &[usize],
        plausible: f64,
    ) -> BlockEvidence {
        let count = homes.len();
        let z = self.score(products, with_accepted);
        let cross = self.shared_rows(products, with_accepted);
        let mut columns = vec![Vec::new(); self.seen.len()];
        homes.iter().enumerate().for_each(|(j, &home)| columns[home].push(j));
        let of_tests = columns.into_iter().enumerate().filter(|(_, columns)| !columns.is_empty());
        let blocks: Vec<Block> =
            of_tests.map(|(test, columns)| self.block(test, columns, products, with_accepted, (&cross, &z))).collect();
        // alone, without what their columns share, the blocks tell the likeliest prior nearly: the search begins there
        let alone = |tau: f64| blocks.iter().map(|block| block.alone(tau)).sum::<f64>();
        let (_, solved) = climbed(plausible, alone, |tau| {
            let solved = self.solved(&blocks, count, tau);
            (solved.evidence, solved)
        });
        let Solved { tau, evidence, chi2, parts, v } = solved;
        let mut amplitudes = vec![0.0; count];
        for (block, (x, follow)) in blocks.iter().zip(parts) {
            let seen = &self.seen[block.test];
            let by_shared = DVector::from_iterator(seen.len(), seen.iter().map(|&place| v[place]));
            let own = x + follow * by_shared;
            block.columns.iter().zip(own.iter()).for_each(|(&j, value)| amplitudes[j] = *value);
        }
        // one nat for having chosen τ from the data
        let implausibility = implausibility(&amplitudes, tau, plausible);
        BlockEvidence { log_evidence: evidence - 1.0, chi2, tau, implausibility, amplitudes }
    }

    /// Evidence of the columns of single tests with amplitudes drawn from N(0, τ²), and what they are fitted to.
    fn solved(&self, blocks: &[Block], count: usize, tau: f64) -> Solved {
        let mut normal = self.normal.clone();
        let mut u = DVector::zeros(self.shared.len());
        let (mut log_ratio, mut chi2) = (2.0 * count as f64 * tau.ln() - log_determinant(&self.factor), 0.0);
        let mut parts = Vec::with_capacity(blocks.len());
        for block in blocks {
            let factor = block.factor(tau);
            log_ratio += log_determinant(&factor);
            let x = factor.solve(&block.z);
            let follow = factor.solve(&block.cross.transpose());
            chi2 += block.z.dot(&x);
            let seen = &self.seen[block.test];
            let taken = &block.cross * &follow;
            let pull = &block.cross * &x;
            for (a, &i) in seen.iter().enumerate() {
                u[i] += pull[a];
                seen.iter().enumerate().for_each(|(b, &j)| normal[(i, j)] -= taken[(a, b)]);
            }
            parts.push((x, follow));
        }
        let factor = definite(&normal, &self.shared_squares, 1.0);
        let v = factor.solve(&u);
        log_ratio += log_determinant(&factor);
        chi2 += u.dot(&v);
        Solved { tau, evidence: 0.5 * (chi2 - log_ratio), chi2, parts, v }
    }

    /// Products of some columns with those that act in a test alone: directions of their basis × columns.
    fn rows_of(&self, local: &Local, with_accepted: &DMatrix<f64>, columns: &[usize]) -> DMatrix<f64> {
        let place = |a: usize| local.columns[a] - self.unknowns;
        let own = DMatrix::from_fn(local.columns.len(), columns.len(), |a, b| with_accepted[(place(a), columns[b])]);
        local.basis.mix.tr_mul(&own)
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
        let mut gram = products.gram_in(test, &columns);
        let squares = diagonal_of(&gram);
        let mut with_seen = DMatrix::from_fn(seen.len(), own, |a, b| cross[(seen[a], columns[b])]);
        if let Some(local) = &self.local[test] {
            let rows = self.rows_of(local, with_accepted, &columns);
            gram -= rows.transpose() * &rows;
            with_seen -= local.basis.with_seen.transpose() * &rows;
        }
        let z = DVector::from_iterator(own, columns.iter().map(|&j| z[j]));
        Block { columns, gram, squares, cross: with_seen, z, test }
    }
}

/// Factor of a matrix that its priors make definite, from which others were eliminated; `squares` is its diagonal before that.
///
/// No pivot can be smaller than the prior's part of the diagonal, `prior`. Where one is, rounding of the products is larger than
/// what the readings leave of that direction: the diagonal is raised by the size of rounding until none is. Only values that
/// are not finite fail then.
fn definite(matrix: &DMatrix<f64>, squares: &[f64], prior: f64) -> Cholesky<f64, Dyn> {
    let is_sound = |factor: &Cholesky<f64, Dyn>| {
        factor.l_dirty().diagonal().iter().all(|pivot| pivot * pivot > LEAST_OF_PRIOR * prior)
    };
    let count = matrix.nrows();
    let (mut raised, mut rounding) = (0.0, count as f64 * f64::EPSILON);
    while rounding < MOST_ROUNDING {
        let mut tried = matrix.clone();
        squares.iter().enumerate().for_each(|(i, square)| tried[(i, i)] += raised * square);
        if let Some(factor) = Cholesky::new(tried).filter(is_sound) {
            return factor;
        }
        raised += rounding;
        rounding *= 10.0;
    }
    Cholesky::pack_dirty(DMatrix::identity(count, count))
}

fn diagonal_of(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.diagonal().iter().copied().collect()
}

/// Share of the diagonal that rounding can be: sums of a million products err by less.
const MOST_ROUNDING: f64 = 1e-8;
/// Share of the prior that a pivot must keep: the other half is left to harmless rounding.
const LEAST_OF_PRIOR: f64 = 0.5;
