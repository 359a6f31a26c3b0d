//! What a test is drawn over: the position of an axis, or the angle of a planar circle. Where the bar points is `bar_turn`'s.

use nalgebra::Vector2;

use super::circle_fit::{FittedCircle, fit_circle};
use crate::chain::Chain;
use crate::machine::AxisKind;
use crate::session::{Motion, MotionError, Path, Session, Test};

/// What moves over a test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SweptOver {
    /// An axis, by index.
    Axis(usize),
    /// The axes of a planar circle to the right and up, by index.
    Circle([usize; 2]),
}

/// Positions over which a test is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Swept {
    pub over: SweptOver,
    /// By row: mm of a linear axis, else degrees.
    pub value: Vec<f64>,
    /// Angle round the circle where there is one, rad.
    pub angle_rad: Option<Vec<f64>>,
    /// Mean radius of the commanded circle, mm.
    pub radius_mm: Option<f64>,
}

/// Where the axes of a test stand, and over what it is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    pub motion: Motion,
    /// `None` for static poses.
    pub swept: Option<Swept>,
}

impl Course {
    /// The course of a test of a session.
    pub fn of(session: &Session, chain: &Chain, test: &Test) -> Result<Course, MotionError> {
        let motion = Motion::of(session, chain, test)?;
        let swept = swept(session, test, &motion);
        Ok(Course { motion, swept })
    }
}

/// The rotary axis that turns farthest, the angle of a planar circle, or the linear axis that goes farthest.
fn swept(session: &Session, test: &Test, motion: &Motion) -> Option<Swept> {
    motion.time_s.as_ref()?;
    let axes = &session.machine.axes;
    let travel = |axis: usize| {
        let (low, high) =
            motion.axis(axis).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), q| (low.min(q), high.max(q)));
        high - low
    };
    let farthest = |kind: AxisKind| {
        let moving = motion.moving.iter().copied().filter(|&axis| axes[axis].kind == kind && travel(axis) > 0.0);
        moving.max_by(|&a, &b| travel(a).total_cmp(&travel(b)))
    };
    if let Some(axis) = farthest(AxisKind::Rotary) {
        let angle: Vec<f64> = motion.axis(axis).collect();
        let value = angle.iter().map(|angle| angle.to_degrees()).collect();
        return Some(Swept { over: SweptOver::Axis(axis), value, angle_rad: Some(angle), radius_mm: None });
    }
    let linear: Vec<usize> = motion.moving.iter().copied().filter(|&axis| travel(axis) > 0.0).collect();
    if let [first, second] = linear[..] {
        let (first, second) = match &test.path {
            Some(Path::Circle { plane, .. }) => (plane.first, plane.second),
            _ => plane_order(session, first, second),
        };
        let places: Vec<Vector2<f64>> =
            (0..motion.rows()).map(|row| Vector2::new(motion.row(row)[first], motion.row(row)[second])).collect();
        let way_mm = travel(first).hypot(travel(second));
        let is_round = |circle: &FittedCircle| {
            circle.rms_mm < MOST_UNROUND * circle.radius_mm && circle.radius_mm < FLATTEST * way_mm
        };
        if let Some(circle) = fit_circle(&places).filter(is_round) {
            let off = places.iter().map(|place| place - circle.centre_mm);
            let angle: Vec<f64> = off.map(|off| off.y.atan2(off.x)).collect();
            let value = unwrapped_deg(&angle);
            let (over, radius_mm) = (SweptOver::Circle([first, second]), Some(circle.radius_mm));
            return Some(Swept { over, value, angle_rad: Some(angle), radius_mm });
        }
    }
    let axis = farthest(AxisKind::Linear)?;
    let value = motion.axis(axis).collect();
    Some(Swept { over: SweptOver::Axis(axis), value, angle_rad: None, radius_mm: None })
}

/// XY, YZ, ZX: the order in which a circle's angle counts.
fn plane_order(session: &Session, one: usize, other: usize) -> (usize, usize) {
    let along = |axis: usize| session.machine.axes[axis].coordinate_direction().unwrap_or(0);
    if (along(one) + 1) % 3 == along(other) { (one, other) } else { (other, one) }
}

/// Distances of positions from a circle, rms over its radius, up to which two slides ran one: commands leave nothing, scales of a
/// slide that were read stretch it by a thousandth.
const MOST_UNROUND: f64 = 0.01;
/// Radius over the travel from which an arc is a straight line: 6° of a circle.
const FLATTEST: f64 = 10.0;

/// Angles that run on over a whole turn; their middle lies between 0 and 360°, so that both directions have the same ones.
fn unwrapped_deg(angle_rad: &[f64]) -> Vec<f64> {
    let mut turns = 0.0;
    let mut last: Option<f64> = None;
    let mut degrees: Vec<f64> = angle_rad
        .iter()
        .map(|angle| {
            let degrees = angle.to_degrees();
            if let Some(last) = last {
                turns -= 360.0 * ((degrees - last) / 360.0).round();
            }
            last = Some(degrees);
            degrees + turns
        })
        .collect();
    if let (Some(first), Some(last)) = (degrees.first(), degrees.last()) {
        let whole = 360.0 * (0.5 * (first + last) / 360.0).floor();
        degrees.iter_mut().for_each(|angle| *angle -= whole);
    }
    degrees
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_run_on_over_the_half_turn() {
        let degrees = unwrapped_deg(&[3.0, 3.1, -3.1, -3.0]);
        assert!(degrees.windows(2).all(|pair| pair[1] > pair[0]), "{degrees:?}");
        // there and back over the same arc
        let back = unwrapped_deg(&[-3.0, -3.1, 3.1, 3.0]);
        let turned: Vec<f64> = back.into_iter().rev().collect();
        assert!(degrees.iter().zip(&turned).all(|(one, other)| (one - other).abs() < 1e-9), "{degrees:?} {turned:?}");
    }
}
