//! Which of several candidates is refined, and which of them counts as the best one. Whether the evidence demands it stands in `acceptance`.

use crate::effects::{Signature, is_a, signature};
use std::collections::HashSet;

use rayon::prelude::*;

use super::selected::Candidate;
use crate::diagnose::model::linear_model::{LinearModel, Term};
use crate::diagnose::model::regression::Regression;
use crate::diagnose::thresholds::Thresholds;
use crate::effects::CandidateFamily;
use crate::machine::{Effect, Machine, ParameterValue};

/// Log odds below which a difference is none: rounding of the machine that computes is smaller, what any reading says is larger.
const ROUNDING: f64 = 1e-6;

/// Candidates best first. Those that say the same to rounding, as arrival about two axes that only move together, stay nearly
/// always in the order of the families.
pub(crate) fn sort_by_odds(candidates: &mut [Candidate]) {
    let rounded = |candidate: &Candidate| (candidate.log_odds / ROUNDING).round();
    candidates.sort_by(|one, other| rounded(other).total_cmp(&rounded(one)).then(one.family.cmp(&other.family)));
}

/// Families refined at each stage.
const REFINED: usize = 12;

/// Shortest shift between lengths and positions of a single test, ms: a mistake of pairing is no matter of milliseconds.
const SHORTEST_SHIFT_MS: f64 = 200.0;
/// Longest one, ms: beyond it a test's rows belong to no motion near them.
const LONGEST_SHIFT_MS: f64 = 5000.0;

/// Whether a candidate's size is one that it can have.
pub(crate) fn is_sensible(
    thresholds: &Thresholds,
    family: &CandidateFamily,
    candidate: &Candidate,
    misfit: f64,
) -> bool {
    let amplitudes = &candidate.judgement.amplitudes;
    let first = family.outlets.first();
    let through_first = candidate.terms.iter().zip(amplitudes).filter(|(term, _)| Some(&term.outlet) == first);
    if through_first.map(|(_, size)| size * size).sum::<f64>().sqrt() > family.most {
        return false;
    }
    let shift_ms = amplitudes.iter().fold(0.0f64, |largest, size| largest.max(size.abs()));
    let explains = candidate.judgement.chi2 > thresholds.explains_most * misfit;
    !candidate.is_shift_of_one_test() || (explains && (SHORTEST_SHIFT_MS..LONGEST_SHIFT_MS).contains(&shift_ms))
}

/// Free curves that are refined beside the named ones.
const REFINED_FREE: usize = 6;

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

/// Share of the best log odds of a look from which a family may be the best one where half of the readings are looked at.
const CONTENDS: f64 = 0.25;

/// Notes the families of candidates, best first, that came near the best one.
pub(crate) fn note_contenders(contenders: &mut [bool], candidates: &[Candidate]) {
    let best = candidates.first().map_or(0.0, |best| best.log_odds);
    let near = candidates.iter().filter(|candidate| candidate.log_odds >= CONTENDS * best);
    near.for_each(|candidate| contenders[candidate.family] = true);
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
    sort_by_odds(&mut candidates);
    candidates
}

/// The candidate to accept: the best named one, unless a free curve explains far more; customary names win ties.
pub(crate) fn choose(candidates: &[Candidate], families: &[CandidateFamily], model: &LinearModel) -> usize {
    let t = &model.thresholds;
    let best_named = candidates.iter().position(|candidate| !candidate.is_free());
    let best = match best_named {
        Some(named) if candidates[0].is_free() => {
            let far_more =
                candidates[0].judgement.chi2 > t.free_margin * candidates[named].judgement.chi2 + 2.0 * t.accept;
            if far_more { 0 } else { named }
        }
        _ => 0,
    };
    let best = simpler(model, candidates, best).unwrap_or(best);
    // a free curve over an axis that only follows another one says the same as one over that axis
    let share = t.inexact * candidates[best].log_odds.max(0.0);
    let tie = if candidates[best].is_free() { t.free_tie } else { t.tie.max(share) };
    let near = |candidate: &Candidate| {
        candidates[best].log_odds - candidate.log_odds < tie && candidate.is_free() == candidates[best].is_free()
    };
    (0..candidates.len())
        .filter(|&k| k == best || near(&candidates[k]))
        .min_by_key(|&k| (families[candidates[k].family].rank, k != best))
        .unwrap_or(best)
}

/// A candidate of the best one's kind that explains nearly as much in half as many directions or fewer; beside a part that
/// tips as an axis reverses, lost motion of that axis itself.
pub(crate) fn simpler(model: &LinearModel, candidates: &[Candidate], best: usize) -> Option<usize> {
    let (t, machine) = (&model.thresholds, model.context.machine());
    let Candidate { effect, terms, judgement, log_odds, .. } = &candidates[best];
    if let Some(driving) = tips_with(effect) {
        return candidates.iter().position(|other| {
            is_lost_motion_of(machine, other, driving) && other.judgement.chi2 > t.own_rather * judgement.chi2
        });
    }
    let is_along = is_along(terms);
    let share = match signature(&effect.kind) {
        Some(Signature::Oscillation) => t.one_direction,
        Some(Signature::ErrorMotion) => t.fewer_motions,
        _ => return None,
    };
    candidates.iter().position(|other| {
        other.effect.kind == effect.kind
            && (other.effect.place == effect.place || is_a(&effect.kind, Signature::Oscillation))
            && 2 * directions(&other.terms) <= directions(terms)
            && other.judgement.chi2 > share * judgement.chi2
            && (!is_along || other.log_odds > log_odds - t.two_angles.max(t.inexact * log_odds))
    })
}

/// Name of the axis as whose reversal a part tips; `None` for another effect.
fn tips_with(effect: &Effect) -> Option<&str> {
    match effect.parameter("of") {
        Some(ParameterValue::Word(driving)) if is_a(&effect.kind, Signature::Play) => Some(driving),
        _ => None,
    }
}

/// Whether a candidate is lost motion of the axis of a name.
fn is_lost_motion_of(machine: &Machine, candidate: &Candidate, axis: &str) -> bool {
    is_a(&candidate.effect.kind, Signature::Reversal) && candidate.effect.place.name(machine) == axis
}

/// Whether a candidate is a part that tips as another one's axis reverses, and the other that axis's own lost motion: drives
/// lose motion more often than bearings.
pub(crate) fn is_driven_by(machine: &Machine, tipping: &Candidate, own: &Candidate) -> bool {
    tips_with(&tipping.effect).is_some_and(|driving| is_lost_motion_of(machine, own, driving))
}

/// How many directions terms have, a free one counting as two.
pub(crate) fn directions(terms: &[Term]) -> usize {
    terms.iter().map(|term| term.outlet).collect::<HashSet<_>>().len() + usize::from(is_along(terms))
}

/// Whether terms move a ball along one direction that is free.
fn is_along(terms: &[Term]) -> bool {
    terms.iter().any(|term| term.along.is_some())
}
