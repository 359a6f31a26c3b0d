//! Which few effects the evidence demands: screen every family, refine the best, compare, accept, repeat. No words, no proof.

use rayon::prelude::*;

use super::floor::{likely_noise, noise_floor};
use super::ground::{Column, Ground, Term};
use super::library::{Family, Refined, family_terms};
use super::stage::{Accepted, Judgement, Stage};
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

impl Candidate {
    /// Its columns as they join the model.
    pub fn accepted(&self) -> impl Iterator<Item = Accepted> + '_ {
        self.columns.iter().map(|column| Accepted { column: column.clone(), prior: self.judgement.tau.max(1.0) })
    }
}

/// An accepted effect with its rivals.
#[derive(Debug, Clone)]
pub struct Found {
    pub chosen: Candidate,
    /// Other candidates at the same stage, best first, with their log odds relative to the chosen one (below zero).
    pub rivals: Vec<(Candidate, f64)>,
    /// Gain in log likelihood with the noise fitted before and after, less the cost of shapes and amplitudes.
    pub log_odds: f64,
    /// The gain alone.
    pub gain: f64,
    /// Fall of the mean square residual, mm².
    pub fall_mm2: f64,
}

/// Result of a search.
pub struct Search {
    pub floor: Vec<NoiseModel>,
    pub noise_before: Vec<NoiseModel>,
    pub noise_after: Vec<NoiseModel>,
    pub found: Vec<Found>,
    /// Residuals with what was found in the fit, mm.
    pub residual_mm: Vec<Vec<f64>>,
    /// Log odds of the best candidate that was not accepted.
    pub best_left: f64,
}

/// The same session at two resolutions: all rows for what is fast, averaged rows for what is slow.
pub struct Grounds<'g, 'a> {
    pub fine: &'g Ground<'a>,
    pub coarse: &'g Ground<'a>,
}

/// Most effects of one session.
const MOST_EFFECTS: usize = 6;
/// Log odds above which an effect is accepted.
const ACCEPT: f64 = 14.0;
/// Families refined at each stage.
const REFINED: usize = 12;
/// A free curve is preferred to a form of the catalogue only when it explains so much more.
const FREE_CURVE_MARGIN: f64 = 1.3;

/// Searches a session.
pub fn search(grounds: &Grounds, families: &[Family]) -> Search {
    let fine = grounds.fine;
    let fine_floor = noise_floor(fine, &fine.residual_mm);
    let coarse_floor = noise_floor(grounds.coarse, &grounds.coarse.residual_mm);
    let mut model: [Vec<Accepted>; 2] = [Vec::new(), Vec::new()];
    let mut found: Vec<Found> = Vec::new();
    let mut residual_mm = Stage::new(fine, &fine_floor, &model[0], &fine.kept).residual_mm(&model[0]);
    let noise_before = likely_noise(fine, &residual_mm, &fine_floor, &fine_floor);
    let mut noise = noise_before.clone();
    let mut best_left = f64::NEG_INFINITY;
    while found.len() < MOST_EFFECTS {
        let fine_noise = sharper(&fine_floor, &noise);
        let stages = [
            Stage::new(fine, &fine_noise, &model[0], &fine.kept),
            Stage::new(grounds.coarse, &coarse_floor, &model[1], &grounds.coarse.kept),
        ];
        let mut candidates = screen(&stages, families);
        keep_diverse(&mut candidates, families);
        let candidates = refine_all(&stages, families, candidates);
        let Some(best) = candidates.first() else { break };
        // the noise that the best candidate leaves is the one to compare under
        let with_best = joined(&model[0], best);
        let left = Stage::new(fine, &fine_noise, &with_best, &fine.kept).residual_mm(&with_best);
        let noise_left = likely_noise(fine, &left, &fine_noise, &fine_floor);
        let stage = Stage::new(fine, &noise_left, &model[0], &fine.kept);
        let candidates = compare(&stage, families, candidates);
        let index = choose(&candidates, families, fine);
        let chosen = candidates[index].clone();
        let with_chosen = joined(&model[0], &chosen);
        let after = Stage::new(fine, &noise_left, &with_chosen, &fine.kept);
        let left = after.residual_mm(&with_chosen);
        let noise_chosen = likely_noise(fine, &left, &noise_left, &fine_floor);
        let gain = 0.5 * (pooled_misfit(fine, &noise, &residual_mm) - pooled_misfit(fine, &noise_chosen, &left));
        let log_odds = gain - (0.5 * chosen.judgement.chi2 - chosen.log_odds);
        trace(fine, families, found.len(), &candidates, index, (gain, log_odds), &noise_chosen);
        let fall_mm2 = mean_square(fine, &residual_mm) - mean_square(fine, &left);
        if !is_demanded(&found, &chosen, (fall_mm2, log_odds), &fine_floor) {
            best_left = log_odds;
            break;
        }
        let lead = candidates[index].log_odds;
        let rivals = candidates.into_iter().enumerate().filter(|(k, _)| *k != index).map(|(_, rival)| {
            let odds = rival.log_odds - lead;
            (rival, odds)
        });
        let rivals = rivals.collect();
        let coarse_columns = grounds.coarse.columns(&chosen.effect, &chosen.terms).unwrap_or_default();
        let prior = chosen.judgement.tau.max(1.0);
        model[1].extend(coarse_columns.into_iter().map(|column| Accepted { column, prior }));
        model[0] = with_chosen;
        residual_mm = left;
        noise = noise_chosen;
        found.push(Found { chosen, rivals, log_odds, gain, fall_mm2 });
    }
    Search { floor: fine_floor, noise_before, noise_after: noise, found, residual_mm, best_left }
}

/// A search that was not made: nothing found.
pub fn nothing(ground: &Ground) -> Search {
    let floor = noise_floor(ground, &ground.residual_mm);
    Search {
        noise_before: floor.clone(),
        noise_after: floor.clone(),
        floor,
        found: Vec::new(),
        residual_mm: ground.residual_mm.clone(),
        best_left: f64::NEG_INFINITY,
    }
}

/// Log odds that a further effect at another place needs: what is left of an inexact form must not pass for it.
const ACCEPT_FURTHER: f64 = 30.0;
/// Share of the mean square that all effects found before explain which a further one must explain, at the same place
/// and elsewhere.
const LEAST_SHARE: f64 = 0.002;
const LEAST_SHARE_ELSEWHERE: f64 = 0.015;
/// Rms that an effect must take off the residual, in noise floors: the first one, and a further one elsewhere.
const LEAST_RMS: f64 = 0.1;
const LEAST_RMS_ELSEWHERE: f64 = 0.3;

/// Whether the evidence demands a candidate beside what was found.
fn is_demanded(found: &[Found], chosen: &Candidate, (fall_mm2, log_odds): (f64, f64), floor: &[NoiseModel]) -> bool {
    let noise_mm2 = floor.iter().map(|noise| noise.rms_mm().powi(2)).sum::<f64>() / floor.len().max(1) as f64;
    let in_noise = |share: f64| fall_mm2 > share * share * noise_mm2;
    if found.is_empty() {
        return log_odds > ACCEPT && in_noise(LEAST_RMS);
    }
    let explained: f64 = found.iter().map(|found| found.fall_mm2).sum();
    let same_place = found.iter().any(|other| other.chosen.effect.place == chosen.effect.place);
    match same_place {
        true => log_odds > ACCEPT && fall_mm2 > LEAST_SHARE * explained,
        false => {
            log_odds > ACCEPT_FURTHER && fall_mm2 > LEAST_SHARE_ELSEWHERE * explained && in_noise(LEAST_RMS_ELSEWHERE)
        }
    }
}

/// Mean square of the rows that take part, mm².
fn mean_square(ground: &Ground, residual_mm: &[Vec<f64>]) -> f64 {
    let kept = residual_mm
        .iter()
        .zip(&ground.kept)
        .flat_map(|(residual, kept)| residual.iter().zip(kept).filter(|(_, kept)| **kept));
    crate::identify::rms(kept.map(|(value, _)| *value)).powi(2)
}

/// Prints the standing of the best candidates when the variable FIVEAXIS_TRACE is set: for work on the search itself.
fn trace(
    ground: &Ground,
    families: &[Family],
    stage: usize,
    candidates: &[Candidate],
    index: usize,
    (gain, log_odds): (f64, f64),
    noise: &[NoiseModel],
) {
    if std::env::var_os("FIVEAXIS_TRACE").is_none() {
        return;
    }
    let machine = ground.context.machine();
    eprintln!("stage {stage}: gain {gain:.1} log odds {log_odds:.1} chosen {index}; noise {:?}", noise.first());
    for candidate in candidates.iter().take(8) {
        let outlets: Vec<String> =
            families[candidate.family].outlets.iter().map(|outlet| outlet.name(machine)).collect();
        let effect = &candidate.effect;
        eprintln!(
            "   {:9.1} chi2 {:9.1} {} {} {} {:?}",
            candidate.log_odds,
            candidate.judgement.chi2,
            effect.kind,
            effect.place.name(machine),
            outlets.join(" "),
            effect.parameters
        );
    }
}

/// Keeps the best candidates, but not only free curves: as many named ones are refined as free ones.
fn keep_diverse(candidates: &mut Vec<Candidate>, families: &[Family]) {
    let mut named = 0;
    let mut free = 0;
    candidates.retain(|candidate| {
        let count = if families[candidate.family].kind == "unknown" { &mut free } else { &mut named };
        *count += 1;
        *count <= if families[candidate.family].kind == "unknown" { 3 } else { REFINED }
    });
}

/// Judges refined candidates under one noise, on all rows.
fn compare(stage: &Stage, families: &[Family], mut candidates: Vec<Candidate>) -> Vec<Candidate> {
    candidates.par_iter_mut().for_each(|candidate| {
        let cost = candidate.judgement.log_evidence - candidate.log_odds;
        candidate.judgement = stage.judge(&candidate.columns, families[candidate.family].plausible);
        candidate.log_odds = candidate.judgement.log_evidence - cost;
    });
    candidates.sort_by(|a, b| b.log_odds.total_cmp(&a.log_odds));
    candidates
}

/// Log odds within which candidates count as equal, so that the customary name decides.
const TIE: f64 = 3.0;

/// The candidate to accept: the best named one, unless a free curve explains far more; customary names win ties.
fn choose(candidates: &[Candidate], families: &[Family], ground: &Ground) -> usize {
    let is_free = |candidate: &Candidate| families[candidate.family].kind == "unknown";
    let best_named = candidates.iter().position(|candidate| !is_free(candidate));
    let best = match best_named {
        Some(named) if is_free(&candidates[0]) => {
            let far_more = candidates[0].judgement.chi2 > FREE_CURVE_MARGIN * candidates[named].judgement.chi2 + 30.0;
            if far_more { 0 } else { named }
        }
        _ => 0,
    };
    let near = |candidate: &Candidate| candidates[best].log_odds - candidate.log_odds < TIE && !is_free(candidate);
    (0..candidates.len())
        .filter(|&k| k == best || near(&candidates[k]))
        .min_by_key(|&k| (families[candidates[k].family].customary_rank(ground), k != best))
        .unwrap_or(best)
}

/// The smaller of floor and present noise: missing physics must not make the screening blind.
fn sharper(floor: &[NoiseModel], noise: &[NoiseModel]) -> Vec<NoiseModel> {
    floor
        .iter()
        .zip(noise)
        .map(|(floor, noise)| if noise.rms_mm() < floor.rms_mm() { *noise } else { *floor })
        .collect()
}

fn pooled_misfit(ground: &Ground, noise: &[NoiseModel], residual_mm: &[Vec<f64>]) -> f64 {
    (0..ground.tests())
        .map(|test| {
            let kept = &ground.kept[test];
            let masked: Vec<f64> =
                residual_mm[test].iter().zip(kept).map(|(r, kept)| if *kept { *r } else { f64::NAN }).collect();
            misfit(&noise[test], &[masked])
        })
        .sum()
}

fn joined(model: &[Accepted], candidate: &Candidate) -> Vec<Accepted> {
    model.iter().cloned().chain(candidate.accepted()).collect()
}

/// The stage at which a family is judged: all rows for fast ones.
fn stage_of<'s, 'g, 'a>(stages: &'s [Stage<'g, 'a>; 2], family: &Family) -> &'s Stage<'g, 'a> {
    &stages[usize::from(!family.fast)]
}

/// Cells of a long periodic grid that are judged exactly after a quick look at all.
const SPECTRAL_CELLS: usize = 5;
/// Periodic grids longer than this get the quick look.
const LONG_GRID: usize = 24;

/// The best cell of every family, best first.
fn screen(stages: &[Stage; 2], families: &[Family]) -> Vec<Candidate> {
    let machine = stages[0].ground.context.machine();
    let matched = stages[0].matched();
    let mut list: Vec<Candidate> = families
        .par_iter()
        .enumerate()
        .filter_map(|(index, family)| {
            let stage = stage_of(stages, family);
            let grid: Vec<&Effect> = if family.kind == "cyclic-error" && family.grid.len() > LONG_GRID {
                loudest(stage.ground, family, &matched)
            } else {
                family.grid.iter().collect()
            };
            let cells = grid.into_iter().filter_map(|effect| {
                let terms = family_terms(machine, family, effect, stage.ground.tests());
                let columns = stage.ground.columns(effect, &terms).ok()?;
                let judgement = stage.judge(&columns, family.plausible);
                let log_odds = judgement.log_evidence;
                Some(Candidate { family: index, effect: effect.clone(), terms, columns, log_odds, judgement })
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

/// The periods of a grid whose sine or cosine the matched residual holds most of, over tests in which the axis moves.
fn loudest<'f>(ground: &Ground, family: &'f Family, matched: &[Vec<f64>]) -> Vec<&'f Effect> {
    let Some(axis) = family.place.axis() else { return Vec::new() };
    let gains = ground.gains(&family.outlets[0]);
    let tests: Vec<usize> = (0..ground.tests())
        .filter(|&test| ground.context.motion(test).moving.contains(&axis) && !gains[test].is_empty())
        .collect();
    let rows: Vec<(f64, f64, f64)> = tests
        .iter()
        .flat_map(|&test| {
            let gain = &gains[test];
            let positions = ground.context.motion(test).axis(axis);
            positions.zip(gain.iter().zip(&matched[test])).map(|(q, (g, m))| (q, g * m, g * g)).collect::<Vec<_>>()
        })
        .collect();
    let power = |effect: &Effect| -> f64 {
        let Some(frequency) = angular_frequency(effect) else { return 0.0 };
        let (mut c, mut s, mut cc, mut ss) = (0.0, 0.0, 0.0, 0.0);
        for &(q, gm, gg) in &rows {
            let (sin, cos) = (frequency * q).sin_cos();
            c += gm * cos;
            s += gm * sin;
            cc += gg * cos * cos;
            ss += gg * sin * sin;
        }
        c * c / cc.max(f64::MIN_POSITIVE) + s * s / ss.max(f64::MIN_POSITIVE)
    };
    let mut order: Vec<(usize, f64)> = family.grid.iter().map(power).enumerate().collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    order.into_iter().take(SPECTRAL_CELLS).map(|(index, _)| &family.grid[index]).collect()
}

/// Phase per mm or rad of the first order or period of an effect.
fn angular_frequency(effect: &Effect) -> Option<f64> {
    match (effect.parameter("orders"), effect.parameter("periods")) {
        (Some(ParameterValue::List(orders)), _) => orders.first().copied(),
        (_, Some(ParameterValue::List(periods))) => periods.first().map(|period| std::f64::consts::TAU / period),
        _ => None,
    }
}

/// Refined shapes; their columns are those of all rows.
fn refine_all(stages: &[Stage; 2], families: &[Family], candidates: Vec<Candidate>) -> Vec<Candidate> {
    let mut list: Vec<Candidate> = candidates
        .into_par_iter()
        .map(|candidate| {
            let family = &families[candidate.family];
            let mut refined = refine(stage_of(stages, family), family, candidate);
            if let Ok(columns) = stages[0].ground.columns(&refined.effect, &refined.terms) {
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
