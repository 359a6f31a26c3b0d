//! A gauge's zero that walks in the course of a session, as columns of the linear model. It fits nothing.
//!
//! A random walk from zero over the time `T` with standard deviation `σ` at its end is `Σ a_k √2 sin((k−½)πt/T)` with independent
//! `a_k` of standard deviation `σ/((k−½)π)` (Karhunen and Loève): each term is one column with a prior.

use crate::diagnose::model::linear_model::{Column, LinearModel};
use crate::diagnose::model::regression::Accepted;
use std::f64::consts::{PI, SQRT_2};

/// Terms of the walk: they hold 97 % of its variance.
const TERMS: usize = 6;

/// Columns, mm per µm, of a walk with a standard deviation of `end_mm` at the end of the session; none for static poses.
pub(crate) fn walk_of_the_zero(model: &LinearModel, end_mm: f64) -> Vec<Accepted> {
    let tests = &model.context.session().tests;
    let end_s = (0..model.tests()).map(|test| model.context.ends_at_s(test)).fold(0.0, f64::max);
    if !model.has_sweeps() || end_s <= 0.0 || end_mm <= 0.0 {
        return Vec::new();
    }
    (0..TERMS)
        .map(|k| {
            let waves = (k as f64 + 0.5) * PI;
            let in_test = |test: usize| -> Vec<f64> {
                let Some(time_s) = &model.context.motion(test).time_s else { return Vec::new() };
                let at = |time: &f64| 1e-3 * SQRT_2 * (waves * (tests[test].started_at_s + time) / end_s).sin();
                time_s.iter().map(at).collect()
            };
            let by_test = (0..model.tests()).map(in_test).collect();
            Accepted { column: Column::new(by_test), prior: 1e3 * end_mm / waves }
        })
        .collect()
}
