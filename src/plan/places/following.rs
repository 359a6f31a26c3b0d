//! Setups in which linear axes follow a rotary axis so that the bar keeps its direction in the turning frame. Not yet checked for collisions.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::ball_places::Offer;
use super::candidate::{Candidate, Candidates, WantedSweep};
use super::drive::{Drive, Swing};
use super::pairing::{LEAST_LEVER_MM, Pairing, pairings};
use super::run_in::shortest_deg;
use super::slides::{Slides, arc_within};
use super::solver::{Solved, Stance};
use crate::chain::{Geometry, LinkId};
use crate::machine::Machine;
use crate::session::{Follow, Path};

/// Bars tried, shortest first: the reading does not depend on the bar's length, the travel does.
const BARS: usize = 3;

/// Setups of one axis with linear axes following, by the kinds asked for.
pub(crate) fn following(
    machine: &Machine,
    geometry: &Geometry,
    all: &Candidates,
    &WantedSweep { axis, from, to, lengths_mm, starts, avoid }: &WantedSweep,
    kinds: &[Follow],
    offer: Offer,
) -> Vec<Candidate> {
    let chain = geometry.chain();
    let mut list = Vec::new();
    if kinds.is_empty() {
        return list;
    }
    let mut pairings = pairings(all, chain, axis, offer);
    pairings.retain(|pairing| all.places[pairing.place].aside_mm == 0.0);
    for start in starts {
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
        for &Pairing { place: place_index, site: site_index, on_tool } in &pairings {
            let (place, site) = (&all.places[place_index], &all.sites[site_index]);
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
                let Some((positions, swing)) = slides.swing(&stances, start, carried, other, bar_mm, kind) else {
                    continue;
                };
                let arc = arc_within(machine, avoid, &positions, &swing, (from, to), shortest_deg(machine, axis));
                let Some((from, to)) = arc else { continue };
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
    list
}

impl Slides {
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
        let mut swing = Swing::none(start.len());
        for &axis in &self.axes {
            positions[axis] = 0.5 * (none[axis] + half[axis]);
            swing.cos[axis] = 0.5 * (none[axis] - half[axis]);
            swing.sin[axis] = quarter[axis] - positions[axis];
        }
        Some((positions, swing))
    }
}

/// Kinds of following in the order of the field's books.
pub const FOLLOWED: [Follow; 3] = [Follow::Radial, Follow::Tangential, Follow::Axial];
