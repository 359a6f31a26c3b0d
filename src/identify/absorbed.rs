//! What a fit has absorbed of the noise: the posterior spread of its predictions, as few columns per trace length.
//!
//! Residuals lack the part of the noise that the unknowns followed. With the posterior covariance C of the unknowns the
//! expected misfit of a noise model is `r'Σ⁻¹r + tr(Σ⁻¹ J C J')`; its minimum over the noise is a step of expectation
//! maximisation towards restricted maximum likelihood (Laird & Ware 1982). `J C J'` has a handful of significant
//! columns, and tests with the same rows share them.

use nalgebra::{Cholesky, DMatrix};
use rayon::prelude::*;

use super::solve::Solution;
use crate::identify::model::problem::Problem;
use crate::statistics::{Absorbed, principal};

/// Share of the absorbed variance that may be left out.
const LEFT_OUT_SHARE: f64 = 1e-3;

/// Absorbed noise of the tests for which `counts` holds, those with the same rows pooled.
pub fn absorbed(problem: &Problem, solution: &Solution, kept: &[Vec<bool>], tests: &[usize]) -> Vec<Absorbed> {
    let count = problem.unknowns.len();
    let with_prior = &solution.information + DMatrix::identity(count, count);
    let Some(covariance) = Cholesky::new(with_prior).map(|factor| factor.inverse()) else { return Vec::new() };
    let geometry = problem.geometry(&solution.values);
    let columns: Vec<DMatrix<f64>> = tests
        .par_iter()
        .map(|&test| {
            let jacobian = problem.predict(test, &geometry, &solution.values).jacobian;
            spread(problem, test, jacobian, &kept[test], &covariance)
        })
        .collect();
    let mut groups: Vec<(&Vec<bool>, Vec<&DMatrix<f64>>)> = Vec::new();
    for (&test, columns) in tests.iter().zip(&columns) {
        match groups.iter_mut().find(|(rows, _)| *rows == &kept[test]) {
            Some((_, list)) => list.push(columns),
            None => groups.push((&kept[test], vec![columns])),
        }
    }
    groups
        .into_iter()
        .map(|(present, list)| {
            let views: Vec<_> = list.iter().flat_map(|matrix| matrix.column_iter()).collect();
            let stacked =
                if views.is_empty() { DMatrix::zeros(present.len(), 0) } else { DMatrix::from_columns(&views) };
            let few = significant(&stacked);
            let columns = few.column_iter().map(|column| column.iter().copied().collect()).collect();
            Absorbed { present: present.clone(), columns }
        })
        .collect()
}

/// Columns U of one test with `U U' ≈ J C J'`, mm; rows that took no part are zero.
fn spread(
    problem: &Problem,
    test: usize,
    mut jacobian: DMatrix<f64>,
    kept: &[bool],
    covariance: &DMatrix<f64>,
) -> DMatrix<f64> {
    let own = &problem.tests[test].columns;
    let part = DMatrix::from_fn(own.len(), own.len(), |i, j| covariance[(own[i], own[j])]);
    let Some(factor) = Cholesky::new(part) else { return DMatrix::zeros(jacobian.nrows(), 0) };
    for (k, &index) in own.iter().enumerate() {
        jacobian.column_mut(k).scale_mut(problem.unknowns[index].prior_sigma);
    }
    for (row, kept) in kept.iter().enumerate() {
        if !kept {
            jacobian.row_mut(row).fill(0.0);
        }
    }
    significant(&(jacobian * factor.l()))
}

/// Few columns with nearly the same `U U'`: the leading principal components.
fn significant(columns: &DMatrix<f64>) -> DMatrix<f64> {
    let components = principal(columns);
    let total: f64 = components.iter().map(|(variance, _)| variance.max(0.0)).sum();
    let mut left = total;
    let leading: Vec<_> = components
        .into_iter()
        .take_while(|(variance, _)| {
            let goes_on = left > LEFT_OUT_SHARE * total;
            left -= variance;
            goes_on
        })
        .map(|(_, way)| columns * way)
        .collect();
    if leading.is_empty() { DMatrix::zeros(columns.nrows(), 0) } else { DMatrix::from_columns(&leading) }
}
