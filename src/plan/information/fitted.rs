//! What a fit of the recordings of some tests would say of the wanted errors: determined or not, and how well.

use super::block::{Block, HELD, Nuisance};
use super::posterior::Posterior;
use super::unknowns::Unknowns;

/// Share of the priors in the variance from which an error is not determined.
pub(crate) const HALF: f64 = 0.5;

/// What a fit of the recordings would say of an error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fitted {
    /// Share of the priors in its variance.
    pub prior_share: f64,
    /// mm or rad.
    pub sigma: f64,
}

impl Fitted {
    /// The fit would call it determined.
    pub fn is_determined(&self) -> bool {
        self.prior_share < HALF
    }
}

/// For each wanted error: what a fit of the recordings would say of it.
pub(crate) fn fitted(unknowns: &Unknowns, blocks: &[&Block]) -> Vec<Fitted> {
    let is_not_fitted =
        |nuisance: &Nuisance| matches!(nuisance, Nuisance::SpindleBall(_) | Nuisance::Stand(_) | Nuisance::Scale(_));
    let mut fitted = Posterior::before(&unknowns.with_exact_linear_axes());
    blocks.iter().for_each(|block| fitted.add(&block.with_prior_scaled(is_not_fitted, HELD)));
    let of = |k: usize| Fitted { prior_share: fitted.prior_share(k), sigma: fitted.covariance(k, k).sqrt() };
    (0..unknowns.wanted).map(of).collect()
}
