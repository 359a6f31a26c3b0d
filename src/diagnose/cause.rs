//! A cause by its name in the catalogue, and how many are named. It weighs nothing.

use crate::effects::Driver;

/// Causes named beside one at most: the answer keeps to so many.
pub const MOST_RIVALS: usize = 4;

/// Causes less probable than this are not named beside one.
pub(crate) const LEAST_PROBABILITY: f64 = 0.02;

/// A cause that was found, or a rival of one.
#[derive(Debug, Clone, PartialEq)]
pub struct Cause {
    /// Name in the catalogue.
    pub effect: String,
    pub driver: Driver,
    pub place: String,
    /// ISO names of the motions, largest first.
    pub components: Vec<String>,
}
