//! One search without a limit on pivots: as many as pay, or the one from which all that can be had as quickly.

use crate::plan::context::choice::Choice;
use crate::plan::context::evaluation::Evaluation;
use crate::plan::places::candidate::Candidate;

/// What is found for a goal: a choice, and the best one from a single pivot setup where that was looked for.
pub(crate) struct Found<'a> {
    pub choice: Choice<'a>,
    pub one_pivot: Option<Choice<'a>>,
}

impl<'a> Evaluation<'a> {
    /// As many pivots as pay, or the one pivot from which all that can be had as quickly; and what one pivot reaches.
    pub(crate) fn free_choice(&mut self) -> Found<'a> {
        let list: &'a [Candidate] = &self.context.all.list;
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
}
