//! Axis positions for a tool pose in the workpiece: all solutions, what is out of reach, what is singular.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

use super::kinematics::{AxisInWorkpiece, Kinematics};
use super::turns::{TwoTurns, angle, reach, two_turns};
use crate::machine::AxisKind;

/// A tool pose that is wanted, in the workpiece's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Tip, mm.
    pub tip_mm: Vector3<f64>,
    /// From the tip into the spindle, unit length.
    pub axis: Vector3<f64>,
    /// The direction across the tool, for machines that can turn it (arms of six joints); `None`: any.
    pub across: Option<Vector3<f64>>,
}

/// One set of axis positions.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// Positions by axis index, mm or rad.
    pub positions: Vec<f64>,
    /// Axes that leave their range, by index.
    pub outside: Vec<usize>,
    /// An axis whose position does not matter: it kept the one it was asked to be near.
    pub free: Option<usize>,
    /// Distance of the tip from the target, mm.
    pub off_mm: f64,
    /// Angle of the tool from the target, rad.
    pub off_rad: f64,
}

/// Directions that two rotary axes can give the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// The rotary axis nearest to the workpiece and the one nearest to the tool, by index.
    pub axes: [usize; 2],
    /// Direction of the first axis in the workpiece.
    pub about: Vector3<f64>,
    /// Smallest and largest angle of the tool from `about`, rad, limits of travel left out.
    pub angles_rad: [f64; 2],
    /// Angle of the target from the nearer of `about` and its opposite, rad.
    pub from_pole_rad: f64,
    /// The pole can be reached: there the first axis is free, and near it turns by 1/sin(angle) for every unit of direction.
    pub has_pole: [bool; 2],
}

impl Reach {
    /// Singular directions of the tool in the workpiece.
    pub fn singular(&self) -> Vec<Vector3<f64>> {
        let poles = [(self.has_pole[0], self.about), (self.has_pole[1], -self.about)];
        poles.iter().filter(|(is_reached, _)| *is_reached).map(|(_, pole)| *pole).collect()
    }

    /// Turn of the first axis per unit of change of the tool's direction.
    pub fn turn_per_direction(&self) -> f64 {
        1.0 / self.from_pole_rad.sin().abs()
    }
}

/// Everything known about a target.
#[derive(Debug, Clone, PartialEq)]
pub struct Inverse {
    /// Nearest to the positions asked for first; turns by whole rounds within the travel are solutions of their own.
    pub solutions: Vec<Solution>,
    /// The solutions are all there are; else they were searched for and some may be missing.
    pub is_complete: bool,
    /// For two rotary axes.
    pub reach: Option<Reach>,
}

/// Why there are no axis positions.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InverseError {
    #[error("the tool cannot point there: the nearest direction that {axes} reach is {by_deg:.4} deg away")]
    Direction { axes: String, by_deg: f64 },
    #[error("the slides {axes} do not span space at these rotary positions; the tip cannot be placed")]
    Slides { axes: String },
    #[error(
        "no axis positions were found from {starts} starts: the pose is out of reach of {axes}, or needs a direction across the tool (--tool-across) that these axes can give"
    )]
    NotFound { starts: usize, axes: String },
    #[error("component errors change faster than the axes move: their tables or amplitudes have a wrong unit")]
    NoEnd,
}

/// Rounds of component errors: each brings a digit or more.
const MOST_ROUNDS: usize = 60;
/// Positions that move by less than this have arrived, mm and rad.
const POSITION_TOLERANCE: f64 = 1e-13;
/// A pole nearer than this to the reach counts as reached, rad: errors of a machine tip it by less than that.
const POLE_TOLERANCE_RAD: f64 = 1e-3;

impl Kinematics<'_> {
    /// All axis positions that bring the tool to a target; `near` orders them and holds axes that are free.
    pub fn inverse(&self, target: &Target, near: &[f64]) -> Result<Inverse, InverseError> {
        let kinds: Vec<AxisKind> = self.machine().axes.iter().map(|axis| axis.kind).collect();
        let of_kind = |kind| (0..kinds.len()).filter(|&axis| kinds[axis] == kind).collect::<Vec<usize>>();
        let (turning, sliding) = (of_kind(AxisKind::Rotary), of_kind(AxisKind::Linear));
        let (&[first, second], &[x, y, z]) = (turning.as_slice(), sliding.as_slice()) else {
            return self.searched(target, near);
        };
        let mut axes = Vec::new();
        let reach = self.reach([first, second], target, near, &mut axes);
        let five = Five { kinematics: self, turning: [first, second], sliding: [x, y, z], target, near };
        let mut solutions: Vec<Solution> = Vec::new();
        let mut is_complete = true;
        for branch in 0..2 {
            let Some(found) = five.branch(branch, &mut axes)? else { continue };
            let rounds = self.rounds(found, near);
            is_complete &= rounds.is_complete;
            for other in rounds.solutions {
                // errors that are not periodic are others a turn away
                let exact = match self.component_errors(&other.positions) {
                    None => Some(other),
                    Some(_) => Five { near: &other.positions, ..five }.branch(branch, &mut axes)?,
                };
                self.add(exact.into_iter().collect(), &mut solutions);
            }
        }
        self.order(&mut solutions, near);
        Ok(Inverse { solutions, is_complete, reach: Some(reach) })
    }

    /// What the two rotary axes reach with the errors of the positions `near`.
    fn reach(&self, turning: [usize; 2], target: &Target, near: &[f64], axes: &mut Vec<AxisInWorkpiece>) -> Reach {
        let motion = self.component_errors(near);
        let mut zero = near.to_vec();
        turning.iter().for_each(|&axis| zero[axis] = 0.0);
        let pose = self.pose_and_axes(&zero, motion.as_deref(), axes);
        let [about, second] = turning.map(|axis| axes[axis].direction);
        let (lowest, highest) = reach(&about, &second, &pose.axis);
        let from = angle(&about, &target.axis);
        Reach {
            axes: turning,
            about,
            angles_rad: [lowest, highest],
            from_pole_rad: from.min(std::f64::consts::PI - from),
            has_pole: [lowest < POLE_TOLERANCE_RAD, highest > std::f64::consts::PI - POLE_TOLERANCE_RAD],
        }
    }

    /// A solution and those that differ from it by whole turns within the travel, the nearest to `near` of many.
    pub(super) fn rounds(&self, solution: Solution, near: &[f64]) -> Rounds {
        let mut all = vec![solution];
        let mut is_complete = true;
        for (index, axis) in self.machine().axes.iter().enumerate().filter(|(_, axis)| axis.kind == AxisKind::Rotary) {
            let Some((from, to)) = axis.range else { continue };
            let rounds = |solution: &Solution| -> Vec<Solution> {
                let q = solution.positions[index];
                let ends = [(from - q) / TAU - ROUND_EDGE, (to - q) / TAU + ROUND_EDGE];
                let mut inside = whole_numbers(ends, (near[index] - q) / TAU);
                if inside.is_empty() {
                    // the one nearest to its travel is told
                    inside.push(((0.5 * (from + to) - q) / TAU).round());
                }
                if solution.free == Some(index) {
                    // any position does: one stands for all
                    inside.sort_by(|one, other| one.abs().total_cmp(&other.abs()));
                    inside.truncate(1);
                }
                let at = |turns: &f64| {
                    let mut other = solution.clone();
                    other.positions[index] = q + turns * TAU;
                    other
                };
                inside.iter().map(at).collect()
            };
            all = all.iter().flat_map(rounds).collect();
            if all.len() > MOST_SOLUTIONS {
                self.order(&mut all, near);
                all.truncate(MOST_SOLUTIONS);
                is_complete = false;
            }
        }
        Rounds { solutions: all, is_complete }
    }

    /// Adds solutions that are not there yet.
    pub(super) fn add(&self, found: Vec<Solution>, to: &mut Vec<Solution>) {
        for mut solution in found {
            solution.outside = self.outside(&solution.positions);
            let is_same = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-7;
            let is_known = to.iter().any(|other| other.positions.iter().zip(&solution.positions).all(is_same));
            if !is_known {
                to.push(solution);
            }
        }
    }

    /// Axes beyond their range, by index.
    fn outside(&self, positions: &[f64]) -> Vec<usize> {
        let is_outside = |&index: &usize| {
            let axis = &self.machine().axes[index];
            axis.range.is_some_and(|(from, to)| positions[index] < from - 1e-9 || positions[index] > to + 1e-9)
        };
        (0..positions.len()).filter(is_outside).collect()
    }

    /// Solutions inside the travel first, then by the way of the rotary axes from `near`.
    pub(super) fn order(&self, solutions: &mut [Solution], near: &[f64]) {
        let turned = |solution: &Solution| -> f64 {
            let axes = self.machine().axes.iter().zip(&solution.positions).zip(near);
            axes.filter(|((axis, _), _)| axis.kind == AxisKind::Rotary).map(|((_, q), near)| (q - near).abs()).sum()
        };
        solutions.sort_by(|a, b| {
            (a.outside.len(), turned(a)).partial_cmp(&(b.outside.len(), turned(b))).unwrap_or(std::cmp::Ordering::Equal)
        });
    }
}

/// Share of a round by which a position may lie outside by rounding.
const ROUND_EDGE: f64 = 1e-12;
/// Most solutions that are told: an axis with a hundred rounds of travel has no more use for its hundred.
const MOST_SOLUTIONS: usize = 64;

/// Solutions that differ by whole turns.
pub(super) struct Rounds {
    pub(super) solutions: Vec<Solution>,
    /// Whether these are all within the travel.
    is_complete: bool,
}

/// Whole numbers between two ends, of many the nearest to a number: one more than are told, so that it shows.
fn whole_numbers([from, to]: [f64; 2], near: f64) -> Vec<f64> {
    let (first, last) = (from.ceil(), to.floor());
    let most = MOST_SOLUTIONS as f64;
    let begin = (near - 0.5 * most).round().min(last - most).max(first);
    let count = (last - begin + 1.0).clamp(0.0, most + 1.0) as usize;
    (0..count).map(|k| begin + k as f64).collect()
}

/// A machine of three slides and two turns with what is asked of it.
#[derive(Clone, Copy)]
struct Five<'k, 'a> {
    kinematics: &'k Kinematics<'a>,
    /// Nearest to the workpiece first.
    turning: [usize; 2],
    sliding: [usize; 3],
    target: &'k Target,
    near: &'k [f64],
}

/// Positions by the component errors of a round before.
struct Round {
    positions: Vec<f64>,
    /// The axis that is free in it.
    free: Option<usize>,
    /// How far the tool's direction is out of reach with these errors, rad.
    by_rad: f64,
}

impl Five<'_, '_> {
    /// One of the two solutions, `None` where there is only one. The component errors settle round by round.
    fn branch(&self, branch: usize, axes: &mut Vec<AxisInWorkpiece>) -> Result<Option<Solution>, InverseError> {
        let mut positions = self.near.to_vec();
        for round in 0..MOST_ROUNDS {
            let Some(Round { positions: next, free, by_rad }) = self.with_errors_of(&positions, branch, axes)? else {
                return Ok(None);
            };
            let step = |(a, b): (&f64, &f64)| (a - b).abs() / (1.0 + a.abs());
            let moved = next.iter().zip(&positions).map(step).fold(0.0, f64::max);
            positions = next;
            if moved < POSITION_TOLERANCE || round + 1 == MOST_ROUNDS {
                // the errors of other positions may put a direction at the edge out of reach: only those of the end count
                if by_rad > 0.0 && branch > 0 {
                    return Ok(None);
                }
                if by_rad > 0.0 {
                    return Err(InverseError::Direction {
                        axes: self.names(&self.turning),
                        by_deg: by_rad.to_degrees(),
                    });
                }
                let pose = self.kinematics.pose(&positions);
                let off_mm = (pose.tip_mm - self.target.tip_mm).norm();
                let off_rad = pose.angle_to(&self.target.axis);
                if off_mm > 1e-6 || off_rad > 1e-8 {
                    return Err(InverseError::NoEnd);
                }
                return Ok(Some(Solution { positions, outside: Vec::new(), free, off_mm, off_rad }));
            }
        }
        Err(InverseError::NoEnd)
    }

    /// The solution with the component errors of given positions, and the axis that is free in it.
    fn with_errors_of(
        &self,
        at: &[f64],
        branch: usize,
        axes: &mut Vec<AxisInWorkpiece>,
    ) -> Result<Option<Round>, InverseError> {
        let motion = self.kinematics.component_errors(at);
        let [first, second] = self.turning;
        let mut next = at.to_vec();
        (next[first], next[second]) = (0.0, 0.0);
        let pose = self.kinematics.pose_and_axes(&next, motion.as_deref(), axes);
        let turns = two_turns(&axes[first].direction, &axes[second].direction, &pose.axis, &self.target.axis);
        let mut by_rad = 0.0;
        let (pair, free) = match turns {
            TwoTurns::Pairs(pairs) => match pairs.get(branch) {
                Some(pair) => (*pair, None),
                None => return Ok(None),
            },
            TwoTurns::OutOfReach { by_rad: by, nearest } => {
                by_rad = by;
                (nearest, None)
            }
            TwoTurns::FirstFree(_) | TwoTurns::SecondFree(_) if branch > 0 => return Ok(None),
            TwoTurns::FirstFree(turn) => ((self.near[first], turn), Some(first)),
            TwoTurns::SecondFree(turn) => ((turn, self.near[second]), Some(second)),
            TwoTurns::Parallel => {
                let by_deg = angle(&pose.axis, &self.target.axis).to_degrees();
                return Err(InverseError::Direction { axes: self.names(&self.turning), by_deg });
            }
        };
        // of the same place after whole turns the one near to where the axis is wanted
        let nearest = |turn: f64, axis: usize| turn + ((self.near[axis] - turn) / TAU).round() * TAU;
        (next[first], next[second]) = (nearest(pair.0, first), nearest(pair.1, second));
        let pose = self.kinematics.pose_and_axes(&next, motion.as_deref(), axes);
        let ways = Matrix3::from_columns(&self.sliding.map(|axis| axes[axis].direction));
        let Some(steps) = ways.try_inverse().filter(|inverse| inverse.amax() < 1e6) else {
            return Err(InverseError::Slides { axes: self.names(&self.sliding) });
        };
        let step = steps * (self.target.tip_mm - pose.tip_mm);
        for (k, &axis) in self.sliding.iter().enumerate() {
            next[axis] += step[k];
        }
        Ok(Some(Round { positions: next, free, by_rad }))
    }

    fn names(&self, list: &[usize]) -> String {
        let axes = &self.kinematics.machine().axes;
        list.iter().map(|&axis| axes[axis].name.as_str()).collect::<Vec<&str>>().join(" and ")
    }
}
