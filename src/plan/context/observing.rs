//! What lengths of reachable setups can show at all, from a sample of the setups. It chooses nothing.

use super::evaluation::Evaluation;
use crate::plan::information::fitted::HALF;
use crate::plan::information::observability::Observability;
use crate::plan::information::posterior::Posterior;

/// Setups of each axis that stand for all when it is asked what lengths can show.
const SAMPLE: usize = 16;
/// Setups in which errors that the sample does not show are looked for.
const LOOKED_AT: usize = 12_000;
/// Correlation from which two errors that no length shows are named together: three that share a sum have about a half.
const TOGETHER: f64 = 0.4;

/// What reachable setups show of each wanted error.
pub(crate) fn observability(evaluation: &Evaluation) -> Vec<Observability> {
    let unknowns = evaluation.context.unknowns.with_exact_linear_axes();
    let mut loose = Posterior::before_with_loose_setups(&unknowns);
    let mut known = Posterior::before(&unknowns);
    for axis in 0..evaluation.context.machine.axes.len() {
        let mine: Vec<_> = evaluation.context.all.list.iter().filter(|candidate| candidate.axis == axis).collect();
        let step = mine.len().div_ceil(SAMPLE).max(1);
        for candidate in mine.iter().step_by(step) {
            let block = evaluation.entry(candidate, None).block;
            loose.add(&block);
            known.add(&block);
        }
    }
    // what the sample does not show, some other setup may
    for candidate in
        evaluation.context.all.list.iter().step_by(evaluation.context.all.list.len().div_ceil(LOOKED_AT).max(1))
    {
        let is_unseen = |k: &usize| loose.prior_share(*k) >= HALF;
        let unseen: Vec<usize> = (0..unknowns.wanted).filter(is_unseen).collect();
        if unseen.is_empty() {
            break;
        }
        let block = evaluation.entry(candidate, None).block;
        let with = loose.variances_with(&block);
        if unseen.iter().any(|&k| with[k] < HALF * loose.covariance(k, k)) {
            loose.add(&block);
            known.add(&block);
        }
    }
    let is_seen: Vec<bool> = (0..unknowns.wanted).map(|k| loose.prior_share(k) < HALF).collect();
    let correlation = |k: usize, other: usize| {
        loose.covariance(k, other) / (loose.covariance(k, k) * loose.covariance(other, other)).sqrt()
    };
    (0..unknowns.wanted)
        .map(|k| Observability {
            is_seen: is_seen[k],
            partners: (0..unknowns.wanted)
                .filter(|&other| other != k && !is_seen[k] && !is_seen[other])
                .filter(|&other| correlation(k, other).abs() > TOGETHER)
                .collect(),
            by_pivot: known.covariance(k, k) < HALF * unknowns.prior(k).powi(2),
        })
        .collect()
}
