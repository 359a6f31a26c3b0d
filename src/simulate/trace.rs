//! A simulated recording: what `forward` and `instrument` give.

use crate::session::Motion;

/// A simulated recording: lengths over the rows of a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    pub test: String,
    pub motion: Motion,
    /// Readings, mm, one per row.
    pub length_mm: Vec<f64>,
}
