//! Five-axis machine accuracy.
