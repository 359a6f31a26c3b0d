//! Numbers of a plan as its JSON and text state them.

/// Rounded to some digits, without a negative zero.
pub(crate) fn round(value: f64, digits: i32) -> f64 {
    let scale = 10f64.powi(digits);
    (value * scale).round() / scale + 0.0
}
