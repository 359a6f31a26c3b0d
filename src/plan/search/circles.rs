//! Circles of two linear axes with which a plan begins: one in every plane where one is clear, all about one pivot.

use std::collections::BTreeMap;

use super::under_way::Search;
use crate::plan::context::evaluation::Evaluation;
use crate::plan::places::drive::Drive;

/// Indices of entries by the two axes of their circle.
type ByPlane = BTreeMap<(usize, usize), Vec<usize>>;

/// Pivot places tried for the circles of a plan.
const TRIED: usize = 8;

impl<'a> Evaluation<'a> {
    /// Begins a plan with a circle in every plane where one is clear, all about one pivot: who asks for circles wants them,
    /// also where other tests would tell the squareness.
    pub(crate) fn take_circles(&mut self, search: &mut Search<'a>) {
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
            let minutes = self.minutes(&search.entries[k], &search.posterior);
            if self.budget.is_none_or(|budget| search.minutes + minutes <= budget) {
                self.take(search, k);
            }
        }
    }
}
