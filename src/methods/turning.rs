//! One sweep of a rotary axis as a circle in its turning plane: centre and radius, for any machine. No location errors yet.
//!
//! The ball that the axis carries runs on a circle; the other ball stands near the axis. Every length L is reduced to the
//! turning plane as the slant line of a cone, `ρ = √(L² − h²)` with h the nominal distance of the two balls along the
//! axis (short bar: h = 0), and drawn at the commanded angle φ. The circle through the points `ρ·(cos φ, sin φ)` has its
//! centre where the axis pierces the turning plane **of the standing ball**, seen from that ball: a tilt of the axis
//! moves the carried ball along the bar by as much as it moves that point.
//!
//! Start position (eq. 4.1): the pivot was moved at the first angle until the bar read its nominal length, so the
//! circle's radius is not the nominal one but holds the axis's error at that angle. The radius is therefore an unknown
//! of the fit, and the nominal length is used nowhere.

use nalgebra::{Vector2, Vector3};

use super::circle_fit::fit_circle;
use super::error::MethodError;
use crate::chain::{Chain, Geometry, LinkId};
use crate::machine::AxisKind;
use crate::session::{Motion, Session};

/// Fewest readings of a sweep.
const FEWEST_READINGS: usize = 8;
/// Shortest arc from which a centre is told apart from a radius, rad.
const SHORTEST_ARC_RAD: f64 = 0.5;
/// How far the standing ball may be off the axis for the commanded angle to be the bar's, mm.
const ON_AXIS_MM: f64 = 1.0;

/// Circle of one sweep in its turning plane.
#[derive(Debug, Clone, PartialEq)]
pub struct TurningCircle {
    /// Index of the test in the session.
    pub test: usize,
    /// Index of the axis that turns.
    pub axis: usize,
    /// Directions of the plane's two coordinates in R at the zero position.
    pub plane: [Vector3<f64>; 2],
    /// Distance from the standing to the carried ball along the axis, mm: 0 for a short bar in the turning plane.
    pub reach_mm: f64,
    /// Place of the standing ball along the axis, from the axis's origin, mm.
    pub at_mm: f64,
    /// Where the axis pierces the standing ball's turning plane, seen from that ball's nominal place on the axis, mm.
    pub centre_mm: Vector2<f64>,
    /// Radius of the carried ball's circle, mm.
    pub radius_mm: f64,
    /// Distance of the points from the circle, root mean square in the turning plane, mm.
    pub rms_mm: f64,
    /// Rows with a reading.
    pub rows: Vec<usize>,
    /// Angle of the carried ball in the turning plane at these rows, rad.
    pub angle_rad: Vec<f64>,
    /// Lengths at these rows, mm.
    pub length_mm: Vec<f64>,
}

impl TurningCircle {
    /// Length that the fitted circle gives at an angle, mm.
    pub fn length_at(&self, angle_rad: f64) -> f64 {
        let toward = Vector2::new(angle_rad.cos(), angle_rad.sin());
        let along = self.centre_mm.dot(&toward);
        let across = self.centre_mm.norm_squared() - along * along;
        let reduced_mm = along + (self.radius_mm * self.radius_mm - across).max(0.0).sqrt();
        reduced_mm.hypot(self.reach_mm)
    }
}

/// The axis that a recorded test turns while all others stand, when one ball is carried by it and the other is not.
pub fn turning_axis(session: &Session, chain: &Chain, test: usize) -> Option<usize> {
    let test = &session.tests[test];
    let motion = Motion::of(session, chain, test).ok()?;
    let moves = |axis: &&usize| motion.axis(**axis).any(|q| q != motion.row(0)[**axis]);
    let moving: Vec<usize> = motion.moving.iter().filter(moves).copied().collect();
    let [axis] = moving[..] else { return None };
    let carried = |link: &str| Some(chain.carries(axis, chain.link(link)?));
    let rotary = session.machine.axes[axis].kind == AxisKind::Rotary;
    (rotary && test.recording.is_some() && carried(&test.pivot.link)? != carried(&test.spindle_ball.link)?)
        .then_some(axis)
}

/// Fits the circle of one test that turns `axis`.
pub fn turning_circle(
    session: &Session,
    chain: &Chain,
    test_index: usize,
    axis: usize,
) -> Result<TurningCircle, MethodError> {
    let test = &session.tests[test_index];
    let refuse = |reason: String| MethodError::Test { test: test.name.clone(), reason };
    let recording = test.recording.as_ref().ok_or_else(|| refuse("has no recording".into()))?;
    let motion = Motion::of(session, chain, test)?;
    let (pivot, spindle) = test.links(chain)?;
    let balls = if chain.carries(axis, pivot) {
        [(pivot, &test.pivot.at), (spindle, &test.spindle_ball.at)]
    } else {
        [(spindle, &test.spindle_ball.at), (pivot, &test.pivot.at)]
    };
    let geometry = Geometry::nominal(chain);
    let joint = chain.joint(axis);
    let plane = plane_of(&joint.direction);
    // levers of both balls from the axis's origin, in the directions of R at the zero position
    let levers = |row: usize| balls.map(|ball| lever(&geometry, axis, ball, motion.row(row)));
    let rows: Vec<usize> = (0..motion.rows()).filter(|&row| recording.length_mm[row].is_finite()).collect();
    if rows.len() < FEWEST_READINGS {
        return Err(refuse(format!("has {} readings; a circle needs at least {FEWEST_READINGS}", rows.len())));
    }
    let [carried, standing] = levers(rows[0]);
    let reach_mm = (carried - standing).dot(&joint.direction);
    let at_mm = standing.dot(&joint.direction);
    let off_axis_mm = (standing - joint.direction * at_mm).norm();
    if off_axis_mm > ON_AXIS_MM {
        return Err(refuse(format!(
            "the standing ball is {off_axis_mm:.1} mm off the axis of {}; the circle fit needs it on the axis, within {ON_AXIS_MM} mm",
            session.machine.axes[axis].name
        )));
    }
    let mut points = Vec::with_capacity(rows.len());
    let mut angle_rad = Vec::with_capacity(rows.len());
    let mut length_mm = Vec::with_capacity(rows.len());
    for &row in &rows {
        let [carried, standing] = levers(row);
        let arm = carried - standing;
        let angle = arm.dot(&plane[1]).atan2(arm.dot(&plane[0]));
        let length = recording.length_mm[row];
        let squared = length * length - reach_mm * reach_mm;
        if squared <= 0.0 {
            return Err(refuse(format!(
                "row {}: a bar of {length:.4} mm does not reach {:.4} mm along the axis; check the ball places",
                row + 1,
                reach_mm.abs()
            )));
        }
        points.push(Vector2::new(angle.cos(), angle.sin()) * squared.sqrt());
        angle_rad.push(angle);
        length_mm.push(length);
    }
    let swept: Vec<f64> = rows.iter().map(|&row| motion.row(row)[axis]).collect();
    let arc =
        swept.iter().copied().fold(f64::NEG_INFINITY, f64::max) - swept.iter().copied().fold(f64::INFINITY, f64::min);
    if arc < SHORTEST_ARC_RAD {
        return Err(refuse(format!(
            "sweeps only {:.1}°; a centre is told apart from a radius from {:.0}° on",
            arc.to_degrees(),
            SHORTEST_ARC_RAD.to_degrees()
        )));
    }
    let circle = fit_circle(&points).ok_or_else(|| refuse("its readings lie on no circle".into()))?;
    Ok(TurningCircle {
        test: test_index,
        axis,
        plane,
        reach_mm,
        at_mm,
        centre_mm: circle.centre_mm,
        radius_mm: circle.radius_mm,
        rms_mm: circle.rms_mm,
        rows,
        angle_rad,
        length_mm,
    })
}

/// Lever of a ball from the axis's origin in the frame of the axis's carrier, nominal geometry, mm.
fn lever(geometry: &Geometry, axis: usize, ball: (LinkId, &Vector3<f64>), positions: &[f64]) -> Vector3<f64> {
    let chain = geometry.chain();
    let carried = chain.carried_by(axis);
    let carrier = LinkId { depth: carried.depth - 1, ..carried };
    let pose = geometry.pose(carrier, positions, None);
    let place = geometry.point(ball.0, ball.1, positions, None);
    pose.rotation.transpose() * (place - pose.translation_mm) - chain.joint(axis).origin
}

/// Two directions across the axis: Y Z for an axis along X, Z X along Y, X Y along Z, otherwise the nearest such pair.
fn plane_of(direction: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let along = direction.iamax();
    let unit = |k: usize| Vector3::from_fn(|row, _| if row == k % 3 { 1.0 } else { 0.0 });
    let across = |k: usize| unit(k) - direction * direction[k % 3];
    let first = across(along + 1).normalize();
    let second = direction.cross(&first) * direction[along].signum();
    [first, second]
}
