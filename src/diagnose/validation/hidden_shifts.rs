//! How far causes that a session cannot show may have moved its location errors. It looks at no residual.

use nalgebra::DVector;

use super::detection_limits::{Hidden, HiddenForm};
use crate::diagnose::model::regression::Regression;
use crate::effects::PRESENT;

/// What one hidden cause would do to the unknowns of the fit, in units of their priors.
pub(crate) struct HiddenShift {
    /// Its place in the list of unseen causes, if it is listed.
    pub(crate) cause: Option<usize>,
    /// Mean square of what it may have done.
    pub(crate) variance: DVector<f64>,
    /// Shift by one display unit of it: of its functions the one that moves an unknown most.
    pub(crate) per_unit: DVector<f64>,
}

/// Shifts by all causes that may be there unseen and that a single form stands for; `before` other ones stand in the list before
/// them.
///
/// A cause `c` of size `a` that is not in the model moves the unknowns by `a·N⁻¹Aᵀc`, N the normal matrix with the priors
/// (omitted-variable bias of least squares).
pub(crate) fn hidden_shifts(regression: &Regression, hidden: &[Hidden], before: usize) -> Vec<HiddenShift> {
    let covariance = regression.covariance();
    let mut listed = before..;
    let places: Vec<Option<usize>> = hidden.iter().map(|one| if one.matters { listed.next() } else { None }).collect();
    let of = |(one, cause): (&Hidden, Option<usize>)| {
        let form = one.form.as_ref()?;
        let columns = regression.model.columns(&form.effect, &form.terms).ok()?;
        let shifts = &covariance * regression.cross(&columns);
        let mean_square = mean_square(form, one.unseen.smallest) / columns.len() as f64;
        let unknowns = 0..covariance.nrows();
        let most = |k| shifts.row(k).iter().copied().max_by(|a: &f64, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0);
        Some(HiddenShift {
            cause,
            variance: DVector::from_iterator(
                unknowns.len(),
                unknowns.clone().map(|k| mean_square * shifts.row(k).norm_squared()),
            ),
            per_unit: DVector::from_iterator(unknowns.len(), unknowns.map(most)),
        })
    };
    hidden.iter().zip(places).filter_map(of).collect()
}

/// Expected square of the size of a hidden cause, display units.
///
/// What the budget of the linear axes says is taken from it. Any other cause is there at a size that matters with the probability
/// [`PRESENT`], shared by its outlets; sizes have equal probability per octave up to what is plausible, those too small to matter
/// as well. Sizes that would have been seen are left out.
fn mean_square(form: &HiddenForm, smallest: Option<f64>) -> f64 {
    let unseen = smallest.unwrap_or(f64::INFINITY);
    if let Some(budget) = form.family.budget {
        return budget.min(unseen).powi(2);
    }
    let most = form.family.plausible;
    // of what never matters no probability is known
    let log_range = (most / form.notable).ln();
    if log_range <= 0.0 {
        return 0.0;
    }
    let present = PRESENT * (-form.family.rarity).exp() / form.family.outlets.len().max(1) as f64;
    present * unseen.min(most).powi(2) / (2.0 * log_range)
}
