//! A ball's way through the chain with everything that stands still folded into constants; evaluates nothing.
//!
//! Frames are counted from the bed (frame 0) to the ball; one moving axis lies between neighbours:
//! `r_outer = matrix·(Rz(q)·r_inner) + offset` (turn) or `r_outer = r_inner + offset + q·direction` (slide).
//! A turning axis's inner frame has its origin on the axis and its z along it, so that every rotation is about z.

use nalgebra::{Matrix3, Vector3};

use super::column::Column;
use super::geometry::{Composition, Geometry, PlacedJoint, turn_about};
use super::link::LinkId;
use super::poses::Poses;
use crate::machine::AxisKind;

/// One moving axis between two frames.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Step {
    pub axis: usize,
    pub offset: [f64; 3],
    pub kind: StepKind,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum StepKind {
    /// Turn about the inner frame's z by `q`, then by the constant matrix (rows).
    Turn { matrix: [[f64; 3]; 3] },
    /// Slide along a constant direction of the outer frame.
    Slide { direction: [f64; 3] },
}

/// How a link's coordinates become those of its frame: `r = matrix·x + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LinkInFrame {
    frame: usize,
    matrix: Matrix3<f64>,
    offset: Vector3<f64>,
}

/// A ball's way from the bed: steps outermost first, the ball in the innermost frame.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Way {
    pub steps: Vec<Step>,
    pub ball: [f64; 3],
    link: LinkId,
    /// By depth from the bed.
    links: Vec<LinkInFrame>,
}

/// Velocity of the ball, seen in a frame, per unit of an error: `matrix·r + constant`, times an axis position if any.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Velocity {
    pub frame: usize,
    pub matrix: Matrix3<f64>,
    pub constant: Vector3<f64>,
    pub times_position_of: Option<usize>,
}

/// Velocity of a carried point in a link's own coordinates.
struct LinkVelocity {
    depth: usize,
    /// `None`: all points move alike.
    turning: Option<Matrix3<f64>>,
    constant: Vector3<f64>,
    times_position_of: Option<usize>,
}

impl Way {
    /// Lowers the way of a ball on `link` at `at` for poses that say which axes stand still.
    pub fn of(geometry: &Geometry, ball: (LinkId, &Vector3<f64>), poses: &Poses) -> Way {
        let path = geometry.chain.path(ball.0);
        let mut steps = Vec::with_capacity(path.len());
        let mut here = LinkInFrame { frame: 0, matrix: Matrix3::identity(), offset: Vector3::zeros() };
        let mut links = Vec::with_capacity(path.len() + 1);
        links.push(here);
        for &axis in path {
            let placed = &geometry.placed[axis];
            here = match poses.standing(axis) {
                Some(q) => standing(placed, q, &here),
                None => {
                    let (step, inner) = moving(placed, axis, &here);
                    steps.push(step);
                    inner
                }
            };
            links.push(here);
        }
        Way { steps, ball: (here.matrix * ball.1 + here.offset).into(), link: ball.0, links }
    }

    /// Velocity of this way's ball per unit of a column; `None` when the column does not touch it.
    pub fn velocity(&self, geometry: &Geometry, column: Column, poses: &Poses) -> Option<Velocity> {
        let path = geometry.chain.path(self.link);
        let depth_of = |axis: usize| path.iter().position(|&other| other == axis);
        let local = match column {
            Column::Pivot(k) | Column::Spindle(k) => LinkVelocity::shift(path.len(), unit(k)),
            Column::SpindleReversed(k) => LinkVelocity::shift(path.len(), -unit(k)),
            Column::Location { axis, component } => {
                location_velocity(geometry, axis, depth_of(axis)?, component, poses)
            }
            Column::Motion { axis, component } => motion_velocity(geometry, axis, depth_of(axis)?, component, poses),
            Column::Position { axis } => position_velocity(geometry, axis, depth_of(axis)?),
        };
        let link = &self.links[local.depth];
        let (mut matrix, mut constant) = (Matrix3::zeros(), link.matrix * local.constant);
        if let Some(turning) = local.turning {
            matrix = link.matrix * turning * inverse(&link.matrix, geometry.composition);
            constant -= matrix * link.offset;
        }
        Some(Velocity { frame: link.frame, matrix, constant, times_position_of: local.times_position_of })
    }
}

/// The link behind an axis that stands at `q`: its place in the frame of the link before it.
fn standing(placed: &PlacedJoint, q: f64, carrier: &LinkInFrame) -> LinkInFrame {
    let matrix = match placed.joint.kind {
        AxisKind::Linear => Matrix3::identity(),
        AxisKind::Rotary => placed.rotation * turn_about(&(placed.joint.direction * placed.joint.sign), q),
    };
    let offset = match placed.joint.kind {
        AxisKind::Linear => placed.translation + placed.slide(q),
        AxisKind::Rotary => placed.joint.origin + placed.translation - matrix * placed.joint.origin,
    };
    LinkInFrame {
        frame: carrier.frame,
        matrix: carrier.matrix * matrix,
        offset: carrier.matrix * offset + carrier.offset,
    }
}

/// The step of a moving axis and the link behind it in the new inner frame.
fn moving(placed: &PlacedJoint, axis: usize, carrier: &LinkInFrame) -> (Step, LinkInFrame) {
    let joint = &placed.joint;
    match joint.kind {
        AxisKind::Linear => {
            let direction = carrier.matrix * placed.rotation * joint.direction * joint.sign;
            let kind = StepKind::Slide { direction: direction.into() };
            let offset = carrier.matrix * placed.translation;
            let inner = LinkInFrame { frame: carrier.frame + 1, ..*carrier };
            (Step { axis, offset: offset.into(), kind }, inner)
        }
        AxisKind::Rotary => {
            let axis_frame = frame_along(&(joint.direction * joint.sign));
            let matrix = carrier.matrix * placed.rotation * axis_frame;
            let rows = [0, 1, 2].map(|row| [0, 1, 2].map(|column| matrix[(row, column)]));
            let kind = StepKind::Turn { matrix: rows };
            let offset = carrier.matrix * (joint.origin + placed.translation) + carrier.offset;
            let back = axis_frame.transpose();
            let inner = LinkInFrame { frame: carrier.frame + 1, matrix: back, offset: -(back * joint.origin) };
            (Step { axis, offset: offset.into(), kind }, inner)
        }
    }
}

/// A rotation whose z is the given direction; coordinate axes give exact (signed) permutations.
fn frame_along(z: &Vector3<f64>) -> Matrix3<f64> {
    let guess = unit(z.iamax() + 1);
    let x = (guess - z * z.dot(&guess)).normalize();
    Matrix3::from_columns(&[x, z.cross(&x), *z])
}

fn unit(k: usize) -> Vector3<f64> {
    let mut unit = Vector3::zeros();
    unit[k % 3] = 1.0;
    unit
}

/// Inverse of a product of rotations, or of the first-order matrices (always regular: determinant 1 + ε²).
fn inverse(matrix: &Matrix3<f64>, composition: Composition) -> Matrix3<f64> {
    match composition {
        Composition::Exact => matrix.transpose(),
        Composition::FirstOrder => matrix.try_inverse().unwrap_or_else(Matrix3::identity),
    }
}

impl LinkVelocity {
    fn shift(depth: usize, direction: Vector3<f64>) -> LinkVelocity {
        LinkVelocity { depth, turning: None, constant: direction, times_position_of: None }
    }

    /// `turning·(x − about)`.
    fn about(depth: usize, turning: Matrix3<f64>, about: &Vector3<f64>) -> LinkVelocity {
        LinkVelocity { depth, turning: Some(turning), constant: -(turning * about), times_position_of: None }
    }
}

/// A location error moves what the axis carries; seen by the carrier.
fn location_velocity(geometry: &Geometry, axis: usize, depth: usize, component: usize, poses: &Poses) -> LinkVelocity {
    if component < 3 {
        return LinkVelocity::shift(depth, unit(component));
    }
    let placed = &geometry.placed[axis];
    let joint = &placed.joint;
    let turn_about = placed.turn_about[component % 3].cross_matrix();
    // first order: the error turns the lever as it was before the error
    let lever = match geometry.composition {
        Composition::Exact => Matrix3::identity(),
        Composition::FirstOrder => inverse(&placed.rotation, geometry.composition),
    };
    match joint.kind {
        AxisKind::Rotary => LinkVelocity::about(depth, turn_about * lever, &(joint.origin + placed.translation)),
        AxisKind::Linear => {
            let per_mm = turn_about * lever * placed.slide(1.0);
            match poses.standing(axis) {
                Some(q) => LinkVelocity::shift(depth, per_mm * q),
                None => LinkVelocity { times_position_of: Some(axis), ..LinkVelocity::shift(depth, per_mm) },
            }
        }
    }
}

/// A component error at value zero: before E on a turning axis, on the carriage of a sliding one.
fn motion_velocity(geometry: &Geometry, axis: usize, depth: usize, component: usize, poses: &Poses) -> LinkVelocity {
    let placed = &geometry.placed[axis];
    let joint = &placed.joint;
    let turn = unit(component % 3).cross_matrix();
    match (joint.kind, component < 3) {
        (AxisKind::Linear, true) => LinkVelocity::shift(depth, unit(component)),
        (AxisKind::Linear, false) => match poses.standing(axis) {
            // the carriage's own frame lies behind a slide that moves
            None => LinkVelocity::about(depth + 1, turn, &joint.origin),
            Some(q) => LinkVelocity::about(depth, turn, &(joint.origin + placed.translation + placed.slide(q))),
        },
        (AxisKind::Rotary, true) => LinkVelocity::shift(depth, placed.rotation * unit(component)),
        (AxisKind::Rotary, false) => {
            let matrix = placed.rotation * turn * inverse(&placed.rotation, geometry.composition);
            LinkVelocity::about(depth, matrix, &(joint.origin + placed.translation))
        }
    }
}

/// The nominal motion itself.
fn position_velocity(geometry: &Geometry, axis: usize, depth: usize) -> LinkVelocity {
    let placed = &geometry.placed[axis];
    let joint = &placed.joint;
    let direction = joint.direction * joint.sign;
    match joint.kind {
        AxisKind::Linear => LinkVelocity::shift(depth, placed.rotation * direction),
        AxisKind::Rotary => {
            let matrix = placed.rotation * direction.cross_matrix() * inverse(&placed.rotation, geometry.composition);
            LinkVelocity::about(depth, matrix, &(joint.origin + placed.translation))
        }
    }
}
