//! One number of a reading, and what carries the axes along which it is read. It computes nothing.

use nalgebra::{Matrix3, Vector3};

use crate::chain::LinkId;

/// One number of a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scalar {
    /// Coordinate of the target along an axis (0, 1, 2) of the instrument, mm.
    Coordinate(usize),
    /// Turn of the target about an axis (0, 1, 2) of the instrument, counted from the rotation that was read, mm at
    /// `LEVER_MM`.
    Turn(usize),
    /// Known distance of two sockets, mm.
    Gap,
}

impl Scalar {
    /// Name beside the test's: `x`, `turn z`.
    pub fn name(self) -> &'static str {
        match self {
            Scalar::Coordinate(k) => ["x", "y", "z"][k.min(2)],
            Scalar::Turn(k) => ["turn x", "turn y", "turn z"][k.min(2)],
            Scalar::Gap => "distance",
        }
    }

    /// True for turns: they have a noise of their own.
    pub fn is_turn(self) -> bool {
        matches!(self, Scalar::Turn(_))
    }
}

/// Something with axes on a link.
#[derive(Debug, Clone, Copy)]
pub struct Mounted<'a> {
    pub link: LinkId,
    /// Its origin on the link, mm.
    pub at: &'a Vector3<f64>,
    /// Its axes as columns, on the link.
    pub axes: &'a Matrix3<f64>,
}
