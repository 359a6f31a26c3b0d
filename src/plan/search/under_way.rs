//! A choice of tests under way: what is taken, what proved not clear, what is known by now. Which test comes next is `greedy`'s.

use std::collections::BTreeMap;

use crate::plan::context::choice::Entry;
use crate::plan::context::evaluation::Evaluation;
use crate::plan::information::posterior::Posterior;

/// Gain per minute below which a test is not worth running, when no goal is missed by it.
pub(crate) const LEAST_GAIN: f64 = 1e-2;
/// Goals from which an error counts as seen.
pub(crate) const SEEN: f64 = 5.0;

/// A choice under way.
pub(crate) struct Search<'a> {
    pub entries: Vec<Entry<'a>>,
    pub posterior: Posterior,
    /// Indices of the entries taken, in order.
    pub chosen: Vec<usize>,
    /// By entry: taken or not clear.
    pub dead: Vec<bool>,
    /// By axis: setups that proved not clear.
    pub failures: BTreeMap<usize, usize>,
    pub minutes: f64,
}

impl<'a> Evaluation<'a> {
    /// True when the candidate's pivot is mounted already or one more may be.
    pub fn may_mount(&self, search: &Search, k: usize) -> bool {
        let site = search.entries[k].candidate.site;
        self.context.settings.pivots.is_none_or(|most| {
            let site_of = |place: usize| search.entries[search.chosen[place]].candidate.site;
            let places = 0..search.chosen.len();
            let is_first = |place: &usize| (0..*place).all(|before| site_of(before) != site_of(*place));
            places.clone().any(|place| site_of(place) == site) || places.filter(is_first).count() < most
        })
    }

    /// Checks an entry for collisions unless that is done; false when it is not clear.
    pub(crate) fn is_clear(&mut self, search: &mut Search<'a>, k: usize) -> bool {
        if search.entries[k].sweep.is_some() {
            return true;
        }
        if search.dead[k] {
            return false;
        }
        match self.cleared_entry(search.entries[k].candidate) {
            Some(entry) => search.entries[k] = entry,
            None => search.dead[k] = true,
        }
        search.entries[k].sweep.is_some()
    }

    /// Looks at samples of an entry's arc unless that is done; false when nothing of it is clear.
    pub(crate) fn may_be_clear(&mut self, search: &mut Search<'a>, k: usize) -> bool {
        if search.entries[k].is_whole() {
            match self.sampled_entry(search.entries[k].candidate) {
                Some(entry) => search.entries[k] = entry,
                None => search.dead[k] = true,
            }
        }
        !search.dead[k]
    }

    /// Takes a test that was found clear in another search, if it fits in the time left.
    pub(crate) fn take_again(&self, search: &mut Search<'a>, known: &Entry<'a>) {
        let listed = search.entries.iter().position(|entry| std::ptr::eq(entry.candidate, known.candidate));
        // a refined choice has setups of its own
        let place = listed.or_else(|| {
            search.entries.push(known.clone());
            search.dead.push(false);
            Some(search.entries.len() - 1)
        });
        let minutes = self.minutes(known, &search.posterior);
        let fits = self.budget.is_none_or(|budget| search.minutes + minutes <= budget);
        if let Some(k) = place.filter(|_| fits) {
            search.entries[k] = self.entry(known.candidate, known.sweep.clone());
            self.take(search, k);
        }
    }

    pub(crate) fn take(&self, search: &mut Search, k: usize) {
        search.minutes += self.minutes(&search.entries[k], &search.posterior);
        search.posterior.add(&search.entries[k].block);
        search.chosen.push(k);
        search.dead[k] = true;
    }
}
