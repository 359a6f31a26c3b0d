//! What candidates tell and cost, and which of two choices is better. Which are taken is `greedy`'s and `method_tests`'.

use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::hash::BuildHasherDefault;
use std::rc::Rc;

use super::choice::{Choice, Entry, Reached, Untimed};
use super::plan_context::PlanContext;
use super::settings::Goal;
use crate::collision::Scratch;
use crate::plan::information::block::{BLOCK_ROWS, Block, Nuisance, place_in_arc};
use crate::plan::information::fitted::fitted;
use crate::plan::information::hashing::Mix;
use crate::plan::information::observability::Observability;
use crate::plan::information::posterior::Posterior;
use crate::plan::information::unknowns::{Balls, Unknowns};
use crate::plan::places::candidate::Candidate;
use crate::plan::places::run_in::RUN_IN;
use crate::plan::reach::pace::{feed_mm_per_min, is_in_blocks};
use crate::plan::reach::sweep_reach::{ClearArc, SampledArc};

/// Minutes to mount and align a pivot.
const PIVOT_MIN: f64 = 8.0;
/// Minutes to change the spindle cup or fixture.
const SPINDLE_MIN: f64 = 4.0;
/// Minutes to change the bar's length and calibrate it.
const BAR_MIN: f64 = 3.0;
/// Minutes to index the spindle.
pub(crate) const INDEX_MIN: f64 = 1.0;
/// Minutes around each run: approach, trigger, retreat.
const RUN_MIN: f64 = 0.5;
/// Minutes that a test in arcs may cost more than one in straight blocks: controls keep their feed less evenly there.
const BLOCKS_MIN: f64 = 0.5;
/// Differences of Σ ln max(σ², goal²) that are none: undetermined errors shift a little with the number of pivots.
pub(crate) const SAME_WORTH: f64 = 0.02;
/// Setups of one axis that may prove not clear before the rest is given up.
pub(crate) const MAX_FAILURES: usize = 1500;

/// What the whole arc of a candidate tells: the same setup comes up in every search.
pub(crate) struct WholeArc {
    block: Rc<Block>,
    /// Variances of the wanted errors with this test alone; empty until asked for.
    alone: Vec<f64>,
}

/// By axis: how often a pair ended a sweep or a way.
pub(crate) type EndedBy = BTreeMap<usize, HashMap<(String, String), usize>>;

/// Something known of candidates, by their address in `all`.
type ByCandidate<T> = HashMap<*const Candidate, T, BuildHasherDefault<Mix>>;

/// The context of a plan with the goals of the moment and what was found of its candidates by now.
pub(crate) struct Evaluation<'a> {
    pub context: &'a PlanContext<'a>,
    pub scratch: Scratch,
    /// Time that is to be filled, min; `None`: tests until the goals are reached.
    pub budget: Option<f64>,
    /// Standard deviations wanted of the wanted errors, mm and rad.
    pub goals: Vec<f64>,
    /// For each wanted error: what lengths of reachable setups show of it if nothing stands in their way.
    pub observability: Vec<Observability>,
    /// Arcs of samples and clear arcs found before, by the candidate's address in `all`: the same setup comes up in several searches.
    pub sampled_arcs: ByCandidate<Option<SampledArc>>,
    pub arcs: ByCandidate<Option<ClearArc>>,
    /// What whole arcs tell, by the candidate's address in `all`, and the variances that they leave alone: likewise.
    pub whole_arcs: RefCell<ByCandidate<WholeArc>>,
    /// Variances of the wanted errors that all setups of a pivot place would leave, by place: every goal ranks by them.
    pub promises: RefCell<BTreeMap<usize, Vec<f64>>>,
    /// The choice without a limit on time, where it does not fit in the time allowed.
    pub untimed: Option<Untimed>,
    /// All pairs of clear setups are tried where nothing else shows an error.
    pub tries_all_pairs: bool,
    /// Some runs have the spindle indexed.
    pub is_indexed: bool,
    /// By axis: how often a pair ended or forbade a sweep.
    pub forbidden: EndedBy,
    /// The same for the ways to the starts of sweeps that would be clear.
    pub blocked_ways: EndedBy,
}

impl<'a> Evaluation<'a> {
    /// Nothing is known of the candidates yet.
    pub fn of(context: &'a PlanContext<'a>) -> Evaluation<'a> {
        Evaluation {
            budget: context.settings.goal.minutes,
            goals: goals(&context.unknowns, &context.settings.goal),
            context,
            scratch: Scratch::default(),
            observability: Vec::new(),
            sampled_arcs: ByCandidate::default(),
            arcs: ByCandidate::default(),
            whole_arcs: RefCell::default(),
            promises: RefCell::default(),
            untimed: None,
            tries_all_pairs: true,
            is_indexed: false,
            forbidden: BTreeMap::new(),
            blocked_ways: BTreeMap::new(),
        }
    }

    /// A candidate's information over its sweep.
    pub fn entry(&self, candidate: &'a Candidate, sweep: Option<ClearArc>) -> Entry<'a> {
        let block = match &sweep {
            Some(sweep) => Rc::new(self.block(candidate, Some((sweep.from_deg, sweep.to_deg)))),
            None => {
                let mut whole_arcs = self.whole_arcs.borrow_mut();
                let known = whole_arcs
                    .entry(candidate)
                    .or_insert_with(|| WholeArc { block: Rc::new(self.block(candidate, None)), alone: Vec::new() });
                known.block.clone()
            }
        };
        Entry { candidate, block, sweep, at_most_deg: None, indexed_about: None }
    }

    /// A candidate's information over an arc that its clear sweep does not exceed.
    pub fn entry_at_most(&self, candidate: &'a Candidate, arc: &SampledArc) -> Entry<'a> {
        let at_most_deg = arc.capture_deg();
        let whole = self.entry(candidate, None);
        match arc.is_whole() {
            true => Entry { at_most_deg: Some(at_most_deg), ..whole },
            false => {
                let block = Rc::new(self.block(candidate, Some(at_most_deg)));
                Entry { block, at_most_deg: Some(at_most_deg), ..whole }
            }
        }
    }

    /// Variances of the wanted errors if this test were the first, pivots and bars unknown.
    pub fn variances_alone(&self, entry: &Entry, before: &Posterior) -> Vec<f64> {
        let mut whole_arcs = self.whole_arcs.borrow_mut();
        match whole_arcs.get_mut(&std::ptr::from_ref(entry.candidate)).filter(|_| entry.is_whole()) {
            Some(known) if known.alone.is_empty() => {
                known.alone = before.variances_with(&entry.block);
                known.alone.clone()
            }
            Some(known) => known.alone.clone(),
            None => before.variances_with(&entry.block),
        }
    }

    fn block(&self, candidate: &Candidate, arc_deg: Option<(f64, f64)>) -> Block {
        let (from, to) = match arc_deg {
            Some((from_deg, to_deg)) => (from_deg.to_radians(), to_deg.to_radians()),
            None => (candidate.from, candidate.to),
        };
        let site = self.context.site(candidate.site);
        let place = &self.context.all.places[candidate.place];
        let link = &self.context.bodies.mounts[site.mount].link;
        let balls = Balls {
            pivot: (site.link, link.as_str(), &site.at),
            spindle: (place.link, &place.at),
            bar_mm: candidate.bar_mm,
        };
        if candidate.is_plain() {
            return self.context.unknowns.turn_block(
                &self.context.geometry,
                balls,
                |angle| candidate.pose(angle),
                (from, to),
            );
        }
        let poses: Vec<Vec<f64>> = (0..BLOCK_ROWS).map(|row| candidate.pose(place_in_arc(from, to, row))).collect();
        self.context.unknowns.block(&self.context.geometry, balls, &poses, to - from)
    }

    /// What a test costs beside what is mounted already: its minutes, and some for a run in straight blocks.
    pub fn cost(&self, entry: &Entry, mounted: &Posterior) -> f64 {
        let in_blocks = is_in_blocks(self.context.machine, entry.candidate);
        self.minutes(entry, mounted) + if in_blocks { BLOCKS_MIN } else { 0.0 }
    }

    /// Minutes that a test adds to what is mounted already.
    pub fn minutes(&self, entry: &Entry, mounted: &Posterior) -> f64 {
        let mounting: f64 = entry
            .block
            .nuisances
            .iter()
            .map(|part| match part.of {
                Nuisance::Stand(_) | Nuisance::Scale(_) => 0.0,
                _ if mounted.knows(part) => 0.0,
                Nuisance::Pivot(..) => PIVOT_MIN,
                Nuisance::SpindleBall(_) => SPINDLE_MIN,
                Nuisance::Bar(_) => BAR_MIN,
            })
            .sum();
        let index = if entry.indexed_about.is_some() { INDEX_MIN } else { 0.0 };
        mounting + index + self.run_minutes(entry)
    }

    /// Both directions of a test, min.
    pub fn run_minutes(&self, entry: &Entry) -> f64 {
        let sweep_deg = entry.sweep.as_ref().map(|sweep| (sweep.from_deg, sweep.to_deg));
        let arc = match sweep_deg.or(entry.at_most_deg) {
            Some((from_deg, to_deg)) => (to_deg - from_deg).to_radians(),
            None => entry.candidate.to - entry.candidate.from,
        };
        let way = (arc + 2.0 * RUN_IN.to_radians()) * entry.candidate.way_radius_mm();
        let feed = feed_mm_per_min(self.context.machine, entry.candidate, self.context.settings.feed_mm_per_min);
        2.0 * (way / feed + RUN_MIN)
    }

    /// Σ ln max(σ², goal²).
    pub fn worth(&self, variances: &[f64]) -> f64 {
        // with time to spend there is no "good enough"
        let enough = if self.budget.is_some() { 0.1 } else { 1.0 };
        variances.iter().zip(&self.goals).map(|(variance, goal)| variance.max((enough * goal).powi(2)).ln()).sum()
    }

    /// As good and no dearer; with time given, more errors determined, or as many and those better.
    pub(crate) fn is_better(&self, one: &Reached, other: &Reached) -> bool {
        let as_good = one.determined >= other.determined && one.worth <= other.worth + SAME_WORTH;
        match self.budget {
            Some(_) => {
                let more = one.determined.cmp(&other.determined);
                more.is_gt() || more.is_eq() && one.worth < other.worth
            }
            None => as_good && one.cost <= other.cost,
        }
    }

    /// What a choice reaches and costs.
    pub fn reached(&self, choice: &Choice) -> Reached {
        let blocks: Vec<&Block> = choice.chosen.iter().map(|&k| &*choice.entries[k].block).collect();
        let mut posterior = Posterior::before_with_loose_setups(&self.context.unknowns);
        let (mut minutes, mut cost) = (0.0, 0.0);
        for &k in &choice.chosen {
            minutes += self.minutes(&choice.entries[k], &posterior);
            cost += self.cost(&choice.entries[k], &posterior);
            posterior.add(&choice.entries[k].block);
        }
        let pivots: HashSet<usize> = choice.chosen.iter().map(|&k| choice.entries[k].candidate.site).collect();
        Reached {
            determined: fitted(&self.context.unknowns, &blocks).iter().filter(|error| error.is_determined()).count(),
            worth: self.worth(&posterior.variances()),
            minutes,
            cost,
            pivots: pivots.len(),
        }
    }
}

/// The goal for each wanted error, mm and rad.
pub(crate) fn goals(unknowns: &Unknowns, goal: &Goal) -> Vec<f64> {
    let of = |component: usize| if component >= 3 { goal.orientation_rad } else { goal.position_mm };
    unknowns.errors[..unknowns.wanted].iter().map(|&(_, component, _)| of(component)).collect()
}
