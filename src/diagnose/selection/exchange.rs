//! Exchanges what a greedy search took too early for sets of effects that stand better. Which effect comes next is for growing.

use crate::effects::{Signature, is_a};
use std::collections::HashSet;

use super::acceptance::{adds_enough, relieves};
use super::joint_fit::{JointFit, mean_square, rest_of};
use super::ranking::simpler;
use super::selected::{Candidate, SelectedEffect, SelectionContext};
use super::shapes::shape_average::cancels;
use crate::diagnose::model::regression::{Accepted, Regression};
use crate::diagnose::noise::noise_floor::mean_noise_mm2;

/// Other first steps that are tried.
const OTHER_STARTS: usize = 4;

/// Effects of the machine that may stand for a ball out of round.
const MOST_FOR_A_BALL: usize = 3;

/// Whether an effect is growth of two nodes that nearly cancel, or differs in every test: they follow whatever changes from test
/// to test.
fn bends_to_anything(found: &SelectedEffect) -> bool {
    let chosen = &found.chosen;
    chosen.differs_by_test()
        || is_a(&chosen.effect.kind, Signature::Growth) && cancels(&chosen.terms, &chosen.judgement.amplitudes)
}

/// How many places a set acts at.
fn places_of(set: &JointFit) -> usize {
    set.found.iter().map(|found| found.chosen.effect.place).collect::<HashSet<_>>().len()
}

impl SelectionContext<'_, '_, '_> {
    /// Replaces what a greedy search took too early: the first effect where much stays unexplained or it bends to anything, then
    /// each beside the others.
    pub(crate) fn exchange(&self, joint: &mut JointFit) {
        let floor_mm2 = mean_noise_mm2(&self.floors[0]);
        let left_mm2 = mean_square(self.resolutions.fine, &joint.residual_mm);
        let is_doubtful = |first: &SelectedEffect| {
            left_mm2 > self.limits.thresholds.explained.powi(2) * floor_mm2 || bends_to_anything(first)
        };
        // what follows anything has hidden what else there is
        self.only_contenders.set(!joint.found.first().is_some_and(bends_to_anything));
        if joint.found.first().is_some_and(is_doubtful) {
            self.start_otherwise(joint);
        }
        let round_ball = self.round_balls(joint);
        self.take_other_motions(joint);
        for index in (0..joint.found.len()).rev() {
            // a model that was replaced may be shorter
            if index >= joint.found.len() {
                continue;
            }
            // an effect that was given has no rivals yet
            let has_rivals = !joint.found[index].rivals.is_empty();
            if has_rivals && (joint.found.len() == 1 || !self.goes_on()) {
                continue;
            }
            // a free curve at the place of an effect found before it is the rest of that one's form
            if rest_of(&joint.found, index).is_some() {
                continue;
            }
            let mut trial = joint.without(self, index);
            let Some(step) = self.next(&trial, None, f64::NEG_INFINITY) else { continue };
            let old = joint.found[index].chosen.family;
            let mut rivals = step.found.rivals.clone();
            let ranked_odds = step.found.ranked_odds;
            // beside the same motion in fewer directions, one in more is a rival and no other set
            let is_simpler =
                simpler(self.resolutions.fine, &[step.found.chosen.clone(), joint.found[index].chosen.clone()], 0)
                    .is_some();
            if step.found.chosen.family != old && !is_simpler {
                rivals.insert(0, (step.found.chosen.clone(), 0.0));
                trial.add(self, step);
                self.grow(&mut trial, None);
                if self.replace(joint, trial, self.limits.thresholds.better) {
                    continue;
                }
            } else if step.found.chosen.family == old {
                self.refine_beside(joint, index, &step.found);
            }
            // beside the others the rivals are fewer than when it was taken
            rivals.retain(|(rival, _)| rival.family != old);
            joint.found[index].rivals = rivals;
            joint.found[index].ranked_odds = ranked_odds;
        }
        if let (Some(ball), Some(first)) = (round_ball, joint.found.first_mut()) {
            first.rivals.push(ball);
        }
        self.only_contenders.set(false);
    }

    /// Takes the shape that an effect has beside the others where the set stands better with it: each was refined with those found
    /// before it alone.
    fn refine_beside(&self, joint: &mut JointFit, index: usize, refined: &SelectedEffect) {
        let mut found = joint.found.clone();
        found[index] = refined.clone();
        let trial = JointFit::of(self, found.into_iter(), &joint.noise);
        if trial.standing(self) > joint.standing(self) {
            *joint = trial;
        }
    }

    /// Takes the form of an effect in other motions where a free curve had to follow those: one cause rather than two.
    fn take_other_motions(&self, joint: &mut JointFit) {
        let last = joint.found.len().saturating_sub(1);
        let Some(whole) = rest_of(&joint.found, last) else { return };
        let moves = |candidate: &Candidate, outlet| candidate.terms.iter().any(|term| term.outlet == outlet);
        let (lead, rest) = (&joint.found[whole].chosen, &joint.found[last].chosen);
        let is_error_motion = is_a(&lead.effect.kind, Signature::ErrorMotion);
        if !is_error_motion || !self.goes_on() || rest.terms.iter().any(|term| moves(lead, term.outlet)) {
            return;
        }
        let is_same_form = |rival: &Candidate| {
            let is_alike = rival.effect.kind == lead.effect.kind && rival.effect.place == lead.effect.place;
            is_alike && rest.terms.iter().all(|term| moves(rival, term.outlet))
        };
        let rivals = joint.found[whole].rivals.iter().map(|(rival, _)| rival);
        let Some(other) = rivals.clone().find(|rival| is_same_form(rival)).cloned() else { return };
        let mut trial = joint.without(self, last).without(self, whole);
        if let Some(step) = self.next(&trial, Some(other), f64::NEG_INFINITY) {
            trial.add(self, step);
            self.grow(&mut trial, None);
            let trial = self.pruned(trial);
            self.replace(joint, trial, -self.limits.thresholds.one_cause);
        }
    }

    /// Tries other first effects.
    fn start_otherwise(&self, joint: &mut JointFit) {
        let bends = bends_to_anything(&joint.found[0]);
        // what follows anything gives way to the best of the others, no matter at how many places that acts
        let mut best: Option<JointFit> = None;
        let worth =
            |set: &JointFit| set.standing(self) - self.limits.accept_further * places_of(set).saturating_sub(1) as f64;
        let mut tried = vec![joint.found[0].chosen.effect.kind.clone()];
        let rivals: Vec<Candidate> = joint.found[0].rivals.iter().map(|(rival, _)| rival.clone()).collect();
        for rival in rivals {
            let kind = &rival.effect.kind;
            if !self.goes_on() || tried.len() > OTHER_STARTS || tried.contains(kind) || rival.is_free() {
                continue;
            }
            tried.push(kind.clone());
            let mut trial = JointFit::empty(self);
            let to_beat = if bends { f64::NEG_INFINITY } else { joint.standing(self) };
            self.grow_to_beat(to_beat, &mut trial, Some(rival));
            if !bends {
                self.replace(joint, trial, self.limits.thresholds.better);
            } else if best.as_ref().is_none_or(|best| worth(&trial) > worth(best)) {
                best = Some(trial);
            }
        }
        if let Some(best) = best {
            self.replace(joint, best, self.limits.thresholds.better);
        }
    }

    /// Takes what the machine does in place of a ball out of round, which has amplitudes for all of it: on circles of one bar
    /// the direction of the bar is the position of the slides.
    ///
    /// The ball that was left, with its log odds beside the machine's effects: nothing tells it from them.
    fn round_balls(&self, joint: &mut JointFit) -> Option<(Candidate, f64)> {
        let first = joint.found.first().filter(|first| is_a(&first.chosen.effect.kind, Signature::BallForm))?;
        let of_machine = |rival: &&Candidate| !is_a(&rival.effect.kind, Signature::BallForm) && !rival.is_event();
        let rivals: Vec<Candidate> = first.rivals.iter().map(|(rival, _)| rival).filter(of_machine).cloned().collect();
        let (ball, stands) = (first.chosen.clone(), joint.standing(self));
        let better = self.limits.thresholds.unlikely_set.min(self.limits.thresholds.ball_share * first.gain);
        let mut tried: Vec<String> = Vec::new();
        self.balls_are_round.set(true);
        for rival in rivals {
            if tried.len() < OTHER_STARTS && !tried.contains(&rival.effect.kind) {
                tried.push(rival.effect.kind.clone());
                let mut trial = JointFit::empty(self);
                self.grow(&mut trial, Some(rival));
                let are_few = (1..=MOST_FOR_A_BALL).contains(&trial.found.len());
                if are_few && self.replace(joint, trial, -better) {
                    return Some((ball, (stands - joint.standing(self)).min(0.0) - self.limits.thresholds.tie));
                }
            }
        }
        self.balls_are_round.set(false);
        None
    }

    /// The model without effects that add too little to what the others explain, whichever was taken first.
    pub(crate) fn pruned(&self, mut joint: JointFit) -> JointFit {
        let fine = self.resolutions.fine;
        let left = |columns: &[Accepted]| {
            let regression = Regression::on(self.whitened[0].clone(), columns);
            (mean_square(fine, &regression.residual_mm(columns)), regression.pulls())
        };
        let before_mm2 = left(&[]).0;
        while joint.found.len() > 1 {
            let (all_mm2, all_pulls) = left(&joint.columns[0]);
            let mut first = 0;
            let falls: Vec<(f64, f64, f64)> = joint
                .found
                .iter()
                .map(|found| {
                    let own = first..first + found.chosen.columns.len();
                    first = own.end;
                    let others = (0..joint.columns[0].len()).filter(|column| !own.contains(column));
                    let others: Vec<Accepted> = others.map(|column| joint.columns[0][column].clone()).collect();
                    let (without_mm2, pulls) = left(&others);
                    (without_mm2 - all_mm2, before_mm2 - without_mm2, pulls.shared_relief(&all_pulls))
                })
                .collect();
            let adds_little = (0..falls.len())
                .filter(|&index| {
                    let place = joint.found[index].chosen.effect.place;
                    // a free curve can stand for any form at its place: it is the one to go
                    let is_free = |k: usize| joint.found[k].chosen.is_free();
                    let stands_for = |k: usize| is_free(k) && joint.found[k].chosen.effect.place == place;
                    if !is_free(index) && (0..falls.len()).any(|k| k != index && stands_for(k)) {
                        return false;
                    }
                    let beside = (0..falls.len()).any(|k| k != index && joint.found[k].chosen.effect.place == place);
                    let (fall_mm2, explained_mm2, relief) = falls[index];
                    !relieves(&self.limits.thresholds, &joint.found[index].chosen, relief)
                        && !adds_enough(
                            &self.limits.thresholds,
                            beside,
                            fall_mm2,
                            explained_mm2,
                            mean_noise_mm2(&self.floors[0]),
                        )
                })
                .min_by(|&a, &b| falls[a].0.total_cmp(&falls[b].0));
            let Some(index) = adds_little else { break };
            joint = joint.without(self, index);
        }
        joint
    }

    /// Takes a trial when it stands better by some log odds; whether it did.
    pub(crate) fn replace(&self, joint: &mut JointFit, trial: JointFit, margin: f64) -> bool {
        let trial = if trial.standing(self) > joint.standing(self) { self.pruned(trial) } else { trial };
        let (now, other) = (joint.standing(self), trial.standing(self));
        let starts_free = |joint: &JointFit| joint.found.first().is_some_and(|first| first.chosen.is_free());
        // a free curve before a named form must stand far better, as where one effect is chosen
        let margin = if starts_free(&trial) && !starts_free(joint) {
            self.limits
                .thresholds
                .unlikely_set
                .max(joint.found.first().map_or(0.0, |first| self.limits.thresholds.free_set_share * first.gain))
        } else {
            margin
        };
        // a set that acts at more places must stand better by what each further one needs, unless what it replaces follows anything
        let bends = joint.found.iter().any(bends_to_anything);
        let further = if bends { 0 } else { places_of(&trial).saturating_sub(places_of(joint).max(1)) };
        let margin = if margin < 0.0 { margin } else { margin.max(self.limits.accept_further * further as f64) };
        let is_better = other > now + margin;
        if is_better {
            *joint = trial;
        }
        is_better
    }
}
