//! Setups in which linear axes follow a rotary axis so that the bar keeps its direction in the turning frame. Not yet checked for collisions.

use std::collections::HashMap;

use nalgebra::{Matrix3, Vector3};

use super::candidates::{Avoid, Candidate, Candidates, static_positions};
use super::course::{Drive, Swing};
use super::reach::SHORTEST_DEG;
use super::run_in::{OFF_LIMIT, RUN_IN};
use super::solver::{Solved, Stance};
use crate::chain::{Chain, Geometry, LinkId};
use crate::machine::{AxisKind, Machine};
use crate::session::{Follow, Path};

/// Bars tried, shortest first: the reading does not depend on the bar's length, the travel does.
const BARS: usize = 3;
/// Most setups kept for one axis.
const MOST_SETUPS: usize = 1500;
/// Smallest lever of the carried ball, mm: below, nothing of the axis is seen.
const LEAST_LEVER_MM: f64 = 30.0;
/// Slides closer than this to a common plane bring no ball everywhere.
const SINGULAR: f64 = 1e-3;

/// Setups of one axis with linear axes following, by the kinds asked for.
pub(super) fn following(
    machine: &Machine,
    geometry: &Geometry,
    all: &Candidates,
    lengths_mm: &[f64],
    (axis, from, to): (usize, f64, f64),
    avoid: &Avoid,
    kinds: &[Follow],
) -> Vec<Candidate> {
    let chain = geometry.chain();
    let mut list = Vec::new();
    if kinds.is_empty() {
        return list;
    }
    for start in static_positions(machine, chain, axis, avoid) {
        // the circle through three places is the whole motion: a quarter turn apart
        let turned: Vec<Vec<f64>> = [0.0, 0.5, 1.0]
            .iter()
            .map(|half| {
                let mut start = start.clone();
                start[axis] = half * std::f64::consts::PI;
                start
            })
            .collect();
        let stances: Vec<Stance> = turned.iter().map(|start| Stance::new(machine, geometry, axis, start)).collect();
        let mut slides: HashMap<(LinkId, LinkId), Option<Slides>> = HashMap::new();
        for (place_index, place) in all.places.iter().enumerate().filter(|(_, place)| place.aside_mm == 0.0) {
            let on_tool = chain.carries(axis, place.link);
            for (site_index, site) in all.sites.iter().enumerate() {
                // a pivot that stands still may stand anywhere: every third place is enough
                if chain.carries(axis, site.link) == on_tool || (on_tool && site_index % 3 != place_index % 3) {
                    continue;
                }
                let (pivot, spindle) = ((site.link, &site.at), (place.link, &place.at));
                let (carried, other) = if on_tool { (spindle, pivot) } else { (pivot, spindle) };
                let slides = slides.entry((carried.0, other.0)).or_insert_with(|| {
                    // a slide that the axis carries across its line changes where the bar is to point
                    let turns_along = stances[0].pull(chain, carried.0, other.0).changes_lever;
                    if turns_along { None } else { Slides::of(&stances[0], chain, carried.0, other.0) }
                });
                let Some(slides) = slides else { continue };
                let (rho_mm, along_mm) = stances[0].lever(&stances[0].point(carried));
                if rho_mm < LEAST_LEVER_MM {
                    continue;
                }
                for (&bar_mm, &kind) in
                    lengths_mm.iter().take(BARS).flat_map(|bar| kinds.iter().map(move |kind| (bar, kind)))
                {
                    let Some((positions, swing)) = slides.swing(&stances, &start, carried, other, bar_mm, kind) else {
                        continue;
                    };
                    let Some((from, to)) = arc_within(machine, avoid, &positions, &swing, from, to) else { continue };
                    let h_mm = if kind == Follow::Axial { bar_mm } else { 0.0 };
                    list.push(Candidate {
                        axis,
                        site: site_index,
                        place: place_index,
                        bar_mm,
                        solved: Solved { positions, rho_mm, h_mm, along_mm },
                        from,
                        to,
                        drive: Drive::Follow(kind, Box::new(swing)),
                    });
                }
            }
        }
    }
    thinned(list)
}

/// Every n-th pivot place when there are more setups than needed: whole places, so that their bars stay together.
fn thinned(mut list: Vec<Candidate>) -> Vec<Candidate> {
    let stride = list.len().div_ceil(MOST_SETUPS);
    if stride > 1 {
        let mut sites: Vec<usize> = list.iter().map(|candidate| candidate.site).collect();
        sites.sort_unstable();
        sites.dedup();
        let kept: Vec<usize> = sites.into_iter().step_by(stride).collect();
        list.retain(|candidate| kept.binary_search(&candidate.site).is_ok());
    }
    list
}

/// The linear axes between two balls when they bring one to any place relative to the other, whatever the turn.
pub(super) struct Slides {
    axes: Vec<usize>,
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

    /// Middle positions and swing of the slides so that the other ball stands a bar's length from the carried one.
    fn swing(
        &self,
        stances: &[Stance],
        start: &[f64],
        carried: (LinkId, &Vector3<f64>),
        other: (LinkId, &Vector3<f64>),
        bar_mm: f64,
        kind: Follow,
    ) -> Option<(Vec<f64>, Swing)> {
        let travel = |stance: &Stance| -> Option<Vec<f64>> {
            let ball = stance.point(carried);
            let direction = Path::bar_direction(kind, stance.about(), &(ball - stance.origin()))?;
            // the gap between where the other ball is wanted and where it is closes
            let gap = ball + direction * bar_mm - stance.point(other);
            Some(self.moved(start, &-gap))
        };
        let [none, quarter, half] = [travel(&stances[0])?, travel(&stances[1])?, travel(&stances[2])?];
        let mut positions = start.to_vec();
        let mut swing = Swing { cos: vec![0.0; start.len()], sin: vec![0.0; start.len()] };
        for &axis in &self.axes {
            positions[axis] = 0.5 * (none[axis] + half[axis]);
            swing.cos[axis] = 0.5 * (none[axis] - half[axis]);
            swing.sin[axis] = quarter[axis] - positions[axis];
        }
        Some((positions, swing))
    }
}

/// Resolution at which the arc within ranges is looked for, deg.
const RANGE_STEP_DEG: f64 = 2.0;
/// Linear axes stay this far inside their ranges, mm: off the limit, and what a straight run-in of 4 mm or 4 deg leaves the
/// circle by, at most 0.14 mm (where both are the same way), which is more than between two neighbours of that resolution.
const INSIDE_MM: f64 = OFF_LIMIT + 0.15;

/// The longest part of an arc over which, run-in included, the linear axes stay in range and out of avoided regions, rad.
pub(super) fn arc_within(
    machine: &Machine,
    avoid: &Avoid,
    middle: &[f64],
    swing: &Swing,
    from: f64,
    to: f64,
) -> Option<(f64, f64)> {
    let linear: Vec<usize> = (0..middle.len()).filter(|&k| machine.axes[k].kind == AxisKind::Linear).collect();
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
    (to - from >= SHORTEST_DEG).then(|| (from.to_radians(), to.to_radians()))
}

/// Kinds of following in the order of the field's books.
pub const FOLLOWED: [Follow; 3] = [Follow::Radial, Follow::Tangential, Follow::Axial];
