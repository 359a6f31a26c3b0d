//! Two tests from one pivot that tell together what neither tells alone. Which tests are kept is `greedy`'s.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use super::under_way::{LEAST_GAIN, SEEN, Search};
use crate::plan::context::evaluation::Evaluation;

/// Groups of setups with one pivot and ball, members of each, and pairs checked when single tests bring nothing.
const PAIR_GROUPS: usize = 120;
const PAIR_MEMBERS: usize = 6;
const PAIR_CHECKS: usize = 1500;
/// Members of each pivot's clear setups that are paired when an error is still missing.
const CLEAR_MEMBERS: usize = 24;

impl<'a> Evaluation<'a> {
    /// The pair of clear tests from one pivot and one spindle ball with the greatest gain per minute, if any has one.
    pub(crate) fn best_pair(&mut self, search: &mut Search<'a>, worth: f64) -> Option<[usize; 2]> {
        let usable: Vec<bool> =
            (0..search.entries.len()).map(|k| !search.dead[k] && self.may_mount(search, k)).collect();
        let mut groups: BTreeMap<(usize, usize, usize), Vec<usize>> = BTreeMap::new();
        for (k, entry) in search.entries.iter().enumerate().filter(|(k, _)| usable[*k]) {
            let c = entry.candidate;
            groups.entry((c.axis, c.site, c.place)).or_default().push(k);
        }
        let mut pairs: Vec<(f64, [usize; 2])> = Vec::new();
        for axis in groups.keys().map(|key| key.0).collect::<std::collections::BTreeSet<_>>() {
            let mine: Vec<&Vec<usize>> =
                groups.iter().filter(|(key, group)| key.0 == axis && group.len() > 1).map(|(_, group)| group).collect();
            let stride = mine.len().div_ceil(PAIR_GROUPS).max(1);
            for group in mine.iter().step_by(stride) {
                let reach = group.len().div_ceil(PAIR_MEMBERS).max(1);
                let members: Vec<usize> = group.iter().step_by(reach).copied().collect();
                pairs.extend(self.gaining_pairs(search, worth, &members));
            }
        }
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut refused: HashSet<usize> = HashSet::new();
        for (bound, pair) in pairs.into_iter().take(PAIR_CHECKS) {
            if pair.iter().any(|k| refused.contains(k)) {
                continue;
            }
            let mut both = true;
            for k in pair {
                if both && search.entries[k].sweep.is_none() {
                    match self.cleared_entry(search.entries[k].candidate) {
                        Some(entry) => search.entries[k] = entry,
                        None => {
                            refused.insert(k);
                            both = false;
                        }
                    }
                }
            }
            if !both {
                continue;
            }
            // shortened sweeps tell less: half of what was promised is still worth taking
            if self.gaining_pairs(search, worth, &pair).first().is_some_and(|(rate, _)| *rate > 0.5 * bound) {
                return Some(pair);
            }
        }
        None
    }

    /// The best pair among all setups that are clear, for axes with errors that are still missing although lengths show them.
    pub(crate) fn clear_pair(&mut self, search: &mut Search<'a>, worth: f64) -> Option<[usize; 2]> {
        let variances = search.posterior.variances();
        let axes: BTreeSet<usize> = (0..self.context.unknowns.wanted)
            .filter(|&k| self.observability[k].is_seen && variances[k] > (SEEN * self.goals[k]).powi(2))
            .map(|k| self.context.unknowns.errors[k].0)
            .collect();
        let members = |group: &Vec<usize>| -> Vec<usize> {
            group.iter().step_by(group.len().div_ceil(CLEAR_MEMBERS)).copied().collect()
        };
        loop {
            let mut groups: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
            for k in 0..search.entries.len() {
                let candidate = search.entries[k].candidate;
                if !search.dead[k]
                    && axes.contains(&candidate.axis)
                    && self.may_mount(search, k)
                    && self.may_be_clear(search, k)
                {
                    groups.entry((candidate.axis, candidate.site)).or_default().push(k);
                }
            }
            let mut pairs: Vec<(f64, [usize; 2])> =
                groups.values().flat_map(|group| self.gaining_pairs(search, worth, &members(group))).collect();
            // the first of equals, so that plans repeat
            pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            let (best, all_clear) = self.best_clear(search, worth, &pairs);
            if best.is_some() || all_clear {
                return best;
            }
        }
    }

    /// The best of pairs that are clear, from what samples promise of them, best first; and whether all looked at are clear.
    fn best_clear(
        &mut self,
        search: &mut Search<'a>,
        worth: f64,
        pairs: &[(f64, [usize; 2])],
    ) -> (Option<[usize; 2]>, bool) {
        let (mut best, mut all_clear): (Option<(f64, [usize; 2])>, bool) = (None, true);
        for &(promise, pair) in pairs {
            if best.is_some_and(|(rate, _)| rate >= promise) {
                break;
            }
            if !pair.iter().all(|&k| self.is_clear(search, k)) {
                all_clear = false;
                continue;
            }
            if let Some(&(rate, _)) = self.gaining_pairs(search, worth, &pair).first()
                && best.is_none_or(|(best, _)| rate > best)
            {
                best = Some((rate, pair));
            }
        }
        (best.map(|(_, pair)| pair), all_clear)
    }

    /// Pairs of members that fit in the time left and gain enough, with their gain per minute.
    fn gaining_pairs(&self, search: &Search, worth: f64, members: &[usize]) -> Vec<(f64, [usize; 2])> {
        let mut pairs = Vec::new();
        for (place, &one) in members.iter().enumerate() {
            let mut with_one = search.posterior.clone();
            with_one.add(&search.entries[one].block);
            let first = &search.entries[one];
            let (first_cost, first_min) = (self.cost(first, &search.posterior), self.minutes(first, &search.posterior));
            for &other in &members[place + 1..] {
                let second = &search.entries[other];
                let cost = first_cost + self.cost(second, &with_one);
                let gain = worth - self.worth(&with_one.variances_with(&second.block));
                let minutes = || search.minutes + first_min + self.minutes(second, &with_one);
                let fits = self.budget.is_none_or(|budget| minutes() <= budget);
                if fits && gain / cost > LEAST_GAIN {
                    pairs.push((gain / cost, [one, other]));
                }
            }
        }
        pairs
    }
}
