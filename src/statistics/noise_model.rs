//! Noise of recordings as white + AR(1) + slow drift. It knows nothing of geometry, and fits nothing.
//!
//! A reading's noise is `w_k + a_k + d_k`: white w, an AR(1) part `a_k = ρ a_{k−1} + …` of standard deviation σ_a,
//! and a random walk d that has standard deviation σ_d at the end of a trace; it starts at zero, or at an offset of the whole trace.

/// Smallest noise that a fit may find, mm: a twentieth of the last digit of a recording, so that ideal traces can be fitted.
pub const NOISE_FLOOR_MM: f64 = 5e-6;

/// Parameters of the noise, lengths in mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseModel {
    pub white_mm: f64,
    pub ar_mm: f64,
    /// Correlation of the AR(1) part from one sample to the next.
    pub ar_rho: f64,
    /// Standard deviation of the drift at the end of a trace.
    pub drift_mm: f64,
    /// Standard deviation of a whole trace: what a gauge drifts from one test to the next.
    pub offset_mm: f64,
}

impl NoiseModel {
    /// White noise alone.
    pub fn white(white_mm: f64) -> NoiseModel {
        NoiseModel { white_mm, ar_mm: 0.0, ar_rho: 0.0, drift_mm: 0.0, offset_mm: 0.0 }
    }

    /// Standard deviation of one reading in its trace, averaged over the trace, mm.
    pub fn rms_mm(&self) -> f64 {
        (self.white_mm.powi(2) + self.ar_mm.powi(2) + 0.5 * self.drift_mm.powi(2)).sqrt()
    }

    /// The same noise scaled.
    pub fn scaled(&self, factor: f64) -> NoiseModel {
        NoiseModel {
            white_mm: self.white_mm * factor,
            ar_mm: self.ar_mm * factor,
            drift_mm: self.drift_mm * factor,
            offset_mm: self.offset_mm * factor,
            ..*self
        }
    }
}
