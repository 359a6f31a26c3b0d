//! Which searches are run for a goal and for a time, and which of their choices is kept. How one search goes is `greedy`'s and `one_pivot`'s.

use super::candidates::Candidate;
use super::choose::{Choice, Desk};
use super::planned::OnePivot;

impl<'a> Desk<'a> {
    /// The choice found for the goal; with time given, that choice and what else fits in the time.
    pub(super) fn searched(&mut self) -> (Choice<'a>, Option<OnePivot>) {
        let budget = self.budget.take();
        let (base, one_pivot) = self.once();
        let base_minutes = self.reached(&base).minutes;
        self.budget = budget;
        let Some(minutes) = budget else { return (base, one_pivot) };
        let list: &'a [Candidate] = &self.all.list;
        let mut best = self.greedy_from(list.iter(), &base);
        // more tests can leave a greater share of an error's variance to priors, and time too short for the goal may be
        // spent better otherwise
        let (other, other_one) = match base_minutes <= minutes {
            true => (base, one_pivot),
            false => self.once(),
        };
        if self.is_better(&self.reached(&other), &self.reached(&best)) {
            best = other;
        }
        (best, if base_minutes <= minutes { one_pivot } else { other_one })
    }

    /// One search for the goals as they are.
    fn once(&mut self) -> (Choice<'a>, Option<OnePivot>) {
        match self.settings.pivots {
            Some(1) => (self.one_pivot_choice(), None),
            _ => self.free_choice(),
        }
    }
}
