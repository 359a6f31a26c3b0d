//! Grows a set of effects: screens every family, refines the best, compares, accepts, and repeats. It takes nothing back.

use super::acceptance::is_demanded;
use super::joint_fit::{JointFit, joined, mean_square, pooled_misfit, without_trends};
use super::limits::MOST_EFFECTS;
use super::ranking::{choose, compare, is_sensible, keep_diverse, note_contenders};
use super::screening::screen::screen_wanted;
use super::selected::{Candidate, SelectedEffect, SelectionContext, Step};
use super::shapes::shape_fit::refine_all;
use crate::diagnose::model::regression::Regression;
use crate::diagnose::noise::noise_floor::{likely_noise, mean_noise_mm2, wandering};
use crate::diagnose::noise::zero_walk::walk_of_the_zero;
use crate::effects::{CandidateFamily, Signature, is_a};
use crate::statistics::NoiseModel;

impl SelectionContext<'_, '_, '_> {
    /// Whether other sets of effects may still be tried.
    pub(crate) fn goes_on(&self) -> bool {
        self.steps.get() < self.limits.steps
    }

    /// Adds effects as long as the evidence demands one; the first one may be given.
    pub(crate) fn grow(&self, joint: &mut JointFit, first: Option<Candidate>) {
        self.grow_to_beat(f64::NEG_INFINITY, joint, first);
    }

    /// The same of a set that is to stand better than another one, as long as it may: of the effects that a set can hold none that
    /// follows is far stronger than the next one.
    pub(crate) fn grow_to_beat(&self, standing: f64, joint: &mut JointFit, mut first: Option<Candidate>) {
        let fine = self.resolutions.fine;
        while joint.found.len() < MOST_EFFECTS {
            let is_given = first.is_some() || standing == f64::NEG_INFINITY;
            let missing = if is_given { f64::NEG_INFINITY } else { standing - joint.standing(self) };
            let least_log_odds = missing / (MOST_EFFECTS - joint.found.len()) as f64;
            let Some(step) = self.next(joint, first.take(), least_log_odds) else { break };
            let within_mm2 = |residual_mm: &[Vec<f64>]| mean_square(fine, &without_trends(fine, residual_mm));
            let fall_within_mm2 = || within_mm2(&joint.residual_mm) - within_mm2(&step.residual_mm);
            let standing = (step.found.fall_mm2, step.found.log_odds, joint.pulls.shared_relief(&step.pulls));
            let (chosen, floor) = (&step.found.chosen, &self.floors[0]);
            let demanded = is_demanded(&self.limits, &joint.found, chosen, standing, fall_within_mm2, floor);
            if !demanded || self.is_wander_of_the_zero(joint, &step) {
                break;
            }
            joint.add(self, step);
        }
    }

    /// Whether an effect is not worth telling, the gauge's zero wandering from test to test, and walking over the session, more than the
    /// floor has it. Of what shows within a test that takes nothing.
    fn is_wander_of_the_zero(&self, joint: &JointFit, step: &Step) -> bool {
        let chosen = &step.found.chosen;
        let thresholds = &self.limits.thresholds;
        let fine = self.resolutions.fine;
        let cost = chosen.judgement.log_evidence - chosen.log_odds;
        let noise: Vec<NoiseModel> = step.noise.iter().map(|noise| wandering(noise, thresholds.zero_wanders)).collect();
        let walk = walk_of_the_zero(fine, thresholds.zero_walks * mean_noise_mm2(&self.floors[0]).sqrt());
        let beside = [joint.columns[0].as_slice(), walk.as_slice()].concat();
        let regression = Regression::new(fine, &noise, &beside, &fine.kept);
        let judgement = regression.judge(&chosen.columns, self.families[chosen.family].plausible);
        judgement.log_evidence - cost < self.limits.beside_wander
    }

    /// Whether a candidate may be told: where only free curves are looked at, all of them.
    fn is_told(&self, candidate: &Candidate) -> bool {
        self.only_free.get() || !self.families[candidate.family].only_rival
    }

    /// The candidate to accept, among those that are told.
    fn choice(&self, candidates: &[Candidate]) -> Option<usize> {
        let told: Vec<usize> = (0..candidates.len()).filter(|&k| self.is_told(&candidates[k])).collect();
        let list: Vec<Candidate> = told.iter().map(|&k| candidates[k].clone()).collect();
        (!list.is_empty()).then(|| told[choose(&list, self.families, self.resolutions.fine)])
    }

    /// Families that are looked at, by number.
    fn wanted(&self) -> Vec<bool> {
        let contenders = self.contenders.borrow();
        let is_wanted = |(family, contends): (&CandidateFamily, &bool)| {
            let is_allowed = !self.only_free.get() || is_a(family.kind, Signature::FreeCurve);
            is_allowed && (*contends || !self.only_contenders.get())
        };
        self.families.iter().zip(contenders.iter()).map(is_wanted).collect()
    }

    /// The next effect beside those of a model; `given` stands for the choice when it is stated. None where the best one of the grids has
    /// lower log odds than `least_log_odds`.
    pub(crate) fn next(&self, joint: &JointFit, given: Option<Candidate>, least_log_odds: f64) -> Option<Step> {
        self.steps.set(self.steps.get() + 1);
        let fine = self.resolutions.fine;
        let families = self.families;
        let candidates = match given {
            Some(given) => vec![given],
            None => {
                let [fine, coarse] = &self.whitened;
                let regressions = [
                    Regression::on(fine.clone(), &joint.columns[0]),
                    Regression::on(coarse.clone(), &joint.columns[1]),
                ];
                let wanted = self.wanted();
                let wanted = |index: usize| wanted[index];
                let mut candidates = screen_wanted(&regressions, families, self.resolutions.cells, wanted);
                note_contenders(&mut self.contenders.borrow_mut(), &candidates);
                candidates.retain(|candidate| {
                    let family = &families[candidate.family];
                    is_sensible(&self.limits.thresholds, family, candidate, regressions[0].misfit)
                });
                candidates.retain(|candidate| {
                    !self.balls_are_round.get() || !is_a(&candidate.effect.kind, Signature::BallForm)
                });
                if candidates.first().is_none_or(|best| best.log_odds < least_log_odds) {
                    return None;
                }
                keep_diverse(&mut candidates, families);
                refine_all(&regressions, families, candidates)
            }
        };
        let best = candidates.iter().find(|candidate| self.is_told(candidate))?;
        // the noise that the best candidate leaves is the one to compare under
        let with_best = joined(&joint.columns[0], best);
        let left = Regression::on(self.whitened[0].clone(), &with_best).residual_mm(&with_best);
        let noise_left = likely_noise(fine, &left, &self.floors[0], &self.floors[0]);
        let regression = Regression::new(fine, &noise_left, &joint.columns[0], &fine.kept);
        let candidates = compare(&regression, families, candidates);
        note_contenders(&mut self.contenders.borrow_mut(), &candidates);
        let index = self.choice(&candidates)?;
        let chosen = candidates[index].clone();
        let with_chosen = joined(&joint.columns[0], &chosen);
        let regression = Regression::new(fine, &noise_left, &with_chosen, &fine.kept);
        let (residual_mm, pulls) = (regression.residual_mm(&with_chosen), regression.pulls());
        let noise = likely_noise(fine, &residual_mm, &noise_left, &self.floors[0]);
        let gain = 0.5 * (joint.misfit(self) - pooled_misfit(fine, &noise, &residual_mm) - pulls.misfit());
        let log_odds = gain - (0.5 * chosen.judgement.chi2 - chosen.log_odds);
        let fall_mm2 = mean_square(fine, &joint.residual_mm) - mean_square(fine, &residual_mm);
        let lead = candidates[index].log_odds;
        let rivals = candidates.into_iter().enumerate().filter(|(k, _)| *k != index).map(|(_, rival)| {
            let odds = rival.log_odds - lead;
            (rival, odds)
        });
        let found = SelectedEffect {
            rivals: rivals.collect(),
            chosen,
            log_odds,
            gain,
            ranked_odds: lead,
            beside_gain: gain,
            fall_mm2,
            form_withdrawn: false,
        };
        Some(Step { found, residual_mm, pulls, noise })
    }
}
