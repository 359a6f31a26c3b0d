//! Rotations and their vectors: exponential, logarithm and the Jacobians between them. No chain.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// Rotation by a vector: its direction the axis, its length the angle, rad.
pub fn rotation(vector: &Vector3<f64>) -> Matrix3<f64> {
    Rotation3::new(*vector).into_inner()
}

/// The vector of a rotation, its angle at most π.
pub fn rotation_vector(matrix: &Matrix3<f64>) -> Vector3<f64> {
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*matrix)).scaled_axis()
}

/// Angles below which the series are exact to rounding, rad.
const SERIES_BELOW_RAD: f64 = 1e-4;

/// `J` with `rotation(v + δ) ≈ rotation(J δ) · rotation(v)` (Barfoot, State Estimation for Robotics, 7.37).
pub fn left_jacobian(vector: &Vector3<f64>) -> Matrix3<f64> {
    let cross = vector.cross_matrix();
    let angle = vector.norm();
    let (first, second) = match angle < SERIES_BELOW_RAD {
        true => (0.5, 1.0 / 6.0),
        false => ((1.0 - angle.cos()) / angle.powi(2), (angle - angle.sin()) / angle.powi(3)),
    };
    Matrix3::identity() + cross * first + cross * cross * second
}

/// Inverse of the right Jacobian: `log(rotation(v) · rotation(δ)) ≈ v + J⁻¹ δ`.
pub fn inverse_right_jacobian(vector: &Vector3<f64>) -> Matrix3<f64> {
    let cross = vector.cross_matrix();
    let angle = vector.norm();
    let second = match angle < SERIES_BELOW_RAD {
        true => 1.0 / 12.0,
        false => angle.powi(-2) - (1.0 + angle.cos()) / (2.0 * angle * angle.sin()),
    };
    Matrix3::identity() + cross * 0.5 + cross * cross * second
}

/// The rotation nearest to a matrix in the least-squares sense (Kabsch); a mirrored matrix gives the nearest that is not.
pub fn nearest_rotation(matrix: &Matrix3<f64>) -> Matrix3<f64> {
    let svd = matrix.svd(true, true);
    let (Some(u), Some(vt)) = (svd.u, svd.v_t) else { return Matrix3::identity() };
    let mut signs = Vector3::repeat(1.0);
    // nalgebra sorts singular values in falling order: the last direction is the least certain
    signs[2] = (u * vt).determinant().signum();
    u * Matrix3::from_diagonal(&signs) * vt
}
