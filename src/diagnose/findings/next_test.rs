//! The test that would tell a finding from its rivals: made from the session's own balls and bars, judged before it is run.
//!
//! For every candidate test the session is laid out once more with it. The lead's trace, as fitted, is then offered to a
//! rival: what the rival cannot imitate (weighted squares) is the evidence that the test would add if the lead is true.

use crate::diagnose::cause::Cause;
use rayon::prelude::*;

use super::finding::{Finding, NextTest};
use super::proposals::{Layout, Longer, Proposal, proposals};
use crate::diagnose::model::linear_model::Column;
use crate::diagnose::model::regression::{Accepted, Regression};
use crate::diagnose::selection::selected::Candidate;
use crate::effects::DESCRIBED_BY_NAME;

/// Rise of the probability below which a test is not worth proposing.
const LEAST_RISE: f64 = 0.02;
/// Probabilities this close count as equal: the shorter test is proposed then.
const EQUAL_PROBABILITY: f64 = 0.01;
/// Amplitudes of a rival may be so many times those that it has now.
const MOST_TIMES_AMPLITUDE: f64 = 10.0;

/// Proposes a test for a finding with rivals; `candidates` are lead and rivals, the lead first, as the search left them.
pub fn next_test(layout: &Layout, finding: &Finding, candidates: &[(Cause, &Candidate)]) -> Option<NextTest> {
    let (lead, rivals) = candidates.split_first()?;
    // amplitudes that each test has for itself say nothing of a test that was not run
    if lead.1.terms.iter().all(|term| term.test.is_some()) {
        return None;
    }
    let proposals = proposals(layout.session, &finding.tests);
    layout.with(&proposals, |longer| judged(longer, &proposals, finding, lead, rivals))
}

/// The proposal that tells lead and rivals apart best; of those alike the shortest.
fn judged(
    longer: &mut Longer,
    proposals: &[Proposal],
    finding: &Finding,
    lead: &(Cause, &Candidate),
    rivals: &[(Cause, &Candidate)],
) -> Option<NextTest> {
    let terms = || std::iter::once(lead).chain(rivals).flat_map(|(_, candidate)| &candidate.terms);
    longer.model.prepare(terms().map(|term| &term.outlet));
    let longer = &*longer;
    let model = &longer.model;
    let columns =
        |candidate: &Candidate| -> Option<Vec<Column>> { model.columns(&candidate.effect, &candidate.terms).ok() };
    let lead_columns = columns(lead.1)?;
    let others: Vec<(f64, &Candidate, Vec<Column>)> = finding
        .rivals
        .iter()
        .filter_map(|(cause, weight)| {
            let (_, rival) = rivals.iter().find(|(other, _)| other == cause)?;
            Some((*weight, *rival, columns(rival)?))
        })
        .collect();
    // of rivals whose traces are not at hand nothing is settled
    let unsettled =
        finding.rivals.iter().map(|(_, weight)| weight).sum::<f64>() - others.iter().map(|(w, ..)| w).sum::<f64>();
    // evidence for the lead against every rival with the session as it is and with one proposal each
    let gaps = |run: &[usize]| -> Vec<f64> {
        let rows = longer.rows_with(run);
        let gap = |truth: (&Candidate, &[Column]), imitator: (&Candidate, &[Column])| -> f64 {
            let loose = MOST_TIMES_AMPLITUDE * imitator.0.judgement.tau.max(1.0);
            let joint: Vec<Accepted> =
                imitator.1.iter().map(|column| Accepted { column: column.clone(), prior: loose }).collect();
            let regression = Regression::new(model, &longer.noise, &joint, &rows);
            let (information, _) = regression.project(truth.1);
            let sizes = nalgebra::DVector::from_column_slice(&truth.0.judgement.amplitudes);
            sizes.dot(&(information * &sizes)).max(0.0)
        };
        others
            .iter()
            .map(|(_, rival, columns)| {
                let (lead, rival) = ((lead.1, lead_columns.as_slice()), (*rival, columns.as_slice()));
                gap(lead, rival).min(gap(rival, lead))
            })
            .collect()
    };
    let now = gaps(&[]);
    let judged: Vec<(f64, f64, usize)> = proposals
        .par_iter()
        .enumerate()
        .map(|(index, proposal)| {
            let then = gaps(&[index]);
            let left: f64 = others
                .iter()
                .zip(now.iter().zip(&then))
                .map(|((w, ..), (now, then))| w * (0.5 * (now - then)).exp())
                .sum();
            (finding.probability / (finding.probability + left + unsettled.max(0.0)), proposal.minutes(), index)
        })
        .collect();
    let best = judged.iter().map(|(after, ..)| *after).fold(0.0, f64::max);
    let (after, minutes, index) = judged
        .into_iter()
        .filter(|(after, ..)| *after > best - EQUAL_PROBABILITY)
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    // both without the causes that no candidate describes
    (after > finding.probability + LEAST_RISE).then(|| NextTest {
        says: format!("{}: {:.0} min", proposals[index].says, minutes.max(1.0)),
        probability_after: DESCRIBED_BY_NAME * after,
        minutes,
    })
}
