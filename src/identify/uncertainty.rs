//! Covariance of the unknowns asked for, and what of each estimate is data, prior or setup.

use nalgebra::{Cholesky, DMatrix, SymmetricEigen};

use super::estimate::Estimate;
use super::solve::Solution;
use crate::identify::model::problem::Problem;
use crate::identify::model::unknowns::{Quantity, Unknown};

/// How much tighter or wider the spindle balls' priors become when they are held or released.
const WIDENED: f64 = 1e3;

/// Covariance `D(H + 1)⁻¹D` of the unknowns asked for, H the data information in units of the priors D.
pub(super) fn covariance(problem: &Problem, information: &DMatrix<f64>) -> DMatrix<f64> {
    let inverse = inverse_with_prior(information, &vec![1.0; problem.unknowns.len()]);
    let sigma = |k: usize| problem.unknowns[k].prior_sigma;
    DMatrix::from_fn(problem.asked, problem.asked, |i, j| inverse[(i, j)] * sigma(i) * sigma(j))
}

/// `(H + diag(weights))⁻¹`; weights above zero make it solvable. Unknowns are scaled to equal size first: what the data say
/// of them differs by many powers of ten.
fn inverse_with_prior(information: &DMatrix<f64>, weights: &[f64]) -> DMatrix<f64> {
    let count = weights.len();
    let scale: Vec<f64> = (0..count).map(|k| (information[(k, k)].max(0.0) + weights[k]).sqrt().recip()).collect();
    let scaled = DMatrix::from_fn(count, count, |i, j| {
        let weight = if i == j { weights[i] } else { 0.0 };
        (information[(i, j)] + weight) * scale[i] * scale[j]
    });
    let inverse = match Cholesky::new(scaled.clone()) {
        Some(factor) => factor.inverse(),
        // rounding spoiled directions of which nearly nothing is known: they stay at what rounding leaves of one
        None => {
            let parts = SymmetricEigen::new(scaled);
            let factors = parts.eigenvalues.map(|value| value.max(f64::EPSILON).recip());
            &parts.eigenvectors * DMatrix::from_diagonal(&factors) * parts.eigenvectors.transpose()
        }
    };
    DMatrix::from_fn(count, count, |i, j| inverse[(i, j)] * scale[i] * scale[j])
}

pub(super) fn estimates(
    problem: &Problem,
    solution: &Solution,
    covariance: &DMatrix<f64>,
    of_design: &DMatrix<f64>,
) -> Vec<Estimate> {
    let unknowns = &problem.unknowns[..problem.asked];
    let is_reference = |unknown: &Unknown| {
        matches!(unknown.quantity, Quantity::SpindleBall { .. })
            && unknown.prior_sigma <= problem.session.spread.spindle_ball_mm
    };
    // a held quantity gets a prior a thousand times tighter, a released one a thousand times wider
    let reference_weight = |unknowns: &[Unknown], weight: f64| -> Vec<f64> {
        unknowns.iter().map(|unknown| if is_reference(unknown) { weight } else { 1.0 }).collect()
    };
    let (hold, release) = (WIDENED * WIDENED, 1.0 / (WIDENED * WIDENED));
    let held_with_budget = inverse_with_prior(&solution.information, &reference_weight(&problem.unknowns, hold));
    // with exact linear axes
    let information = solution.information_of(unknowns.len());
    let held = inverse_with_prior(&information, &reference_weight(unknowns, hold));
    let by_design = inverse_with_prior(of_design, &reference_weight(unknowns, hold));
    let released = inverse_with_prior(&information, &reference_weight(unknowns, release));
    unknowns
        .iter()
        .enumerate()
        .map(|(k, unknown)| {
            // of the variance C_kk, Σ_j C_kj² stems from the priors j (C in units of the priors)
            let from_priors: f64 =
                (0..unknowns.len()).filter(|&j| !is_reference(&unknowns[j])).map(|j| by_design[(k, j)].powi(2)).sum();
            let prior_share = (from_priors / by_design[(k, k)]).clamp(0.0, 1.0);
            let from_setups: f64 = (0..unknowns.len())
                .filter(|&j| unknowns[j].quantity.is_setup())
                .map(|j| (covariance[(k, j)] / unknowns[j].prior_sigma).powi(2))
                .sum();
            let determined = prior_share < 0.5;
            Estimate {
                value: solution.values[k],
                sigma: covariance[(k, k)].sqrt(),
                sigma_to_spindle_ball: held_with_budget[(k, k)].sqrt() * unknown.prior_sigma,
                sigma_noise: held[(k, k)].sqrt() * unknown.prior_sigma,
                prior_share,
                setup_share: (from_setups / covariance[(k, k)]).clamp(0.0, 1.0),
                determined,
                relative_to_spindle_ball: determined && released[(k, k)] > 4.0 * held[(k, k)] && !is_reference(unknown),
            }
        })
        .collect()
}
