//! Continuous shapes of a candidate brought to their best by a pattern search. It compares no candidates.

use rayon::prelude::*;

use super::judged_shape::{PARAMETER_COST, judged};
use crate::diagnose::model::last_shape::LastShape;
use crate::diagnose::model::regression::Regression;
use crate::diagnose::selection::ranking::sort_by_odds;
use crate::diagnose::selection::screening::screen::stage_of;
use crate::diagnose::selection::selected::Candidate;
use crate::effects::{CandidateFamily, Refined};
use crate::effects::{Signature, WARM, signature};
use crate::machine::{Effect, ParameterValue};

/// Refined shapes; their columns are those of all rows.
pub fn refine_all(
    regressions: &[Regression; 2],
    families: &[CandidateFamily],
    candidates: Vec<Candidate>,
) -> Vec<Candidate> {
    let list: Vec<Candidate> = candidates
        .into_par_iter()
        .map(|candidate| {
            let family = &families[candidate.family];
            refine(stage_of(regressions, family), family, candidate)
        })
        .collect();
    // overtones and sidebands are a part of what the first period explains
    let leading = list.iter().map(|candidate| candidate.judgement.chi2).fold(0.0, f64::max);
    let mut list: Vec<Candidate> = list
        .into_par_iter()
        .filter_map(|candidate| {
            let family = &families[candidate.family];
            let may_lead = OVERTONES_ADD * candidate.judgement.chi2 > leading;
            let regression = stage_of(regressions, family);
            let on_all_rows = family.turns_within_rows && may_lead;
            let candidate =
                if on_all_rows { refine_on_all_rows(&regressions[0], family, candidate) } else { candidate };
            let mut refined = match signature(&candidate.effect.kind) {
                Some(Signature::Period) if may_lead => with_overtones(regression, family, candidate),
                Some(Signature::Oscillation) if may_lead && candidate.judgement.chi2 > WORTH_OVERTONES => {
                    super::vibration_shape::with_wander(regression, family, candidate)
                }
                Some(Signature::Growth) if may_lead => with_warm_start(regression, family, candidate),
                Some(Signature::Scale) if may_lead => with_curvature(regression, family, candidate),
                Some(Signature::Lift) if may_lead => with_other_edge(regression, family, candidate),
                _ => candidate,
            };
            refined.columns = regressions[0].model.columns(&refined.effect, &refined.terms).ok()?;
            Some(refined)
        })
        .collect();
    sort_by_odds(&mut list);
    list
}

/// Rounds of the pattern search over shape parameters.
const ROUNDS: usize = 9;

/// Improves the shape parameters of a candidate by a pattern search.
fn refine(regression: &Regression, family: &CandidateFamily, candidate: Candidate) -> Candidate {
    let (mut best, moved) = pattern_search(regression, family, candidate);
    let refined = family.refined.iter().filter(|refined| parameter(&best.effect, refined).is_some()).count();
    let cost = PARAMETER_COST * refined as f64;
    if moved {
        best.log_odds -= cost;
    }
    best
}

/// The same with all rows for a shape that was refined on averages; the shapes of the grid are starts again, for the best one on averages
/// may lie in another valley.
fn refine_on_all_rows(regression: &Regression, family: &CandidateFamily, candidate: Candidate) -> Candidate {
    let cost = candidate.judgement.log_evidence - candidate.log_odds;
    let starts = family.grid.iter().chain([&candidate.effect]).filter_map(|effect| {
        judged(regression, family, candidate.family, effect.clone(), cost, &mut LastShape::default())
    });
    match starts.max_by(|one, other| one.log_odds.total_cmp(&other.log_odds)) {
        Some(start) => pattern_search(regression, family, start).0,
        None => candidate,
    }
}

/// The best shape near a candidate's by a pattern search, and whether it is another one.
fn pattern_search(regression: &Regression, family: &CandidateFamily, candidate: Candidate) -> (Candidate, bool) {
    let index = candidate.family;
    let mut best = candidate;
    let cost = best.judgement.log_evidence - best.log_odds;
    let mut steps: Vec<f64> = family.refined.iter().map(|refined| refined.step).collect();
    let mut moved = false;
    let mut last = LastShape::default();
    for _ in 0..ROUNDS {
        for (k, refined) in family.refined.iter().enumerate() {
            let Some(now) = parameter(&best.effect, refined) else { continue };
            let mut improved = false;
            for sign in [1.0, -1.0] {
                let value = stepped(refined, now, sign * steps[k]);
                if value == now {
                    continue;
                }
                let mut effect = best.effect.clone();
                set_parameter(&mut effect, refined, value);
                let trial = judged(regression, family, index, effect, cost, &mut last);
                if let Some(trial) = trial.filter(|trial| trial.log_odds > best.log_odds) {
                    best = trial;
                    improved = true;
                    moved = true;
                    break;
                }
            }
            if !improved {
                steps[k] *= 0.5;
            }
        }
    }
    (best, moved)
}

/// With overtones a cyclic error explains at most so many times what its first period does.
const OVERTONES_ADD: f64 = 2.0;
/// Fall of the weighted squares from which the overtones of a cyclic error are looked for.
const WORTH_OVERTONES: f64 = 100.0;
/// Beats over the travel of a slide, or in a turn, by which an amplitude may swell: a bent screw, an eccentric worm wheel.
const BEATS: [f64; 8] = [0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 3.0];

/// A cyclic error with its second harmonic and a sideband, as far as the readings ask for them.
fn with_overtones(regression: &Regression, family: &CandidateFamily, mut best: Candidate) -> Candidate {
    if best.judgement.chi2 < WORTH_OVERTONES {
        return best;
    }
    let rotary = best.effect.parameter("orders").is_some();
    let name = if rotary { "orders" } else { "periods" };
    let Some(ParameterValue::List(first)) = best.effect.parameter(name).cloned() else { return best };
    let Some(refined) = family.refined.first() else { return best };
    let first = first[0];
    let within = |value: &f64| (refined.least..=refined.most).contains(value) && *value != first;
    let second = vec![if rotary { 2.0 * first } else { 0.5 * first }];
    let beats = BEATS.iter().flat_map(|beat| [*beat, -beat]);
    // periods beat over the travel, the longest period of the family; orders within a turn
    let sidebands = beats.map(|beat| if rotary { first + beat } else { 1.0 / (1.0 / first + beat / refined.most) });
    let mut last = LastShape::default();
    for further in [second, sidebands.collect()] {
        let further = further.into_iter().filter(within);
        let trials = further.filter_map(|value| with_further(regression, family, (&best, name, value), &mut last));
        let Some(trial) = trials.max_by(|a, b| a.log_odds.total_cmp(&b.log_odds)) else { continue };
        if trial.log_odds > best.log_odds + regression.model.thresholds.better {
            best = trial;
        }
    }
    if list_length(&best.effect, name) > 1 { tuned(regression, family, (best, name), &mut last) } else { best }
}

/// Growth by friction, or with a channel, of a part that was out of balance as the session began, as far as the readings
/// ask for it.
fn with_warm_start(regression: &Regression, family: &CandidateFamily, best: Candidate) -> Candidate {
    if best.judgement.chi2 < WORTH_OVERTONES {
        return best;
    }
    let cost = best.judgement.log_evidence - best.log_odds;
    let lags = |effect: &&Effect| effect.number("lag").is_some_and(|lag| lag > 0.0);
    let may_begin_warm = |effect: &&Effect| effect.parameter("heat").is_some() || lags(effect);
    // what looked like a short lag, or like two nodes, may be a longer lag of a part that was out of balance
    let lagging = family.grid.iter().filter(lags);
    let trials = std::iter::once(&best.effect).filter(may_begin_warm).chain(lagging).filter_map(|effect| {
        let warm = effect.clone().with("begins", ParameterValue::Word(WARM.into()));
        judged(regression, family, best.family, warm, cost, &mut LastShape::default())
    });
    match trials.max_by(|a, b| a.log_odds.total_cmp(&b.log_odds)) {
        Some(trial) if trial.log_odds > best.log_odds + regression.model.thresholds.better => {
            // what its shape costs is in its log odds
            pattern_search(regression, family, trial).0
        }
        _ => best,
    }
}

/// Change of a scale's error per length over a metre, as a share of it, up to which it is one scale; the first step in which
/// it is looked for, and how often that is halved.
const MOST_CURVED: f64 = 2.0;
const CURVED_STEP: f64 = 0.4;
const CURVED_HALVINGS: usize = 5;

/// A scale that is larger at one end than at the other, as far as the readings ask for it; its size is that in the middle of
/// where the slide was.
fn with_curvature(regression: &Regression, family: &CandidateFamily, straight: Candidate) -> Candidate {
    let Some(axis) = straight.effect.place.axis().filter(|_| straight.judgement.chi2 > WORTH_OVERTONES) else {
        return straight;
    };
    let (from, to) = regression.model.context.visited(axis);
    let cost = straight.judgement.log_evidence - straight.log_odds;
    let curved = |curvature: f64| {
        let effect = straight.effect.clone().with("curvature", ParameterValue::Number(curvature));
        let effect = effect.with("centre", ParameterValue::Number(0.5 * (from + to)));
        judged(regression, family, straight.family, effect, cost, &mut LastShape::default())
    };
    let (mut at, mut step) = (0.0, CURVED_STEP);
    let mut best = straight.clone();
    for _ in 0..=CURVED_HALVINGS {
        for sign in [1.0, -1.0] {
            loop {
                let next: f64 = at + sign * step;
                match Some(next).filter(|next| next.abs() <= MOST_CURVED).and_then(curved) {
                    Some(trial) if trial.log_odds > best.log_odds => (at, best) = (next, trial),
                    _ => break,
                }
            }
        }
        step *= 0.5;
    }
    best.log_odds -= PARAMETER_COST;
    if best.log_odds > straight.log_odds + regression.model.thresholds.better { best } else { straight }
}

/// Places tried for an edge of a lift.
const EDGES: usize = 30;

/// A lift with one edge where it is and the other anywhere: of a stretch that the grid does not have, one edge is found
/// first.
fn with_other_edge(regression: &Regression, family: &CandidateFamily, best: Candidate) -> Candidate {
    let bounds = |name: &str| family.refined.iter().find(|refined| refined.name == name);
    let (Some(from), Some(to)) = (bounds("from"), bounds("to")) else { return best };
    let (Some(begins), Some(ends)) = (best.effect.number("from"), best.effect.number("to")) else { return best };
    if best.judgement.chi2 < WORTH_OVERTONES {
        return best;
    }
    let cost = best.judgement.log_evidence - best.log_odds;
    let places = (0..EDGES).map(|k| from.least + (to.most - from.least) * k as f64 / (EDGES - 1) as f64);
    let trials = places.flat_map(|place| [(begins, place), (ends, place)]).filter_map(|(kept, place)| {
        let lift = best.effect.clone().with("from", ParameterValue::Number(kept.min(place)));
        let lift = lift.with("to", ParameterValue::Number(kept.max(place)));
        judged(regression, family, best.family, lift, cost, &mut LastShape::default())
    });
    match trials.max_by(|a, b| a.log_odds.total_cmp(&b.log_odds)) {
        Some(trial) if trial.log_odds > best.log_odds => {
            let refined = pattern_search(regression, family, trial).0;
            if refined.log_odds > best.log_odds { refined } else { best }
        }
        _ => best,
    }
}

/// First step of tuning, as a ratio, and its halvings: a sideband that was missing has pulled the first period.
const TUNING_STEP: f64 = 0.004;
const TUNINGS: i32 = 5;

/// Periods or orders tuned together; an exact second harmonic stays one.
fn tuned(
    regression: &Regression,
    family: &CandidateFamily,
    (mut best, name): (Candidate, &str),
    last: &mut LastShape,
) -> Candidate {
    let cost = best.judgement.log_evidence - best.log_odds;
    for halving in 0..TUNINGS {
        let step = TUNING_STEP * 0.5f64.powi(halving);
        for element in 0..list_length(&best.effect, name) {
            for factor in [1.0 + step, 1.0 / (1.0 + step)] {
                while let Some(ParameterValue::List(mut values)) = best.effect.parameter(name).cloned() {
                    let first = values[0];
                    let tied: Vec<bool> =
                        values.iter().map(|value| [0.5, 2.0].iter().any(|ratio| *value == ratio * first)).collect();
                    if tied[element] {
                        break;
                    }
                    for (k, value) in values.iter_mut().enumerate() {
                        if k == element || (element == 0 && tied[k]) {
                            *value *= factor;
                        }
                    }
                    let mut effect = best.effect.clone();
                    effect.set(name, ParameterValue::List(values));
                    match judged(regression, family, best.family, effect, cost, last) {
                        Some(trial) if trial.log_odds > best.log_odds => best = trial,
                        _ => break,
                    }
                }
            }
        }
    }
    best
}

fn list_length(effect: &Effect, name: &str) -> usize {
    match effect.parameter(name) {
        Some(ParameterValue::List(values)) => values.len(),
        _ => 0,
    }
}

/// A candidate with one more element of a list parameter.
fn with_further(
    regression: &Regression,
    family: &CandidateFamily,
    (base, name, value): (&Candidate, &str, f64),
    last: &mut LastShape,
) -> Option<Candidate> {
    let Some(ParameterValue::List(mut values)) = base.effect.parameter(name).cloned() else { return None };
    values.push(value);
    let mut effect = base.effect.clone();
    effect.set(name, ParameterValue::List(values));
    let cost = base.judgement.log_evidence - base.log_odds;
    judged(regression, family, base.family, effect, cost, last)
}

/// Next value of a parameter: lists of periods, travels and frequencies move by ratio, the others by difference.
fn stepped(refined: &Refined, now: f64, step: f64) -> f64 {
    let by_ratio = matches!(refined.name, "periods" | "travel" | "turned" | "servo_hz" | "frequency");
    let next = if by_ratio { now * (1.0 + step.abs()).powf(step.signum()) } else { now + step };
    next.clamp(refined.least, refined.most)
}

fn parameter(effect: &Effect, refined: &Refined) -> Option<f64> {
    match (effect.parameter(refined.name), refined.element) {
        (Some(ParameterValue::Number(value)), None) => Some(*value),
        (Some(ParameterValue::List(values)), Some(element)) => values.get(element).copied(),
        (None, None) => match refined.name {
            "skew" | "creep_share" => Some(0.0),
            "creep_time" => Some(30.0),
            "damping" => Some(0.7),
            _ => None,
        },
        _ => None,
    }
}

fn set_parameter(effect: &mut Effect, refined: &Refined, value: f64) {
    match refined.element {
        None => effect.set(refined.name, ParameterValue::Number(value)),
        Some(element) => {
            if let Some(ParameterValue::List(values)) = effect.parameter(refined.name) {
                let mut values = values.clone();
                values[element] = value;
                effect.set(refined.name, ParameterValue::List(values));
            }
        }
    }
}
