//! A choice made cheaper, with tests fewer and quicker ones: pivots are shifted, standing axes turned, tests exchanged.
//!
//! A set of tests is weighed by its minutes and, at a price, by what it leaves open of what is demanded, so that a search may go
//! through sets that do not meet the demand to cheaper ones that do.
//! What a move would tell is worked out first, which takes microseconds; only moves that promise most are checked for
//! collisions. It ends where no move helps or the checks are used up: what it does not find may exist.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::DMatrix;

use super::part::Demand;
use crate::machine::AxisKind;
use crate::plan::context::choice::{Choice, Entry};
use crate::plan::context::evaluation::Evaluation;
use crate::plan::information::block::Part;
use crate::plan::information::posterior::Posterior;
use crate::plan::places::candidate::Candidate;
use crate::plan::reach::sweep_reach::ClearArc;

/// Sets of tests, each with another one left out, from which a cheaper choice is sought.
const STARTS: usize = 3;
/// Most setups checked for collisions for one choice, and for one start.
const MOST_CHECKS: usize = 240;
const CHECKS_OF_START: usize = 80;
/// First and last shift of pivots, mm, and turn of standing axes, deg.
const FIRST_STEP: f64 = 32.0;
const LAST_STEP: f64 = 4.0;
/// Shifts of a pivot that are taken for a start although they cost, mm.
const FAR_STEPS: [f64; 2] = [60.0, 30.0];
/// Moves of each kind that are checked before the next step.
const CHECKED: usize = 5;
/// What is left open below which a demand is met: Σ ln (σ/σ demanded).
const MET: f64 = 1e-9;
/// Minutes that a set may cost more for closing what is open by 1: a factor e in one error.
const PRICE_MIN: f64 = 4.0;
/// Least fall of the cost that is worth a move, min.
const LEAST_FALL: f64 = 0.02;
/// Singular value, as a share of the greatest, below which a combination of setup quantities is not seen.
const UNSEEN: f64 = 1e-6;

/// What a set of tests leaves open of a demand, and what it costs: its minutes, and some for runs in straight blocks.
#[derive(Debug, Clone, Copy)]
struct Standing {
    open: f64,
    minutes: f64,
}

impl Standing {
    fn meets(&self) -> bool {
        self.open <= MET
    }

    fn cost(&self) -> f64 {
        self.minutes + PRICE_MIN * self.open
    }
}

/// A set of tests under way.
#[derive(Clone)]
struct Set<'a> {
    tests: Vec<Entry<'a>>,
    standing: Standing,
}

/// For each test of a set the setup that takes its place, if another one does.
type Way<'a> = Vec<Option<&'a Candidate>>;

/// What a refinement is to reach and may spend.
struct Refinement<'d, 'a> {
    demand: &'d Demand,
    checks_left: usize,
    /// Setups by pivot place.
    setups: BTreeMap<usize, Vec<&'a Candidate>>,
}

impl<'a> Refinement<'_, 'a> {
    /// Counts the setups that a move looks at.
    fn spend(&mut self, others: &Way<'a>) {
        self.checks_left = self.checks_left.saturating_sub(others.iter().flatten().count());
    }
}

impl<'a> Evaluation<'a> {
    /// The choice, or a quicker one that meets the same demand.
    pub(crate) fn refined(&mut self, choice: Choice<'a>, demand: &Demand) -> Choice<'a> {
        let tests: Vec<Entry<'a>> = choice.chosen.iter().map(|&k| choice.entries[k].clone()).collect();
        let mut best = Set { standing: self.standing(&tests, demand), tests };
        if !best.standing.meets() {
            return choice;
        }
        let mut refinement = Refinement { demand, checks_left: MOST_CHECKS, setups: BTreeMap::new() };
        while let Some(cheaper) = self.with_one_less(&best, &mut refinement) {
            best = cheaper;
        }
        if let Some(quicker) = self.descend(best.clone(), &mut refinement) {
            best = quicker;
        }
        while let Some(quicker) = self.quicker_from_afar(&best, &mut refinement) {
            best = quicker;
        }
        Choice { chosen: (0..best.tests.len()).collect(), entries: best.tests }
    }

    /// A quicker set with one test less that meets the demand.
    fn with_one_less(&mut self, whole: &Set<'a>, refinement: &mut Refinement<'_, 'a>) -> Option<Set<'a>> {
        if whole.tests.len() < 2 {
            return None;
        }
        let mut starts: Vec<Set<'a>> = (0..whole.tests.len())
            .filter(|&k| !whole.tests[k].candidate.is_circle())
            .map(|k| {
                let mut tests = whole.tests.clone();
                tests.remove(k);
                Set { standing: self.standing(&tests, refinement.demand), tests }
            })
            .filter(|set| self.has_enough_rows(set, refinement.demand))
            .collect();
        starts.sort_by(|a, b| a.standing.open.total_cmp(&b.standing.open));
        let is_quicker = |set: &Set| set.standing.minutes < whole.standing.minutes - LEAST_FALL;
        starts.into_iter().take(STARTS).find_map(|start| self.descend(start, refinement).filter(is_quicker))
    }

    /// Rows enough for the errors demanded beside all that they see of pivots and bars.
    fn has_enough_rows(&self, set: &Set<'a>, demand: &Demand) -> bool {
        let rows: usize = set.tests.iter().map(|test| test.block.errors.nrows()).sum();
        let mut columns: Vec<(u64, usize)> = Vec::new();
        let fitted = |test: &Entry<'a>| -> Vec<Part> {
            test.block.nuisances.iter().filter(|part| part.of.is_fitted()).cloned().collect()
        };
        let mut width = 0;
        for part in set.tests.iter().flat_map(fitted) {
            if columns.iter().all(|(hash, _)| *hash != part.hash) {
                columns.push((part.hash, width));
                width += part.columns.ncols();
            }
        }
        let mut seen = DMatrix::zeros(rows, width);
        let mut row = 0;
        for test in &set.tests {
            for part in fitted(test) {
                if let Some((_, first)) = columns.iter().find(|(hash, _)| *hash == part.hash) {
                    seen.view_mut((row, *first), part.columns.shape()).copy_from(&part.columns);
                }
            }
            row += test.block.errors.nrows();
        }
        let values = seen.singular_values();
        let by_setups = values.iter().filter(|value| **value > UNSEEN * values.max()).count();
        rows >= demand.errors() + by_setups
    }

    /// The quickest set that meets the demand on the way down from a start, moving as long as the cost falls.
    fn descend(&mut self, mut set: Set<'a>, refinement: &mut Refinement<'_, 'a>) -> Option<Set<'a>> {
        let mut best = set.standing.meets().then(|| set.clone());
        let mut step = FIRST_STEP;
        let least_left = refinement.checks_left.saturating_sub(CHECKS_OF_START);
        while refinement.checks_left > least_left {
            let moved = self.exchanged(&set, refinement).or_else(|| self.shifted(&set, step, refinement));
            match moved {
                Some(better) => {
                    let is_quicker = |best: &Set| better.standing.minutes < best.standing.minutes;
                    if better.standing.meets() && best.as_ref().is_none_or(is_quicker) {
                        best = Some(better.clone());
                    }
                    set = better;
                }
                None if step > LAST_STEP => step *= 0.5,
                None => break,
            }
        }
        best
    }

    /// A quicker set that meets the demand, found on the way down from the present one with a pivot shifted far.
    fn quicker_from_afar(&mut self, set: &Set<'a>, refinement: &mut Refinement<'_, 'a>) -> Option<Set<'a>> {
        for step in FAR_STEPS {
            let mut moves = self.foreseen_moves(set, self.pivot_shifts(set, step), refinement.demand);
            moves.truncate(STARTS);
            for (_, others) in moves {
                if refinement.checks_left == 0 {
                    return None;
                }
                refinement.spend(&others);
                let Some(tests) = self.moved(set, &others, Self::cleared_entry) else { continue };
                let start = Set { standing: self.standing(&tests, refinement.demand), tests };
                let is_quicker = |found: &Set| found.standing.minutes < set.standing.minutes - LEAST_FALL;
                if let Some(found) = self.descend(start, refinement).filter(is_quicker) {
                    return Some(found);
                }
            }
        }
        None
    }

    /// The set with one test exchanged for another from a pivot that is mounted anyway.
    fn exchanged(&mut self, set: &Set<'a>, refinement: &mut Refinement<'_, 'a>) -> Option<Set<'a>> {
        let sites: BTreeSet<usize> = set.tests.iter().map(|test| test.candidate.site).collect();
        for &site in &sites {
            refinement.setups.entry(site).or_insert_with(|| self.setups_from(site, set));
        }
        let mut promises: Vec<(f64, usize, &'a Candidate)> = Vec::new();
        for out in (0..set.tests.len()).filter(|&k| !set.tests[k].candidate.is_circle()) {
            let mut posterior = Posterior::before_with_loose_setups(&self.context.unknowns);
            let mut minutes = 0.0;
            for (_, test) in set.tests.iter().enumerate().filter(|(k, _)| *k != out) {
                minutes += self.cost(test, &posterior);
                posterior.add(&test.block);
            }
            for &candidate in sites.iter().flat_map(|site| &refinement.setups[site]) {
                let Some(entry) = self.as_known(candidate) else { continue };
                let minutes = minutes + self.cost(&entry, &posterior);
                if minutes > set.standing.cost() - LEAST_FALL {
                    continue;
                }
                let open = refinement.demand.open(&posterior.variances_with(&entry.block));
                let promised = Standing { open, minutes }.cost();
                if promised < set.standing.cost() - LEAST_FALL {
                    promises.push((promised, out, candidate));
                }
            }
        }
        promises.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut best: Option<Set<'a>> = None;
        for (promise, out, candidate) in promises.into_iter().take(CHECKED) {
            if best.as_ref().is_some_and(|best| best.standing.cost() <= promise) {
                break;
            }
            let mut others: Way<'a> = vec![None; set.tests.len()];
            others[out] = Some(candidate);
            self.keep_if_clear(&mut best, set, &others, refinement);
        }
        best
    }

    /// The set with one of its pivots shifted, or a standing axis of a test turned.
    fn shifted(&mut self, set: &Set<'a>, step: f64, refinement: &mut Refinement<'_, 'a>) -> Option<Set<'a>> {
        let mut ways = self.pivot_shifts(set, step);
        ways.extend(self.turns(set, step));
        let mut best: Option<Set<'a>> = None;
        for (_, others) in self.foreseen_moves(set, ways, refinement.demand).into_iter().take(CHECKED) {
            self.keep_if_clear(&mut best, set, &others, refinement);
        }
        best
    }

    /// Moves in the order of what they would cost if arcs stayed as long as they are.
    fn foreseen_moves(&self, set: &Set<'a>, ways: Vec<Way<'a>>, demand: &Demand) -> Vec<(f64, Way<'a>)> {
        let cost = |others: &Way<'a>| {
            let foreseen: Vec<Entry<'a>> =
                set.tests.iter().zip(others).map(|(test, other)| self.foreseen(test, *other)).collect();
            self.standing(&foreseen, demand).cost()
        };
        let mut moves: Vec<(f64, Way<'a>)> = ways.into_iter().map(|others| (cost(&others), others)).collect();
        moves.sort_by(|a, b| a.0.total_cmp(&b.0));
        moves
    }

    /// Keeps a set after a move if it is clear and costs less than the one it came from and than the best so far.
    ///
    /// Samples tell first whether it can: no clear arc is longer than they leave.
    fn keep_if_clear(
        &mut self,
        best: &mut Option<Set<'a>>,
        set: &Set<'a>,
        others: &Way<'a>,
        refinement: &mut Refinement<'_, 'a>,
    ) {
        refinement.spend(others);
        let most = best.as_ref().map_or(set.standing.cost() - LEAST_FALL, |best| best.standing.cost());
        for look in [Self::as_sampled, Self::cleared_entry] {
            let Some(tests) = self.moved(set, others, look) else { return };
            let standing = self.standing(&tests, refinement.demand);
            if standing.cost() >= most {
                return;
            }
            if tests.iter().all(|test| test.sweep.is_some()) {
                *best = Some(Set { tests, standing });
                return;
            }
        }
    }

    /// The tests of a set after a move, each as a look at it shows it; `None` when one is not clear.
    fn moved(
        &mut self,
        set: &Set<'a>,
        others: &Way<'a>,
        look: fn(&mut Self, &'a Candidate) -> Option<Entry<'a>>,
    ) -> Option<Vec<Entry<'a>>> {
        let moved = set.tests.iter().zip(others).map(|(test, other)| match other {
            Some(other) => look(self, other),
            None => Some(test.clone()),
        });
        moved.collect()
    }

    /// A candidate with its clear arc where that is known, else with what samples leave of it.
    fn as_sampled(&mut self, candidate: &'a Candidate) -> Option<Entry<'a>> {
        self.sampled(candidate)?;
        self.as_known(candidate)
    }

    /// For each pivot and way: the setups of the tests that stand on it, from beside.
    fn pivot_shifts(&self, set: &Set<'a>, step_mm: f64) -> Vec<Way<'a>> {
        let sites: BTreeSet<usize> = set.tests.iter().map(|test| test.candidate.site).collect();
        let mut shifts = Vec::new();
        for &site in &sites {
            let mine = |test: &&Entry| test.candidate.site == site;
            if set.tests.iter().filter(mine).any(|test| test.candidate.is_circle()) {
                continue;
            }
            for way in 0..6 {
                let mut way_mm = [0.0; 3];
                way_mm[way / 2] = if way % 2 == 0 { step_mm } else { -step_mm };
                let Some(beside) = self.context.beside(site, way_mm) else { continue };
                let others: Option<Way<'a>> = set
                    .tests
                    .iter()
                    .map(|test| match mine(&test) {
                        true => self.context.same_from(test.candidate, beside, None).map(Some),
                        false => Some(None),
                    })
                    .collect();
                shifts.extend(others);
            }
        }
        shifts
    }

    /// For each test and standing rotary axis: the setup with that axis turned either way.
    fn turns(&self, set: &Set<'a>, step_deg: f64) -> Vec<Way<'a>> {
        let mut turns = Vec::new();
        for (k, test) in set.tests.iter().enumerate().filter(|(_, test)| !test.candidate.is_circle()) {
            let rotary = |axis: &usize| self.context.machine.axes[*axis].kind == AxisKind::Rotary;
            for axis in (0..self.context.machine.axes.len()).filter(rotary).filter(|&axis| axis != test.candidate.axis)
            {
                for by_deg in [step_deg, -step_deg] {
                    let turned = Some((axis, by_deg.to_radians()));
                    if let Some(other) = self.context.same_from(test.candidate, test.candidate.site, turned) {
                        turns.push((0..set.tests.len()).map(|place| (place == k).then_some(other)).collect());
                    }
                }
            }
        }
        turns
    }

    /// A moved test as long as its arc is now, as far as ranges let it.
    fn foreseen(&self, test: &Entry<'a>, moved: Option<&'a Candidate>) -> Entry<'a> {
        let (Some(moved), Some(arc)) = (moved, &test.sweep) else { return test.clone() };
        let from_deg = arc.from_deg.max(moved.from.to_degrees());
        let to_deg = arc.to_deg.min(moved.to.to_degrees()).max(from_deg);
        self.entry(moved, Some(ClearArc { from_deg, to_deg, ends: [None, None] }))
    }

    /// All setups from a pivot place.
    fn setups_from(&self, site: usize, set: &Set<'a>) -> Vec<&'a Candidate> {
        let list: &'a [Candidate] = &self.context.all.list;
        if site < self.context.all.sites.len() {
            return list.iter().filter(|candidate| candidate.site == site && !candidate.is_circle()).collect();
        }
        let like: Vec<&Candidate> = set.tests.iter().map(|test| test.candidate).collect();
        self.context.setups_at(site, &like).map(|list| list.iter().collect()).unwrap_or_default()
    }

    /// A candidate as far as it is known: with its clear arc, with what samples leave, or whole; `None` when it is not clear.
    fn as_known(&self, candidate: &'a Candidate) -> Option<Entry<'a>> {
        let address = std::ptr::from_ref(candidate);
        match (self.arcs.get(&address), self.sampled_arcs.get(&address)) {
            (Some(known), _) => known.clone().map(|arc| self.entry(candidate, Some(arc))),
            (None, Some(known)) => known.as_ref().map(|arc| self.entry_at_most(candidate, arc)),
            (None, None) => Some(self.entry(candidate, None)),
        }
    }

    fn standing(&self, tests: &[Entry<'a>], demand: &Demand) -> Standing {
        let mut posterior = Posterior::before_with_loose_setups(&self.context.unknowns);
        let mut minutes = 0.0;
        for test in tests {
            minutes += self.cost(test, &posterior);
            posterior.add(&test.block);
        }
        let open = demand.open(&posterior.variances());
        let by_priors = || demand.open_by_priors(self, tests.iter().map(|test| &*test.block).collect());
        Standing { open: if open > MET { open } else { by_priors() }, minutes }
    }
}
