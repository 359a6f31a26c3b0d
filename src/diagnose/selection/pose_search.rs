//! The search in sessions of static poses, where readings share the error of their pose and no noise is known beforehand.
//!
//! Likelihoods are weakened by the number of readings that count as one: then evidence for an effect is evidence that
//! poses not used for it are predicted better. A first search learns how fast the axes are to each other from what
//! arrival leaves; the second starts anew with that.

use std::sync::Arc;

use super::joint_fit::{joined, mean_square};
use super::ranking::{choose, compare, keep_diverse, note_contenders};
use super::screening::screen::screen;
use super::screening::screening_grid::ScreeningGrid;
use super::selected::{Candidate, Search, SelectedEffect};
use super::shapes::judged_shape::PARAMETER_COST;
use super::shapes::shape_fit::refine_all;
use crate::diagnose::model::linear_model::{Column, LinearModel};
use crate::diagnose::model::regression::{Accepted, Regression};
use crate::diagnose::model::whitened::WhitenedData;
use crate::diagnose::noise::pose_noise::{Poses, noise_groups, readings_as_one, squares_by_class, white_by_class};
use crate::effects::CandidateFamily;
use crate::effects::{Signature, is_a};
use crate::machine::{ParameterValue, Place};
use crate::statistics::{BlockEvidence, NoiseModel};

/// Effects at most: a bound on time, far beyond what recordings of an arm have shown.
const MOST_EFFECTS: usize = 40;
/// Share of a rival's log odds that is left once the chosen one is in the model, up to which it was a rival at all.
const STILL_THERE: f64 = 0.5;
/// Share of the best log odds of a look that a further one must keep to be accepted without another look.
const NEARLY_AS_STRONG: f64 = 0.3;
/// Log evidence that another shape of an accepted effect must gain: less says nothing, and all that is known of its columns would
/// have to be worked out again.
const WORTH_ANOTHER_SHAPE: f64 = 0.5;
/// Steps by which relative top speeds are refined, as ratios, coarse to fine; each is tried so many times on every axis.
const RATE_STEPS: [f64; 3] = [1.25, 1.1, 1.04];
const RATE_ROUNDS: usize = 2;

/// Searches a session of static poses.
pub fn search_poses(model: &LinearModel, families: &[CandidateFamily]) -> Search {
    let poses = Poses::of(model);
    let mut state = State::start(model, families, &poses);
    let floor = state.noise.clone();
    let residual_before_mm2 = mean_square(model, &state.residual_mm);
    // a load that was measured is asked before anything else that could imitate it, then the weight of what is beyond
    let loads = only_loads(families);
    state.rounds(&loads, &poses, model.thresholds.accept);
    if !state.has_load() {
        state.take_weights(families, &poses);
    }
    state.rounds(&without_free_curves(families), &poses, model.thresholds.accept);
    let mut families = families.to_vec();
    if let Some(rates) = state.refined_rates() {
        let arrivals = families.iter_mut().filter(|family| is_a(family.kind, Signature::Arrival));
        for effect in arrivals.flat_map(|family| &mut family.grid) {
            effect.set("rates", ParameterValue::List(rates.clone()));
        }
        state = state.again();
    }
    if !state.has_load() {
        state.rounds(&loads, &poses, model.thresholds.accept_form);
    }
    if state.found.is_empty() {
        state.take_weights(&families, &poses);
    }
    state.rounds(&without_free_curves(&families), &poses, model.thresholds.accept_form);
    state.weigh_again(&families, &poses);
    state.rounds(&families, &poses, model.thresholds.accept_form);
    Search {
        beside: Vec::new(),
        residual_before_mm2,
        floor,
        noise_after: state.noise,
        found: state.found,
        residual_mm: state.residual_mm,
        other: None,
        contenders: state.contenders,
        stated_misfit: 0.0,
    }
}

/// The same list with nothing to look at but compliance under measured loads.
fn only_loads(families: &[CandidateFamily]) -> Vec<CandidateFamily> {
    let mut loads = families.to_vec();
    loads.iter_mut().filter(|family| !is_a(family.kind, Signature::Load)).for_each(|family| family.grid.clear());
    loads
}

/// The same list with nothing to look at for free curves: they are many columns and asked when named forms are used up.
fn without_free_curves(families: &[CandidateFamily]) -> Vec<CandidateFamily> {
    let mut named = families.to_vec();
    named.iter_mut().filter(|family| is_a(family.kind, Signature::FreeCurve)).for_each(|family| family.grid.clear());
    named
}

/// What has been found so far and what it leaves.
pub(super) struct State<'g, 'a> {
    pub(super) model: &'g LinearModel<'a>,
    pub(super) joint: Vec<Accepted>,
    pub(super) found: Vec<SelectedEffect>,
    pub(super) residual_mm: Vec<Vec<f64>>,
    /// White noise at the level of the residual, enlarged for readings that count as one.
    noise: Vec<NoiseModel>,
    /// The session under the noise that it began with. That of each group of tests only changes by a factor: shapes that were judged
    /// are not worked out again.
    whitened: (Vec<NoiseModel>, Arc<WhitenedData<'g, 'a>>),
    /// Families that came near the best one at any look so far, by number; those asked before any look are among them.
    contenders: Vec<bool>,
}

impl<'g, 'a> State<'g, 'a> {
    /// What is left beside some columns.
    pub(super) fn regression(&self, joint: &[Accepted]) -> Regression<'g, 'a> {
        let (noise, data) = &self.whitened;
        Regression::weighted(data.clone(), weights(data, noise, &self.noise), joint)
    }

    /// The same for rows and for averaged rows alike: poses are not averaged.
    fn regressions(&self, joint: &[Accepted]) -> [Regression<'g, 'a>; 2] {
        let regression = self.regression(joint);
        [regression.clone(), regression]
    }

    fn start(model: &'g LinearModel<'a>, families: &[CandidateFamily], poses: &Poses) -> State<'g, 'a> {
        let residual_mm = model.residual_mm.clone();
        let noise = noise(model, poses, &residual_mm);
        let data = WhitenedData::new(model, &noise, &model.kept).grouped(noise_groups(model));
        let whitened = (noise.clone(), Arc::new(data));
        let is_asked_first =
            |family: &CandidateFamily| is_a(family.kind, Signature::Load) || is_a(family.kind, Signature::Weight);
        let contenders = families.iter().map(is_asked_first).collect();
        State { model, joint: Vec::new(), found: Vec::new(), residual_mm, noise, whitened, contenders }
    }

    /// Starts anew with what is known of shapes.
    fn again(self) -> State<'g, 'a> {
        let (residual_mm, noise) = (self.model.residual_mm.clone(), self.whitened.0.clone());
        State { joint: Vec::new(), found: Vec::new(), residual_mm, noise, ..self }
    }

    /// Whether a measured load was found to act.
    fn has_load(&self) -> bool {
        self.found.iter().any(|found| is_a(&found.chosen.effect.kind, Signature::Load))
    }

    /// Noise as a residual shows it.
    pub(super) fn set_noise(&mut self, poses: &Poses, residual_mm: &[Vec<f64>]) {
        self.noise = noise(self.model, poses, residual_mm);
    }

    /// Gain in log likelihood from one residual to another, the noise fitted to each.
    fn gain(&self, poses: &Poses, before_mm: &[Vec<f64>], after_mm: &[Vec<f64>]) -> f64 {
        let classes = squares_by_class(self.model, before_mm).into_iter().zip(squares_by_class(self.model, after_mm));
        let ratios = classes.filter(|((_, count), (after, _))| *count > 0 && *after > 0.0);
        let sum: f64 = ratios.map(|((before, count), (after, _))| count as f64 * (before / after).ln()).sum();
        0.5 * sum / readings_as_one(self.model, poses, after_mm)
    }

    /// Accepts candidates that were judged together, each with what it adds beside the others.
    pub(super) fn accept_together(&mut self, candidates: Vec<Candidate>, poses: &Poses) {
        let others = |without: usize| {
            let rest = candidates.iter().enumerate().filter(move |(k, _)| *k != without);
            rest.flat_map(|(_, candidate)| candidate.accepted())
        };
        let before = self.joint.clone();
        let joint: Vec<Accepted> = before.iter().cloned().chain(others(candidates.len())).collect();
        let left = self.regression(&joint).residual_mm(&joint);
        let square_after = mean_square(self.model, &left);
        let mut found = Vec::with_capacity(candidates.len());
        for (index, candidate) in candidates.iter().enumerate() {
            let rest: Vec<Accepted> = before.iter().cloned().chain(others(index)).collect();
            let regression = self.regression(&rest);
            let without = regression.residual_mm(&rest);
            let judgement = regression.judge(&candidate.columns, candidate.judgement.tau);
            let gain = self.gain(poses, &without, &left);
            let (log_odds, tau) = (judgement.log_evidence, candidate.judgement.tau);
            let judgement = BlockEvidence { tau, ..judgement };
            let chosen = Candidate { judgement, log_odds, ..candidate.clone() };
            found.push(SelectedEffect {
                log_odds: gain - (0.5 * chosen.judgement.chi2 - log_odds),
                chosen,
                rivals: Vec::new(),
                gain,
                ranked_odds: gain,
                beside_gain: gain,
                fall_mm2: mean_square(self.model, &without) - square_after,
                form_withdrawn: false,
            });
        }
        self.found.extend(found);
        self.set_noise(poses, &left);
        self.residual_mm = left;
        self.joint = joint;
    }

    /// Rounds until nothing more passes.
    fn rounds(&mut self, families: &[CandidateFamily], poses: &Poses, least_log_odds: f64) {
        let cells = ScreeningGrid::of(self.model, families);
        while self.found.len() < MOST_EFFECTS {
            let regressions = self.regressions(&self.joint);
            let mut candidates = screen(&regressions, families, &cells);
            note_contenders(&mut self.contenders, &candidates);
            keep_diverse(&mut candidates, families);
            let candidates = refine_all(&regressions, families, candidates);
            note_contenders(&mut self.contenders, &candidates);
            let best = candidates.first().map_or(f64::NEG_INFINITY, |best| best.log_odds);
            let least = if self.found.is_empty() { self.model.thresholds.accept } else { least_log_odds };
            if best < least {
                return;
            }
            let before = self.found.len();
            self.accept_all(families, candidates, least, poses);
            // what acts as other axes turn hardly moves a shape
            let new: Vec<Place> = self.found[before..].iter().map(|found| found.chosen.effect.place).collect();
            for place in 0..self.found.len() {
                if new.contains(&self.found[place].chosen.effect.place) {
                    self.refine_again(families, place, poses);
                }
            }
        }
    }

    /// Accepts the best candidate of a look, and the next ones as long as they stay nearly as strong beside it: a look costs far
    /// more than a judgement.
    fn accept_all(&mut self, families: &[CandidateFamily], mut candidates: Vec<Candidate>, least: f64, poses: &Poses) {
        let strongest = candidates.first().map_or(0.0, |best| best.log_odds);
        loop {
            let index = choose(&candidates, families, self.model);
            self.accept(families, candidates.clone(), index, poses);
            candidates.remove(index);
            if self.found.len() >= MOST_EFFECTS {
                return;
            }
            let regression = self.regression(&self.joint);
            candidates = compare(&regression, families, candidates);
            note_contenders(&mut self.contenders, &candidates);
            if candidates.first().is_none_or(|next| next.log_odds < least.max(NEARLY_AS_STRONG * strongest)) {
                return;
            }
        }
    }

    fn accept(&mut self, families: &[CandidateFamily], candidates: Vec<Candidate>, index: usize, poses: &Poses) {
        let chosen = candidates[index].clone();
        let joint = joined(&self.joint, &chosen);
        let regression = self.regression(&joint);
        let left = regression.residual_mm(&joint);
        let (square_before, square_after) =
            (mean_square(self.model, &self.residual_mm), mean_square(self.model, &left));
        let gain = self.gain(poses, &self.residual_mm, &left);
        let log_odds = gain - (0.5 * chosen.judgement.chi2 - chosen.log_odds);
        let rivals = candidates
            .into_iter()
            .enumerate()
            .filter(|(k, _)| *k != index)
            .filter(|(_, other)| {
                let again = regression.judge(&other.columns, families[other.family].plausible).log_evidence;
                again < STILL_THERE * other.judgement.log_evidence
            })
            .map(|(_, rival)| {
                let odds = rival.log_odds - chosen.log_odds;
                (rival, odds)
            })
            .collect();
        self.noise = noise(self.model, poses, &left);
        self.residual_mm = left;
        self.joint = joint;
        self.found.push(SelectedEffect {
            chosen,
            rivals,
            log_odds,
            gain,
            ranked_odds: gain,
            beside_gain: gain,
            fall_mm2: square_before - square_after,
            form_withdrawn: false,
        });
    }

    /// Finds the shape of an accepted effect once more beside the others: it was judged when more was unexplained.
    fn refine_again(&mut self, families: &[CandidateFamily], place: usize, poses: &Poses) {
        let family = self.found[place].chosen.family;
        if families[family].refined.is_empty() {
            return;
        }
        let mut alone = families.to_vec();
        let rest = alone.iter_mut().enumerate().filter(|(index, _)| *index != family);
        rest.for_each(|(_, other)| other.grid.clear());
        let others: Vec<Accepted> = (0..self.found.len())
            .filter(|&other| other != place)
            .flat_map(|other| self.found[other].chosen.accepted())
            .collect();
        let regressions = self.regressions(&others);
        let cells = ScreeningGrid::of(self.model, &alone);
        let Some(again) = refine_all(&regressions, &alone, screen(&regressions, &alone, &cells)).into_iter().next()
        else {
            return;
        };
        let now = regressions[0].judge(&self.found[place].chosen.columns, families[family].plausible);
        if again.judgement.log_evidence <= now.log_evidence + WORTH_ANOTHER_SHAPE {
            return;
        }
        self.found[place].chosen = again;
        let joint: Vec<Accepted> = self.found.iter().flat_map(|found| found.chosen.accepted()).collect();
        self.residual_mm = self.regression(&joint).residual_mm(&joint);
        self.joint = joint;
        self.noise = noise(self.model, poses, &self.residual_mm);
    }

    /// Relative top speeds of the axes, refined for all arrival effects together; `None` where equal ones do as well.
    fn refined_rates(&self) -> Option<Vec<f64>> {
        let (arrivals, others): (Vec<&SelectedEffect>, Vec<&SelectedEffect>) =
            self.found.iter().partition(|found| is_a(&found.chosen.effect.kind, Signature::Arrival));
        if arrivals.is_empty() {
            return None;
        }
        let others: Vec<Accepted> = others.iter().flat_map(|found| found.chosen.accepted()).collect();
        let regression = Regression::new(self.model, &self.noise, &others, &self.model.kept);
        let gain = |rates: &[f64]| -> Option<f64> {
            let mut all: Vec<Column> = Vec::new();
            for found in &arrivals {
                let effect = found.chosen.effect.clone().with("rates", ParameterValue::List(rates.to_vec()));
                all.extend(self.model.columns(&effect, &found.chosen.terms).ok()?);
            }
            Some(0.5 * regression.judge(&all, f64::INFINITY).chi2)
        };
        let axes = self.model.context.machine().axes.len();
        let mut rates = vec![1.0; axes];
        let equal = gain(&rates)?;
        let mut best = equal;
        for step in RATE_STEPS {
            for axis in (0..RATE_ROUNDS).flat_map(|_| 0..axes) {
                for factor in [step, 1.0 / step] {
                    let mut tried = rates.clone();
                    tried[axis] *= factor;
                    if let Some(gain) = gain(&tried).filter(|gain| *gain > best) {
                        (best, rates) = (gain, tried);
                    }
                }
            }
        }
        // only ratios matter
        let largest = rates.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let rounded = rates.iter().map(|rate| (1e3 * rate / largest).round() / 1e3).collect();
        (best - equal > PARAMETER_COST * axes as f64).then_some(rounded)
    }
}

/// By group of tests: how much more squares count under a noise than under another one.
fn weights(data: &WhitenedData, from: &[NoiseModel], to: &[NoiseModel]) -> Vec<f64> {
    let mut weights = vec![1.0; data.group_count()];
    for (&group, (from, to)) in data.groups().iter().zip(from.iter().zip(to)) {
        weights[group] = (from.white_mm / to.white_mm).powi(2);
    }
    weights
}

/// White noise that makes one likelihood out of readings which share the error of their pose.
fn noise(model: &LinearModel, poses: &Poses, residual_mm: &[Vec<f64>]) -> Vec<NoiseModel> {
    white_by_class(model, residual_mm, readings_as_one(model, poses, residual_mm))
}
