//! Which few effects the evidence demands: screen every family, refine the best, compare, accept, repeat. No words, no proof.

use rayon::prelude::*;

use super::floor::{likely_noise, noise_floor};
use super::ground::{Column, Ground, Term};
use super::library::{Family, Refined, terms};
use super::stage::{Judgement, Stage};
use crate::identify::{NoiseModel, misfit};
use crate::machine::{Effect, ParameterValue};

/// A candidate with its best shape.
#[derive(Debug, Clone)]
pub struct Candidate {
    pub family: usize,
    pub effect: Effect,
    pub terms: Vec<Term>,
    pub columns: Vec<Column>,
    pub judgement: Judgement,
    /// Log evidence with the cost of the shape grid taken off.
    pub log_odds: f64,
}

/// An accepted effect with its rivals.
#[derive(Debug, Clone)]
pub struct Found {
    pub chosen: Candidate,
    /// Other candidates at the same stage, best first, with their log odds relative to the chosen one (below zero).
    pub rivals: Vec<(Candidate, f64)>,
    /// Gain in log likelihood with the noise fitted before and after, less the cost of shapes and amplitudes.
    pub log_odds: f64,
}

/// Result of a search.
pub struct Search {
    pub floor: Vec<NoiseModel>,
    pub noise_before: Vec<NoiseModel>,
    pub noise_after: Vec<NoiseModel>,
    pub found: Vec<Found>,
    /// Residuals with what was found in the fit, mm.
    pub residual_mm: Vec<Vec<f64>>,
}

/// Most effects of one session.
const MOST_EFFECTS: usize = 4;
/// Log odds above which an effect is accepted.
const ACCEPT: f64 = 14.0;
/// Families refined at each stage.
const REFINED: usize = 14;
/// A further effect explains at least this share of what the first explained.
const LEAST_SHARE: f64 = 0.01;

/// Searches a session.
pub fn search(ground: &Ground, families: &[Family], kept: &[Vec<bool>]) -> Search {
    let mut columns: Vec<Column> = Vec::new();
    let mut found: Vec<Found> = Vec::new();
    let floor = noise_floor(ground, &ground.residual_mm);
    let mut residual_mm = Stage::new(ground, &floor, &columns, kept).residual_mm(&columns);
    let noise_before = likely_noise(ground, &residual_mm, &floor);
    let mut noise = noise_before.clone();
    let mut first_gain = None;
    while found.len() < MOST_EFFECTS {
        let screening = sharper(&floor, &noise);
        let stage = Stage::new(ground, &screening, &columns, kept);
        let mut candidates = screen(&stage, families);
        candidates.truncate(REFINED);
        let mut candidates = refine_all(&stage, families, candidates);
        let Some(best) = candidates.first() else { break };
        // the noise that the best candidate leaves is the one to compare under
        let with_best = joined(&columns, best);
        let left = Stage::new(ground, &screening, &with_best, kept).residual_mm(&with_best);
        let noise_left = likely_noise(ground, &left, &screening);
        let stage = Stage::new(ground, &noise_left, &columns, kept);
        candidates.par_iter_mut().for_each(|candidate| {
            let cost = candidate.judgement.log_evidence - candidate.log_odds;
            candidate.judgement = stage.judge(&candidate.columns);
            candidate.log_odds = candidate.judgement.log_evidence - cost;
        });
        candidates.sort_by(|a, b| b.log_odds.total_cmp(&a.log_odds));
        let chosen = candidates.remove(0);
        let with_chosen = joined(&columns, &chosen);
        let after = Stage::new(ground, &noise_left, &with_chosen, kept);
        let left = after.residual_mm(&with_chosen);
        let noise_chosen = likely_noise(ground, &left, &noise_left);
        let before_cost = pooled_misfit(ground, &noise, &residual_mm, kept);
        let after_cost = pooled_misfit(ground, &noise_chosen, &left, kept);
        let occam = 0.5 * chosen.judgement.chi2 - chosen.log_odds;
        let gain = 0.5 * (before_cost - after_cost);
        let log_odds = gain - occam;
        if std::env::var_os("FIVEAXIS_TRACE").is_some() {
            eprintln!("stage {}: gain {gain:.1} occam {occam:.1} log odds {log_odds:.1}; noise {:?}", found.len(), noise_chosen[0]);
            for candidate in std::iter::once(&chosen).chain(&candidates).take(8) {
                eprintln!("   {:8.1} chi2 {:8.1} {} {} {:?} {:?}", candidate.log_odds, candidate.judgement.chi2, candidate.effect.kind,
                    candidate.effect.place.name(ground.context.machine()),
                    families[candidate.family].outlets.iter().map(|o| o.name(ground.context.machine())).collect::<Vec<_>>(), candidate.effect.parameters);
            }
        }
        let share = first_gain.map_or(1.0, |first: f64| gain / first);
        if !(log_odds > ACCEPT && share > LEAST_SHARE) {
            break;
        }
        first_gain.get_or_insert(gain);
        let lead = chosen.log_odds;
        let rivals = candidates.into_iter().map(|rival| (rival.log_odds - lead, rival)).map(|(odds, rival)| (rival, odds)).collect();
        columns = with_chosen;
        residual_mm = left;
        noise = noise_chosen;
        found.push(Found { chosen, rivals, log_odds });
    }
    Search { floor, noise_before, noise_after: noise, found, residual_mm }
}

/// The smaller of floor and present noise: missing physics must not make the screening blind.
fn sharper(floor: &[NoiseModel], noise: &[NoiseModel]) -> Vec<NoiseModel> {
    floor.iter().zip(noise).map(|(floor, noise)| if noise.rms_mm() < floor.rms_mm() { *noise } else { *floor }).collect()
}

fn pooled_misfit(ground: &Ground, noise: &[NoiseModel], residual_mm: &[Vec<f64>], kept: &[Vec<bool>]) -> f64 {
    (0..ground.tests())
        .map(|test| {
            let masked: Vec<f64> = residual_mm[test].iter().zip(&kept[test]).map(|(r, kept)| if *kept { *r } else { f64::NAN }).collect();
            misfit(&noise[test], &[masked])
        })
        .sum()
}

fn joined(columns: &[Column], candidate: &Candidate) -> Vec<Column> {
    columns.iter().chain(&candidate.columns).cloned().collect()
}

/// The best cell of every family, best first.
fn screen(stage: &Stage, families: &[Family]) -> Vec<Candidate> {
    let machine = stage.ground.context.machine();
    let mut list: Vec<Candidate> = families
        .par_iter()
        .enumerate()
        .filter_map(|(index, family)| {
            let cells = family.grid.iter().filter_map(|effect| {
                let terms = terms(machine, effect, &family.outlets);
                let columns = stage.ground.columns(effect, &terms).ok()?;
                let judgement = stage.judge(&columns);
                Some(Candidate { family: index, effect: effect.clone(), terms, columns, log_odds: judgement.log_evidence, judgement })
            });
            let mut best = cells.max_by(|a, b| a.log_odds.total_cmp(&b.log_odds))?;
            best.log_odds -= (family.grid.len() as f64).ln();
            Some(best)
        })
        .filter(|candidate| candidate.log_odds > 0.0)
        .collect();
    list.sort_by(|a, b| b.log_odds.total_cmp(&a.log_odds));
    list
}

fn refine_all(stage: &Stage, families: &[Family], candidates: Vec<Candidate>) -> Vec<Candidate> {
    let mut list: Vec<Candidate> =
        candidates.into_par_iter().map(|candidate| refine(stage, &families[candidate.family], candidate)).collect();
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
                let terms = terms(machine, &effect, &family.outlets);
                let Ok(columns) = stage.ground.columns(&effect, &terms) else { continue };
                let judgement = stage.judge(&columns);
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
    let by_ratio = matches!(refined.name, "periods" | "travel");
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
