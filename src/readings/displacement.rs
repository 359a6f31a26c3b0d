//! Displacement of a point along a direction: dial gauges, capacitive sensors. The direction is the instrument's first axis.

use super::scalar::Scalar;

pub(super) const NAME: &str = "displacement";
pub(super) const SCALARS: [Scalar; 1] = [Scalar::Coordinate(0)];
pub(super) const COLUMN_SETS: [&[&str]; 1] = [&["displacement_mm"]];
