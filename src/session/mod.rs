//! A session: tests with their balls, bars and recordings on one machine. It holds what was done, not what it means.

mod claim;
mod instruments;
mod motion;
mod path;
mod recording;
mod second_socket;
mod setups;

pub use claim::{Claim, ClaimedValue, Reduction};
pub use instruments::{locate_instruments, sighted_misfit_mm};
pub use motion::{Motion, MotionError, way_mm};
pub use path::{CirclePlane, Follow, Path};
pub use recording::{Clock, LengthColumn, Recording};
pub use setups::{Setup, Setups};

use nalgebra::Vector3;

use crate::machine::Machine;
use crate::readings::Reading;

/// How well setups are known before the fit: standard deviations per coordinate, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    pub pivot_mm: f64,
    pub spindle_ball_mm: f64,
    pub bar_length_mm: f64,
}

impl Default for Spread {
    /// 20 µm for a pivot cup placed by hand, 3 µm for a ball in a spindle, 0.5 µm for a calibrated bar.
    fn default() -> Spread {
        Spread { pivot_mm: 20e-3, spindle_ball_mm: 3e-3, bar_length_mm: 0.5e-3 }
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
const FREE_ZERO_MM: f64 = 1.0;

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

/// One test: a bar between two balls while some axes move, or one number of what another instrument read of a target.
#[derive(Debug, Clone, PartialEq)]
pub struct Test {
    pub name: String,
    /// Name of the recording's file, relative to the session file.
    pub recording_file: Option<String>,
    pub recording: Option<Recording>,
    /// Planned path, or the arc of a recording without positions.
    pub path: Option<Path>,
    /// Seconds since the session began at the recording's time 0.
    pub started_at_s: f64,
    /// Calibrated length of the bar, mm; `None` for an absolute length gauge.
    pub bar_length_mm: Option<f64>,
    /// Tag of a bar calibrated anew.
    pub bar_setup: Option<String>,
    /// How the bar's zero was set.
    pub zero: Zero,
    /// Known error of the reading: reading minus distance, mm.
    pub bar_error_mm: f64,
    pub pivot: Ball,
    pub spindle_ball: Ball,
    /// Positions of the axes that stand still, mm or rad, by axis index.
    pub positions: Vec<Option<f64>>,
    /// Speed of the moving ball, mm/min.
    pub feed_mm_per_min: Option<f64>,
    /// How far outside the arc the axes started, in the capture's direction, mm or deg.
    pub overshoot: Option<f64>,
    /// What the rows hold: lengths, or one number of a point, a pose, a socket, a displacement.
    pub reading: Reading,
}

impl Test {
    /// Whether it has the balls, bar, feed and standing axes of another one.
    pub fn is_repeat_of(&self, other: &Test) -> bool {
        self.pivot == other.pivot
            && self.spindle_ball == other.spindle_ball
            && self.bar_length_mm == other.bar_length_mm
            && self.positions == other.positions
            && self.feed_mm_per_min == other.feed_mm_per_min
    }

    /// Rows of the recording, or samples of the planned path.
    pub fn rows(&self) -> usize {
        match (&self.recording, &self.path) {
            (Some(recording), _) => recording.len(),
            (None, Some(path)) => path.sample_count(),
            (None, None) => 0,
        }
    }
}

/// Tests on one machine in the order of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Session {
    pub name: String,
    /// File of the machine as the session names it.
    pub machine_file: String,
    pub machine: Machine,
    pub spread: Spread,
    pub tests: Vec<Test>,
}

impl Session {
    /// Whether any test was read by another instrument than a bar.
    pub fn has_parts(&self) -> bool {
        self.tests.iter().any(|test| test.reading.part().is_some())
    }
}
