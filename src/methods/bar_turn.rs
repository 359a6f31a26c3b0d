//! Where the bar points during a test, seen in a coordinate plane: the angle of round plots (ISO 230-4: counter-clockwise from the
//! first letter's axis, seen from the positive end of the third).

use std::f64::consts::{PI, TAU};

use super::error::MethodError;
use crate::chain::{Chain, Geometry};
use crate::machine::AxisKind;
use crate::session::{Motion, Session, Test};

/// Directions of the bar over the rows of a test.
#[derive(Debug, Clone, PartialEq)]
pub struct BarTurn {
    /// Coordinate directions to the right and up: 0, 1, 2 for x, y, z.
    pub plane: [usize; 2],
    /// Direction from the ball that stands to the ball that moves, rad, without jumps.
    pub angle_rad: Vec<f64>,
}

/// Smaller turns are no arc, rad: a bar that follows its axis keeps its direction.
const LEAST_TURN_RAD: f64 = 10.0 * PI / 180.0;
/// The bar's length in the plane varies by less than this share where it sweeps a circle or a cone.
const ROUND: f64 = 0.02;

impl BarTurn {
    /// +1 where the bar turns counter-clockwise.
    pub fn sign(&self) -> f64 {
        let first = self.angle_rad.first().copied().unwrap_or(0.0);
        (self.angle_rad.last().copied().unwrap_or(0.0) - first).signum()
    }
}

/// The turn of the bar in the coordinate plane in which it turns farthest; `None` where it keeps its direction or turns in no
/// coordinate plane.
pub fn bar_turn(
    session: &Session,
    chain: &Chain,
    test: &Test,
    motion: &Motion,
) -> Result<Option<BarTurn>, MethodError> {
    let (pivot, spindle) = test.links(chain)?;
    let geometry = Geometry::nominal(chain);
    let rows = motion.rows();
    let mut ways = [0.0, 0.0];
    let mut bars = Vec::with_capacity(rows);
    let mut last = None;
    for row in 0..rows {
        let positions = motion.row(row);
        let at = [
            geometry.point(pivot, &test.pivot.at, positions, None),
            geometry.point(spindle, &test.spindle_ball.at, positions, None),
        ];
        if let Some(before) = last.replace(at) {
            let before: [nalgebra::Vector3<f64>; 2] = before;
            (0..2).for_each(|k| ways[k] += (at[k] - before[k]).norm());
        }
        bars.push(at[1] - at[0]);
    }
    // tables that slide carry the pivot round: the tool's path over the workpiece is what counts there
    let is_circle = !motion.moving.iter().any(|&axis| session.machine.axes[axis].kind == AxisKind::Rotary);
    let sign = if is_circle || ways[1] >= ways[0] { 1.0 } else { -1.0 };
    let planes = [[0, 1], [1, 2], [2, 0]].map(|[right, up]| {
        let radii = || bars.iter().map(|bar| bar[right].hypot(bar[up]));
        let (least, most) = (radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max));
        let angle_rad = unwrapped(bars.iter().map(|bar| (sign * bar[up]).atan2(sign * bar[right])));
        (BarTurn { plane: [right, up], angle_rad }, most - least <= ROUND * most)
    });
    let turn = |turn: &BarTurn| match (turn.angle_rad.first(), turn.angle_rad.last()) {
        (Some(first), Some(last)) => (last - first).abs(),
        _ => 0.0,
    };
    let round = planes.into_iter().filter(|(of, is_round)| *is_round && turn(of) >= LEAST_TURN_RAD);
    Ok(round.map(|(of, _)| of).max_by(|a, b| turn(a).total_cmp(&turn(b))))
}

/// Angles that run on over the half turn, rad: each within half a turn of the one before.
pub(super) fn unwrapped(angles: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut last = None;
    let run_on = |angle: f64| {
        let before = last.unwrap_or(angle);
        *last.insert(before + (angle - before + PI).rem_euclid(TAU) - PI)
    };
    angles.map(run_on).collect()
}

/// Tests that are drawn together: both directions of one pass, in the order in which the first of each was run. `turns` has
/// each test's turn as a signed angle (rad) about whatever it turns, `None` for a test that turns nothing.
pub fn passes(session: &Session, turns: &[Option<f64>]) -> Vec<Vec<usize>> {
    let mut list: Vec<Vec<usize>> = Vec::new();
    for (index, test) in session.tests.iter().enumerate() {
        let turn = turns.get(index).copied().flatten();
        let is_other_way = |pass: &&mut Vec<usize>| match (&pass[..], turn) {
            (&[first], Some(turn)) => {
                let other = turns[first].unwrap_or(0.0);
                test.is_repeat_of(&session.tests[first])
                    && turn * other < 0.0
                    && (turn + other).abs() < SAME_TURN * turn.abs()
            }
            _ => false,
        };
        match list.iter_mut().find(is_other_way) {
            Some(pass) => pass.push(index),
            None => list.push(vec![index]),
        }
    }
    list
}

/// Turns of two directions of one pass differ by less than this share: overshoot is taken off by hand.
const SAME_TURN: f64 = 0.05;
