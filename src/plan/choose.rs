//! The desk on which candidates are weighed: what each tells, what it costs, which of two choices is better. Which are taken is `greedy`'s and `method`'s.

use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::hash::BuildHasherDefault;
use std::rc::Rc;

use super::approach::Parking;
use super::candidates::{Candidate, Candidates, candidates_at};
use super::finer::Finer;
use super::indexed::{INDEX_MIN, IndexError};
use super::information::{BLOCK_ROWS, Balls, Block, Nuisance, Unknowns, place_in_arc};
use super::knowledge::{Knowledge, Mix};
use super::method::{Method, MethodError, method_choice};
use super::out_of_reach::{self, OutOfReach};
use super::pace::feed_mm_per_min;
use super::places::Offer;
use super::planned::Plan;
use super::reach::ClearArc;
use super::run_in::RUN_IN;
use super::searches::Found;
use super::settings::{Goal, Settings};
use super::sight::{Sight, sights};
use super::words::fitted;
use crate::bodies::{Bodies, Kit};
use crate::chain::{Chain, Geometry};
use crate::collision::{Scratch, World};
use crate::machine::Machine;

/// Minutes to mount and align a pivot.
const PIVOT_MIN: f64 = 8.0;
/// Minutes to change the spindle cup or fixture.
const SPINDLE_MIN: f64 = 4.0;
/// Minutes to change the bar's length and calibrate it.
const BAR_MIN: f64 = 3.0;
/// Minutes around each run: approach, trigger, retreat.
const RUN_MIN: f64 = 0.5;
/// Differences of Σ ln max(σ², goal²) that are none: undetermined errors shift a little with the number of pivots.
pub(super) const SAME_WORTH: f64 = 0.02;
/// Setups of one axis that may prove not clear before the rest is given up.
pub(super) const MAX_FAILURES: usize = 1500;

/// A candidate with what is known of it by now.
#[derive(Clone)]
pub(super) struct Entry<'c> {
    pub candidate: &'c Candidate,
    pub block: Rc<Block>,
    pub sweep: Option<ClearArc>,
    /// Direction of R about which the spindle is indexed by 180° for this run.
    pub indexed_about: Option<usize>,
}

/// Candidates looked at and the indices of those chosen, in order.
#[derive(Default)]
pub(super) struct Choice<'c> {
    pub entries: Vec<Entry<'c>>,
    pub chosen: Vec<usize>,
}

impl<'c> Choice<'c> {
    /// The chosen entries alone.
    pub fn without_rest(&self) -> Choice<'c> {
        let entries: Vec<Entry<'c>> = self.chosen.iter().map(|&k| self.entries[k].clone()).collect();
        Choice { chosen: (0..entries.len()).collect(), entries }
    }
}

/// What the whole arc of a candidate tells: the same setup comes up in every search.
pub(super) struct Told {
    block: Rc<Block>,
    /// Variances of the wanted errors with this test alone; empty until asked for.
    alone: Vec<f64>,
}

/// What a choice reaches and costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reached {
    /// Errors determined.
    pub determined: usize,
    /// Σ ln max(σ², goal²) with pivots and bars unknown.
    pub worth: f64,
    pub minutes: f64,
    pub pivots: usize,
}

/// What a choice would take and reach if time were no limit, by wanted error.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Untimed {
    pub minutes: f64,
    pub determined: Vec<bool>,
    /// The goal, given the spindle ball.
    pub reaches: Vec<bool>,
    /// Why it is not determined with all the time that pays.
    pub reasons: Vec<Option<String>>,
}

/// Something known of candidates, by their address in `all`.
type ByCandidate<T> = HashMap<*const Candidate, T, BuildHasherDefault<Mix>>;

/// What evaluating candidates needs.
pub(super) struct Desk<'a> {
    pub machine: &'a Machine,
    pub bodies: &'a Bodies,
    pub kit: &'a Kit,
    pub settings: &'a Settings,
    pub geometry: Geometry<'a>,
    /// Pairs of bodies that may come as near as the margin; setups are looked for among these.
    pub world: &'a World,
    /// All pairs of bodies; clearances are told of these.
    pub whole_world: &'a World,
    pub unknowns: Unknowns,
    pub all: &'a Candidates,
    /// Places and setups that were added as a choice was refined.
    pub finer: &'a Finer,
    pub parking: Parking,
    pub scratch: Scratch,
    /// Time that is to be filled, min; `None`: tests until the goals are reached.
    pub budget: Option<f64>,
    /// Standard deviations wanted of the wanted errors, mm and rad.
    pub goals: Vec<f64>,
    /// For each wanted error: what lengths of reachable setups show of it if nothing stands in their way.
    pub sights: Vec<Sight>,
    /// Arcs found before, by the candidate's address in `all`: the same setup comes up in several searches.
    pub arcs: ByCandidate<Option<ClearArc>>,
    /// What whole arcs tell, by the candidate's address in `all`, and the variances that they leave alone: likewise.
    pub told: RefCell<ByCandidate<Told>>,
    /// Variances of the wanted errors that all setups of a pivot place would leave, by place: every goal ranks by them.
    pub promises: RefCell<BTreeMap<usize, Vec<f64>>>,
    /// The choice without a limit on time, where it does not fit in the time allowed.
    pub untimed: Option<Untimed>,
    /// All pairs of clear setups are tried where nothing else shows an error.
    pub tries_all_pairs: bool,
    /// Some runs have the spindle indexed.
    pub is_indexed: bool,
    /// By axis: how often a pair ended or forbade a sweep.
    pub forbidden: BTreeMap<usize, HashMap<(String, String), usize>>,
    /// The same for the ways to the starts of sweeps that would be clear.
    pub blocked_ways: BTreeMap<usize, HashMap<(String, String), usize>>,
}

/// Plans the tests of a machine; `Err` when a method does not fit the machine.
pub fn plan(machine: &Machine, bodies: &Bodies, kit: &Kit, settings: &Settings) -> Result<Plan, PlanError> {
    at_desk(machine, bodies, kit, settings, |mut desk| {
        let about = if settings.index_spindle { Some(desk.spindle_direction()?) } else { None };
        let (mut choice, one_pivot) = match (settings.method, settings.pivots) {
            (Some(method), _) => (method_choice(&mut desk, method)?, None),
            (None, _) => desk.searched(),
        };
        if let Some(about) = about {
            desk.repeat_indexed(&mut choice, about);
            desk.is_indexed = choice.entries.iter().any(|entry| entry.indexed_about.is_some());
        }
        Ok(Plan { one_pivot, ..desk.finish(choice) })
    })
}

/// For each wanted error: lengths of setups within reach show it. Nothing is chosen, so it takes a part of a plan's time.
pub(super) fn seen(machine: &Machine, bodies: &Bodies, kit: &Kit, settings: &Settings) -> Result<Vec<bool>, PlanError> {
    at_desk(machine, bodies, kit, settings, |desk| Ok(desk.sights.iter().map(|sight| sight.is_seen).collect()))
}

/// Lays out what a plan is made from.
fn at_desk<T>(
    machine: &Machine,
    bodies: &Bodies,
    kit: &Kit,
    settings: &Settings,
    work: impl for<'a> FnOnce(Desk<'a>) -> Result<T, PlanError>,
) -> Result<T, PlanError> {
    let chain = Chain::of(machine);
    let whole_world = World::new(&chain, bodies).map_err(PlanError::Bodies)?;
    whole_world.refuse_overlaps(machine).map_err(PlanError::Bodies)?;
    whole_world.refuse_always_near(machine, settings.margin_mm).map_err(PlanError::Bodies)?;
    let world = whole_world.without_settled_pairs(machine, settings.margin_mm);
    let offer = match settings.method {
        None => Offer::Spread,
        Some(Method::Chapter5) => Offer::Common,
        Some(_) => Offer::Level,
    };
    let all = candidates_at(machine, bodies, kit, &settings.avoid, &settings.coupled, offer);
    out_of_reach::refuse(machine, bodies, kit, &all)?;
    let finer = Finer::new();
    let unknowns = match settings.coupled.circles {
        true => Unknowns::with_squareness(machine, settings.uncertainty),
        false => Unknowns::of(machine, settings.uncertainty),
    };
    let mut desk = Desk {
        budget: settings.goal.minutes,
        goals: goals(&unknowns, &settings.goal),
        machine,
        bodies,
        kit,
        settings,
        geometry: Geometry::nominal(&chain),
        world: &world,
        whole_world: &whole_world,
        unknowns,
        all: &all,
        finer: &finer,
        parking: Parking::of(machine, bodies, &settings.avoid),
        scratch: Scratch::default(),
        sights: Vec::new(),
        arcs: ByCandidate::default(),
        told: RefCell::default(),
        promises: RefCell::default(),
        untimed: None,
        tries_all_pairs: true,
        is_indexed: false,
        forbidden: BTreeMap::new(),
        blocked_ways: BTreeMap::new(),
    };
    desk.sights = sights(&desk);
    work(desk)
}

impl<'a> Desk<'a> {
    /// As many pivots as pay, or the one pivot from which all that can be had as quickly; and what one pivot reaches.
    pub(super) fn free_choice(&mut self) -> Found<'a> {
        let list: &'a [Candidate] = &self.all.list;
        let mut free = self.greedy(list.iter()).without_rest();
        let mut reached = self.reached(&free);
        if free.entries.iter().any(|entry| !entry.candidate.is_plain()) {
            // what pays at first is not always cheapest in the end: linear axes may stand still in all tests
            let plain = self.greedy(list.iter().filter(|candidate| !candidate.follows())).without_rest();
            let from_plain = self.reached(&plain);
            if self.is_better(&from_plain, &reached) {
                (free, reached) = (plain, from_plain);
            }
        }
        if reached.pivots < 2 {
            return Found { choice: free, one_pivot: None };
        }
        let one = self.one_pivot_choice().without_rest();
        let from_one = self.reached(&one);
        if self.is_better(&from_one, &reached) {
            return Found { choice: one, one_pivot: None };
        }
        Found { choice: free, one_pivot: (from_one.pivots == 1).then_some(one) }
    }

    /// As good and no dearer; with time given, more errors determined, or as many and those better.
    pub(super) fn is_better(&self, one: &Reached, other: &Reached) -> bool {
        let as_good = one.determined >= other.determined && one.worth <= other.worth + SAME_WORTH;
        match self.budget {
            Some(_) => {
                let more = one.determined.cmp(&other.determined);
                more.is_gt() || more.is_eq() && one.worth < other.worth
            }
            None => as_good && one.minutes <= other.minutes,
        }
    }

    /// What a choice reaches and costs.
    pub fn reached(&self, choice: &Choice) -> Reached {
        let blocks: Vec<&Block> = choice.chosen.iter().map(|&k| &*choice.entries[k].block).collect();
        let mut knowledge = Knowledge::before_with_loose_setups(&self.unknowns);
        let mut minutes = 0.0;
        for &k in &choice.chosen {
            minutes += self.cost(&choice.entries[k], &knowledge);
            knowledge.add(&choice.entries[k].block);
        }
        let pivots: HashSet<usize> = choice.chosen.iter().map(|&k| choice.entries[k].candidate.site).collect();
        Reached {
            determined: fitted(self, &blocks).iter().filter(|error| error.is_determined()).count(),
            worth: self.worth(&knowledge.variances()),
            minutes,
            pivots: pivots.len(),
        }
    }
}

/// The goal for each wanted error, mm and rad.
pub(super) fn goals(unknowns: &Unknowns, goal: &Goal) -> Vec<f64> {
    let of = |component: usize| if component >= 3 { goal.orientation_rad } else { goal.position_mm };
    unknowns.errors[..unknowns.wanted].iter().map(|&(_, component, _)| of(component)).collect()
}

/// Why no plan was made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlanError {
    #[error("{0}")]
    Bodies(String),
    #[error("{0}")]
    Method(#[from] MethodError),
    #[error("{0}")]
    Index(#[from] IndexError),
    #[error("{0}")]
    OutOfReach(#[from] OutOfReach),
}

impl<'a> Desk<'a> {
    /// A candidate's information over its sweep.
    pub fn entry(&self, candidate: &'a Candidate, sweep: Option<ClearArc>) -> Entry<'a> {
        let block = match sweep {
            Some(_) => Rc::new(self.block(candidate, sweep.as_ref())),
            None => {
                let mut told = self.told.borrow_mut();
                let known = told
                    .entry(candidate)
                    .or_insert_with(|| Told { block: Rc::new(self.block(candidate, None)), alone: Vec::new() });
                known.block.clone()
            }
        };
        Entry { candidate, block, sweep, indexed_about: None }
    }

    /// Variances of the wanted errors if this test were the first, pivots and bars unknown.
    pub fn variances_alone(&self, entry: &Entry, before: &Knowledge) -> Vec<f64> {
        let mut told = self.told.borrow_mut();
        match told.get_mut(&std::ptr::from_ref(entry.candidate)).filter(|_| entry.sweep.is_none()) {
            Some(known) if known.alone.is_empty() => {
                known.alone = before.variances_with(&entry.block);
                known.alone.clone()
            }
            Some(known) => known.alone.clone(),
            None => before.variances_with(&entry.block),
        }
    }

    fn block(&self, candidate: &Candidate, sweep: Option<&ClearArc>) -> Block {
        let (from, to) = match sweep {
            Some(clear) => (clear.from_deg.to_radians(), clear.to_deg.to_radians()),
            None => (candidate.from, candidate.to),
        };
        let site = self.site(candidate.site);
        let place = &self.all.places[candidate.place];
        let link = &self.bodies.mounts[site.mount].link;
        let balls = Balls {
            pivot: (site.link, link.as_str(), &site.at),
            spindle: (place.link, &place.at),
            bar_mm: candidate.bar_mm,
        };
        if candidate.is_plain() {
            return self.unknowns.turn_block(&self.geometry, balls, |angle| candidate.pose(angle), (from, to));
        }
        let poses: Vec<Vec<f64>> = (0..BLOCK_ROWS).map(|row| candidate.pose(place_in_arc(from, to, row))).collect();
        self.unknowns.block(&self.geometry, balls, &poses, to - from)
    }

    /// Minutes that a test adds to what is mounted already.
    pub fn cost(&self, entry: &Entry, mounted: &Knowledge) -> f64 {
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
        let arc = entry
            .sweep
            .as_ref()
            .map_or(entry.candidate.to - entry.candidate.from, |sweep| (sweep.to_deg - sweep.from_deg).to_radians());
        let way = (arc + 2.0 * RUN_IN.to_radians()) * entry.candidate.way_radius_mm();
        let feed = feed_mm_per_min(self.machine, entry.candidate, self.settings.feed_mm_per_min);
        2.0 * (way / feed + RUN_MIN)
    }

    /// Σ ln max(σ², goal²).
    pub fn worth(&self, variances: &[f64]) -> f64 {
        // with time to spend there is no "good enough"
        let enough = if self.budget.is_some() { 0.1 } else { 1.0 };
        variances.iter().zip(&self.goals).map(|(variance, goal)| variance.max((enough * goal).powi(2)).ln()).sum()
    }
}
