//! One stage of the search: data and fitted columns whitened by a noise model, candidates judged against them.
//!
//! With everything whitened, a candidate block B needs only `z = Bᵀ(I−P)y` and `G = Bᵀ(I−P)B`, P the projection on what
//! has been fitted (with its priors). Its evidence with amplitudes drawn from N(0, τ²) is exact for a linear model.

use crate::statistics::{NoiseModel, add_products};
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use rayon::prelude::*;

use super::eliminated::EliminatedNormal;
use super::linear_model::{Column, CrossProducts, LinearModel, Term};
use super::prior_penalty::PriorPenalty;
use super::whitened::{LastShape, Products, WhitenedData};
use crate::effects::Profile;
use crate::machine::Effect;
use crate::statistics::{BlockEvidence, judge};

/// Whitened session with what has been fitted so far.
#[derive(Clone)]
pub struct Regression<'g, 'a> {
    pub model: &'g LinearModel<'a>,
    whitened: Arc<WhitenedData<'g, 'a>>,
    /// By test: whitened columns that it sees, one after the other, the whitened readings last.
    white: Vec<Vec<f64>>,
    /// Places of a test's columns among all.
    seen: Vec<Vec<usize>>,
    /// By test: the accepted columns that act, as [`EliminatedNormal`] has them, whitened twice: their products with a column are those
    /// of both whitened.
    twice: Vec<Vec<f64>>,
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
    /// Whitens the rows `kept` of the ground and fits nuisance and accepted columns.
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
        let model = whitened.model;
        let nuisance = model.problem.unknowns.len();
        let count = nuisance + accepted.len();
        let parts: Vec<_> = (0..model.tests())
            .into_par_iter()
            .map(|test| {
                let rows = model.residual_mm[test].len();
                let (unknowns, readings) = whitened.columns(test);
                let present: Vec<usize> =
                    (0..accepted.len()).filter(|&k| !accepted[k].column.by_test[test].is_empty()).collect();
                let mut own = Vec::with_capacity(present.len() * rows);
                for &k in &present {
                    let Accepted { column, prior } = &accepted[k];
                    own.extend(column.by_test[test].iter().map(|value| value * prior));
                }
                whitened.whiten(test, &mut own);
                let mut twice = own.clone();
                twice.chunks_exact_mut(rows.max(1)).for_each(|column| whitened.whiten_transposed(test, column));
                let white = [unknowns, &own, readings].concat();
                let mut seen = model.problem.tests[test].columns.clone();
                seen.extend(present.iter().map(|k| nuisance + k));
                let width = seen.len() + 1;
                let mut sums = vec![0.0; width * width];
                add_products(&white, rows, width, &mut sums);
                (white, seen, sums, (present, twice))
            })
            .collect();
        let (mut all_white, mut all_seen, mut all_twice, mut all_sums) = (vec![], vec![], vec![], vec![]);
        for (white, seen, sums, twice) in parts {
            all_white.push(white);
            all_sums.push(sums);
            all_seen.push(seen);
            all_twice.push(twice);
        }
        let beyond = &model.beyond;
        let readings: f64 = all_sums.iter().filter_map(|sums| sums.last()).sum();
        let total = readings + beyond.iter().map(|beyond| beyond * beyond).sum::<f64>();
        let is_local = |k: usize| accepted[k].column.by_test.iter().filter(|column| !column.is_empty()).count() == 1;
        let local: Vec<bool> = (0..count).map(|i| i >= nuisance && is_local(i - nuisance)).collect();
        let fitted = EliminatedNormal::new(&local, beyond, &all_seen, &all_sums);
        let misfit = total - fitted.explained;
        let twice = all_twice
            .iter()
            .enumerate()
            .map(|(test, (present, twice))| fitted.as_it_has_them(test, present, twice, model.residual_mm[test].len()));
        let twice = twice.collect();
        let accepted_prior = accepted.iter().map(|accepted| accepted.prior).collect();
        Regression { model, whitened, white: all_white, seen: all_seen, twice, fitted, accepted_prior, misfit }
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
        let products = self.whitened.products(columns, &mut LastShape::default());
        self.fitted.projected(&products, &self.with_accepted(columns))
    }

    /// Products of the accepted columns with others, by test.
    fn with_accepted(&self, columns: &[Column]) -> Vec<CrossProducts> {
        let in_test = |(test, twice): (usize, &Vec<f64>)| {
            let acts = |&j: &usize| !twice.is_empty() && !columns[j].by_test[test].is_empty();
            let own: Vec<usize> = (0..columns.len()).filter(acts).collect();
            let block: Vec<f64> = own.iter().flat_map(|&j| columns[j].by_test[test].iter().copied()).collect();
            CrossProducts::of(twice, (own, &block), self.model.residual_mm[test].len())
        };
        self.twice.iter().enumerate().map(in_test).collect()
    }

    /// Judges a block whose amplitudes are plausible up to `plausible` display units.
    pub fn judge(&self, columns: &[Column], plausible: f64) -> BlockEvidence {
        let products = self.whitened.products(columns, &mut LastShape::default());
        let mut homes = Vec::with_capacity(columns.len());
        for column in columns {
            let mut present = (0..column.by_test.len()).filter(|&test| !column.by_test[test].is_empty());
            homes.push(present.next().filter(|_| present.next().is_none()));
        }
        self.judge_products(&products, &self.with_accepted(columns), &homes, plausible)
    }

    /// Judges a shape of the family with this number; what was worked out for it at another stage is used again.
    pub fn judge_shape(
        &self,
        (family, effect): (usize, &Effect),
        (profiles, terms): (&[Profile], &[Term]),
        plausible: f64,
        last: &mut LastShape,
    ) -> BlockEvidence {
        let products = self.whitened.products_of((family, effect), (profiles, terms), last);
        let with_accepted = self.model.products_with((profiles, terms), &self.twice);
        let homes: Vec<Option<usize>> = terms.iter().map(|term| term.test).collect();
        self.judge_products(&products, &with_accepted, &homes, plausible)
    }

    /// By test: which terms of a shape act there, the products of their columns with each other, and those with what is left.
    pub fn products_by_test(
        &self,
        (family, effect): (usize, &Effect),
        (profiles, terms): (&[Profile], &[Term]),
    ) -> Vec<(Vec<usize>, DMatrix<f64>, DVector<f64>)> {
        let products = self.whitened.products_of((family, effect), (profiles, terms), &mut LastShape::default());
        let left = self.fitted.score(&products, &self.model.products_with((profiles, terms), &self.twice));
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
        with_accepted: &[CrossProducts],
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
        (0..self.model.tests())
            .map(|test| {
                let rows = self.model.residual_mm[test].len();
                let (base, readings) = self.white[test].split_at(self.seen[test].len() * rows);
                let mut left = readings.to_vec();
                for (column, &k) in base.chunks_exact(rows.max(1)).zip(&self.seen[test]) {
                    let amplitude = self.fitted.amplitudes[k];
                    left.iter_mut().zip(column).for_each(|(left, value)| *left -= amplitude * value);
                }
                self.whitened.whiten_transposed(test, &mut left);
                left
            })
            .collect()
    }
}

/// Columns of single tests from which on a block is judged test by test.
const MOST_TOGETHER: usize = 12;
