//! How far the idealised forms of effects may be from the real ones. A size bears that besides the noise.

/// Uncertainty of a size from the form of its effect, as a share: a form is never exact, a vibration breathes, a screw's
/// period swells along its travel, and the peak of a spike lies between two readings.
pub(crate) fn form_sigma(effect: &str) -> f64 {
    match effect {
        "reversal-spike" => 0.12,
        "vibration" => 0.06,
        "cyclic-error" => 0.07,
        _ => 0.03,
    }
}
