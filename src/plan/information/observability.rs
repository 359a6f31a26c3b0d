//! What lengths of reachable setups can show of an error, whatever stands in their way and however long it takes.

/// What lengths show of one wanted error.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Observability {
    /// Reachable setups, clear or not, would fix it with pivots and bars unknown.
    pub is_seen: bool,
    /// Unseen errors that lengths show in one sum with it.
    pub partners: Vec<usize>,
    /// Lengths would fix it if places of pivots were known to be where they are told to.
    pub by_pivot: bool,
}
