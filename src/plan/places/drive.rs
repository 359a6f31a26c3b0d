//! What moves in a test: one axis alone, one with linear axes following, or two on a circle. Positions are in `course`.

use crate::session::{CirclePlane, Follow};

/// What moves in a test.
#[derive(Debug, Clone, PartialEq)]
pub enum Drive {
    /// The axis alone.
    Turn,
    /// Linear axes keep the bar's direction in the turning frame.
    Follow(Follow, Box<Swing>),
    /// Two linear axes move the spindle ball about the pivot.
    Circle(CirclePlane, Box<Swing>),
}

/// Motion of linear axes with the angle φ of a path: `q = middle + cos·cos φ + sin·sin φ`, by axis, mm.
///
/// The middle stands in the candidate's positions. A bar that turns with a rotary axis asks just that of slides which the
/// axis does not carry: the ball that the axis carries and the bar's direction both go round a circle.
#[derive(Debug, Clone, PartialEq)]
pub struct Swing {
    pub cos: Vec<f64>,
    pub sin: Vec<f64>,
}

impl Swing {
    /// No motion of that many axes.
    pub fn none(axes: usize) -> Swing {
        Swing { cos: vec![0.0; axes], sin: vec![0.0; axes] }
    }

    /// Position of an axis relative to the middle, mm.
    pub fn at(&self, axis: usize, angle_rad: f64) -> f64 {
        self.cos[axis] * angle_rad.cos() + self.sin[axis] * angle_rad.sin()
    }

    /// Farthest that an axis goes from the middle, mm.
    pub fn reach(&self, axis: usize) -> f64 {
        self.cos[axis].hypot(self.sin[axis])
    }
}

/// Step of the rows along which a path is checked and stated, deg.
pub(crate) const STEP_DEG: f64 = 0.5;
