//! The model that a fit fits: unknowns with priors, slides within their budget, readings with derivatives. It solves nothing.

pub(crate) mod error;
pub(crate) mod options;
pub(crate) mod problem;
pub(crate) mod slides;
pub(crate) mod unknowns;
