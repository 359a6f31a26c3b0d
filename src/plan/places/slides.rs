//! Linear axes that bring one ball anywhere relative to the other, and the arc over which they stay where they may. It chooses no setups.

use nalgebra::{Matrix3, Vector3};

use super::candidate::Avoid;
use super::drive::Swing;
use super::run_in::{OFF_LIMIT, RUN_IN};
use super::solver::Stance;
use crate::chain::{Chain, LinkId};
use crate::machine::{AxisKind, Machine};

/// Slides closer than this to a common plane bring no ball everywhere.
const SINGULAR: f64 = 1e-3;

/// The linear axes between two balls when they bring one to any place relative to the other, whatever the turn.
pub(crate) struct Slides {
    pub axes: Vec<usize>,
    /// Slide travel, mm, for a way of the first ball relative to the second in the bed frame, mm.
    travel_of_way: Matrix3<f64>,
    /// What a millimetre of each slide does to that way.
    way_of_travel: Matrix3<f64>,
}

impl Slides {
    /// `None` when other than three slides act or they do not span space.
    pub fn of(stance: &Stance, chain: &Chain, first: LinkId, second: LinkId) -> Option<Slides> {
        let ways: Vec<(usize, Vector3<f64>)> = stance.pull(chain, first, second).ways().collect();
        if ways.len() != 3 {
            return None;
        }
        let way_of_travel = Matrix3::from_columns(&[ways[0].1, ways[1].1, ways[2].1]);
        if way_of_travel.determinant().abs() < SINGULAR {
            return None;
        }
        let axes = ways.iter().map(|(axis, _)| *axis).collect();
        Some(Slides { axes, travel_of_way: way_of_travel.try_inverse()?, way_of_travel })
    }

    /// What a millimetre of an axis does to the way of the first ball relative to the second.
    pub fn way(&self, axis: usize) -> Option<Vector3<f64>> {
        let column = self.axes.iter().position(|&other| other == axis)?;
        Some(self.way_of_travel.column(column).into_owned())
    }

    /// Positions that move the first ball by `way` relative to the second, from a start.
    pub fn moved(&self, start: &[f64], way: &Vector3<f64>) -> Vec<f64> {
        let travel = self.travel_of_way * way;
        let mut positions = start.to_vec();
        self.axes.iter().zip(travel.iter()).for_each(|(&axis, travel)| positions[axis] += travel);
        positions
    }
}

/// Resolution at which the arc within ranges is looked for, deg.
const RANGE_STEP_DEG: f64 = 2.0;
/// Linear axes stay this far inside their ranges, mm: off the limit, and what they do between two neighbours of that
/// resolution, r·(2°)²/8, 0.15 mm at a radius of 1 m.
const INSIDE_MM: f64 = OFF_LIMIT + 0.15;

/// The longest part of an arc over which, run-in included, the linear axes stay in range and out of avoided regions, rad;
/// `None` where it is shorter than some degrees.
pub(crate) fn arc_within(
    machine: &Machine,
    avoid: &Avoid,
    middle: &[f64],
    swing: &Swing,
    (from, to): (f64, f64),
    shortest_deg: f64,
) -> Option<(f64, f64)> {
    let linear: Vec<usize> = machine.axes_of(AxisKind::Linear).collect();
    let limits = |k: usize| machine.axes[k].range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    let always = linear.iter().all(|&k| {
        let (low, high) = limits(k);
        let reach = swing.reach(k) + INSIDE_MM;
        middle[k] - reach >= low && middle[k] + reach <= high && avoid.iter().all(|(other, ..)| *other != k)
    });
    if always {
        return Some((from, to));
    }
    if linear.iter().any(|&k| {
        let (low, high) = limits(k);
        middle[k] + swing.reach(k) < low || middle[k] - swing.reach(k) > high
    }) {
        return None;
    }
    let allowed = |deg: f64| {
        linear.iter().all(|&k| {
            let q = middle[k] + swing.at(k, deg.to_radians());
            let (low, high) = limits(k);
            let off =
                |&(other, from, to): &(usize, f64, f64)| other != k || q <= from - INSIDE_MM || q >= to + INSIDE_MM;
            q >= low + INSIDE_MM && q <= high - INSIDE_MM && avoid.iter().all(off)
        })
    };
    let (first, last) = (from.to_degrees() - RUN_IN, to.to_degrees() + RUN_IN);
    let count = ((last - first) / RANGE_STEP_DEG).ceil().max(1.0) as usize;
    let at = |k: usize| first + (last - first) * k as f64 / count as f64;
    let (mut best, mut start): (Option<(usize, usize)>, Option<usize>) = (None, None);
    for k in 0..=count {
        start = if allowed(at(k)) { start.or(Some(k)) } else { None };
        if let Some(first) = start
            && best.is_none_or(|(a, b)| k - first > b - a)
        {
            best = Some((first, k));
        }
    }
    let (first, last) = best?;
    let (from, to) = (at(first) + RUN_IN, at(last) - RUN_IN);
    (to - from >= shortest_deg).then(|| (from.to_radians(), to.to_radians()))
}
