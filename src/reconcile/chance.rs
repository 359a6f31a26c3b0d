//! What chance gives: shares beyond a number of standard deviations, and thresholds for many comparisons.

use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

/// Share of consistent claims in which some disagreement may be called so by chance.
pub const FALSE_ALARMS: f64 = 0.02;

/// χ² of one degree of freedom that one of `count` comparisons exceeds by chance in [`FALSE_ALARMS`] of the cases.
pub(super) fn one_of(count: usize) -> f64 {
    let share = FALSE_ALARMS / count.max(1) as f64;
    ChiSquared::new(1.0).map_or(f64::INFINITY, |chi2| chi2.inverse_cdf(1.0 - share))
}

/// Share of chance that lies beyond a number of standard deviations, both sides.
pub fn chance(sigmas: f64) -> f64 {
    Normal::new(0.0, 1.0).map_or(f64::NAN, |normal| 2.0 * normal.cdf(-sigmas.abs()))
}
