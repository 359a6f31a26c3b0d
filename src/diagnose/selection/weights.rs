//! Joints that yield to the weight beyond them, taken together: each may look like nothing alone, as where a tendon leads the moment of
//! one joint to the next. What else is in static poses is for the pose search.

use super::pose_search::State;
use super::screening::candidates::family_terms;
use super::selected::{Candidate, SelectedEffect};
use crate::diagnose::model::regression::Accepted;
use crate::diagnose::noise::pose_noise::Poses;
use crate::effects::{CandidateFamily, Signature, is_a};
use crate::statistics::{BlockEvidence, likeliest_priors};

/// Log evidence that a part must add beside the others: the odds against a cause that may or may not be there.
const LEAST_LOG_EVIDENCE: f64 = 3.0;
/// Times that the parts are weighed anew under the noise that they leave.
const ROUNDS: usize = 4;

impl State<'_, '_> {
    /// Takes all that yields to weight together, each part with a prior of its own, where the evidence for the whole demands it.
    pub(super) fn take_weights(&mut self, families: &[CandidateFamily], poses: &Poses) {
        let mut parts = self.parts(families);
        if parts.is_empty() {
            return;
        }
        for _ in 0..ROUNDS {
            let columns: Vec<_> = parts.iter().flat_map(|part| part.columns.iter().cloned()).collect();
            let mut first = 0;
            let own = |part: &Candidate| {
                first += part.columns.len();
                first - part.columns.len()..first
            };
            let ranges: Vec<_> = parts.iter().map(own).collect();
            let plausible = parts.iter().map(|part| families[part.family].plausible).fold(0.0, f64::max);
            let (information, z) = self.regression(&self.joint).project(&columns);
            let (priors, evidence) = likeliest_priors((&information, &z), &ranges, plausible, LEAST_LOG_EVIDENCE);
            if evidence < self.model.thresholds.accept {
                let left = self.residual_mm.clone();
                return self.set_noise(poses, &left);
            }
            parts.iter_mut().zip(&priors).for_each(|(part, tau)| part.judgement.tau = tau.unwrap_or(0.0));
            let mut all = self.joint.clone();
            all.extend(parts.iter().filter(|part| part.judgement.tau > 0.0).flat_map(with_prior));
            let left = self.regression(&all).residual_mm(&all);
            self.set_noise(poses, &left);
        }
        parts.retain(|part| part.judgement.tau > 0.0);
        self.accept_together(parts, poses);
    }

    /// Weighs once more beside what was found after: what only stood for that goes, and what then adds nothing beside the weights.
    pub(super) fn weigh_again(&mut self, families: &[CandidateFamily], poses: &Poses) {
        let is_weight = |found: &SelectedEffect| is_a(&found.chosen.effect.kind, Signature::Weight);
        if !self.found.iter().any(is_weight) {
            return;
        }
        self.found.retain(|found| !is_weight(found));
        self.joint = self.found.iter().flat_map(|found| found.chosen.accepted()).collect();
        self.residual_mm = self.regression(&self.joint).residual_mm(&self.joint);
        self.take_weights(families, poses);
        for index in (0..self.found.len()).rev().filter(|&index| !is_weight(&self.found[index])).collect::<Vec<_>>() {
            let others = self.found.iter().enumerate().filter(|(other, _)| *other != index);
            let others: Vec<Accepted> = others.flat_map(|(_, found)| found.chosen.accepted()).collect();
            let chosen = &self.found[index].chosen;
            let (columns, tau) = (chosen.columns.clone(), chosen.judgement.tau);
            let evidence = self.regression(&others).judge(&columns, tau).log_evidence;
            if evidence < 0.0 {
                self.found.remove(index);
            }
        }
        let joint: Vec<Accepted> = self.found.iter().flat_map(|found| found.chosen.accepted()).collect();
        self.residual_mm = self.regression(&joint).residual_mm(&joint);
        self.joint = joint;
        let left = self.residual_mm.clone();
        self.set_noise(poses, &left);
    }

    /// Every family that yields to weight, not judged yet.
    fn parts(&self, families: &[CandidateFamily]) -> Vec<Candidate> {
        let machine = self.model.context.machine();
        let of = |(index, family): (usize, &CandidateFamily)| {
            let effect = family.grid.first().filter(|_| is_a(family.kind, Signature::Weight))?.clone();
            let terms = family_terms(machine, family, &effect);
            let columns = self.model.columns(&effect, &terms).ok()?;
            let judgement =
                BlockEvidence { log_evidence: 0.0, chi2: 0.0, amplitudes: Vec::new(), tau: 0.0, implausibility: 0.0 };
            Some(Candidate { family: index, effect, terms, columns, judgement, log_odds: 0.0 })
        };
        families.iter().enumerate().filter_map(of).collect()
    }
}

/// Columns of a part with its prior.
fn with_prior(part: &Candidate) -> impl Iterator<Item = Accepted> + '_ {
    part.columns.iter().map(|column| Accepted { column: column.clone(), prior: part.judgement.tau })
}
