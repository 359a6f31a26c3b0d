//! Spreads and noise that the forecast of a plan takes.

use crate::session::{Spread, Zero};

/// Spreads and noise that the forecast takes, mm and rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uncertainty {
    pub spread: Spread,
    /// How the bars' zeros are set: of a free one nothing is known.
    pub zero: Zero,
    /// Standard deviation of one effective sample, mm.
    pub noise_mm: f64,
    /// Effective samples of a full turn; shorter arcs have their share.
    pub samples_per_turn: f64,
    /// Prior of wanted positions, mm: wide, so that only data count; the same as a fit's.
    pub wanted_mm: f64,
    /// Prior of wanted orientations, rad; the same as a fit's.
    pub wanted_rad: f64,
}

impl Default for Uncertainty {
    /// Noise and effective samples as seen in ball-bar sweeps (about 30 in a turn).
    fn default() -> Uncertainty {
        Uncertainty {
            spread: Spread::default(),
            zero: Zero::Calibrated,
            noise_mm: 0.5e-3,
            samples_per_turn: 30.0,
            wanted_mm: 1.0,
            wanted_rad: 0.1 * std::f64::consts::PI / 180.0,
        }
    }
}
