//! What a fit is asked for: its free errors and their prior.

use super::unknowns::{FreePrior, Unknown, default_free, unknowns};
use crate::machine::ErrorName;
use crate::session::{Session, Setups};

/// What to fit and how.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Free location errors; `None`: [`default_free`].
    pub free: Option<Vec<ErrorName>>,
    /// Prior of the free location errors; `None`: [`FreePrior::of`].
    pub prior: Option<FreePrior>,
}

impl Options {
    /// Unknowns of a fit to a session: what is asked for, or what the machine suggests.
    pub fn unknowns(&self, session: &Session, setups: &Setups) -> Vec<Unknown> {
        let free = self.free.clone().unwrap_or_else(|| default_free(&session.machine));
        unknowns(session, setups, &free, self.prior.unwrap_or_else(|| FreePrior::of(&session.machine)))
    }
}
