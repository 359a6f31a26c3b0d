//! Three coordinates of a point of a link in the frame of an instrument: laser tracker, R-test, touch probe on a sphere.
//!
//! With the point p on its link, the instrument's origin o and axes A on its own: `y_k = (A e_k)·(p_I − o)`, p_I the point as
//! the instrument's link sees it. The wrench is the unit force along the instrument's axis at the point.

use nalgebra::Vector3;

use super::scalar::{Mounted, Scalar};
use crate::chain::{Geometry, MotionErrors, Sensitivity, Wrench};

pub(super) const NAME: &str = "point";
pub(super) const SCALARS: [Scalar; 3] = [Scalar::Coordinate(0), Scalar::Coordinate(1), Scalar::Coordinate(2)];
pub(super) const COLUMN_SETS: [&[&str]; 1] = [&["x_mm", "y_mm", "z_mm"]];

/// Coordinate of the target's point along an axis of the instrument, mm, with its derivatives.
pub fn coordinate(
    geometry: &Geometry,
    (instrument, target): (Mounted, Mounted),
    axis: usize,
    (positions, motion): (&[f64], Option<&MotionErrors>),
    out: &mut Sensitivity,
) {
    let way = geometry.way((target.link, target.at), positions, motion);
    let point = way.at_bed;
    let along: Vector3<f64> = instrument.axes.column(axis).into();
    let (seen, force) = match instrument.link.depth {
        0 => (point, along),
        _ => {
            let pose = geometry.pose(instrument.link, positions, motion);
            (pose.rotation.transpose() * (point - pose.translation_mm), pose.rotation * along)
        }
    };
    let pulls = Wrench::force(force);
    let instrument_way = geometry.way((instrument.link, &seen), positions, motion);
    geometry.pulled(&instrument_way, &way, pulls, (positions, motion), out);
    // a turn of the instrument about its own origin moves its axes past the point
    out.pivot_turn += (seen - instrument.at).cross(&out.pivot);
    out.length_mm = along.dot(&(seen - instrument.at));
}
