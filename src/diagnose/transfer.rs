//! Whether a finding that was fitted without a setup predicts this setup's readings: the test of its place and form. It finds nothing.
//!
//! What slips, or is only absorbed by the placement of balls, does not carry over to another place of the balls; what a joint or a
//! slide does, does. The readings of the setup left out are fitted with its own placement and `s` times the prediction: a
//! cause at the right place has s = 1.

use std::collections::HashSet;

use super::finding::Finding;
use super::ground::{Column, Ground};
use super::stage::{Accepted, Stage};
use crate::identify::NoiseModel;
use crate::session::Setups;

/// How far the readings of setups follow what the other setups predict for them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transfer {
    /// Factor by which the prediction fits best; 1 when it is right.
    pub slope: f64,
    pub sigma: f64,
    /// Setups that were left out in turn and are predicted to show something.
    pub setups: usize,
}

/// Sigmas and share by which a slope may be off where the cause is at the right place.
const OFF_SIGMAS: f64 = 3.0;
const OFF: f64 = 0.3;

impl Transfer {
    /// Whether the readings of setups left out are as predicted.
    pub fn is_right(&self) -> bool {
        let off = (self.slope - 1.0).abs();
        off < OFF || off < OFF_SIGMAS * self.sigma
    }
}

/// Weighted square of a prediction, in units of the noise, from which on a setup can say something of it.
const TELLING: f64 = 50.0;

/// By finding: its transfer to other setups; `None` for single events, for amplitudes that each test has for itself, and where
/// fewer than two setups show it.
pub fn transfers(
    ground: &Ground,
    setups: &Setups,
    findings: &[Finding],
    columns: &[Accepted],
    noise: &[NoiseModel],
) -> Vec<Option<Transfer>> {
    let setup_of = |test: usize| (setups.pivot_of[test], setups.spindle_ball_of[test], setups.bar_of[test]);
    let mut known = HashSet::new();
    let distinct: Vec<_> = (0..ground.tests()).map(setup_of).filter(|setup| known.insert(*setup)).collect();
    let is_shared = |k: &usize| columns[*k].column.by_test.iter().filter(|rows| !rows.is_empty()).count() > 1;
    let can_carry: Vec<bool> =
        findings.iter().map(|finding| !finding.single && finding.columns.iter().all(is_shared)).collect();
    let mut slopes: Vec<Vec<(f64, f64)>> = vec![Vec::new(); findings.len()];
    if ground.has_sweeps() && distinct.len() > 1 && can_carry.contains(&true) {
        for setup in distinct {
            let rows = |own: bool| -> Vec<Vec<bool>> {
                let counts = |test: usize| (setup_of(test) == setup) == own;
                (0..ground.tests())
                    .map(|test| ground.kept[test].iter().map(|kept| *kept && counts(test)).collect())
                    .collect()
            };
            let others = Stage::new(ground, noise, columns, &rows(false));
            let own = rows(true);
            for (index, finding) in findings.iter().enumerate().filter(|(index, _)| can_carry[*index]) {
                slopes[index].extend(slope(ground, noise, finding, columns, (&others, &own)));
            }
        }
    }
    slopes.into_iter().map(|slopes| pooled(&slopes)).collect()
}

/// Slope of one setup's readings over what the others predict, with its variance.
fn slope(
    ground: &Ground,
    noise: &[NoiseModel],
    finding: &Finding,
    columns: &[Accepted],
    (others, own): (&Stage, &[Vec<bool>]),
) -> Option<(f64, f64)> {
    let beside = (0..columns.len()).filter(|k| !finding.columns.contains(k)).map(|k| columns[k].clone());
    let stage = Stage::new(ground, noise, &beside.collect::<Vec<_>>(), own);
    let mine: Vec<Column> = finding.columns.iter().map(|&k| columns[k].column.clone()).collect();
    let (information, score) = stage.project(&mine);
    let predicted = nalgebra::DVector::from_iterator(mine.len(), finding.columns.iter().map(|&k| others.accepted(k)));
    let response = &information * &predicted;
    let weight = response.dot(&predicted);
    if weight < TELLING {
        return None;
    }
    let nuisance = ground.problem.unknowns.len();
    let all = others.covariance();
    let covariance = nalgebra::DMatrix::from_fn(mine.len(), mine.len(), |i, j| {
        all[(nuisance + finding.columns[i], nuisance + finding.columns[j])]
    });
    let spread = (response.transpose() * covariance * &response)[(0, 0)].max(0.0);
    Some((score.dot(&predicted) / weight, 1.0 / weight + spread / (weight * weight)))
}

/// Weighted mean of slopes; they differ by more than their noise where forms are not exact, which the sigma then says.
fn pooled(slopes: &[(f64, f64)]) -> Option<Transfer> {
    if slopes.len() < 2 {
        return None;
    }
    let weights: f64 = slopes.iter().map(|(_, variance)| 1.0 / variance).sum();
    let slope = slopes.iter().map(|(slope, variance)| slope / variance).sum::<f64>() / weights;
    let scatter = slopes.iter().map(|(own, variance)| (own - slope).powi(2) / variance).sum::<f64>();
    let excess = (scatter / (slopes.len() - 1) as f64).max(1.0);
    Some(Transfer { slope, sigma: (excess / weights).sqrt(), setups: slopes.len() })
}
