//! How far linear axes may be from straight, square and true to scale: standard deviations before any test, no values.
//!
//! A carriage at position q (mm from its zero) is off by `d(q) = q·g(q)`, g a smooth random function of standard deviation
//! `positioning` along its way and `straightness` across it; two axes are out of square by `squareness`. Angular errors of
//! a carriage count with what they move a ball.

use nalgebra::Vector3;

/// A class of linear axes.
///
/// The acceptance tests of machining centres (ISO 10791-2 geometric, -4 positioning) allow some 0.02 mm on 500 mm for
/// squareness (40 µrad), 0.01 mm on 500 mm for straightness and 0.02 mm on 1000 mm for positioning (20 µm/m both).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinearClass {
    /// Within half the acceptance tolerance in 95 of 100 cases: σ is a quarter of it.
    New,
    /// Within the acceptance tolerance in 95 of 100 cases: σ is half of it.
    Used,
    /// Out of the acceptance tolerance in one case of three: σ is all of it.
    Worn,
}

impl LinearClass {
    /// All classes.
    pub const ALL: [LinearClass; 3] = [LinearClass::New, LinearClass::Used, LinearClass::Worn];

    /// The word in files.
    pub fn name(self) -> &'static str {
        match self {
            LinearClass::New => "new",
            LinearClass::Used => "used",
            LinearClass::Worn => "worn",
        }
    }

    /// Share of the acceptance tolerance that is one standard deviation.
    fn share(self) -> f64 {
        match self {
            LinearClass::New => 0.25,
            LinearClass::Used => 0.5,
            LinearClass::Worn => 1.0,
        }
    }
}

/// Acceptance tolerances: length per length and angle.
const TOLERANCE_PER_LENGTH: f64 = 20e-6;
const TOLERANCE_SQUARENESS_RAD: f64 = 40e-6;

/// Budget of the linear axes: one standard deviation each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearAxes {
    /// The class that the numbers are of; `None`: numbers of the machine file.
    pub class: Option<LinearClass>,
    /// The machine file says so; else the class is assumed.
    pub is_stated: bool,
    /// Along an axis, per length moved from its zero, mm/mm.
    pub positioning: f64,
    /// Across an axis, per length moved from its zero, mm/mm.
    pub straightness: f64,
    /// Squareness of two axes, rad.
    pub squareness_rad: f64,
}

impl Default for LinearAxes {
    /// New axes, assumed.
    fn default() -> LinearAxes {
        LinearAxes { is_stated: false, ..LinearAxes::of(LinearClass::New) }
    }
}

impl LinearAxes {
    /// Axes without any error.
    pub const EXACT: LinearAxes =
        LinearAxes { class: None, is_stated: true, positioning: 0.0, straightness: 0.0, squareness_rad: 0.0 };

    /// The budget of a class, stated.
    pub fn of(class: LinearClass) -> LinearAxes {
        let per_length = TOLERANCE_PER_LENGTH * class.share();
        LinearAxes {
            class: Some(class),
            is_stated: true,
            positioning: per_length,
            straightness: per_length,
            squareness_rad: TOLERANCE_SQUARENESS_RAD * class.share(),
        }
    }

    /// Standard deviation per length moved by an axis, in the directions of R: along and across its way.
    pub fn per_length(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        let (along, across) = (self.positioning.powi(2), self.straightness.powi(2));
        direction.map(|u| (across + (along - across) * u * u).max(0.0).sqrt())
    }
}
