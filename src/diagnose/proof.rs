//! Whether a finding predicts readings that its selection never saw: folds of interleaved chunks, selection redone in each.

use super::finding::Finding;
use super::found::{Found, Grounds};
use super::ground::Ground;
use super::library::Family;
use super::naming::Cause;
use super::search::{floors, search_part};
use super::stage::{Accepted, Stage};
use crate::identify::{NoiseModel, rms};

/// Outcome of the held-out proof.
#[derive(Debug, Clone, PartialEq)]
pub struct Proof {
    /// Rms of held-out residuals without and with what the other fold found, µm.
    pub before_um: f64,
    pub after_um: f64,
    /// Per finding: the same cause was found in every fold, and held-out readings gained from it beside the others.
    pub passed: Vec<bool>,
}

/// Share of what is more than noise that held-out readings may keep where they are predicted.
const KEPT: f64 = 0.5;

impl Proof {
    /// Whether held-out readings lose most of what is more than noise, whatever the folds called it.
    pub fn predicts(&self, noise_um: f64) -> bool {
        let beyond = |um: f64| um.powi(2) - noise_um.powi(2);
        beyond(self.before_um) > 0.0 && beyond(self.after_um) < KEPT * beyond(self.before_um)
    }
}

/// Length of a chunk, s; of a run of static poses, in poses.
const CHUNK_S: f64 = 5.0;
const CHUNK_POSES: usize = 40;
/// Number of folds.
const FOLDS: usize = 2;
/// Multiples of it have fractions that stay apart.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Cross-validates findings; `found` are the effects that the search on all readings took.
pub fn prove(
    grounds: &Grounds,
    families: &[Family],
    found: &[Found],
    findings: &[Finding],
    noise: &[NoiseModel],
) -> Proof {
    let mut before = Vec::new();
    let mut after = Vec::new();
    let mut passed = vec![true; findings.len()];
    let mut gains = vec![0.0; findings.len()];
    for fold in 0..FOLDS {
        let train = [fold_rows(grounds.fine, fold, false), fold_rows(grounds.coarse, fold, false)];
        let test = fold_rows(grounds.fine, fold, true);
        let masked = [grounds.fine.with_rows(train[0].clone()), grounds.coarse.with_rows(train[1].clone())];
        let masked = Grounds { fine: &masked[0], coarse: &masked[1], cells: grounds.cells };
        let searched = search_part(&masked, &floors(&masked), families, found);
        let model: Vec<Accepted> = searched.found.iter().flat_map(|found| found.chosen.accepted()).collect();
        let bare = Stage::new(grounds.fine, noise, &[], &train[0]).residual_mm(&[]);
        let full = Stage::new(grounds.fine, noise, &model, &train[0]).residual_mm(&model);
        before.extend(held_out(&bare, &test));
        after.extend(held_out(&full, &test));
        let unexplained = |residual_mm: &[Vec<f64>]| rms(held_out(residual_mm, &test).into_iter()).powi(2);
        let left = unexplained(&full);
        for (index, finding) in findings.iter().enumerate() {
            let is_again = |found: &Found| is_found_again(grounds, findings, finding, found);
            passed[index] &= searched.found.iter().any(is_again);
            let others = searched.found.iter().filter(|found| !is_again(found));
            let others: Vec<Accepted> = others.flat_map(|found| found.chosen.accepted()).collect();
            let without = match others.is_empty() {
                true => unexplained(&bare),
                false => unexplained(&Stage::new(grounds.fine, noise, &others, &train[0]).residual_mm(&others)),
            };
            gains[index] += without - left;
        }
    }
    for (passed, gain) in passed.iter_mut().zip(&gains) {
        *passed &= *gain > 0.0;
    }
    Proof { before_um: 1e3 * rms(before.into_iter()), after_um: 1e3 * rms(after.into_iter()), passed }
}

/// Share of a finding's probability from which a rival of another kind stands for the same class.
const NEAR: f64 = 0.5;

/// Whether a fold found what a finding says, or a stated rival where the fewer readings of a fold may favour it: of static
/// poses any, of sweeps one of the same kind or nearly as likely.
fn is_found_again(grounds: &Grounds, findings: &[Finding], finding: &Finding, found: &Found) -> bool {
    let machine = grounds.fine.context.machine();
    let effect = &found.chosen.effect;
    let is_near = |(rival, probability): &&(Cause, f64)| {
        !grounds.fine.has_sweeps() || rival.effect == finding.cause.effect || *probability > NEAR * finding.probability
    };
    let rivals = finding.rivals.iter().filter(is_near).map(|(rival, _)| rival);
    let says = |cause: &Cause| {
        let same_place = effect.place.name(machine) == cause.place;
        same_place && (effect.kind == cause.effect || cause.effect == "unknown")
    };
    // a rival that is another finding counts for that one
    let is_other = findings.iter().any(|other| !std::ptr::eq(other, finding) && says(&other.cause));
    says(&finding.cause) || !is_other && rivals.into_iter().any(says)
}

fn held_out(residual_mm: &[Vec<f64>], rows: &[Vec<bool>]) -> Vec<f64> {
    residual_mm
        .iter()
        .zip(rows)
        .flat_map(|(residual, rows)| residual.iter().zip(rows).filter(|(_, keep)| **keep).map(|(value, _)| *value))
        .collect()
}

/// Kept rows inside (`held` true) or outside the chunks of a fold.
///
/// Neighbours in time (a sweep there and the same one back) have their chunks the other way round, so that what happens as
/// they begin is in both folds; each such pair has a phase of its own, so that no range of an axis is in one fold alone.
pub fn fold_rows(ground: &Ground, fold: usize, held: bool) -> Vec<Vec<bool>> {
    let mut place = vec![0; ground.tests()];
    ground.context.order().iter().enumerate().for_each(|(k, &test)| place[test] = k);
    (0..ground.tests())
        .map(|test| {
            let time = ground.context.motion(test).time_s.as_ref();
            let pair = (place[test] / 2) as f64 * GOLDEN;
            let phase = (place[test] % FOLDS) as f64 + FOLDS as f64 * pair.fract();
            (0..ground.kept[test].len())
                .map(|row| {
                    let chunk = time.map_or(row / CHUNK_POSES, |time| (time[row] / CHUNK_S + phase) as usize);
                    ground.kept[test][row] && ((chunk % FOLDS == fold) == held)
                })
                .collect()
        })
        .collect()
}
