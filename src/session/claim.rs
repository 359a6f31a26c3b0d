//! What someone states of a machine: location errors with their scatter, and the tests and the reduction behind them. It judges nothing.

use super::test::Session;
use crate::machine::ErrorName;

/// How the errors follow from the readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reduction {
    /// The thesis's estimator of chapter 4.
    Chapter4,
    /// The thesis's estimator of chapter 5.
    Chapter5,
    /// The thesis's estimator of chapter 6.
    Chapter6,
    /// Least squares over all readings, pivots and bars with the session's spreads.
    Fit,
}

impl Reduction {
    /// All, with their names in files.
    pub const ALL: [(&'static str, Reduction); 4] = [
        ("chapter4", Reduction::Chapter4),
        ("chapter5", Reduction::Chapter5),
        ("chapter6", Reduction::Chapter6),
        ("fit", Reduction::Fit),
    ];
}

/// One stated error.
#[derive(Debug, Clone, PartialEq)]
pub struct ClaimedValue {
    pub name: ErrorName,
    /// mm or rad.
    pub value: f64,
    /// Standard deviation of repeats as stated, mm or rad: repeatability, not uncertainty.
    pub deviation: f64,
}

/// Results of one method on one machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Claim {
    pub name: String,
    /// The design: balls, motions and order of the tests. Its readings play no part.
    pub session: Session,
    pub reduction: Reduction,
    pub values: Vec<ClaimedValue>,
}
