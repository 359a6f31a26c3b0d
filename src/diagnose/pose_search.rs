//! The search in sessions of static poses: an effect is accepted when it predicts poses that took no part in sizing it.
//!
//! Readings of one pose share the arm's error, so likelihoods are weakened by the number of readings that count as
//! one, and shapes that pass by likelihood must also pass on held-out poses. There are as many rounds as effects pass.

use std::collections::HashMap;

use rayon::prelude::*;

use super::ground::{Column, Ground, Term};
use super::library::{Family, family_terms};
use super::pose_floor::{Poses, floor_mm, readings_as_one};
use super::refining::refine;
use super::search::{Candidate, Found, Search, choose, joined, mean_square, trace};
use super::stage::{Accepted, Stage};
use crate::identify::NoiseModel;
use crate::machine::{Effect, ParameterValue};

/// Effects at most: a bound on time, far beyond what recordings of an arm have shown.
const MOST_EFFECTS: usize = 40;
/// Log odds above which a candidate is tried on held-out poses.
const WORTH_TRYING: f64 = 8.0;
/// Candidates refined in each round, named and free ones.
const REFINED: usize = 10;
const REFINED_FREE: usize = 2;
/// Candidates tried on held-out poses in each round before the search ends.
const TRIED: usize = 6;
/// Folds of held-out poses, and poses that are held out together.
const FOLDS: usize = 4;
const BLOCK: usize = 10;
/// Fall of the held-out sum of squares over its standard error from which it counts.
const LEAST_SIGMAS: f64 = 2.5;
/// Share of a rival's log odds that is left once the chosen one is in the model, up to which it was a rival at all.
const STILL_THERE: f64 = 0.5;
/// Steps by which relative top speeds are refined, as ratios, coarse to fine.
const RATE_STEPS: [f64; 3] = [1.25, 1.1, 1.04];

/// Searches a session of static poses.
pub fn search_poses(ground: &Ground, families: &[Family]) -> Search {
    let poses = Poses::of(ground);
    let library = Library::of(ground, families);
    let mut state = State::start(ground, &poses);
    let noise_before = state.noise.clone();
    let residual_before_mm2 = mean_square(ground, &state.residual_mm);
    let mut families = families.to_vec();
    let mut best_left = state.rounds(&families, &library, &poses);
    if let Some(rates) = state.refine_rates(&poses) {
        for effect in
            families.iter_mut().filter(|family| family.kind == "arrival-lag").flat_map(|family| &mut family.grid)
        {
            effect.set("rates", ParameterValue::List(rates.clone()));
        }
        let library = Library::of(ground, &families);
        best_left = state.rounds(&families, &library, &poses);
    }
    let floor = floor_mm(ground, &poses)
        .map_or_else(|| state.noise.clone(), |white| vec![NoiseModel::white(white); ground.tests()]);
    Search {
        residual_before_mm2,
        floor,
        noise_before,
        noise_after: state.noise,
        found: state.found,
        residual_mm: state.residual_mm,
        best_left,
    }
}

/// Columns of named families, worked out once: the model grows, they stay.
struct Library {
    cells: HashMap<(usize, usize), (Vec<Term>, Vec<Column>)>,
}

impl Library {
    fn of(ground: &Ground, families: &[Family]) -> Library {
        let cells: Vec<(usize, usize)> = (0..families.len())
            .filter(|&family| families[family].kind != "unknown")
            .flat_map(|family| (0..families[family].grid.len()).map(move |cell| (family, cell)))
            .collect();
        let cells = cells
            .into_par_iter()
            .filter_map(|(family, cell)| Some(((family, cell), columns(ground, &families[family], cell)?)))
            .collect();
        Library { cells }
    }
}

fn columns(ground: &Ground, family: &Family, cell: usize) -> Option<(Vec<Term>, Vec<Column>)> {
    let effect = &family.grid[cell];
    let terms = family_terms(ground.context.machine(), family, effect, ground.tests());
    let columns = ground.columns(effect, &terms).ok()?;
    Some((terms, columns))
}

/// What has been found so far and what it leaves.
struct State<'g, 'a> {
    ground: &'g Ground<'a>,
    model: Vec<Accepted>,
    found: Vec<Found>,
    residual_mm: Vec<Vec<f64>>,
    /// White noise at the level of the residual, enlarged for readings that count as one.
    noise: Vec<NoiseModel>,
}

impl<'g, 'a> State<'g, 'a> {
    fn start(ground: &'g Ground<'a>, poses: &Poses) -> State<'g, 'a> {
        let residual_mm = ground.residual_mm.clone();
        let noise = noise(ground, poses, &residual_mm);
        State { ground, model: Vec::new(), found: Vec::new(), residual_mm, noise }
    }

    /// Rounds until nothing more passes; log odds of the best candidate that did not.
    fn rounds(&mut self, families: &[Family], library: &Library, poses: &Poses) -> f64 {
        while self.found.len() < MOST_EFFECTS {
            let stage = Stage::new(self.ground, &self.noise, &self.model, &self.ground.kept);
            let candidates = screen(&stage, families, library);
            let best = candidates.first().map_or(f64::NEG_INFINITY, |best| best.log_odds);
            if best < WORTH_TRYING || !self.accept_first(families, candidates, poses) {
                return best;
            }
        }
        f64::NEG_INFINITY
    }

    /// Accepts the first candidate that helps on held-out poses.
    fn accept_first(&mut self, families: &[Family], mut candidates: Vec<Candidate>, poses: &Poses) -> bool {
        let before = held_out(self.ground, &self.noise, &self.model, poses);
        for _ in 0..TRIED {
            if candidates.first().is_none_or(|best| best.log_odds < WORTH_TRYING) {
                return false;
            }
            let index = choose(&candidates, families, self.ground);
            let chosen = candidates[index].clone();
            let with_chosen = joined(&self.model, &chosen);
            let after = held_out(self.ground, &self.noise, &with_chosen, poses);
            if sigmas(&before, &after) > LEAST_SIGMAS {
                self.accept(families, candidates, index, with_chosen, poses);
                return true;
            }
            candidates.remove(index);
        }
        false
    }

    fn accept(
        &mut self,
        families: &[Family],
        candidates: Vec<Candidate>,
        index: usize,
        model: Vec<Accepted>,
        poses: &Poses,
    ) {
        let stage = Stage::new(self.ground, &self.noise, &model, &self.ground.kept);
        let left = stage.residual_mm(&model);
        let (square_before, square_after) =
            (mean_square(self.ground, &self.residual_mm), mean_square(self.ground, &left));
        let readings = self.ground.kept.iter().flatten().filter(|kept| **kept).count() as f64;
        let gain = 0.5 * readings / readings_as_one(self.ground, poses, &left) * (square_before / square_after).ln();
        let chosen = candidates[index].clone();
        let log_odds = gain - (0.5 * chosen.judgement.chi2 - chosen.log_odds);
        trace(self.ground, families, self.found.len(), &candidates, index, (gain, log_odds), &self.noise);
        let rivals = candidates
            .into_iter()
            .enumerate()
            .filter(|(k, _)| *k != index)
            .filter(|(_, other)| {
                let again = stage.judge(&other.columns, families[other.family].plausible).log_evidence;
                again < STILL_THERE * other.judgement.log_evidence
            })
            .map(|(_, rival)| {
                let odds = rival.log_odds - chosen.log_odds;
                (rival, odds)
            })
            .collect();
        self.noise = noise(self.ground, poses, &left);
        self.residual_mm = left;
        self.model = model;
        self.found.push(Found { chosen, rivals, log_odds, gain, fall_mm2: square_before - square_after });
    }

    /// Relative top speeds of the axes, refined for all arrival effects together; `None` where that does not help on
    /// held-out poses or there is no such effect.
    fn refine_rates(&mut self, poses: &Poses) -> Option<Vec<f64>> {
        let arrivals: Vec<usize> =
            (0..self.found.len()).filter(|&k| self.found[k].chosen.effect.kind == "arrival-lag").collect();
        if arrivals.is_empty() {
            return None;
        }
        let others: Vec<Accepted> = (0..self.found.len())
            .filter(|k| !arrivals.contains(k))
            .flat_map(|k| self.found[k].chosen.accepted())
            .collect();
        let stage = Stage::new(self.ground, &self.noise, &others, &self.ground.kept);
        let with_rates = |rates: &[f64]| -> Option<(f64, Vec<Candidate>)> {
            let mut renewed = Vec::new();
            for &k in &arrivals {
                let mut chosen = self.found[k].chosen.clone();
                chosen.effect.set("rates", ParameterValue::List(rates.to_vec()));
                chosen.columns = self.ground.columns(&chosen.effect, &chosen.terms).ok()?;
                renewed.push(chosen);
            }
            let all: Vec<Column> = renewed.iter().flat_map(|chosen| chosen.columns.iter().cloned()).collect();
            Some((stage.judge(&all, f64::INFINITY).chi2, renewed))
        };
        let axes = self.ground.context.machine().axes.len();
        let mut rates = vec![1.0; axes];
        let (mut best, mut renewed) = with_rates(&rates)?;
        for step in RATE_STEPS {
            for _ in 0..2 {
                for axis in 0..axes {
                    for factor in [step, 1.0 / step] {
                        let mut tried = rates.clone();
                        tried[axis] *= factor;
                        if let Some((chi2, candidates)) = with_rates(&tried).filter(|(chi2, _)| *chi2 > best) {
                            (best, renewed, rates) = (chi2, candidates, tried);
                        }
                    }
                }
            }
        }
        // only ratios matter
        let largest = rates.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let rates: Vec<f64> = rates.iter().map(|rate| (1e3 * rate / largest).round() / 1e3).collect();
        let (_, rounded) = with_rates(&rates)?;
        renewed.clone_from(&rounded);
        let model: Vec<Accepted> = (0..self.found.len())
            .flat_map(|k| match arrivals.iter().position(|&arrival| arrival == k) {
                Some(place) => renewed[place].accepted().collect::<Vec<_>>(),
                None => self.found[k].chosen.accepted().collect(),
            })
            .collect();
        let before = held_out(self.ground, &self.noise, &self.model, poses);
        let after = held_out(self.ground, &self.noise, &model, poses);
        if sigmas(&before, &after) < LEAST_SIGMAS {
            return None;
        }
        for (place, &k) in arrivals.iter().enumerate() {
            self.found[k].chosen = renewed[place].clone();
        }
        self.residual_mm = Stage::new(self.ground, &self.noise, &model, &self.ground.kept).residual_mm(&model);
        self.noise = noise(self.ground, poses, &self.residual_mm);
        self.model = model;
        Some(rates)
    }
}

/// White noise that makes one likelihood out of readings which share the error of their pose.
fn noise(ground: &Ground, poses: &Poses, residual_mm: &[Vec<f64>]) -> Vec<NoiseModel> {
    let white = (mean_square(ground, residual_mm) * readings_as_one(ground, poses, residual_mm)).sqrt();
    vec![NoiseModel::white(white.max(crate::identify::NOISE_FLOOR_MM)); ground.tests()]
}

/// The best cell of every family, best first; the best few refined.
fn screen(stage: &Stage, families: &[Family], library: &Library) -> Vec<Candidate> {
    let cell = |family: usize, cell: usize, terms: Vec<Term>, columns: Vec<Column>| -> Candidate {
        let judgement = stage.judge(&columns, families[family].plausible);
        let effect: Effect = families[family].grid[cell].clone();
        let log_odds = judgement.log_evidence - (families[family].grid.len() as f64).ln();
        Candidate { family, effect, terms, columns, judgement, log_odds }
    };
    let best_of = |family: usize| -> Option<Candidate> {
        let cells = 0..families[family].grid.len();
        let judged = cells.filter_map(|k| {
            let (terms, columns) = match library.cells.get(&(family, k)) {
                Some(known) => known.clone(),
                None => columns(stage.ground, &families[family], k)?,
            };
            Some(cell(family, k, terms, columns))
        });
        judged.max_by(|a, b| a.log_odds.total_cmp(&b.log_odds))
    };
    let sorted = |mut list: Vec<Candidate>| {
        list.retain(|candidate| candidate.log_odds > 0.0);
        list.sort_by(|a, b| b.log_odds.total_cmp(&a.log_odds));
        list
    };
    let is_free = |family: &usize| families[*family].kind == "unknown";
    let of = |list: Vec<usize>| sorted(list.into_par_iter().filter_map(best_of).collect());
    let mut list = of((0..families.len()).filter(|family| !is_free(family)).collect());
    list.truncate(REFINED);
    // free curves are many columns: they are asked only when the named forms are nearly used up
    if list.first().is_none_or(|best| best.log_odds < 2.0 * WORTH_TRYING) {
        let mut free = of((0..families.len()).filter(is_free).collect());
        free.truncate(REFINED_FREE);
        list.extend(free);
    }
    sorted(list.into_par_iter().map(|candidate| refine(stage, &families[candidate.family], candidate)).collect())
}

/// Sum of squares of every pose, mm², predicted by a fit without the block that the pose is in.
fn held_out(ground: &Ground, noise: &[NoiseModel], model: &[Accepted], poses: &Poses) -> Vec<f64> {
    let folds: Vec<Vec<f64>> = (0..FOLDS)
        .into_par_iter()
        .map(|fold| {
            let held = |test: usize, row: usize| (poses.of_row[test][row] / BLOCK) % FOLDS == fold;
            let rows = |test: usize| 0..ground.kept[test].len();
            let train: Vec<Vec<bool>> = (0..ground.tests())
                .map(|test| rows(test).map(|row| ground.kept[test][row] && !held(test, row)).collect())
                .collect();
            let residual = Stage::new(ground, noise, model, &train).residual_mm(model);
            let mut squares = vec![0.0; poses.count];
            for (test, residual) in residual.iter().enumerate() {
                for row in rows(test).filter(|&row| ground.kept[test][row] && held(test, row)) {
                    squares[poses.of_row[test][row]] += residual[row] * residual[row];
                }
            }
            squares
        })
        .collect();
    (0..poses.count).map(|pose| folds.iter().map(|fold| fold[pose]).sum()).collect()
}

/// Fall of the sum of squares over its standard error, pose by pose.
fn sigmas(before: &[f64], after: &[f64]) -> f64 {
    let (mut sum, mut square) = (0.0, 0.0);
    for (before, after) in before.iter().zip(after) {
        let fall = before - after;
        sum += fall;
        square += fall * fall;
    }
    sum / square.sqrt().max(f64::MIN_POSITIVE)
}
