//! Setups beside those that every plan begins with: from pivot places between, standing axes turned. Nothing is chosen here.

use super::plan_context::PlanContext;
use crate::machine::{AxisKind, Machine};
use crate::plan::places::ball_places::{Offer, moved_site};
use crate::plan::places::candidate::{Candidate, Candidates, PivotSite, WantedSweep};
use crate::plan::places::following::following;
use crate::plan::places::free_range::sweep_wanted;
use crate::plan::places::starts::static_positions;
use crate::plan::places::turning::turning;

impl<'a> PlanContext<'a> {
    /// A pivot place by its index, added ones behind those of every plan.
    pub(crate) fn site(&self, index: usize) -> &PivotSite {
        let coarse = self.all.sites.len();
        self.all.sites.get(index).or_else(|| self.finer.site(index - coarse)).unwrap_or(&self.all.sites[0])
    }

    /// True for a setup that was added.
    pub(crate) fn is_added(&self, candidate: &Candidate) -> bool {
        !self.all.list.as_ptr_range().contains(&std::ptr::from_ref(candidate))
    }

    /// The index of a place some way along, across and above a mount from another, mm.
    pub(crate) fn beside(&self, site: usize, way_mm: [f64; 3]) -> Option<usize> {
        let moved = moved_site(self.bodies, self.kit, self.site(site), way_mm)?;
        let known = self.all.sites.iter().position(|other| *other == moved);
        known.or_else(|| Some(self.all.sites.len() + self.finer.keep_site(moved)?))
    }

    /// All setups of an added pivot place, at the usual standing positions of rotary axes and at those of some tests.
    pub(crate) fn setups_at(&self, site: usize, like: &[&Candidate]) -> Option<&'a [Candidate]> {
        let chain = self.geometry.chain();
        let rotary = self.machine.axes_of(AxisKind::Rotary);
        let list = rotary.flat_map(|axis| {
            let mut starts = static_positions(self.machine, chain, axis, &self.settings.avoid);
            let tests = like.iter().filter(|candidate| candidate.axis == axis);
            for start in tests.map(|candidate| start_of(self.machine, candidate)) {
                if !starts.contains(&start) {
                    starts.push(start);
                }
            }
            self.setups_of(axis, site, None, &starts)
        });
        self.finer.keep_list(list.collect())
    }

    /// The setup of a test from another pivot place, with one of its standing axes turned on.
    pub(crate) fn same_from(
        &self,
        like: &Candidate,
        site: usize,
        turned: Option<(usize, f64)>,
    ) -> Option<&'a Candidate> {
        let mut start = start_of(self.machine, like);
        if let Some((axis, by_rad)) = turned {
            start[axis] = ((start[axis] + by_rad).to_degrees() * 2.0).round().to_radians() / 2.0;
            let range = self.machine.axes[axis].range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
            let is_avoided = |&(of, from, to): &(usize, f64, f64)| of == axis && start[of] > from && start[of] < to;
            if start[axis] < range.0 || start[axis] > range.1 || self.settings.avoid.iter().any(is_avoided) {
                return None;
            }
        }
        let kind = |candidate: &Candidate| candidate.path(0.0, 1.0);
        let list = self.setups_of(like.axis, site, Some(like.place), std::slice::from_ref(&start));
        let off = |candidate: &Candidate| {
            let (mine, its) = (&like.solved, &candidate.solved);
            (mine.rho_mm - its.rho_mm).abs() + if mine.h_mm * its.h_mm < 0.0 { mine.h_mm.abs() } else { 0.0 }
        };
        let alike =
            list.into_iter().filter(|candidate| candidate.bar_mm == like.bar_mm && kind(candidate) == kind(like));
        let nearest = alike.reduce(|best, other| if off(&other) < off(&best) { other } else { best })?;
        self.finer.keep_list(vec![nearest])?.first()
    }

    /// Setups of one axis from one pivot place, with one spindle ball or with all.
    fn setups_of(&self, axis: usize, site: usize, place: Option<usize>, starts: &[Vec<f64>]) -> Vec<Candidate> {
        let Some((from, to)) = sweep_wanted(self.machine, axis, &self.settings.avoid) else { return Vec::new() };
        let places = match place {
            Some(place) => vec![self.all.places[place].clone()],
            None => self.all.places.clone(),
        };
        let near = Candidates { sites: vec![self.site(site).clone()], places, ..Candidates::default() };
        let (machine, geometry, lengths) = (self.machine, &self.geometry, self.kit.lengths_mm());
        let wanted = WantedSweep { axis, from, to, lengths_mm: &lengths, starts, avoid: &self.settings.avoid };
        let (mut list, _) = turning(machine, geometry, &near, &wanted, Offer::Near);
        list.extend(following(machine, geometry, &near, &wanted, &self.settings.coupled.follow, Offer::Near));
        for candidate in &mut list {
            candidate.site = site;
            candidate.place = place.unwrap_or(candidate.place);
        }
        list
    }
}

/// Where a test's setup was looked for from: linear axes at the place in their range nearest zero, other rotary axes as they stand.
fn start_of(machine: &Machine, candidate: &Candidate) -> Vec<f64> {
    let near_zero = |axis: usize| machine.axes[axis].near_zero();
    let stands = |axis: usize| machine.axes[axis].kind == AxisKind::Rotary && axis != candidate.axis;
    let at = |axis: usize| if stands(axis) { candidate.solved.positions[axis] } else { near_zero(axis) };
    (0..machine.axes.len()).map(at).collect()
}
