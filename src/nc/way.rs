//! The way to the start of a run and back: fast while the balls are far from each other, else at feed with a stop before each leg.

use super::coordinates::Coordinates;
use super::step::Step;
use crate::chain::{Chain, Geometry};
use crate::machine::{AxisKind, Machine};
use crate::plan::PlannedTest;
use crate::units::rounded;

/// Beyond the bar's length, balls nearer than this are near, mm: what a rapid move of 20 m/min goes in the 0.3 s that a hand
/// takes to the feed hold.
const NEAR_MM: f64 = 100.0;
/// Feed of the ways near the cups, mm/min at the ball that moves.
pub(super) const APPROACH_MM_PER_MIN: f64 = 1000.0;
/// Least lever of a turning axis for which the feed is counted, mm.
const LEAST_LEVER_MM: f64 = 50.0;
/// Parts into which a leg is cut to find where it comes near.
const PARTS: usize = 64;

/// One leg of a way.
struct Leg {
    axis: usize,
    from: Vec<f64>,
    to: Vec<f64>,
}

/// What the distances of the balls are computed with.
struct Balls<'a> {
    machine: &'a Machine,
    planned: &'a PlannedTest,
    coordinates: &'a Coordinates,
    chain: Chain,
}

/// From park to the start of the run-in.
pub(super) fn there(machine: &Machine, planned: &PlannedTest, coordinates: &Coordinates) -> Vec<Step> {
    let balls = Balls { machine, planned, coordinates, chain: Chain::of(machine) };
    let corners = planned.approach.corners();
    let mut steps = Vec::new();
    for (leg, pair) in planned.approach.legs.iter().zip(corners.windows(2)) {
        let [from, to] = pair else { continue };
        let leg = Leg { axis: leg.axis, from: from.clone(), to: to.clone() };
        match balls.first_near(&leg) {
            None => steps.push(balls.rapid(&leg, 1.0)),
            Some(part) => {
                if part > 0.0 {
                    steps.push(balls.rapid(&leg, part));
                }
                steps.push(Step::Stop(balls.words(&leg)));
                steps.push(balls.at_feed(&leg, 1.0));
            }
        }
    }
    steps
}

/// The same way back; the first leg follows a stop.
pub(super) fn back(machine: &Machine, planned: &PlannedTest, coordinates: &Coordinates) -> Vec<Step> {
    let balls = Balls { machine, planned, coordinates, chain: Chain::of(machine) };
    let corners = planned.approach.corners();
    let mut steps = Vec::new();
    for (leg, pair) in planned.approach.legs.iter().zip(corners.windows(2)).rev() {
        let [to, from] = pair else { continue };
        let leg = Leg { axis: leg.axis, from: from.clone(), to: to.clone() };
        let reverse = Leg { axis: leg.axis, from: to.clone(), to: from.clone() };
        match balls.first_near(&reverse) {
            None => steps.push(balls.rapid(&leg, 1.0)),
            Some(part) => {
                if !steps.is_empty() {
                    steps.push(Step::Stop(balls.words(&leg)));
                }
                steps.push(balls.at_feed(&leg, 1.0 - part));
                if part > 0.0 {
                    steps.push(balls.rapid(&leg, 1.0));
                }
            }
        }
    }
    steps
}

impl Balls<'_> {
    /// Part of a leg from which on it is near; `None` when it never is.
    fn first_near(&self, leg: &Leg) -> Option<f64> {
        let geometry = Geometry::nominal(&self.chain);
        let test = &self.planned.test;
        let links = test.links(&self.chain).ok()?;
        let near_mm = test.bar_length_mm.unwrap_or(0.0) + NEAR_MM;
        let apart = |q: &[f64]| test.bar(&geometry, links, q).norm();
        let near = (0..=PARTS).find(|&k| apart(&leg.at(k as f64 / PARTS as f64)) < near_mm)?;
        Some(near.saturating_sub(1) as f64 / PARTS as f64)
    }

    fn reading(&self, leg: &Leg, part: f64) -> f64 {
        self.coordinates.reading(self.machine, leg.axis, leg.at(part)[leg.axis])
    }

    fn rapid(&self, leg: &Leg, part: f64) -> Step {
        Step::Rapid { axis: self.machine.axes[leg.axis].name.clone(), to: self.reading(leg, part) }
    }

    fn at_feed(&self, leg: &Leg, part: f64) -> Step {
        let per_minute = feed_of(self.machine, &self.chain, self.planned, leg.axis, &leg.from, &leg.to);
        Step::Feed { axis: self.machine.axes[leg.axis].name.clone(), to: self.reading(leg, part), per_minute }
    }

    fn words(&self, leg: &Leg) -> String {
        let axis = &self.machine.axes[leg.axis];
        format!(
            "near the cups, next {} to {} at feed, hand on the feed hold",
            axis.name,
            rounded(self.reading(leg, 1.0), 3)
        )
    }
}

impl Leg {
    fn at(&self, part: f64) -> Vec<f64> {
        let mut q = self.from.clone();
        q[self.axis] += (self.to[self.axis] - self.from[self.axis]) * part;
        q
    }
}

/// Feed of one axis near the cups, mm/min or deg/min, such that neither ball goes faster than [`APPROACH_MM_PER_MIN`].
pub(super) fn feed_of(
    machine: &Machine,
    chain: &Chain,
    planned: &PlannedTest,
    axis: usize,
    from: &[f64],
    to: &[f64],
) -> f64 {
    if machine.axes[axis].kind == AxisKind::Linear {
        return APPROACH_MM_PER_MIN;
    }
    let geometry = Geometry::nominal(chain);
    let test = &planned.test;
    let Ok((pivot, spindle)) = test.links(chain) else { return APPROACH_MM_PER_MIN };
    let lever = |q: &[f64]| {
        let mut turned = q.to_vec();
        // 0.001 rad: the way on the circle is the chord to 1e-7
        turned[axis] += 1e-3;
        let way = |link, at| (geometry.point(link, at, &turned, None) - geometry.point(link, at, q, None)).norm();
        way(pivot, &test.pivot.at).max(way(spindle, &test.spindle_ball.at)) / 1e-3
    };
    (APPROACH_MM_PER_MIN / lever(from).max(lever(to)).max(LEAST_LEVER_MM)).to_degrees()
}
