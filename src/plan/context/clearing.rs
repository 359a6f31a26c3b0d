//! Which candidates are clear: their sweeps, and the ways to the starts of these. What is found is remembered; nothing is chosen here.

use super::choice::Entry;
use super::evaluation::{EndedBy, Evaluation};
use crate::collision::{Instrument, NoWay};
use crate::plan::places::candidate::Candidate;
use crate::plan::places::run_in::RUN_IN;
use crate::plan::reach::approach::Approach;
use crate::plan::reach::pace::feed_mm_per_min;
use crate::plan::reach::sweep_reach::{ClearArc, ClearSweep, SampledArc, certified_sweep, measured, sampled_sweep};
use crate::session::{Ball, Test};

impl<'a> Evaluation<'a> {
    /// The session test of a candidate.
    pub fn test(&self, candidate: &Candidate, name: String, (from, to): (f64, f64)) -> Test {
        let site = self.context.site(candidate.site);
        let place = &self.context.all.places[candidate.place];
        let ball = |link: &str, at| Ball { link: link.into(), at, setup: None, spread_mm: None, indexed_about: None };
        let spindle_link = self.context.machine.spindle.as_ref().map_or("t", |spindle| spindle.link.as_str());
        Test {
            name,
            recording_file: None,
            recording: None,
            path: Some(candidate.path(from, to)),
            started_at_s: 0.0,
            bar_length_mm: Some(candidate.bar_mm),
            bar_setup: None,
            zero: self.context.settings.uncertainty.zero,
            bar_error_mm: 0.0,
            pivot: ball(&self.context.bodies.mounts[site.mount].link, site.at),
            spindle_ball: ball(spindle_link, place.at),
            positions: candidate.standing(self.context.machine),
            feed_mm_per_min: Some(feed_mm_per_min(
                self.context.machine,
                candidate,
                self.context.settings.feed_mm_per_min,
            )),
            overshoot: Some(RUN_IN),
            marks: None,
            approached: Vec::new(),
            reading: crate::readings::Reading::Length,
        }
    }

    /// The way from a park position to the start of a sweep's run-in; `None` when an avoided region lies between.
    pub fn approach(
        &mut self,
        candidate: &Candidate,
        sweep: &ClearArc,
        park: usize,
    ) -> Option<Result<Approach, NoWay>> {
        let test = self.test(candidate, String::new(), (sweep.from_deg, sweep.to_deg));
        let instrument =
            Instrument::of(self.context.world, self.context.machine, self.context.bodies, self.context.kit, &test)
                .ok()?;
        let scene = instrument.scene_without_bar(self.context.world);
        let (rows, _) = candidate.rows(self.context.machine, sweep.from_deg, sweep.to_deg);
        let start = rows.first()?;
        if !self.context.parking.serves(park, start) {
            return None;
        }
        Some(self.context.parking.approach(park, &scene, start, self.context.settings.margin_mm, &mut self.scratch))
    }

    /// The longest clear sweep of a candidate to whose start there is a clear way; remembers what stood in the way.
    pub fn clear(&mut self, candidate: &'a Candidate) -> Option<ClearArc> {
        if let Some(known) = self.arcs.get(&std::ptr::from_ref(candidate)) {
            return known.clone();
        }
        let found = self.clear_anew(candidate);
        self.arcs.insert(candidate, found.clone());
        found
    }

    /// True when a candidate was looked at and has a clear sweep with a clear way to it.
    pub fn is_known_clear(&self, candidate: &Candidate) -> bool {
        matches!(self.arcs.get(&std::ptr::from_ref(candidate)), Some(Some(_)))
    }

    /// The longest arc of a candidate's samples that are clear: at most so long is its clear sweep. Remembers what forbids one.
    pub fn sampled(&mut self, candidate: &'a Candidate) -> Option<SampledArc> {
        if let Some(known) = self.sampled_arcs.get(&std::ptr::from_ref(candidate)) {
            return known.clone();
        }
        let found = self.instrument(candidate).map(|instrument| {
            let scene = instrument.scene(self.context.world);
            let margin_mm = self.context.settings.margin_mm;
            sampled_sweep(&scene, self.context.machine, candidate, margin_mm, &mut self.scratch)
        });
        let arc = match found {
            Some(Err(pair)) => {
                self.remember_forbidden(candidate, pair);
                None
            }
            found => found.and_then(Result::ok),
        };
        self.sampled_arcs.insert(candidate, arc.clone());
        arc
    }

    /// A candidate with its clear arc; `None` when it has none.
    pub fn cleared_entry(&mut self, candidate: &'a Candidate) -> Option<Entry<'a>> {
        self.clear(candidate).map(|sweep| self.entry(candidate, Some(sweep)))
    }

    /// A candidate with what samples leave of its arc; `None` when that is too short.
    pub fn sampled_entry(&mut self, candidate: &'a Candidate) -> Option<Entry<'a>> {
        self.sampled(candidate).map(|arc| self.entry_at_most(candidate, &arc))
    }

    fn clear_anew(&mut self, candidate: &'a Candidate) -> Option<ClearArc> {
        let sampled = self.sampled(candidate)?;
        let instrument = self.instrument(candidate)?;
        let scene = instrument.scene(self.context.world);
        let margin_mm = self.context.settings.margin_mm;
        match certified_sweep(&scene, self.context.machine, candidate, sampled, margin_mm, &mut self.scratch) {
            Ok(sweep) => match self.no_way(candidate, &sweep) {
                None => return Some(sweep),
                Some(pair) if !self.context.is_added(candidate) => count(&mut self.blocked_ways, candidate, pair),
                Some(_) => {}
            },
            Err(pair) => self.remember_forbidden(candidate, pair),
        }
        None
    }

    /// Reasons speak of the setups that every plan begins with.
    fn remember_forbidden(&mut self, candidate: &Candidate, pair: (String, String)) {
        if !self.context.is_added(candidate) {
            count(&mut self.forbidden, candidate, pair);
        }
    }

    /// The bar with its cups as a candidate mounts them.
    fn instrument(&self, candidate: &Candidate) -> Option<Instrument<'a>> {
        let arc = (candidate.from.to_degrees(), candidate.to.to_degrees());
        let test = self.test(candidate, String::new(), arc);
        Instrument::of(self.context.world, self.context.machine, self.context.bodies, self.context.kit, &test).ok()
    }

    /// A clear arc of a candidate with its least clearance.
    pub fn measured(&mut self, candidate: &Candidate, arc: &ClearArc) -> Option<ClearSweep> {
        let test = self.test(candidate, String::new(), (arc.from_deg, arc.to_deg));
        let instrument = Instrument::of(
            self.context.whole_world,
            self.context.machine,
            self.context.bodies,
            self.context.kit,
            &test,
        )
        .ok()?;
        let (rows, _) = candidate.rows(self.context.machine, arc.from_deg, arc.to_deg);
        Some(measured(&instrument.scene(self.context.whole_world), arc, &rows, &mut self.scratch))
    }

    /// What stands in every way from every park position to the start of a sweep; `None` when one is clear.
    fn no_way(&mut self, candidate: &Candidate, sweep: &ClearArc) -> Option<(String, String)> {
        let mut first = None;
        for park in 0..self.context.parking.count() {
            match self.approach(candidate, sweep, park) {
                Some(Ok(_)) => return None,
                Some(Err(no_way)) => first = first.or(Some(no_way.hit.pair)),
                None => {}
            }
        }
        first.or_else(|| Some(("every park position".into(), "region kept out of use".into())))
    }
}

/// One more sweep of the candidate's axis that a pair ends.
fn count(pairs: &mut EndedBy, candidate: &Candidate, pair: (String, String)) {
    *pairs.entry(candidate.axis).or_default().entry(pair).or_default() += 1;
}
