//! The contract of a reading: its kind, its numbers, and how instrument and target of a test evaluate them. The equations stand in one file per kind.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use super::point::coordinate;
use super::pose::turn;
use super::rotation::{left_jacobian, rotation};
use super::scalar::{Mounted, Scalar};
use crate::chain::{Geometry, LinkId, MotionErrors, Sensitivity};

/// Kinds of readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Kind {
    /// Distance of two balls, by a bar.
    #[default]
    Length,
    /// Three coordinates of a point of a link in an instrument's frame: laser tracker, R-test, touch probe.
    Point,
    /// The same with the rotation of a target.
    Pose,
    /// A ball of a link sits in a socket: its centre is where it was before.
    SamePoint,
    /// Displacement of a point along a direction: dial gauge, capacitive sensor.
    Displacement,
}

impl Kind {
    /// All of them.
    pub const ALL: [Kind; 5] = [Kind::Length, Kind::Point, Kind::Pose, Kind::SamePoint, Kind::Displacement];

    /// Name in session files.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Length => "length",
            Kind::Point => super::point::NAME,
            Kind::Pose => super::pose::NAME,
            Kind::SamePoint => super::same_point::NAME,
            Kind::Displacement => super::displacement::NAME,
        }
    }

    /// The numbers of one reading, in order; a length is none of these.
    pub fn scalars(self) -> &'static [Scalar] {
        match self {
            Kind::Length => &[],
            Kind::Point => &super::point::SCALARS,
            Kind::Pose => &super::pose::SCALARS,
            Kind::SamePoint => &super::same_point::SCALARS,
            Kind::Displacement => &super::displacement::SCALARS,
        }
    }

    /// Sets of columns that may hold the readings in a recording; one whole set must be there.
    pub fn column_sets(self) -> &'static [&'static [&'static str]] {
        match self {
            Kind::Length => &[&["length_mm"]],
            Kind::Point => &super::point::COLUMN_SETS,
            Kind::Pose => &super::pose::COLUMN_SETS,
            Kind::SamePoint => &[&[]],
            Kind::Displacement => &super::displacement::COLUMN_SETS,
        }
    }

    /// Whether the instrument's axes are unknown beside its place.
    pub fn instrument_turns(self) -> bool {
        matches!(self, Kind::Point | Kind::Pose | Kind::Displacement)
    }

    /// Whether the target's axes are read.
    pub fn target_turns(self) -> bool {
        self == Kind::Pose
    }
}

/// Number of noise classes.
pub const NOISE_CLASSES: usize = 4;

/// What the rows of a test hold.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Reading {
    /// Ball-to-ball lengths.
    #[default]
    Length,
    /// One number of a reading of several; the pivot stands for the instrument (or socket), the spindle ball for the target.
    Part(Box<Part>),
}

impl Reading {
    /// The part, where it is one.
    pub fn part(&self) -> Option<&Part> {
        match self {
            Reading::Length => None,
            Reading::Part(part) => Some(part),
        }
    }

    /// The same to change.
    pub fn part_mut(&mut self) -> Option<&mut Part> {
        match self {
            Reading::Length => None,
            Reading::Part(part) => Some(part),
        }
    }

    /// Readings with one size of noise: lengths, coordinates, turns, and what was stated of sockets.
    pub fn noise_class(&self) -> usize {
        match self.part() {
            None => 0,
            Some(part) if part.scalar.is_turn() => 2,
            Some(part) if part.scalar == Scalar::Gap => 3,
            Some(_) => 1,
        }
    }

    /// Noise that the session states, mm: that of a known distance.
    pub fn stated_noise_mm(&self) -> Option<f64> {
        self.part().and_then(|part| part.noise_mm)
    }

    /// True for the known distance of two sockets: its second end is a pivot too.
    pub fn is_gap(&self) -> bool {
        self.part().is_some_and(|part| part.scalar == Scalar::Gap)
    }

    /// True for turns.
    pub fn is_turn(&self) -> bool {
        self.part().is_some_and(|part| part.scalar.is_turn())
    }
}

/// One number of the readings of a test in the session file.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    pub kind: Kind,
    /// Name of the test in the session file.
    pub of: String,
    pub scalar: Scalar,
    /// Axes of the instrument as columns, on its link (R at the zero position).
    pub instrument_axes: Matrix3<f64>,
    /// Axes of the target as columns, on its link.
    pub target_axes: Matrix3<f64>,
    /// How well the instrument's axes are known before the fit, rad; `None`: exactly, or it has none.
    pub instrument_turn_rad: Option<f64>,
    /// The same of the target's.
    pub target_turn_rad: Option<f64>,
    /// Rotation of the target's axes as read in the instrument's, row by row; the unit matrix where there is none.
    pub measured: Arc<Vec<Matrix3<f64>>>,
    /// Standard deviation that the session states, mm: of a known distance.
    pub noise_mm: Option<f64>,
    /// Columns of the file that hold the readings.
    pub columns: Arc<Vec<String>>,
}

impl Part {
    /// Whether it is the first number of its reading.
    pub fn leads(&self) -> bool {
        self.scalar == Scalar::Coordinate(0)
    }

    /// Value of the number at a row with all its derivatives, in `out`; `out.length_mm` is the value.
    pub fn evaluate(
        &self,
        geometry: &Geometry,
        (instrument, target): (Mounted, Mounted),
        row: usize,
        (positions, motion): (&[f64], Option<&MotionErrors>),
        out: &mut Sensitivity,
    ) {
        match self.scalar {
            Scalar::Coordinate(axis) => coordinate(geometry, (instrument, target), axis, (positions, motion), out),
            Scalar::Turn(axis) => {
                let read = self.measured.get(row).copied().unwrap_or_else(Matrix3::identity);
                turn(geometry, (instrument, target), (axis, &read), (positions, motion), out);
            }
            Scalar::Gap => {
                let (one, other) = ((instrument.link, instrument.at), (target.link, target.at));
                geometry.sensitivity(one, other, positions, motion, out);
            }
        }
    }
}

/// Instrument and target of a test with their axes turned by what a fit found: evaluates lengths and parts alike.
pub struct Mount<'a> {
    part: Option<&'a Part>,
    instrument_axes: Matrix3<f64>,
    target_axes: Matrix3<f64>,
    /// What a small turn on top of the turns means for their rotation vectors.
    jacobians: [Matrix3<f64>; 2],
}

/// A ball, an instrument or a target: link and place on it.
pub type At<'a> = (LinkId, &'a Vector3<f64>);

impl<'a> Mount<'a> {
    /// `part` is `None` for lengths; `turns` are rotation vectors of instrument and target, rad.
    pub fn of(part: Option<&'a Part>, turns: [Vector3<f64>; 2]) -> Mount<'a> {
        let axes = part.map_or([Matrix3::identity(); 2], |part| [part.instrument_axes, part.target_axes]);
        Mount {
            part,
            instrument_axes: rotation(&turns[0]) * axes[0],
            target_axes: rotation(&turns[1]) * axes[1],
            jacobians: turns.map(|turn| left_jacobian(&turn).transpose()),
        }
    }

    /// Value and derivatives of the reading at a row; turns are differentiated by their rotation vectors.
    pub fn evaluate(
        &self,
        geometry: &Geometry,
        (pivot, spindle): (At, At),
        row: usize,
        (positions, motion): (&[f64], Option<&MotionErrors>),
        out: &mut Sensitivity,
    ) {
        let Some(part) = self.part else {
            return geometry.sensitivity(pivot, spindle, positions, motion, out);
        };
        let instrument = Mounted { link: pivot.0, at: pivot.1, axes: &self.instrument_axes };
        let target = Mounted { link: spindle.0, at: spindle.1, axes: &self.target_axes };
        part.evaluate(geometry, (instrument, target), row, (positions, motion), out);
        out.pivot_turn = self.jacobians[0] * out.pivot_turn;
        out.spindle_turn = self.jacobians[1] * out.spindle_turn;
    }
}
