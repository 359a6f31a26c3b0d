//! Claims of one machine against each other: least squares for its errors, which circles stand out, what another model leaves.
//!
//! `y = X x + e`, y all stated errors, x the machine's own (free), e with the covariance of the budgets. Whitened by the
//! Cholesky factor and projected off X, `r = M L⁻¹ y` holds the disagreements alone, `χ² = |r|²` with `n − rank X` degrees of
//! freedom. A direction g (a circle off by 1 µm, a cause of unit size) becomes `M L⁻¹ g`; with several, least squares of r.

use nalgebra::{DMatrix, DVector};

use super::error::ReconcileError;
use crate::machine::ErrorName;
use crate::statistics::Fitted;

/// What whitens stated errors and takes the machine's own out of them.
pub struct Frame {
    /// `L⁻¹`.
    whitener: DMatrix<f64>,
    /// Orthonormal basis of the whitened X.
    machine: Vec<DVector<f64>>,
    pub degrees_of_freedom: usize,
}

/// Below this share of its length a direction lies in those taken out before, by rounding.
const DEPENDENT: f64 = 1e-6;

/// What is left of a vector perpendicular to an orthonormal basis.
fn off(basis: &[DVector<f64>], vector: &DVector<f64>) -> DVector<f64> {
    // twice: once loses digits where little is left
    (0..2).fold(vector.clone(), |left, _| basis.iter().fold(left, |left, unit| &left - unit * unit.dot(&left)))
}

fn push(basis: &mut Vec<DVector<f64>>, vector: &DVector<f64>) -> bool {
    let left = off(basis, vector);
    let is_new = left.norm() > DEPENDENT * vector.norm() && vector.norm() > 0.0;
    if is_new {
        basis.push(left.normalize());
    }
    is_new
}

impl Frame {
    /// From the names of the stacked errors and their covariance.
    pub fn new(names: &[ErrorName], covariance: DMatrix<f64>) -> Result<Frame, ReconcileError> {
        let factor = covariance.cholesky().ok_or(ReconcileError::Covariance)?.l();
        let whitener = factor.try_inverse().ok_or(ReconcileError::Covariance)?;
        let mut machine = Vec::new();
        let mut seen: Vec<&ErrorName> = Vec::new();
        for name in names {
            if !seen.contains(&name) {
                seen.push(name);
                let column = DVector::from_iterator(names.len(), names.iter().map(|other| f64::from(other == name)));
                push(&mut machine, &(&whitener * column));
            }
        }
        let degrees_of_freedom = names.len() - machine.len();
        if degrees_of_freedom == 0 {
            return Err(ReconcileError::NothingInCommon);
        }
        Ok(Frame { whitener, machine, degrees_of_freedom })
    }

    /// A vector of stacked errors as a disagreement.
    pub fn disagreement(&self, stacked: &DVector<f64>) -> DVector<f64> {
        off(&self.machine, &(&self.whitener * stacked))
    }
}

/// Directions that a disagreement needs one after the other, the strongest first.
#[derive(Debug, Clone, Default)]
pub struct Selection {
    /// Indices of candidates.
    pub picks: Vec<usize>,
    /// By pick: other candidates that would do as well.
    pub alike: Vec<Vec<usize>>,
    pub chi2: f64,
}

/// A candidate does as well as the best when it takes off as much but for this: 5 % of one degree of freedom.
const AS_WELL: f64 = 3.84;

/// Takes directions into the model while one takes off more than `threshold` of χ².
pub fn select(
    disagreement: &DVector<f64>,
    candidates: &[DVector<f64>],
    taken: &[&DVector<f64>],
    threshold: f64,
) -> Selection {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    taken.iter().for_each(|direction| {
        push(&mut basis, direction);
    });
    let mut selection = Selection::default();
    loop {
        let left = off(&basis, disagreement);
        selection.chi2 = left.norm_squared();
        let gain = |direction: &DVector<f64>| {
            let new = off(&basis, direction);
            let is_new = new.norm() > 1e-3 * direction.norm().max(f64::MIN_POSITIVE);
            if is_new { new.normalize().dot(&left).powi(2) } else { 0.0 }
        };
        let gains: Vec<f64> = candidates.iter().map(gain).collect();
        let best = (0..gains.len()).max_by(|a, b| gains[*a].total_cmp(&gains[*b]));
        let Some(best) = best.filter(|best| gains[*best] > threshold) else { return selection };
        let as_well =
            (0..gains.len()).filter(|k| *k != best && gains[*k] > (gains[best] - AS_WELL).max(threshold / 2.0));
        selection.alike.push(as_well.collect());
        selection.picks.push(best);
        push(&mut basis, &candidates[best]);
    }
}

/// Sizes of directions by least squares, with standard deviations; `None` when they are not independent.
pub fn sizes(disagreement: &DVector<f64>, directions: &[&DVector<f64>]) -> Option<Vec<Fitted>> {
    if directions.is_empty() {
        return Some(Vec::new());
    }
    let columns: Vec<DVector<f64>> = directions.iter().map(|direction| (*direction).clone()).collect();
    let matrix = DMatrix::from_columns(&columns);
    let inverse = (matrix.transpose() * &matrix).cholesky()?.inverse();
    let found = &inverse * matrix.transpose() * disagreement;
    Some(found.iter().enumerate().map(|(k, size)| Fitted { value: *size, sigma: inverse[(k, k)].sqrt() }).collect())
}
