//! Positions of points on links for given error values and axis positions; forward only, derivatives are in `sensitivity`.
//!
//! From the bed outward a branch is the product of `E·M·J` (rotary) or `E·J·M` (linear) over its joints:
//! `J` the nominal motion, `E = Tx·Ty·Tz·Rx·Ry·Rz` the location error about the axis's origin, `M` the component
//! errors of the moment. The location error of a linear axis turns only its direction of motion: `J` is the
//! translation by `R·u·q`. The first-order composition takes `I + [ε]×` for every error rotation (thesis eq. 3.2–3.8).

use nalgebra::{Matrix3, Vector3};

use super::link::LinkId;
use super::structure::{Chain, Joint};
use crate::machine::AxisKind;

/// How error rotations are composed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Composition {
    /// Exact rotation matrices.
    #[default]
    Exact,
    /// Small-angle matrices `I + [ε]×`, not re-orthonormalised, as the thesis prints them.
    FirstOrder,
}

/// Component errors of the moment, EX EY EZ (mm) EA EB EC (rad), one entry per axis.
pub type MotionErrors = [[f64; 6]];

/// Pose of a link in the bed frame: `bed = rotation · link + translation`.
///
/// With first-order composition the matrix is not exactly a rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    pub rotation: Matrix3<f64>,
    pub translation_mm: Vector3<f64>,
}

impl Pose {
    /// The bed itself.
    pub fn identity() -> Pose {
        Pose { rotation: Matrix3::identity(), translation_mm: Vector3::zeros() }
    }

    /// A point given in the link (R at the zero position) in the bed frame, mm.
    pub fn point(&self, at: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * at + self.translation_mm
    }

    /// The pose of what stands at `inner` in this one's frame.
    pub fn then(&self, inner: &Pose) -> Pose {
        Pose { rotation: self.rotation * inner.rotation, translation_mm: self.point(&inner.translation_mm) }
    }
}

/// A chain with values for its location errors, ready to place points.
#[derive(Debug, Clone)]
pub struct Geometry<'a> {
    pub(super) chain: &'a Chain,
    pub(super) composition: Composition,
    pub(super) placed: Vec<PlacedJoint>,
}

/// A joint with its location error in the form the composition needs.
#[derive(Debug, Clone)]
pub(super) struct PlacedJoint {
    pub joint: Joint,
    /// Rotation of E: exact or `I + [ε]×`.
    pub rotation: Matrix3<f64>,
    /// Translation of E, mm.
    pub translation: Vector3<f64>,
    /// Directions about which the three error angles turn after E is applied (exact composition).
    pub turn_about: [Vector3<f64>; 3],
}

impl PlacedJoint {
    fn new(joint: &Joint, error: &[f64; 6], composition: Composition) -> PlacedJoint {
        let angles = Vector3::new(error[3], error[4], error[5]);
        PlacedJoint {
            joint: joint.clone(),
            rotation: error_rotation(&angles, composition),
            translation: Vector3::new(error[0], error[1], error[2]),
            turn_about: turn_directions(&angles, composition),
        }
    }

    /// Sine and cosine of the joint's turn at a position; of a linear joint none is needed.
    pub(super) fn sine_cosine(&self, q: f64) -> (f64, f64) {
        match self.joint.kind {
            AxisKind::Rotary => (self.joint.sign * q).sin_cos(),
            AxisKind::Linear => (0.0, 1.0),
        }
    }

    /// Where the nominal motion and M bring a point that the joint carries, relative to the origin, before E.
    pub(super) fn moved(
        &self,
        at: &Vector3<f64>,
        turned: (f64, f64),
        motion: Option<&[f64; 6]>,
        composition: Composition,
    ) -> Vector3<f64> {
        let joint = &self.joint;
        let arm = at - joint.origin;
        match joint.kind {
            AxisKind::Rotary => shifted(turn(&arm, &joint.direction, turned), motion, composition),
            AxisKind::Linear => shifted(arm, motion, composition),
        }
    }

    /// A point that [`PlacedJoint::moved`] has moved, in the carrier's frame.
    pub(super) fn carry(&self, arm: &Vector3<f64>, q: f64) -> Vector3<f64> {
        let origin = self.joint.origin;
        match self.joint.kind {
            AxisKind::Rotary => origin + self.translation + self.rotation * arm,
            AxisKind::Linear => origin + arm + self.translation + self.slide(q),
        }
    }

    /// Displacement of a linear joint: `R·u·q`.
    pub(super) fn slide(&self, q: f64) -> Vector3<f64> {
        self.rotation * self.joint.direction * (self.joint.sign * q)
    }
}

/// A relative position with the component errors applied: `M_R·arm + M_t`.
fn shifted(arm: Vector3<f64>, motion: Option<&[f64; 6]>, composition: Composition) -> Vector3<f64> {
    match motion {
        None => arm,
        Some(m) => {
            let angles = Vector3::new(m[3], m[4], m[5]);
            error_rotation(&angles, composition) * arm + Vector3::new(m[0], m[1], m[2])
        }
    }
}

/// Rotation of three small angles: `Rx·Ry·Rz`, or `I + [ε]×`.
pub(super) fn error_rotation(angles: &Vector3<f64>, composition: Composition) -> Matrix3<f64> {
    match composition {
        Composition::FirstOrder => Matrix3::identity() + angles.cross_matrix(),
        Composition::Exact => {
            let (sa, ca) = angles.x.sin_cos();
            let (sb, cb) = angles.y.sin_cos();
            let (sc, cc) = angles.z.sin_cos();
            Matrix3::new(
                cb * cc,
                -cb * sc,
                sb,
                ca * sc + sa * sb * cc,
                ca * cc - sa * sb * sc,
                -sa * cb,
                sa * sc - ca * sb * cc,
                sa * cc + ca * sb * sc,
                ca * cb,
            )
        }
    }
}

/// Directions d with `∂(E x)/∂angle_k = d_k × (E x − o − t)`: x, `Rx·y`, `Rx·Ry·z` (exact); the unit vectors (first order).
pub(super) fn turn_directions(angles: &Vector3<f64>, composition: Composition) -> [Vector3<f64>; 3] {
    match composition {
        Composition::FirstOrder => [Vector3::x(), Vector3::y(), Vector3::z()],
        Composition::Exact => {
            let (sa, ca) = angles.x.sin_cos();
            let (sb, cb) = angles.y.sin_cos();
            [Vector3::x(), Vector3::new(0.0, ca, sa), Vector3::new(sb, -sa * cb, ca * cb)]
        }
    }
}

/// Rotation of `arm` about the unit vector `about` by an angle of this sine and cosine (Rodrigues).
pub(super) fn turn(arm: &Vector3<f64>, about: &Vector3<f64>, (sine, cosine): (f64, f64)) -> Vector3<f64> {
    arm * cosine + about.cross(arm) * sine + about * (about.dot(arm) * (1.0 - cosine))
}

/// Rotation about a unit vector (Rodrigues).
pub(super) fn turn_about(about: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let (sine, cosine) = angle.sin_cos();
    Matrix3::identity() * cosine + about.cross_matrix() * sine + about * about.transpose() * (1.0 - cosine)
}

impl<'a> Geometry<'a> {
    /// A chain with location errors `errors` (mm, rad, by axis index); missing entries are zero.
    pub fn new(chain: &'a Chain, errors: &[[f64; 6]], composition: Composition) -> Geometry<'a> {
        let placed = (0..chain.axis_count())
            .map(|axis| {
                let error = errors.get(axis).copied().unwrap_or_default();
                PlacedJoint::new(chain.joint(axis), &error, composition)
            })
            .collect();
        Geometry { chain, composition, placed }
    }

    /// The nominal chain: every error zero.
    pub fn nominal(chain: &'a Chain) -> Geometry<'a> {
        Geometry::new(chain, &[], Composition::Exact)
    }

    /// The chain this geometry belongs to.
    pub fn chain(&self) -> &'a Chain {
        self.chain
    }

    /// Composition of the error rotations.
    pub fn composition(&self) -> Composition {
        self.composition
    }

    /// A point on a link in the bed frame, mm. `positions` (mm, rad) and `motion` are by axis index.
    pub fn point(
        &self,
        link: LinkId,
        at: &Vector3<f64>,
        positions: &[f64],
        motion: Option<&MotionErrors>,
    ) -> Vector3<f64> {
        self.chain.path(link).iter().rev().fold(*at, |point, &axis| {
            let (placed, q) = (&self.placed[axis], positions[axis]);
            let arm = placed.moved(&point, placed.sine_cosine(q), motion.map(|m| &m[axis]), self.composition);
            placed.carry(&arm, q)
        })
    }

    /// Pose of a link in the bed frame.
    pub fn pose(&self, link: LinkId, positions: &[f64], motion: Option<&MotionErrors>) -> Pose {
        self.chain.path(link).iter().fold(Pose::identity(), |carrier, &axis| {
            carrier.then(&self.joint_pose(axis, positions[axis], motion.map(|m| &m[axis])))
        })
    }

    /// Pose of the link that an axis carries in its carrier's frame; `motion` are its component errors, `None` for none.
    pub fn joint_pose(&self, axis: usize, q: f64, motion: Option<&[f64; 6]>) -> Pose {
        let placed = &self.placed[axis];
        let joint = &placed.joint;
        let (turned, shift) = match motion {
            None => (Matrix3::identity(), Vector3::zeros()),
            Some(m) => {
                let angles = Vector3::new(m[3], m[4], m[5]);
                (error_rotation(&angles, self.composition), Vector3::new(m[0], m[1], m[2]))
            }
        };
        let (rotation, moved) = match joint.kind {
            AxisKind::Rotary => {
                let about = turn_about(&joint.direction, joint.sign * q);
                (placed.rotation * turned * about, placed.translation + placed.rotation * shift)
            }
            AxisKind::Linear => (turned, placed.translation + shift + placed.slide(q)),
        };
        Pose { rotation, translation_mm: joint.origin + moved - rotation * joint.origin }
    }

    /// Way of what a linear axis carries per unit of its position, in the carrier's frame: `R·u·sign`.
    pub fn slide_direction(&self, axis: usize) -> Vector3<f64> {
        self.placed[axis].slide(1.0)
    }

    /// Distance between two balls, mm: each ball is a link and a place on it.
    pub fn length(
        &self,
        pivot: (LinkId, &Vector3<f64>),
        spindle: (LinkId, &Vector3<f64>),
        positions: &[f64],
        motion: Option<&MotionErrors>,
    ) -> f64 {
        let pivot = self.point(pivot.0, pivot.1, positions, motion);
        let spindle = self.point(spindle.0, spindle.1, positions, motion);
        (pivot - spindle).norm()
    }
}
