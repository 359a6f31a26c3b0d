//! One stage of the search: data and fitted columns whitened by a noise model, candidates judged against them.
//!
//! With everything whitened, a candidate block B needs only `z = Bᵀ(I−P)y` and `G = Bᵀ(I−P)B`, P the projection on what
//! has been fitted (with its priors). Its evidence with amplitudes drawn from N(0, τ²) is exact for a linear model.

use crate::statistics::{NoiseModel, add_products};
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use rayon::prelude::*;

use super::eliminated::EliminatedNormal;
use super::fitted_column::FittedColumn;
use super::last_shape::LastShape;
use super::linear_model::{Column, LinearModel, Term};
use super::prior_penalty::PriorPenalty;
use super::products::Products;
use super::shapes::name;
use super::whitened::{ShapeProducts, WhitenedData, add_weighted, fill};
use crate::effects::Profile;
use crate::machine::Effect;
use crate::statistics::{BlockEvidence, judge};

/// Whitened session with what has been fitted so far.
#[derive(Clone)]
pub struct Regression<'g, 'a> {
    pub model: &'g LinearModel<'a>,
    whitened: Arc<WhitenedData<'g, 'a>>,
    /// By group of tests: how much more squares of the readings count than they were whitened for.
    weights: Vec<f64>,
    /// Accepted columns.
    columns: Vec<Arc<FittedColumn>>,
    /// What was fitted.
    fitted: EliminatedNormal,
    /// Prior sigma of the accepted columns, display units.
    accepted_prior: Vec<f64>,
    /// Weighted sum of squares left after the fit.
    pub misfit: f64,
}

/// A column that has been accepted, with the prior sigma of its amplitude.
#[derive(Debug, Clone)]
pub struct Accepted {
    pub column: Column,
    pub prior: f64,
}

impl<'g, 'a> Regression<'g, 'a> {
    /// Whitens the rows `kept` of the model and fits nuisance and accepted columns.
    pub fn new(
        model: &'g LinearModel<'a>,
        noise: &[NoiseModel],
        accepted: &[Accepted],
        kept: &[Vec<bool>],
    ) -> Regression<'g, 'a> {
        Regression::on(Arc::new(WhitenedData::new(model, noise, kept)), accepted)
    }

    /// Fits nuisance and accepted columns to a session that has been whitened.
    pub fn on(whitened: Arc<WhitenedData<'g, 'a>>, accepted: &[Accepted]) -> Regression<'g, 'a> {
        let weights = vec![1.0; whitened.group_count()];
        Regression::weighted(whitened, weights, accepted)
    }

    /// The same where the noise of each group of tests is what it was whitened by over the root of its weight: all that is known of
    /// shapes stays.
    pub fn weighted(
        whitened: Arc<WhitenedData<'g, 'a>>,
        weights: Vec<f64>,
        accepted: &[Accepted],
    ) -> Regression<'g, 'a> {
        let model = whitened.model;
        let nuisance = model.problem.unknowns.len();
        let columns: Vec<Arc<FittedColumn>> =
            accepted.par_iter().map(|accepted| whitened.fitted_column(&accepted.column)).collect();
        let accepted_prior: Vec<f64> = accepted.iter().map(|accepted| accepted.prior).collect();
        let parts: Vec<(Vec<usize>, Vec<f64>)> = (0..model.tests())
            .into_par_iter()
            .map(|test| {
                let (seen, mut sums) = normal_sums(&whitened, (&columns, &accepted_prior), test);
                let weight = weights[whitened.groups()[test]];
                sums.iter_mut().for_each(|sum| *sum *= weight);
                (seen, sums)
            })
            .collect();
        let (seen, sums): (Vec<Vec<usize>>, Vec<Vec<f64>>) = parts.into_iter().unzip();
        let beyond = &model.beyond;
        let readings: f64 = sums.iter().filter_map(|sums| sums.last()).sum();
        let total = readings + beyond.iter().map(|beyond| beyond * beyond).sum::<f64>();
        let mut local = vec![false; nuisance];
        local.extend(columns.iter().map(|column| column.home.is_some()));
        let fitted = EliminatedNormal::new(&local, beyond, &seen, &sums);
        let misfit = total - fitted.explained;
        Regression { model, whitened, weights, columns, fitted, accepted_prior, misfit }
    }

    /// Amplitude of an accepted column, display units.
    pub fn accepted(&self, index: usize) -> f64 {
        self.fitted.amplitudes[self.model.problem.unknowns.len() + index] * self.accepted_prior[index]
    }

    /// Change of an unknown of the fit, in units of its prior.
    pub fn nuisance(&self, index: usize) -> f64 {
        self.fitted.amplitudes[index]
    }

    /// Covariance of all fitted amplitudes: nuisance in units of the priors, accepted in display units.
    pub fn covariance(&self) -> DMatrix<f64> {
        let mut covariance = self.fitted.covariance();
        let nuisance = self.model.problem.unknowns.len();
        for (k, prior) in self.accepted_prior.iter().enumerate() {
            covariance.row_mut(nuisance + k).scale_mut(*prior);
            covariance.column_mut(nuisance + k).scale_mut(*prior);
        }
        covariance
    }

    /// How far the unknowns of the fit were pulled from what was stated of them.
    pub(crate) fn pulls(&self) -> PriorPenalty {
        PriorPenalty::of(self.model, |k| self.nuisance(k))
    }

    /// Residuals left by nuisance and accepted columns, mm; NaN where there is no reading.
    pub fn residual_mm(&self, accepted: &[Accepted]) -> Vec<Vec<f64>> {
        let nuisance = self.model.problem.unknowns.len();
        let fitted = self.fitted.amplitudes.rows(0, nuisance);
        (0..self.model.tests())
            .map(|test| {
                let joint = &self.model.nuisance[test] * fitted;
                let mut residual: Vec<f64> =
                    self.model.residual_mm[test].iter().zip(joint.iter()).map(|(r, m)| r - m).collect();
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
        self.fitted.projected(&self.products(columns), &self.with_accepted(columns))
    }

    /// Products of what was fitted, in units of priors, with a block: fitted × block.
    pub(crate) fn cross(&self, columns: &[Column]) -> DMatrix<f64> {
        let unknowns = self.products(columns).cross;
        let accepted = self.with_accepted(columns);
        let (above, below) = (unknowns.nrows(), accepted.nrows());
        let mut cross = unknowns.resize_vertically(above + below, 0.0);
        cross.rows_mut(above, below).copy_from(&accepted);
        cross
    }

    /// What the readings say of each column of a block: the diagonal of the projected `G`.
    pub fn information(&self, columns: &[Column]) -> Vec<f64> {
        self.project(columns).0.diagonal().iter().copied().collect()
    }

    /// Products of the accepted columns, in units of their priors, with others: accepted × others.
    fn with_accepted(&self, columns: &[Column]) -> DMatrix<f64> {
        let model: Vec<&Arc<FittedColumn>> = self.columns.iter().collect();
        let mut last = LastShape::default();
        let count = columns.len();
        let sums = self.whitened.sums_with(&model, count, &mut last, |test, block, present| {
            fill(columns, test, block, present);
        });
        let mut with = DMatrix::zeros(sums.len(), count);
        sums.iter().enumerate().for_each(|(i, sums)| add_weighted(&mut with, i, sums, &self.weights));
        self.in_priors(with)
    }

    /// Products of a block.
    fn products(&self, columns: &[Column]) -> Products {
        self.whitened.products(columns, &self.weights)
    }

    /// Products with the accepted columns, these in units of their priors.
    fn in_priors(&self, mut with: DMatrix<f64>) -> DMatrix<f64> {
        let priors = self.accepted_prior.iter().enumerate();
        priors.for_each(|(i, prior)| with.row_mut(i).scale_mut(*prior));
        with
    }

    /// Products of a shape, and those with the accepted columns.
    fn of_shape(
        &self,
        shape: (usize, &str),
        columns: (&[Profile], &[Term]),
        last: &mut LastShape,
    ) -> (Products, DMatrix<f64>) {
        let ShapeProducts { products, with } =
            self.whitened.products_of(shape, columns, (&self.columns, &self.weights), last);
        (products, self.in_priors(with))
    }

    /// Judges a block whose amplitudes are plausible up to `plausible` display units.
    pub fn judge(&self, columns: &[Column], plausible: f64) -> BlockEvidence {
        let homes: Vec<Option<usize>> = columns.iter().map(Column::home).collect();
        self.judge_products(&self.products(columns), &self.with_accepted(columns), &homes, plausible)
    }

    /// Judges a shape of the family with this number; what was worked out for it at another stage is used again.
    pub fn judge_shape(
        &self,
        (family, effect): (usize, &Effect),
        (profiles, terms): (&[Profile], &[Term]),
        plausible: f64,
        last: &mut LastShape,
    ) -> BlockEvidence {
        self.judge_named((family, &name(effect)), (profiles, terms), plausible, last)
    }

    /// The same of a shape whose name is known.
    pub(crate) fn judge_named(
        &self,
        shape: (usize, &str),
        (profiles, terms): (&[Profile], &[Term]),
        plausible: f64,
        last: &mut LastShape,
    ) -> BlockEvidence {
        let (products, with_accepted) = self.of_shape(shape, (profiles, terms), last);
        let homes: Vec<Option<usize>> = terms.iter().map(|term| term.test).collect();
        self.judge_products(&products, &with_accepted, &homes, plausible)
    }

    /// By test: which terms of a shape act there, the products of their columns with each other, and those with what is left.
    pub fn products_by_test(
        &self,
        (family, effect): (usize, &Effect),
        (profiles, terms): (&[Profile], &[Term]),
    ) -> Vec<(Vec<usize>, DMatrix<f64>, DVector<f64>)> {
        let (products, with_accepted) =
            self.of_shape((family, &name(effect)), (profiles, terms), &mut LastShape::default());
        let left = self.fitted.score(&products, &with_accepted);
        let in_test = |test: usize| {
            let own: Vec<usize> = (0..terms.len()).filter(|&k| terms[k].test == Some(test)).collect();
            let z = DVector::from_iterator(own.len(), own.iter().map(|&k| left[k]));
            let gram = products.gram_in(test, &own);
            (own, gram, z)
        };
        (0..self.model.tests()).map(in_test).collect()
    }

    /// Judges a block by its products; `homes` are the tests in which its columns act, where that is one each.
    fn judge_products(
        &self,
        products: &Products,
        with_accepted: &DMatrix<f64>,
        homes: &[Option<usize>],
        plausible: f64,
    ) -> BlockEvidence {
        let homes: Option<Vec<usize>> = homes.iter().copied().collect();
        match homes {
            Some(homes) if homes.len() > MOST_TOGETHER => {
                self.fitted.judge_by_test(products, with_accepted, &homes, plausible)
            }
            _ => {
                let (information, z) = self.fitted.projected(products, with_accepted);
                judge(information, z, plausible)
            }
        }
    }

    /// What is left of the data, whitened twice: its product with a column is the column's score.
    pub fn matched(&self) -> Vec<Vec<f64>> {
        let nuisance = self.model.problem.unknowns.len();
        let in_test = |test: usize| {
            let rows = self.whitened.rows(test);
            let seen = &self.model.problem.tests[test].columns;
            let (base, readings) = self.whitened.base(test).split_at(seen.len() * rows);
            let mut left = readings.to_vec();
            let mut take = |column: &[f64], amplitude: f64| {
                left.iter_mut().zip(column).for_each(|(left, value)| *left -= amplitude * value);
            };
            for (column, &k) in base.chunks_exact(rows.max(1)).zip(seen) {
                take(column, self.fitted.amplitudes[k]);
            }
            for (k, (column, prior)) in self.columns.iter().zip(&self.accepted_prior).enumerate() {
                take(&column.white[test], self.fitted.amplitudes[nuisance + k] * prior);
            }
            self.whitened.whiten_transposed(test, &mut left);
            let weight = self.weights[self.whitened.groups()[test]];
            left.iter_mut().for_each(|left| *left *= weight);
            left
        };
        (0..self.model.tests()).map(in_test).collect()
    }
}

/// The columns of the unknowns and of a model that a test sees, as places among all, and the products of all pairs, those with
/// the readings last (row by row, lower triangle), the model's columns in units of their priors.
fn normal_sums(
    whitened: &WhitenedData,
    (columns, priors): (&[Arc<FittedColumn>], &[f64]),
    test: usize,
) -> (Vec<usize>, Vec<f64>) {
    let model = whitened.model;
    let rows = whitened.rows(test);
    let present: Vec<usize> = (0..columns.len()).filter(|&k| !columns[k].white[test].is_empty()).collect();
    let mut seen = model.problem.tests[test].columns.clone();
    let unknowns = seen.len();
    seen.extend(present.iter().map(|k| model.problem.unknowns.len() + k));
    let (base, own) = (whitened.base_sums(test), present.len());
    let mut with_each_other = vec![0.0; own * own];
    let white: Vec<f64> = present.iter().flat_map(|&k| columns[k].white[test].iter().copied()).collect();
    add_products(&white, rows, own, &mut with_each_other);
    let width = seen.len() + 1;
    let mut sums = vec![0.0; width * width];
    for a in 0..unknowns {
        let own = a * (unknowns + 1);
        sums[a * width..a * width + a + 1].copy_from_slice(&base[own..own + a + 1]);
    }
    let readings = seen.len() * width;
    let last = unknowns * (unknowns + 1);
    sums[readings..readings + unknowns].copy_from_slice(&base[last..last + unknowns]);
    sums[readings + seen.len()] = base[last + unknowns];
    for (i, &k) in present.iter().enumerate() {
        let (row, with_base) = ((unknowns + i) * width, &columns[k].with_base[test]);
        for (sum, value) in sums[row..].iter_mut().zip(&with_base[..unknowns]) {
            *sum = priors[k] * value;
        }
        for (j, &other) in present.iter().enumerate().take(i + 1) {
            sums[row + unknowns + j] = priors[k] * priors[other] * with_each_other[i * own + j];
        }
        sums[readings + unknowns + i] = priors[k] * with_base[unknowns];
    }
    (seen, sums)
}

/// Columns of single tests from which on a block is judged test by test.
const MOST_TOGETHER: usize = 12;
