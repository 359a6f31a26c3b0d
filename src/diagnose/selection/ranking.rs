//! Which of several candidates is refined, and which of them counts as the best one. Whether the evidence demands it stands in `demand`.

use crate::effects::{Signature, is_a, signature};
use std::collections::HashSet;

use rayon::prelude::*;

use super::candidates::CandidateFamily;
use super::selected::Candidate;
use crate::diagnose::model::linear_model::{LinearModel, Term};
use crate::diagnose::model::regression::Regression;
use crate::machine::{Machine, ParameterValue};

/// Families refined at each stage.
const REFINED: usize = 12;

/// A free curve is preferred to a form of the catalogue only when it explains so much more.
const FREE_CURVE_MARGIN: f64 = 1.3;

/// Shortest shift between lengths and positions of a single test, ms: a mistake of pairing is no matter of milliseconds.
const SHORTEST_SHIFT_MS: f64 = 200.0;
/// Longest one, ms: beyond it a test's rows belong to no motion near them.
const LONGEST_SHIFT_MS: f64 = 5000.0;

/// Share of the misfit that a wrong pairing of one test must explain: the files are wrong, or the machine is.
const SHIFT_SHARE: f64 = 0.5;

/// Largest form of a ball, µm: those of gauges are round to some tenths, worn ones to one.
const ROUND_WITHIN: f64 = 1.1;

/// Whether a candidate's size is one that it can have.
pub(crate) fn is_sensible(candidate: &Candidate, misfit: f64) -> bool {
    let amplitudes = &candidate.judgement.amplitudes;
    if is_a(&candidate.effect.kind, Signature::BallForm) {
        return amplitudes.iter().map(|size| size * size).sum::<f64>().sqrt() < ROUND_WITHIN;
    }
    let shift_ms = amplitudes.iter().fold(0.0f64, |largest, size| largest.max(size.abs()));
    let explains = candidate.judgement.chi2 > SHIFT_SHARE * misfit;
    !candidate.is_shift_of_one_test() || (explains && (SHORTEST_SHIFT_MS..LONGEST_SHIFT_MS).contains(&shift_ms))
}

/// Free curves that are refined beside the named ones.
const REFINED_FREE: usize = 3;

/// Candidates of one kind that are refined: on a coarse grid a jump may stand behind many ways to grow.
const REFINED_ALIKE: usize = 8;

/// Candidates judged on all rows that are refined in any case: evidence on averaged rows, under their own noise, is no
/// measure for it.
const REFINED_FAST: usize = 3;

/// Keeps the best candidates, but not only free curves, only one kind, or only what was judged on averaged rows.
pub(crate) fn keep_diverse(candidates: &mut Vec<Candidate>, families: &[CandidateFamily]) {
    let mut named: Vec<&'static str> = Vec::new();
    let (mut free, mut fast) = (0, 0);
    candidates.retain(|candidate| {
        if candidate.is_free() {
            free += 1;
            return free <= REFINED_FREE;
        }
        let family = &families[candidate.family];
        let alike = named.iter().filter(|other| **other == family.kind).count();
        let in_any_case = family.fast && fast < REFINED_FAST;
        let keep = alike < REFINED_ALIKE && (named.len() < REFINED || in_any_case);
        if keep {
            named.push(family.kind);
            fast += usize::from(family.fast);
        }
        keep
    });
}

/// Judges refined candidates under one noise, on all rows.
pub(crate) fn compare(
    regression: &Regression,
    families: &[CandidateFamily],
    mut candidates: Vec<Candidate>,
) -> Vec<Candidate> {
    candidates.par_iter_mut().for_each(|candidate| {
        let cost = candidate.judgement.log_evidence - candidate.log_odds;
        candidate.judgement = regression.judge(&candidate.columns, families[candidate.family].plausible);
        candidate.log_odds = candidate.judgement.log_evidence - cost;
    });
    candidates.sort_by(|a, b| b.log_odds.total_cmp(&a.log_odds));
    candidates
}

/// Log odds within which candidates count as equal, so that the customary name decides.
const TIE: f64 = 3.0;

/// The same as a share of the best one's log odds: forms are never exact.
const TIE_SHARE: f64 = 0.002;

/// The same among free curves.
const FREE_TIE: f64 = 10.0;

/// The candidate to accept: the best named one, unless a free curve explains far more; customary names win ties.
pub(crate) fn choose(candidates: &[Candidate], families: &[CandidateFamily], model: &LinearModel) -> usize {
    let best_named = candidates.iter().position(|candidate| !candidate.is_free());
    let best = match best_named {
        Some(named) if candidates[0].is_free() => {
            let far_more = candidates[0].judgement.chi2 > FREE_CURVE_MARGIN * candidates[named].judgement.chi2 + 30.0;
            if far_more { 0 } else { named }
        }
        _ => 0,
    };
    let best = simpler(model.context.machine(), candidates, best).unwrap_or(best);
    // a free curve over an axis that only follows another one says the same as one over that axis
    let share = TIE_SHARE * candidates[best].log_odds.max(0.0);
    let tie = if candidates[best].is_free() { FREE_TIE } else { TIE.max(share) };
    let near = |candidate: &Candidate| {
        candidates[best].log_odds - candidate.log_odds < tie && candidate.is_free() == candidates[best].is_free()
    };
    (0..candidates.len())
        .filter(|&k| k == best || near(&candidates[k]))
        .min_by_key(|&k| (families[candidates[k].family].customary_rank(model), k != best))
        .unwrap_or(best)
}

/// Share of what a vibration in all directions explains with which one direction alone is the likelier cause: a phase that
/// wanders is no other direction.
const ONE_DIRECTION: f64 = 0.93;

/// The same beside one direction that is free, in log odds, both being as free in their course, and what two angles may gain by
/// chance.
const A_GIVEN_DIRECTION: f64 = 0.993;
const TWO_ANGLES: f64 = 50.0;

/// The same for error motions: what lies between the orders is no other motion.
const FEWER_MOTIONS: f64 = 0.99;

/// Share of what a part that tips explains with which lost motion of the axis that drives it is the likelier cause.
const OWN_RATHER: f64 = 0.9;

/// A candidate of the best one's kind that explains nearly as much in half as many directions or fewer; beside a part that
/// tips as an axis reverses, lost motion of that axis itself.
pub(crate) fn simpler(machine: &Machine, candidates: &[Candidate], best: usize) -> Option<usize> {
    let Candidate { effect, terms, judgement, log_odds, .. } = &candidates[best];
    if let (Some(Signature::Play), Some(ParameterValue::Word(driving))) =
        (signature(&effect.kind), effect.parameter("of"))
    {
        return candidates.iter().position(|other| {
            is_a(&other.effect.kind, Signature::Reversal)
                && other.effect.place.name(machine) == driving
                && other.judgement.chi2 > OWN_RATHER * judgement.chi2
        });
    }
    let is_along = is_along(terms);
    let share = match signature(&effect.kind) {
        Some(Signature::Oscillation) => ONE_DIRECTION,
        Some(Signature::ErrorMotion) => FEWER_MOTIONS,
        _ => return None,
    };
    candidates.iter().position(|other| {
        other.effect.kind == effect.kind
            && (other.effect.place == effect.place || is_a(&effect.kind, Signature::Oscillation))
            && 2 * directions(&other.terms) <= directions(terms)
            && other.judgement.chi2 > share * judgement.chi2
            && (!is_along || other.log_odds > (A_GIVEN_DIRECTION * log_odds).min(log_odds - TWO_ANGLES))
    })
}

/// How many directions terms have, a free one counting as two.
pub(crate) fn directions(terms: &[Term]) -> usize {
    terms.iter().map(|term| term.outlet).collect::<HashSet<_>>().len() + usize::from(is_along(terms))
}

/// Whether terms move a ball along one direction that is free.
fn is_along(terms: &[Term]) -> bool {
    terms.iter().any(|term| term.along.is_some())
}
