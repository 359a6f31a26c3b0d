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
    /// By how much it makes readings larger: of the tests so named in the session file, or of all. What is left is compared at the size
    /// at which they were read.
    pub(super) scale: (f64, Option<Vec<String>>),
}

impl Undone {
    /// By how much it makes readings of a test larger.
    pub(super) fn scale_of(&self, test: &Test) -> f64 {
        let (scale, of) = &self.scale;
        if of.as_ref().is_none_or(|of| is_of(test, of)) { *scale } else { 1.0 }
    }
}

/// Whether a test stands in the session file by one of the names.
pub(super) fn is_of(test: &Test, names: &[String]) -> bool {
    names.iter().any(|name| name == test.stated_name())
}

/// What coordinates are called among the components of a mistake.
pub(super) const COORDINATES: &str = "coordinates";

/// Of mistakes that leave readings as large as they are.
pub(super) const AS_READ: (f64, Option<Vec<String>>) = (1.0, None);
