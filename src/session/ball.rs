//! Balls and how well their places and a bar's length are known before any reading. It holds no readings.

use nalgebra::Vector3;

/// How well setups are known before the fit: standard deviations per coordinate, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    pub pivot_mm: f64,
    pub spindle_ball_mm: f64,
    pub bar_length_mm: f64,
    /// Vector from the line of the last head axis to the spindle, per coordinate across the line: an error of the machine, which every
    /// spindle ball has beside its own. Zero where the machine file's vector is taken as it is.
    pub pivot_length_mm: f64,
}

/// Pivot length of which nothing is known, mm: as wide as what is assumed of location errors.
pub const FREE_PIVOT_LENGTH_MM: f64 = 1.0;

impl Default for Spread {
    /// 20 µm for a pivot cup placed by hand, 3 µm for a ball in a spindle, 0.5 µm for a calibrated bar, the machine file's pivot length.
    fn default() -> Spread {
        Spread { pivot_mm: 20e-3, spindle_ball_mm: 3e-3, bar_length_mm: 0.5e-3, pivot_length_mm: 0.0 }
    }
}

/// How the zero of a bar's deviations was set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Zero {
    /// On a calibrator: the bar has its stated length to within its spread.
    #[default]
    Calibrated,
    /// By hand, somewhere: readings tell how a length changes and not how long it is.
    Free,
}

impl Zero {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Zero::Calibrated => "calibrated",
            Zero::Free => "free",
        }
    }

    /// How well a bar's zero is known before the fit, standard deviation in mm, for a bar calibrated to `spread_mm`.
    pub fn spread_mm(self, spread_mm: f64) -> f64 {
        match self {
            Zero::Calibrated => spread_mm,
            Zero::Free => FREE_ZERO_MM,
        }
    }
}

/// Half the stroke of usual bars, mm: a zero set by hand lies within it. Wide enough to be without influence wherever data
/// speak.
pub(crate) const FREE_ZERO_MM: f64 = 1.0;

/// A ball: its centre in R with all axes at zero and the link that carries it.
#[derive(Debug, Clone, PartialEq)]
pub struct Ball {
    /// Name of the carrying link.
    pub link: String,
    /// Centre, mm.
    pub at: Vector3<f64>,
    /// Tag of a ball mounted anew at the same place.
    pub setup: Option<String>,
    /// Own spread per coordinate, mm.
    pub spread_mm: Option<f64>,
    /// Direction of R (0, 1, 2 for x, y, z) about which the spindle stands indexed by 180°: the same ball as in the tests
    /// without, its placement error turned with the spindle.
    pub indexed_about: Option<usize>,
}

impl Ball {
    /// Sign with which the ball's placement error enters along a coordinate.
    pub fn sign(&self, coordinate: usize) -> f64 {
        match self.indexed_about {
            Some(about) if about != coordinate => -1.0,
            _ => 1.0,
        }
    }
}
