//! Short tests with what is mounted that would show what a session cannot: counted before they are run. It looks at no residual.

use rayon::prelude::*;

use super::detection_limits::{AXIS_SENSE, Unseen, unseen_causes};
use crate::diagnose::findings::proposals::{Layout, Longer, Proposal, proposals};
use crate::diagnose::model::regression::Regression;
use crate::diagnose::selection::screening::candidates::families;
use crate::effects::CandidateFamily;

/// A test that would show some of the unseen causes.
#[derive(Debug, Clone, PartialEq)]
pub struct UncoveringTest {
    pub says: String,
    /// Time on the machine, minutes.
    pub minutes: f64,
    /// Causes that it shows beside the tests named before it, by their place in the list of unseen causes.
    pub uncovers: Vec<usize>,
}

/// Tests named at most: a short list is run, a long one is not.
const MOST_TESTS: usize = 3;

/// Tests that show most of what is unseen, the one that shows most first, each counted with those before it.
pub fn uncovering_tests(layout: &Layout, unseen: &[Unseen]) -> Vec<UncoveringTest> {
    let proposals = proposals(layout.session, &[]);
    layout.with(&proposals, |longer| Some(greedy(longer, &proposals, unseen))).unwrap_or_default()
}

fn greedy(longer: &Longer, proposals: &[Proposal], unseen: &[Unseen]) -> Vec<UncoveringTest> {
    let families = families(&longer.model);
    let mut run: Vec<usize> = Vec::new();
    let mut hidden: Vec<usize> = (0..unseen.len()).collect();
    let mut named = Vec::new();
    while named.len() < MOST_TESTS {
        let open: Vec<usize> = (0..proposals.len()).filter(|index| !run.contains(index)).collect();
        let shown_by = |&index: &usize| {
            let with: Vec<usize> = run.iter().copied().chain([index]).collect();
            (index, shown(longer, &families, &with, unseen, &hidden))
        };
        let counted: Vec<(usize, Vec<usize>)> = open.par_iter().map(shown_by).collect();
        let minutes = |index: usize| proposals[index].minutes();
        let best =
            counted.into_iter().max_by(|a, b| a.1.len().cmp(&b.1.len()).then(minutes(b.0).total_cmp(&minutes(a.0))));
        let Some((index, uncovers)) = best.filter(|(_, uncovers)| !uncovers.is_empty()) else { break };
        hidden.retain(|cause| !uncovers.contains(cause));
        run.push(index);
        named.push(UncoveringTest { says: proposals[index].says.clone(), minutes: minutes(index), uncovers });
    }
    named
}

/// Which of the hidden causes show when these proposals are run.
fn shown(
    longer: &Longer,
    families: &[CandidateFamily],
    run: &[usize],
    unseen: &[Unseen],
    hidden: &[usize],
) -> Vec<usize> {
    let rows = longer.rows_with(run);
    let regression = Regression::new(&longer.model, &longer.noise, &[], &rows);
    let still = unseen_causes(&longer.model, families, &regression);
    let is_hidden = |cause: &Unseen| {
        still.iter().any(|other| {
            other.cause.effect == cause.cause.effect
                && other.cause.place == cause.cause.place
                && other.cause.components.iter().any(|component| cause.cause.components.contains(component))
        })
    };
    // no length tells the sense of an axis as looking does
    let by_looking = |cause: &Unseen| cause.cause.effect == AXIS_SENSE;
    hidden.iter().copied().filter(|&k| !by_looking(&unseen[k]) && !is_hidden(&unseen[k])).collect()
}
