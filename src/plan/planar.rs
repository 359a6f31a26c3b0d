//! Planar circles of two linear axes about a pivot, for squareness: which are reachable, and which of them a plan begins with.

use std::collections::BTreeMap;

use super::candidates::{Avoid, Candidate, Candidates, static_positions};
use super::choose::Desk;
use super::course::{Drive, Swing};
use super::greedy::Search;
use super::slides::{Slides, arc_within};
use super::solver::{Solved, Stance};
use crate::bodies::Bodies;
use crate::chain::Geometry;
use crate::machine::{AxisKind, Machine};
use crate::session::CirclePlane;

/// Planes by the names of their axes, the one that carries the cosine first (G17, G19 and G18 of a control).
pub const PLANES: [[&str; 2]; 3] = [["X", "Y"], ["Y", "Z"], ["Z", "X"]];
/// Bars tried, shortest first.
const BARS: usize = 2;
/// Most pivot places tried for one plane.
const MOST_SITES: usize = 60;
/// Slides within this of right angles and equal lengths draw a circle.
const SQUARE: f64 = 1e-9;

/// Circles in all planes that the machine's slides make.
pub(super) fn circles(
    machine: &Machine,
    geometry: &Geometry,
    bodies: &Bodies,
    all: &Candidates,
    lengths_mm: &[f64],
    avoid: &Avoid,
) -> Vec<Candidate> {
    let chain = geometry.chain();
    let mut list = Vec::new();
    for names in PLANES {
        let [Some(first), Some(second)] = names.map(|name| linear_axis(machine, name)) else { continue };
        // rotary axes at the first of their static positions
        let Some(start) = static_positions(machine, chain, first, avoid).into_iter().next() else { continue };
        let stance = Stance::new(machine, geometry, first, &start);
        let step = all.sites.len().div_ceil(MOST_SITES).max(1);
        for (place_index, place) in all.places.iter().enumerate().filter(|(_, place)| place.aside_mm == 0.0) {
            for (site_index, site) in all.sites.iter().enumerate().step_by(step) {
                let Some(slides) = Slides::of(&stance, chain, place.link, site.link) else { continue };
                let (Some(u), Some(v)) = (slides.way(first), slides.way(second)) else { continue };
                if u.dot(&v).abs() > SQUARE || (u.norm() - 1.0).abs() > SQUARE || (v.norm() - 1.0).abs() > SQUARE {
                    continue;
                }
                let ball = stance.point((place.link, &place.at));
                let pivot = stance.point((site.link, &site.at));
                let positions = slides.moved(&start, &(pivot - ball));
                let normal = stance.turned(site.link, &bodies.mounts[site.mount].normal);
                for &bar_mm in lengths_mm.iter().take(BARS) {
                    let mut swing = Swing::none(start.len());
                    swing.cos[first] = bar_mm;
                    swing.sin[second] = bar_mm;
                    // a pivot cup opens to one side: the turn is taken about that side
                    let open = [u.dot(&normal), v.dot(&normal)];
                    let middle = if open[0].hypot(open[1]) < 0.1 {
                        std::f64::consts::PI
                    } else {
                        open[1].atan2(open[0]).to_degrees().round().to_radians()
                    };
                    let (from, to) = (middle - std::f64::consts::PI, middle + std::f64::consts::PI);
                    let Some((from, to)) = arc_within(machine, avoid, &positions, &swing, from, to) else { continue };
                    list.push(Candidate {
                        axis: first,
                        site: site_index,
                        place: place_index,
                        bar_mm,
                        solved: Solved { positions: positions.clone(), rho_mm: bar_mm, h_mm: 0.0, along_mm: 0.0 },
                        from,
                        to,
                        drive: Drive::Circle(CirclePlane { first, second }, Box::new(swing)),
                    });
                }
            }
        }
    }
    list
}

/// The linear axis of this name that runs along its coordinate direction.
fn linear_axis(machine: &Machine, name: &str) -> Option<usize> {
    let axis = machine.axis_index(name)?;
    let along = "XYZ".find(name)?;
    let is_it = machine.axes[axis].kind == AxisKind::Linear && machine.axes[axis].coordinate_direction() == Some(along);
    is_it.then_some(axis)
}

/// Indices of entries by the two axes of their circle.
type ByPlane = BTreeMap<(usize, usize), Vec<usize>>;

/// Pivot places tried for the circles of a plan.
const TRIED: usize = 8;

impl<'a> Desk<'a> {
    /// Begins a plan with a circle in every plane where one is clear, all about one pivot: who asks for circles wants them,
    /// also where other tests would tell the squareness.
    pub(super) fn take_circles(&mut self, search: &mut Search<'a>) {
        // places by planes and arcs within the ranges, then by how many sweeps of rotary axes share them
        let mut places: BTreeMap<usize, (ByPlane, usize)> = BTreeMap::new();
        for (k, entry) in search.entries.iter().enumerate() {
            let candidate = entry.candidate;
            let (planes, sweeps) = places.entry(candidate.site).or_default();
            match &candidate.drive {
                Drive::Circle(plane, _) => planes.entry((plane.first, plane.second)).or_default().push(k),
                _ => *sweeps += 1,
            }
        }
        let mut ranked: Vec<_> = places.into_values().filter(|(planes, _)| !planes.is_empty()).collect();
        let longest_deg = |candidates: &Vec<usize>| {
            let arc = |&k: &usize| search.entries[k].candidate.to - search.entries[k].candidate.from;
            candidates.iter().map(arc).fold(0.0, f64::max).to_degrees().round() as usize
        };
        ranked.sort_by_key(|(planes, sweeps)| {
            let arcs: usize = planes.values().map(longest_deg).sum();
            std::cmp::Reverse((planes.len(), arcs, *sweeps))
        });
        let mut best: Option<(usize, f64, Vec<usize>)> = None;
        for (planes, _) in ranked.into_iter().take(TRIED) {
            let mut clear = Vec::new();
            let mut arc_deg = 0.0;
            for candidates in planes.into_values() {
                let Some(&k) = candidates.iter().find(|&&k| self.is_clear(search, k)) else { continue };
                arc_deg += search.entries[k].sweep.as_ref().map_or(0.0, |sweep| sweep.to_deg - sweep.from_deg);
                clear.push(k);
            }
            if best.as_ref().is_none_or(|(count, most_deg, _)| (clear.len(), arc_deg) > (*count, *most_deg)) {
                best = Some((clear.len(), arc_deg, clear));
            }
        }
        for k in best.map(|(.., circles)| circles).unwrap_or_default() {
            let cost = self.cost(&search.entries[k], &search.knowledge);
            if self.budget.is_none_or(|budget| search.minutes + cost <= budget) {
                self.take(search, k);
            }
        }
    }

    /// Checks an entry for collisions unless that is done; false when it is not clear.
    pub(super) fn is_clear(&mut self, search: &mut Search<'a>, k: usize) -> bool {
        if search.entries[k].sweep.is_some() {
            return true;
        }
        if search.dead[k] {
            return false;
        }
        let candidate = search.entries[k].candidate;
        match self.clear(candidate) {
            Some(sweep) => search.entries[k] = self.entry(candidate, Some(sweep)),
            None => {
                search.dead[k] = true;
            }
        }
        search.entries[k].sweep.is_some()
    }
}
