//! The thesis's measuring methods of chapters 4 to 7, and what their tests keep to. Which tests they take is in `method_tests`.

/// A measuring method of the thesis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Each rotary axis from its own pivot: the short bar at h = 0, then the extended bar.
    Chapter4,
    /// As chapter 4 with one pivot setup for all axes.
    Chapter5,
    /// The short bar only, at two places along each axis.
    Chapter6,
    /// As chapter 4, the ball of tilting heads on a flat fixture and the pivot on an angle plate where needed.
    Chapter7,
}

/// Why a method gave no plan.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{method} does not fit this machine: {reason}")]
pub struct MethodError {
    pub method: &'static str,
    pub reason: String,
}

/// Least distance between the two places of chapter 6, mm.
pub(crate) const APART_MM: f64 = 30.0;
/// h = 0 within this, mm.
pub(crate) const LEVEL_MM: f64 = 1e-3;
