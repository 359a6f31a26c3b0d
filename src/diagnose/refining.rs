//! Continuous shapes of a candidate brought to their best by a pattern search. It compares no candidates.

use rayon::prelude::*;

use super::library::{Family, Refined, family_terms};
use super::screening::stage_of;
use super::search::Candidate;
use super::stage::Stage;
use crate::machine::{Effect, ParameterValue};

/// Refined shapes; their columns are those of all rows.
pub fn refine_all(stages: &[Stage; 2], families: &[Family], candidates: Vec<Candidate>) -> Vec<Candidate> {
    let mut list: Vec<Candidate> = candidates
        .into_par_iter()
        .map(|candidate| {
            let family = &families[candidate.family];
            let stage = stage_of(stages, family);
            let mut refined = refine(stage, family, candidate);
            if !std::ptr::eq(stage.ground, stages[0].ground)
                && let Ok(columns) = stages[0].ground.columns(&refined.effect, &refined.terms)
            {
                refined.columns = columns;
            }
            refined
        })
        .collect();
    list.sort_by(|a, b| b.log_odds.total_cmp(&a.log_odds));
    list
}

/// Rounds of the pattern search over shape parameters.
const ROUNDS: usize = 9;
/// Log evidence that a refined parameter costs.
const PARAMETER_COST: f64 = 1.5;

/// Improves the shape parameters of a candidate by a pattern search.
fn refine(stage: &Stage, family: &Family, candidate: Candidate) -> Candidate {
    let machine = stage.ground.context.machine();
    let mut best = candidate;
    let cost = best.judgement.log_evidence - best.log_odds;
    let mut steps: Vec<f64> = family.refined.iter().map(|refined| refined.step).collect();
    let mut moved = false;
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
                let terms = family_terms(machine, family, &effect, stage.ground.tests());
                let Ok(columns) = stage.ground.columns(&effect, &terms) else { continue };
                let judgement = stage.judge(&columns, family.plausible);
                let log_odds = judgement.log_evidence - cost;
                if log_odds > best.log_odds {
                    best = Candidate { family: best.family, effect, terms, columns, judgement, log_odds };
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
    if moved {
        best.log_odds -= PARAMETER_COST * family.refined.len() as f64;
    }
    best
}

/// Next value of a parameter: periods, orders and travels move by ratio, the others by difference.
fn stepped(refined: &Refined, now: f64, step: f64) -> f64 {
    let by_ratio = matches!(refined.name, "periods" | "travel" | "servo_hz" | "frequency");
    let next = if by_ratio { now * (1.0 + step.abs()).powf(step.signum()) } else { now + step };
    next.clamp(refined.least, refined.most)
}

fn parameter(effect: &Effect, refined: &Refined) -> Option<f64> {
    match (effect.parameter(refined.name), refined.element) {
        (Some(ParameterValue::Number(value)), None) => Some(*value),
        (Some(ParameterValue::List(values)), Some(element)) => values.get(element).copied(),
        (None, None) => match refined.name {
            "skew" | "creep_share" => Some(0.0),
            "creep_time" => Some(20.0),
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
