//! A mistake in columns or statements with the session as it would be without. Which one was made is for others to judge.

use crate::diagnose::fault_kind::FaultKind;
use crate::session::{Session, Test};

/// A mistake with the session as it would be without.
pub(super) struct Undone {
    pub(super) kind: FaultKind,
    pub(super) place: &'static str,
    pub(super) components: Vec<String>,
    pub(super) says: String,
    pub(super) session: Session,
    /// By how much it makes readings of a test larger, by its name; of all tests without one. What is left is compared at the size at
    /// which they were read.
    pub(super) scale: (f64, Option<Vec<String>>),
}

impl Undone {
    /// By how much it makes readings of a test larger.
    pub(super) fn scale_of(&self, test: &Test) -> f64 {
        let (scale, of) = &self.scale;
        if of.as_ref().is_none_or(|of| of.contains(&test.name)) { *scale } else { 1.0 }
    }
}

/// Of mistakes that leave readings as large as they are.
pub(super) const AS_READ: (f64, Option<Vec<String>>) = (1.0, None);
