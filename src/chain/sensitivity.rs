//! Closed-form derivatives of a ball-to-ball length with respect to every error, axis position and ball coordinate.
//!
//! To first order `δL = û·δp − û·δs` with û the bar's direction from spindle ball s to pivot ball p. Walking a branch
//! from the bed outward, û is carried along as the pull g on the next carrier; an error motion (δ, ε) of a joint adds
//! `g·δ + (r × g)·ε` with r the lever from the axis's origin to the ball.

use nalgebra::{Matrix3, Vector3};

use super::geometry::{Composition, Geometry, MotionErrors};
use super::link::LinkId;
use crate::machine::AxisKind;

/// Length and its derivatives at one pose; entries are by axis index, components as EX EY EZ EA EB EC.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivity {
    /// Ball-to-ball distance, mm.
    pub length_mm: f64,
    /// Unit vector from the spindle ball to the pivot ball in the bed frame.
    pub direction: Vector3<f64>,
    /// ∂L/∂(location error): mm/mm for the first three, mm/rad for the last three.
    pub location: Vec<[f64; 6]>,
    /// ∂L/∂(component error of the moment), same units.
    pub motion: Vec<[f64; 6]>,
    /// ∂L/∂(axis position): mm/mm or mm/rad.
    pub position: Vec<f64>,
    /// ∂L/∂(pivot ball's place on its link), mm/mm.
    pub pivot: Vector3<f64>,
    /// ∂L/∂(spindle ball's place on its link), mm/mm.
    pub spindle: Vector3<f64>,
    /// ∂L/∂(turn of what stands at the pivot's place about that place), on its link, mm/rad; zero for a ball.
    pub pivot_turn: Vector3<f64>,
    /// The same at the spindle ball's place.
    pub spindle_turn: Vector3<f64>,
}

impl Sensitivity {
    /// Room for the derivatives of a chain with `axis_count` axes.
    pub fn zeros(axis_count: usize) -> Sensitivity {
        Sensitivity {
            length_mm: 0.0,
            direction: Vector3::zeros(),
            location: vec![[0.0; 6]; axis_count],
            motion: vec![[0.0; 6]; axis_count],
            position: vec![0.0; axis_count],
            pivot: Vector3::zeros(),
            spindle: Vector3::zeros(),
            pivot_turn: Vector3::zeros(),
            spindle_turn: Vector3::zeros(),
        }
    }

    fn clear(&mut self) {
        self.location.fill([0.0; 6]);
        self.motion.fill([0.0; 6]);
        self.position.fill(0.0);
    }
}

/// How a reading pulls on what carries a point: a force at the point and a couple. A small motion (δ, ε) of the carrier about
/// a place at lever r from the point changes the reading by `force·δ + (r × force + couple)·ε`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wrench {
    /// Change of the reading per mm, without unit (a turn's reading counts at a lever).
    pub force: Vector3<f64>,
    /// Change of the reading per rad, mm.
    pub couple: Vector3<f64>,
}

impl Wrench {
    /// A force alone: what a length or a coordinate pulls with.
    pub fn force(force: Vector3<f64>) -> Wrench {
        Wrench { force, couple: Vector3::zeros() }
    }

    /// A couple alone: what a rotation pulls with.
    pub fn couple(couple: Vector3<f64>) -> Wrench {
        Wrench { force: Vector3::zeros(), couple }
    }

    /// The wrench on the other side of the instrument.
    fn opposite(self) -> Wrench {
        Wrench { force: -self.force, couple: -self.couple }
    }

    fn turned_by(self, rotation: &Matrix3<f64>) -> Wrench {
        Wrench { force: rotation * self.force, couple: rotation * self.couple }
    }
}

/// Longest branch for which the ball's way through the chain is kept on the stack.
const MAX_DEPTH: usize = 32;

/// A joint on a ball's way through the chain.
#[derive(Debug, Clone, Copy, Default)]
struct Passed {
    /// Lever of the carried ball after the nominal motion and M, before E.
    arm: Vector3<f64>,
    /// Sine and cosine of the nominal turn.
    turned: (f64, f64),
}

/// A ball's way through the chain at one pose: each joint that it passes, from the bed outward.
pub struct Way {
    link: LinkId,
    passed: [Passed; MAX_DEPTH],
    /// The ball in the bed frame, mm.
    pub at_bed: Vector3<f64>,
}

impl Geometry<'_> {
    /// Length and all its derivatives at one pose, written into `out`.
    ///
    /// Balls that coincide have no direction: the derivatives are then zero.
    pub fn sensitivity(
        &self,
        pivot: (LinkId, &Vector3<f64>),
        spindle: (LinkId, &Vector3<f64>),
        positions: &[f64],
        motion: Option<&MotionErrors>,
        out: &mut Sensitivity,
    ) {
        out.clear();
        let pivot = self.way(pivot, positions, motion);
        let spindle = self.way(spindle, positions, motion);
        let bar = pivot.at_bed - spindle.at_bed;
        out.length_mm = bar.norm();
        out.direction = if out.length_mm > 0.0 { bar / out.length_mm } else { Vector3::zeros() };
        let wrench = Wrench::force(out.direction);
        out.pivot = self.pull(&pivot, wrench, positions, motion, out).force;
        out.spindle = self.pull(&spindle, wrench.opposite(), positions, motion, out).force;
    }

    /// All derivatives of a reading that pulls with `wrench` (in the bed frame) on the link of the second point and with the
    /// opposite one on the link of the first, both taken at the same place in space; its value is not touched.
    pub fn pulled(
        &self,
        pivot: &Way,
        spindle: &Way,
        wrench: Wrench,
        (positions, motion): (&[f64], Option<&MotionErrors>),
        out: &mut Sensitivity,
    ) {
        out.clear();
        let left = self.pull(pivot, wrench.opposite(), positions, motion, out);
        (out.pivot, out.pivot_turn) = (left.force, left.couple);
        let left = self.pull(spindle, wrench, positions, motion, out);
        (out.spindle, out.spindle_turn) = (left.force, left.couple);
        out.direction = wrench.force;
    }

    /// Way of a ball through the chain at one pose.
    #[inline]
    pub fn way(&self, ball: (LinkId, &Vector3<f64>), positions: &[f64], motion: Option<&MotionErrors>) -> Way {
        let path = self.chain.path(ball.0);
        let mut way = Way { link: ball.0, passed: [Passed::default(); MAX_DEPTH], at_bed: *ball.1 };
        for (passed, &axis) in way.passed[..path.len()].iter_mut().zip(path).rev() {
            let (placed, q) = (&self.placed[axis], positions[axis]);
            let turned = placed.sine_cosine(q);
            let arm = placed.moved(&way.at_bed, turned, motion.map(|m| &m[axis]), self.composition);
            *passed = Passed { arm, turned };
            way.at_bed = placed.carry(&arm, q);
        }
        way
    }

    /// Adds the derivatives of what a wrench pulls with for all joints of the ball's path; returns it in the ball's own link.
    fn pull(
        &self,
        way: &Way,
        wrench: Wrench,
        positions: &[f64],
        motion: Option<&MotionErrors>,
        out: &mut Sensitivity,
    ) -> Wrench {
        self.chain.path(way.link).iter().zip(&way.passed).fold(wrench, |g, (&axis, passed)| {
            let m = motion.map(|m| &m[axis]);
            match self.placed[axis].joint.kind {
                AxisKind::Rotary => self.pull_rotary(axis, passed, g, m, out),
                AxisKind::Linear => self.pull_linear(axis, passed.arm, g, positions[axis], m, out),
            }
        })
    }

    /// Adds the derivatives of a rotary joint; returns what pulls on what carries it.
    fn pull_rotary(
        &self,
        axis: usize,
        &Passed { arm, turned: (sine, cosine) }: &Passed,
        g: Wrench,
        m: Option<&[f64; 6]>,
        out: &mut Sensitivity,
    ) -> Wrench {
        let placed = &self.placed[axis];
        let exact_arm = match self.composition {
            Composition::Exact => placed.rotation * arm,
            Composition::FirstOrder => arm,
        };
        add_error(&mut out.location[axis], &g, &exact_arm, &placed.turn_about);
        // the carrier's pull seen before E
        let g = g.turned_by(&placed.rotation.transpose());
        let (turned, g_turned) = undo_motion(arm, g, m, self.composition);
        add_motion(&mut out.motion[axis], &g, &turned, m, self.composition);
        let joint = &placed.joint;
        let moment = joint.direction.cross(&turned);
        out.position[axis] +=
            joint.sign * g_turned.force.dot(&moment) + joint.sign * g_turned.couple.dot(&joint.direction);
        turn_back(&g_turned, &joint.direction, (-sine, cosine))
    }

    /// Adds the derivatives of a linear joint; returns what pulls on what carries it.
    fn pull_linear(
        &self,
        axis: usize,
        arm: Vector3<f64>,
        g: Wrench,
        q: f64,
        m: Option<&[f64; 6]>,
        out: &mut Sensitivity,
    ) -> Wrench {
        let placed = &self.placed[axis];
        let joint = &placed.joint;
        let slide = placed.slide(q);
        let lever = match self.composition {
            Composition::Exact => slide,
            Composition::FirstOrder => joint.direction * (joint.sign * q),
        };
        // the error turns the way of the slide and not what it carries: a couple does nothing through it
        add_error(&mut out.location[axis], &Wrench::force(g.force), &lever, &placed.turn_about);
        out.position[axis] += joint.sign * g.force.dot(&(placed.rotation * joint.direction));
        let (carried, g_carried) = undo_motion(arm, g, m, self.composition);
        add_motion(&mut out.motion[axis], &g, &carried, m, self.composition);
        g_carried
    }
}

/// Adds `force·δ` and `d_k·(arm × force + couple)` to the six derivatives.
fn add_error(into: &mut [f64; 6], g: &Wrench, arm: &Vector3<f64>, turn_about: &[Vector3<f64>; 3]) {
    let moment = arm.cross(&g.force) + g.couple;
    for k in 0..3 {
        into[k] += g.force[k];
        into[k + 3] += turn_about[k].dot(&moment);
    }
}

/// Derivatives with respect to the component errors at their present value `m`; `arm` is the lever before M.
fn add_motion(into: &mut [f64; 6], g: &Wrench, arm: &Vector3<f64>, m: Option<&[f64; 6]>, composition: Composition) {
    let units = [Vector3::x(), Vector3::y(), Vector3::z()];
    match (m, composition) {
        (Some(m), Composition::Exact) => {
            let angles = Vector3::new(m[3], m[4], m[5]);
            let after = super::geometry::error_rotation(&angles, composition) * arm;
            add_error(into, g, &after, &super::geometry::turn_directions(&angles, composition));
        }
        _ => add_error(into, g, arm, &units),
    }
}

/// Lever and pull before M: `arm = M_R·before + M_t`, `g_before = M_Rᵀ·g`.
fn undo_motion(arm: Vector3<f64>, g: Wrench, m: Option<&[f64; 6]>, composition: Composition) -> (Vector3<f64>, Wrench) {
    let Some(m) = m else { return (arm, g) };
    let rotation: Matrix3<f64> = super::geometry::error_rotation(&Vector3::new(m[3], m[4], m[5]), composition);
    let shifted = arm - Vector3::new(m[0], m[1], m[2]);
    let before = match composition {
        Composition::Exact => rotation.transpose() * shifted,
        // I + [ε]× is not orthogonal; it is always invertible (determinant 1 + ε²)
        Composition::FirstOrder => rotation.try_inverse().unwrap_or_else(Matrix3::identity) * shifted,
    };
    (before, g.turned_by(&rotation.transpose()))
}

/// The pull on the carried part: `J_Rᵀ·g`.
fn turn_back(g: &Wrench, about: &Vector3<f64>, back: (f64, f64)) -> Wrench {
    let turned = |vector: &Vector3<f64>| match vector.iter().all(|part| *part == 0.0) {
        true => *vector,
        false => super::geometry::turn(vector, about, back),
    };
    Wrench { force: turned(&g.force), couple: turned(&g.couple) }
}
