//! A mistake in columns or statements with the session as it would be without. Which one was made is for others to judge.

use crate::diagnose::fault_kind::FaultKind;
use crate::session::Session;

/// A mistake with the session as it would be without.
pub(super) struct Undone {
    pub(super) kind: FaultKind,
    pub(super) place: &'static str,
    pub(super) components: Vec<String>,
    pub(super) says: String,
    pub(super) session: Session,
}
