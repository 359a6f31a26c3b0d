//! Tests chosen one by one by gain per minute, pairs where single ones bring nothing, needless ones dropped. It places nothing.
//!
//! Gains of earlier rounds are upper bounds (information only shrinks as more is known, and a shortened sweep only loses),
//! so most candidates are never looked at again. Gain is the fall of Σ ln max(σᵢ², goalᵢ²) over the wanted errors.

use std::collections::{BTreeMap, BinaryHeap};

use super::under_way::{LEAST_GAIN, SEEN, Search};
use crate::plan::context::choice::{Choice, Entry};
use crate::plan::context::evaluation::{Evaluation, MAX_FAILURES};
use crate::plan::information::block::Block;
use crate::plan::information::fitted::{Fitted, fitted};
use crate::plan::information::posterior::Posterior;
use crate::plan::places::candidate::Candidate;
use crate::plan::places::drive::Drive;

/// Times that goals are tightened for errors that rest on priors, and by which factor.
const TIGHTENINGS: usize = 8;
const TIGHTER: f64 = 0.7;
/// Most tests of a plan.
const MAX_TESTS: usize = 24;

/// Gains per minute closer than this are equal: rounding must not choose between setups that mirror each other.
const SAME_RATE: f64 = 1e-9;

/// Heap order: gain per minute, then the candidate's place in the list so that plans repeat.
struct Bound {
    /// Gain per minute in steps of what counts as equal.
    rate: f64,
    order: (u64, usize),
    /// In which round it was found.
    round: usize,
}

impl Bound {
    fn new(rate: f64, k: usize, round: usize) -> Bound {
        Bound { rate: (rate / SAME_RATE).round(), order: scatter(k), round }
    }
}

impl PartialEq for Bound {
    fn eq(&self, other: &Bound) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Bound {}
impl PartialOrd for Bound {
    fn partial_cmp(&self, other: &Bound) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Bound {
    fn cmp(&self, other: &Bound) -> std::cmp::Ordering {
        self.rate.total_cmp(&other.rate).then(other.order.cmp(&self.order))
    }
}

/// Breaks ties apart: neighbours in the list tend to fail for the same reason.
fn scatter(index: usize) -> (u64, usize) {
    ((index as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15), index)
}

impl<'a> Evaluation<'a> {
    /// Chooses tests one by one from a list.
    pub(crate) fn greedy(&mut self, list: impl Iterator<Item = &'a Candidate>) -> Choice<'a> {
        self.greedy_from(list, &Choice::default())
    }

    /// Chooses tests one by one from a list after those of another choice, as far as these fit in the time.
    pub(crate) fn greedy_from(&mut self, list: impl Iterator<Item = &'a Candidate>, base: &Choice<'a>) -> Choice<'a> {
        let entries: Vec<Entry<'a>> = list.map(|candidate| self.entry(candidate, None)).collect();
        let mut search = Search {
            dead: vec![false; entries.len()],
            entries,
            posterior: Posterior::before_with_loose_setups(&self.context.unknowns),
            chosen: Vec::new(),
            failures: BTreeMap::new(),
            minutes: 0.0,
        };
        for &k in &base.chosen {
            self.take_again(&mut search, &base.entries[k]);
        }
        if self.context.settings.coupled.circles && base.chosen.is_empty() {
            self.take_circles(&mut search);
        }
        self.extend(&mut search);
        if self.budget.is_none() {
            let goals = self.goals.clone();
            for _ in 0..TIGHTENINGS {
                if !self.tighten(&search, &goals) {
                    break;
                }
                self.extend(&mut search);
            }
            self.drop_needless(&search.entries, &mut search.chosen);
            self.goals = goals;
        }
        Choice { entries: search.entries, chosen: search.chosen }
    }

    /// Asks for more of errors that tests see but whose sigma rests on how well pivots and bars are known; false: there are none.
    fn tighten(&mut self, search: &Search, goals: &[f64]) -> bool {
        let blocks: Vec<&Block> = search.chosen.iter().map(|&k| &*search.entries[k].block).collect();
        let seen = search.posterior.variances();
        let mut tightened = false;
        for (k, Fitted { prior_share, sigma }) in fitted(&self.context.unknowns, &blocks).into_iter().enumerate() {
            if prior_share >= self.context.settings.sure_share && seen[k] < (SEEN * goals[k]).powi(2) {
                self.goals[k] = TIGHTER * sigma;
                tightened = true;
            }
        }
        tightened
    }

    /// Takes tests as long as one pays.
    fn extend(&mut self, search: &mut Search<'a>) {
        let count = search.entries.len();
        let mut gains = vec![f64::MAX; count];
        let alive = |dead: &[bool]| -> BinaryHeap<Bound> {
            (0..count).filter(|k| !dead[*k]).map(|k| Bound::new(f64::MAX, k, 0)).collect()
        };
        let mut heap = alive(&search.dead);
        let (mut round, mut worth) = (1, self.worth(&search.posterior.variances()));
        while let Some(Bound { order: (_, k), round: seen, .. }) = heap.pop() {
            if search.dead[k] || search.chosen.len() >= MAX_TESTS || !self.may_mount(search, k) {
                continue;
            }
            let cost = self.cost(&search.entries[k], &search.posterior);
            let minutes = || search.minutes + self.minutes(&search.entries[k], &search.posterior);
            if self.budget.is_some_and(|budget| minutes() > budget) {
                continue;
            }
            if seen < round {
                let entry = &search.entries[k];
                gains[k] = worth
                    - match search.chosen.is_empty() {
                        true => self.worth(&self.variances_alone(entry, &search.posterior)),
                        false => self.worth(&search.posterior.variances_with(&entry.block)),
                    };
                heap.push(Bound::new(gains[k] / cost, k, round));
                continue;
            }
            if gains[k] / cost <= LEAST_GAIN {
                // one test alone brings nothing; two from one pivot may
                let pair = self.best_pair(search, worth).or_else(|| match self.tries_all_pairs {
                    true => self.clear_pair(search, worth),
                    false => None,
                });
                let Some(pair) = pair.filter(|_| search.chosen.len() + 2 <= MAX_TESTS) else { break };
                pair.into_iter().for_each(|k| self.take(search, k));
                worth = self.worth(&search.posterior.variances());
                round += 1;
                gains.fill(f64::MAX);
                heap = alive(&search.dead);
                continue;
            }
            if search.entries[k].sweep.is_none() {
                let candidate = search.entries[k].candidate;
                if search.failures.get(&candidate.axis).is_some_and(|&count| count >= MAX_FAILURES) {
                    search.dead[k] = true;
                    continue;
                }
                // what samples leave of the arc bounds its gain; certified is what still leads
                let looked_at = match search.entries[k].at_most_deg {
                    None => self.sampled_entry(candidate),
                    Some(_) => self.cleared_entry(candidate),
                };
                match looked_at {
                    Some(entry) => {
                        search.entries[k] = entry;
                        heap.push(Bound::new(f64::MAX, k, 0));
                    }
                    None => {
                        search.dead[k] = true;
                        *search.failures.entry(candidate.axis).or_default() += 1;
                    }
                }
                continue;
            }
            self.take(search, k);
            worth = self.worth(&search.posterior.variances());
            round += 1;
            // gains only fall, but costs fall too when a setup is mounted: bounds anew
            heap = (0..count)
                .filter(|k| !search.dead[*k])
                .map(|k| Bound::new(gains[k] / self.cost(&search.entries[k], &search.posterior), k, 0))
                .collect();
        }
    }

    /// Drops tests without which the wanted errors are as good, dearest first.
    fn drop_needless(&self, entries: &[Entry], chosen: &mut Vec<usize>) {
        let worth_of = |set: &[usize]| {
            let mut posterior = Posterior::before_with_loose_setups(&self.context.unknowns);
            set.iter().for_each(|&k| posterior.add(&entries[k].block));
            self.worth(&posterior.variances())
        };
        let full = worth_of(chosen);
        let mut place = 0;
        while place < chosen.len() {
            let mut without = chosen.clone();
            let wanted = matches!(entries[without.remove(place)].candidate.drive, Drive::Circle(..));
            // a thousandth of a factor e in one error
            if !wanted && worth_of(&without) <= full + 1e-3 {
                *chosen = without;
            } else {
                place += 1;
            }
        }
    }
}
