//! One planar circle as deviations over the angle in its plane; finds the circles of a session. Fits nothing.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::Vector3;

use crate::chain::{Chain, Geometry};
use crate::machine::AxisKind;
use crate::methods::bar_turn::unwrapped;
use crate::methods::error::MethodError;
use crate::session::{Motion, Session};
use crate::statistics::mean;

/// Direction of contouring in the plane, seen from the positive end of the third axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Counter-clockwise: from the first letter's axis to the second's.
    Ccw,
    Cw,
}

impl Direction {
    /// +1 for rising angle.
    pub fn sign(self) -> f64 {
        match self {
            Direction::Ccw => 1.0,
            Direction::Cw => -1.0,
        }
    }
}

/// One run of a planar circle.
#[derive(Debug, Clone, PartialEq)]
pub struct CircleRun {
    /// Index of the test in the session.
    pub test: usize,
    /// Axis indices of the plane's letters: XY, YZ or ZX.
    pub axes: [usize; 2],
    /// Coordinate direction across the plane: 0, 1, 2.
    pub third: usize,
    pub direction: Direction,
    /// Nominal radius in the plane, mm.
    pub radius_mm: f64,
    /// Length of the arc, rad.
    pub arc_rad: f64,
    /// Angle of the bar from pivot to spindle ball, rad, running on without jumps; rows with a reading.
    pub angle_rad: Vec<f64>,
    /// Radius in the plane minus nominal radius at these angles, mm.
    pub deviation_mm: Vec<f64>,
}

/// Fewest readings of a circle.
const FEWEST_READINGS: usize = 24;
/// Shorter arcs are no circle tests: centre, squareness and radius are not told apart, rad.
const SHORTEST_ARC_RAD: f64 = FRAC_PI_2;
/// Nominal radii within a circle may differ by this, mm: positions are printed to 1e-5.
const ROUND_MM: f64 = 0.05;
/// An arc that lacks less than this of 360° is a full turn, rad.
const CLOSED_WITHIN_RAD: f64 = 2.0 * PI / 180.0;
/// Two runs are over the same circle when start, end and radius agree within this, mm and rad.
const SAME_PATH: f64 = 0.02;

impl CircleRun {
    /// True when the path closes.
    pub fn full_turn(&self) -> bool {
        self.arc_rad > TAU - CLOSED_WITHIN_RAD
    }

    /// Same plane, radius and arc; the direction may differ.
    pub fn same_path(&self, other: &CircleRun) -> bool {
        self.axes == other.axes
            && (self.radius_mm - other.radius_mm).abs() < SAME_PATH
            && (self.arc_rad - other.arc_rad).abs() < SAME_PATH
            && (self.full_turn() || turned_apart(self.middle(), other.middle()) < SAME_PATH)
    }

    fn middle(&self) -> f64 {
        (self.angle_rad[0] + self.angle_rad[self.angle_rad.len() - 1]) / 2.0
    }

    /// Deviation at an angle between two readings, mm.
    pub fn deviation_at(&self, angle_rad: f64) -> Option<f64> {
        let (first, last) = (self.angle_rad[0], self.angle_rad[self.angle_rad.len() - 1]);
        let (low, high) = (first.min(last), first.max(last));
        let angle = low + (angle_rad - low).rem_euclid(TAU);
        if angle > high {
            return None;
        }
        // angles rise or fall along the run
        let sign = self.direction.sign();
        let after =
            self.angle_rad.partition_point(|&other| sign * other < sign * angle).clamp(1, self.angle_rad.len() - 1);
        let (from, to) = (self.angle_rad[after - 1], self.angle_rad[after]);
        let share = if to == from { 0.0 } else { (angle - from) / (to - from) };
        Some(self.deviation_mm[after - 1] + share * (self.deviation_mm[after] - self.deviation_mm[after - 1]))
    }
}

/// Smallest angle between two directions, rad.
fn turned_apart(one: f64, other: f64) -> f64 {
    let turn = (one - other).rem_euclid(TAU);
    turn.min(TAU - turn)
}

/// All recorded circles of two linear axes.
pub fn circle_runs(session: &Session, chain: &Chain) -> Result<Vec<CircleRun>, MethodError> {
    let mut runs = Vec::new();
    for test in 0..session.tests.len() {
        if let Some(run) = circle_run(session, chain, test)? {
            runs.push(run);
        }
    }
    Ok(runs)
}

/// The test as a circle; `None` when it is none: other axes move, no recording, or the radius is not constant.
fn circle_run(session: &Session, chain: &Chain, test_index: usize) -> Result<Option<CircleRun>, MethodError> {
    let test = &session.tests[test_index];
    let Some(recording) = &test.recording else { return Ok(None) };
    let motion = Motion::of(session, chain, test)?;
    let Some((axes, third)) = plane(session, &motion) else { return Ok(None) };
    let links = test.links(chain)?;
    let geometry = Geometry::nominal(chain);
    let unit = |k: usize| Vector3::from_fn(|row, _| if row == k % 3 { 1.0 } else { 0.0 });
    let (mut angles, mut deviation_mm, mut radii): (Vec<f64>, Vec<f64>, Vec<f64>) = Default::default();
    for (row, &length) in recording.length_mm.iter().enumerate().filter(|(_, length)| length.is_finite()) {
        let positions = motion.row(row);
        let bar = test.bar(&geometry, links, positions);
        let (along, up, out) = (bar.dot(&unit(third + 1)), bar.dot(&unit(third + 2)), bar.dot(&unit(third)));
        let in_plane = length * length - out * out;
        if in_plane <= 0.0 {
            return Ok(None);
        }
        angles.push(up.atan2(along));
        radii.push(along.hypot(up));
        deviation_mm.push(in_plane.sqrt() - along.hypot(up));
    }
    let angle_rad = unwrapped(angles.into_iter());
    if angle_rad.len() < FEWEST_READINGS {
        return Ok(None);
    }
    let radius_mm = mean(radii.iter().copied()).unwrap_or(f64::NAN);
    let turn = angle_rad[angle_rad.len() - 1] - angle_rad[0];
    let one_way = angle_rad.windows(2).all(|pair| (pair[1] - pair[0]) * turn > 0.0);
    if !one_way || turn.abs() < SHORTEST_ARC_RAD || radii.iter().any(|radius| (radius - radius_mm).abs() > ROUND_MM) {
        return Ok(None);
    }
    let direction = if turn > 0.0 { Direction::Ccw } else { Direction::Cw };
    Ok(Some(CircleRun {
        test: test_index,
        axes,
        third,
        direction,
        radius_mm,
        arc_rad: turn.abs(),
        angle_rad,
        deviation_mm,
    }))
}

/// The two moving axes in the order of the plane's letters, and the coordinate across.
fn plane(session: &Session, motion: &Motion) -> Option<([usize; 2], usize)> {
    if motion.rows() == 0 {
        return None;
    }
    let moves = |axis: &usize| motion.axis(*axis).any(|q| q != motion.row(0)[*axis]);
    let moving: Vec<usize> = motion.moving.iter().copied().filter(moves).collect();
    let [one, other] = moving[..] else { return None };
    let axes = &session.machine.axes;
    if axes[one].kind != AxisKind::Linear || axes[other].kind != AxisKind::Linear {
        return None;
    }
    let (one_along, other_along) = (axes[one].coordinate_direction()?, axes[other].coordinate_direction()?);
    match (other_along + 3 - one_along) % 3 {
        1 => Some(([one, other], (one_along + 2) % 3)),
        2 => Some(([other, one], (one_along + 1) % 3)),
        _ => None,
    }
}
