//! A point of a link with the rotation of a target there: 6D targets of trackers and cameras.
//!
//! The three coordinates are those of a point. The rotation is read as a whole, M; what is compared are the components of
//! `φ = log(M·Rᵀ)`, R the rotation that the chain predicts, all in the instrument's axes. They count at a lever, so that 1 µm stands for 1 arcsec.

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

use super::rotation::{inverse_right_jacobian, rotation_vector};
use super::scalar::{Mounted, Scalar};
use crate::chain::{Geometry, MotionErrors, Sensitivity, Wrench};
use crate::units::ARCSEC_PER_RAD;

pub(super) const NAME: &str = "pose";
pub(super) const SCALARS: [Scalar; 6] = [
    Scalar::Coordinate(0),
    Scalar::Coordinate(1),
    Scalar::Coordinate(2),
    Scalar::Turn(0),
    Scalar::Turn(1),
    Scalar::Turn(2),
];
pub(super) const COLUMN_SETS: [&[&str]; 3] = [
    &["x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz"],
    &["x_mm", "y_mm", "z_mm", "r00", "r01", "r02", "r10", "r11", "r12", "r20", "r21", "r22"],
    &["x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg"],
];

/// Lever at which rotations count, mm: one arcsec moves its end by 1 µm.
pub const LEVER_MM: f64 = ARCSEC_PER_RAD * 1e-3;

/// Turn of the target about an axis of the instrument, counted from the rotation `read`, mm at [`LEVER_MM`], with its
/// derivatives.
pub fn turn(
    geometry: &Geometry,
    (instrument, target): (Mounted, Mounted),
    (axis, read): (usize, &Matrix3<f64>),
    (positions, motion): (&[f64], Option<&MotionErrors>),
    out: &mut Sensitivity,
) {
    let frame = geometry.pose(instrument.link, positions, motion);
    let carried = geometry.pose(target.link, positions, motion);
    let axes = frame.rotation * instrument.axes;
    let off = rotation_vector(&(read * (axes.transpose() * carried.rotation * target.axes).transpose()));
    let about: Vector3<f64> = inverse_right_jacobian(&off).row(axis).transpose();
    let pulls = Wrench::couple(axes * about * LEVER_MM);
    let origin = Vector3::zeros();
    let way = |link| geometry.way((link, &origin), positions, motion);
    geometry.pulled(&way(instrument.link), &way(target.link), pulls, (positions, motion), out);
    out.length_mm = -LEVER_MM * off[axis];
}

/// Rotation of a unit quaternion.
pub fn rotation_of_quaternion([w, x, y, z]: [f64; 4]) -> Matrix3<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).to_rotation_matrix().into_inner()
}

/// Rotation by angles (rad) about x, then the new y, then the newest z: `Rx·Ry·Rz`.
pub fn rotation_of_euler_xyz([x, y, z]: [f64; 3]) -> Matrix3<f64> {
    let about = |axis, angle| Rotation3::from_axis_angle(&axis, angle);
    (about(Vector3::x_axis(), x) * about(Vector3::y_axis(), y) * about(Vector3::z_axis(), z)).into_inner()
}

/// Quaternion of a rotation, w first and not negative.
pub fn quaternion(matrix: &Matrix3<f64>) -> [f64; 4] {
    let unit = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*matrix));
    let sign = if unit.w < 0.0 { -1.0 } else { 1.0 };
    [unit.w, unit.i, unit.j, unit.k].map(|part| sign * part)
}

/// Angles about x, the new y and the newest z, rad, of a rotation `Rx·Ry·Rz`; with y at ±90°, where x and z are one turn, any that
/// make it.
pub fn euler_xyz(matrix: &Matrix3<f64>) -> [f64; 3] {
    let y = matrix[(0, 2)].atan2(matrix[(0, 0)].hypot(matrix[(0, 1)]));
    let z = (-matrix[(0, 1)]).atan2(matrix[(0, 0)]);
    // with z taken back the second column is that of Rx, whatever z is
    let second = matrix.column(0) * z.sin() + matrix.column(1) * z.cos();
    [second.z.atan2(second.y), y, z]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_make_the_rotation_again_where_two_of_them_are_one_turn() {
        for y in [-90.0, -89.999_999, -30.0, 0.0, 60.0, 89.999_999_9, 90.0f64] {
            for (x, z) in [(0.0f64, 0.0), (20.0, -70.0), (170.0, 100.0), (-120.0, 179.0f64)] {
                let matrix = rotation_of_euler_xyz([x.to_radians(), y.to_radians(), z.to_radians()]);
                let off = (rotation_of_euler_xyz(euler_xyz(&matrix)) - matrix).norm();
                assert!(off < 1e-14, "{x} {y} {z}: {off}");
            }
        }
    }
}
