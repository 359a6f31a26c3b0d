//! Whether a finding that was fitted without some place of the balls predicts the readings there. It finds nothing.
//!
//! The readings of the setup left out are fitted with its own placement and `s` times the prediction: a cause at the right
//! place and of the right form has s = 1. Another s refutes it; s = 1 is no proof, since a neighbour in form or place may predict as well.

use crate::statistics::NoiseModel;
use std::collections::HashSet;

use crate::diagnose::findings::finding::Finding;
use crate::diagnose::model::linear_model::{Column, LinearModel};
use crate::diagnose::model::regression::{Accepted, Regression};
use crate::session::Setups;

/// How far the readings of setups follow what the other setups predict for them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftOutSetup {
    /// Factor by which the prediction fits best; 1 when it is right.
    pub slope: f64,
    pub sigma: f64,
    /// Setups that were left out in turn and are predicted to show something.
    pub setups: usize,
}

/// Sigmas and share by which a slope may be off where the cause is at the right place.
const OFF_SIGMAS: f64 = 3.0;
const OFF_SHARE: f64 = 0.3;

impl LeftOutSetup {
    /// Whether the readings of setups left out are as predicted.
    pub fn is_right(&self) -> bool {
        let off = (self.slope - 1.0).abs();
        off < OFF_SHARE || off < OFF_SIGMAS * self.sigma
    }
}

/// Weighted square of a prediction, in units of the noise, from which on a setup can say something of it.
const LEAST_SQUARES_TELLING: f64 = 50.0;

/// By finding: its transfer to other setups; `None` for single events, for amplitudes that each test has for itself, and where
/// fewer than two setups show it.
pub fn transfers(
    model: &LinearModel,
    setups: &Setups,
    findings: &[Finding],
    columns: &[Accepted],
    noise: &[NoiseModel],
) -> Vec<Option<LeftOutSetup>> {
    let setup_of = |test: usize| (setups.pivot_of[test], setups.spindle_ball_of[test]);
    let mut known = HashSet::new();
    let distinct: Vec<_> = (0..model.tests()).map(setup_of).filter(|setup| known.insert(*setup)).collect();
    let is_shared = |k: &usize| columns[*k].column.by_test.iter().filter(|rows| !rows.is_empty()).count() > 1;
    let can_carry =
        |finding: &Finding| !finding.single && !finding.columns.is_empty() && finding.columns.iter().all(is_shared);
    let can_carry: Vec<bool> = findings.iter().map(can_carry).collect();
    let mut slopes: Vec<Vec<Slope>> = vec![Vec::new(); findings.len()];
    if model.has_sweeps() && distinct.len() > 1 && can_carry.contains(&true) {
        for setup in distinct {
            let rows = |own: bool| -> Vec<Vec<bool>> {
                let counts = |test: usize| (setup_of(test) == setup) == own;
                (0..model.tests())
                    .map(|test| model.kept[test].iter().map(|kept| *kept && counts(test)).collect())
                    .collect()
            };
            let others = Regression::new(model, noise, columns, &rows(false));
            let own = rows(true);
            for (index, finding) in findings.iter().enumerate().filter(|(index, _)| can_carry[*index]) {
                slopes[index].extend(slope(model, noise, finding, columns, (&others, &own)));
            }
        }
    }
    slopes.into_iter().map(|slopes| pooled(&slopes)).collect()
}

/// Slope of one setup's readings over what the others predict, with the variances of its own readings and of the prediction.
#[derive(Clone)]
struct Slope {
    slope: f64,
    own: f64,
    shared: f64,
}

/// The slope of one setup.
fn slope(
    model: &LinearModel,
    noise: &[NoiseModel],
    finding: &Finding,
    columns: &[Accepted],
    (others, own): (&Regression, &[Vec<bool>]),
) -> Option<Slope> {
    let beside = (0..columns.len()).filter(|k| !finding.columns.contains(k)).map(|k| columns[k].clone());
    let regression = Regression::new(model, noise, &beside.collect::<Vec<_>>(), own);
    let mine: Vec<Column> = finding.columns.iter().map(|&k| columns[k].column.clone()).collect();
    let (information, score) = regression.project(&mine);
    let predicted = nalgebra::DVector::from_iterator(mine.len(), finding.columns.iter().map(|&k| others.accepted(k)));
    let response = &information * &predicted;
    let weight = response.dot(&predicted);
    if weight < LEAST_SQUARES_TELLING {
        return None;
    }
    let nuisance = model.problem.unknowns.len();
    let all = others.covariance();
    let covariance = nalgebra::DMatrix::from_fn(mine.len(), mine.len(), |i, j| {
        all[(nuisance + finding.columns[i], nuisance + finding.columns[j])]
    });
    let spread = (response.transpose() * covariance * &response)[(0, 0)].max(0.0);
    Some(Slope { slope: score.dot(&predicted) / weight, own: 1.0 / weight, shared: spread / (weight * weight) })
}

/// Weighted mean of slopes; they differ by more than their noise where forms are not exact, which the sigma then says.
///
/// The predictions of different setups come from nearly the same readings: their spread does not average out.
fn pooled(slopes: &[Slope]) -> Option<LeftOutSetup> {
    if slopes.len() < 2 {
        return None;
    }
    let weight = |one: &Slope| 1.0 / (one.own + one.shared);
    let weights: f64 = slopes.iter().map(weight).sum();
    let mean = |of: &dyn Fn(&Slope) -> f64| slopes.iter().map(|one| weight(one) * of(one)).sum::<f64>() / weights;
    let slope = mean(&|one| one.slope);
    let scatter = slopes.iter().map(|one| weight(one) * (one.slope - slope).powi(2)).sum::<f64>();
    let excess = (scatter / (slopes.len() - 1) as f64).max(1.0);
    let own = slopes.iter().map(|one| weight(one).powi(2) * one.own).sum::<f64>() / weights.powi(2);
    Some(LeftOutSetup { slope, sigma: (excess * own + mean(&|one| one.shared)).sqrt(), setups: slopes.len() })
}
