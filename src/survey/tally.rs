//! Counts of topologies by family: how many are determined in full. It plans nothing.

use super::outcome::{Family, Outcome};

/// Counts of one family.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tally {
    pub family: Family,
    pub topologies: usize,
    /// All errors of the rotary axes determined.
    pub all_determined: usize,
    /// All that lengths can show determined.
    pub all_visible_determined: usize,
    /// All that lengths can show determined from one pivot setup.
    pub from_one_pivot: usize,
    /// No test at all.
    pub without_test: usize,
}

/// Counts by family.
pub fn tallies(outcomes: &[Outcome]) -> Vec<Tally> {
    let tally = |family: Family| {
        let count = |holds: &dyn Fn(&Outcome) -> bool| {
            outcomes.iter().filter(|outcome| outcome.family == family && holds(outcome)).count()
        };
        Tally {
            family,
            topologies: count(&|_| true),
            all_determined: count(&|outcome| outcome.determined == outcome.errors),
            all_visible_determined: count(&|outcome| outcome.visible > 0 && outcome.determined >= outcome.visible),
            from_one_pivot: count(&Outcome::is_fully_tested_from_one_pivot),
            without_test: count(&|outcome| outcome.tests == 0),
        }
    };
    Family::ALL.into_iter().map(tally).filter(|tally| tally.topologies > 0).collect()
}
