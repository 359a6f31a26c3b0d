//! The linear model of a fitted session: readings, derivatives and columns of effects, whitened and eliminated. It decides nothing.

pub(crate) mod decimate;
pub(crate) mod eliminated;
pub(crate) mod fitted_column;
pub(crate) mod kept_rows;
pub(crate) mod last_shape;
pub(crate) mod linear_model;
pub(crate) mod long_recordings;
pub(crate) mod prior_penalty;
pub(crate) mod products;
pub(crate) mod regression;
pub(crate) mod shapes;
pub(crate) mod whitened;
