//! What of a fit's location errors the readings determine. It fits nothing.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::ambiguity::{OPEN_ANGLE_RAD, OPEN_LENGTH_MM};
use super::estimate::{Fit, FreeLocation};
use crate::machine::{Component, Machine};

/// Standard deviation that errors of machines have anyway, in units of what counts as open: 30 µm and 30 arcsec.
const USUAL_SIGMA_OVER_OPEN: f64 = 3.0;

/// What is determined of a location error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeterminedError {
    pub axis: usize,
    /// Index in [`Component::ALL`].
    pub component: usize,
    /// mm or rad.
    pub value: f64,
    /// It is another value than the fit's by more than half of what counts as open.
    pub is_partial: bool,
}

/// Location errors without what the readings leave open.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DeterminedErrors(pub Vec<DeterminedError>);

impl DeterminedErrors {
    /// Of a fit.
    ///
    /// A direction of errors counts as open where its standard deviation σ is above 10 µm or 10 arcsec. Of its value the share
    /// `30²/(30² + σ²)` is kept, which is nearest to the truth for a machine whose errors are some 30 µm and 30 arcsec.
    /// Combinations that the readings see keep their value: of two errors of which only the sum is seen, each takes half of it.
    pub fn of(fit: &Fit) -> DeterminedErrors {
        let (free, covariance) = fit.location_covariance();
        let is_angle = |one: &FreeLocation| Component::ALL[one.component].is_angle();
        let scale: Vec<f64> =
            free.iter().map(|one| if is_angle(one) { OPEN_ANGLE_RAD } else { OPEN_LENGTH_MM }).collect();
        let fitted: Vec<f64> = free.iter().map(|one| fit.estimates[one.unknown].value).collect();
        let kept = determined_part(&fitted, &covariance, &scale);
        let of = |(k, one): (usize, &FreeLocation)| DeterminedError {
            axis: one.axis,
            component: one.component,
            value: kept[k],
            is_partial: (kept[k] - fitted[k]).abs() > 0.5 * scale[k],
        };
        DeterminedErrors(free.iter().enumerate().map(of).collect())
    }

    /// Puts them into a machine.
    pub fn put_into(&self, machine: &mut Machine) {
        for error in &self.0 {
            machine.axes[error.axis].location_errors[error.component] = error.value;
        }
    }

    /// Those of which a part is left out.
    pub fn partial(&self) -> impl Iterator<Item = &DeterminedError> {
        self.0.iter().filter(|error| error.is_partial)
    }
}

/// Values with the smaller parts along directions whose standard deviation is above one `scale`.
fn determined_part(values: &[f64], covariance: &DMatrix<f64>, scale: &[f64]) -> Vec<f64> {
    let count = values.len();
    let scaled = DMatrix::from_fn(count, count, |i, j| covariance[(i, j)] / (scale[i] * scale[j]));
    if count == 0 || scaled.iter().any(|value| !value.is_finite()) {
        return values.to_vec();
    }
    let eigen = SymmetricEigen::new(scaled);
    let whole = DVector::from_fn(count, |k, _| values[k] / scale[k]);
    let mut kept = whole.clone();
    for k in (0..count).filter(|&k| eigen.eigenvalues[k] > 1.0) {
        let direction = eigen.eigenvectors.column(k);
        let left = eigen.eigenvalues[k] / (USUAL_SIGMA_OVER_OPEN * USUAL_SIGMA_OVER_OPEN + eigen.eigenvalues[k]);
        kept -= direction * (left * direction.dot(&whole));
    }
    kept.iter().zip(scale).map(|(kept, scale)| kept * scale).collect()
}

#[cfg(test)]
mod tests {
    use super::determined_part;
    use nalgebra::DMatrix;

    #[test]
    fn a_sum_that_is_seen_stays_and_what_is_not_seen_goes() {
        // the sum of the first two is known to 0.1, their difference to 300; the third to 0.2, the fourth to 250
        let (sum, difference) = (0.1f64.powi(2), 300f64.powi(2));
        let (own, both) = (0.25 * (sum + difference), 0.25 * (sum - difference));
        let covariance = DMatrix::from_row_slice(
            4,
            4,
            &[own, both, 0.0, 0.0, both, own, 0.0, 0.0, 0.0, 0.0, 0.04, 0.0, 0.0, 0.0, 0.0, 62_500.0],
        );
        let kept = determined_part(&[28.0, -26.0, 7.0, 270.0], &covariance, &[1.0; 4]);
        for (kept, expected) in kept.iter().zip([1.0, 1.0, 7.0, 0.0]) {
            assert!((kept - expected).abs() < 0.05, "{kept} for {expected}");
        }
        // in other units the same
        let kept = determined_part(&[280.0, -260.0, 70.0, 2700.0], &(covariance * 100.0), &[10.0; 4]);
        assert!((kept[0] - 10.0).abs() < 0.5 && kept[3].abs() < 0.5, "{kept:?}");
        assert!((kept[0] + kept[1] - 20.0).abs() < 1e-3 && (kept[2] - 70.0).abs() < 1e-9, "{kept:?}");
    }
}
