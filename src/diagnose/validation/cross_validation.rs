//! Whether a finding predicts readings that its selection never saw: folds of interleaved chunks, selection redone in each.

use crate::diagnose::cause::Cause;
use crate::diagnose::findings::finding::Finding;
use crate::diagnose::model::linear_model::LinearModel;
use crate::diagnose::model::regression::{Accepted, Regression};
use crate::diagnose::selection::search::search_part;
use crate::diagnose::selection::selected::{Floors, Resolutions, Search, SelectedEffect};
use crate::diagnose::thresholds::Thresholds;
use crate::effects::CandidateFamily;
use crate::effects::{Signature, is_a};
use crate::machine::Effect;
use crate::statistics::rms;

/// Outcome of the held-out proof.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossValidation {
    /// Rms of held-out residuals without and with what the other fold found, µm.
    pub before_um: f64,
    pub after_um: f64,
    /// What the folds say of each finding.
    pub findings: Vec<HeldOut>,
}

/// What readings held out say of one finding.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct HeldOut {
    /// The same cause was found in every fold, or in all but one where it is beyond doubt, and held-out readings gained from it
    /// beside the others.
    pub passed: bool,
    /// No fold confirms it, and readings held out are predicted no better with it than without.
    pub is_refuted: bool,
    /// Folds that found it again and whose readings left out gained from it.
    pub confirmed: usize,
}

impl HeldOut {
    /// Most that may be claimed of a finding after its folds: Laplace's rule of succession where they did not confirm it.
    pub fn most_probable(&self) -> f64 {
        if self.passed { 1.0 } else { (self.confirmed as f64 + 1.0) / (FOLDS as f64 + 2.0) }
    }
}

impl CrossValidation {
    /// Whether the finding at `index` was put to the proof and failed it.
    pub fn has_failed(&self, index: usize) -> bool {
        self.findings.get(index).is_some_and(|held_out| !held_out.passed)
    }

    /// Share of what the findings take off the mean square of all readings beyond noise, µm before and after, that they take off
    /// readings held out; `None` where noise is all that there is.
    pub fn carried_over(&self, (before_um, after_um): (f64, f64), noise_um: f64) -> Option<f64> {
        let taken_off = |before: f64, after: f64| {
            let beyond_noise = before.powi(2) - noise_um.powi(2);
            (beyond_noise > 0.0).then(|| (before.powi(2) - after.powi(2)) / beyond_noise)
        };
        let of_all = taken_off(before_um, after_um).filter(|share| *share > 0.0)?;
        Some(taken_off(self.before_um, self.after_um)? / of_all)
    }

    /// Whether held-out readings lose most of what is more than noise, whatever the folds called it.
    pub fn predicts(&self, noise_um: f64, thresholds: &Thresholds) -> bool {
        let beyond = |um: f64| um.powi(2) - noise_um.powi(2);
        beyond(self.before_um) > 0.0 && beyond(self.after_um) < thresholds.explains_most * beyond(self.before_um)
    }
}

/// Length of a chunk, s; of a run of static poses, in poses.
pub const CHUNK_S: f64 = 5.0;
const CHUNK_POSES: usize = 40;
/// Chunks of a test of static poses at least.
const LEAST_CHUNKS: usize = 4;
/// Number of folds.
const FOLDS: usize = 2;

/// Length of a chunk as a share of the time between two knots of a vibration: it must be shorter than what is to be followed
/// across it.
const CHUNK_SHARE: f64 = 0.25;

/// Length of the chunks, s, that fits the courses of what was found.
fn chunk_s(found: &[SelectedEffect]) -> f64 {
    let knots_s = found.iter().filter_map(|found| found.chosen.effect.number("every"));
    knots_s.fold(CHUNK_S, |chunk, every| chunk.min(CHUNK_SHARE * every))
}

/// Cross-validates findings, `None` where a fold would be without readings; `floors` are those of all readings, for half a
/// trace may not show what is noise and what a line of the spectrum, and `search` is the one on all of them.
pub fn prove(
    resolutions: &Resolutions,
    floors: &Floors,
    families: &[CandidateFamily],
    search: &Search,
    findings: &[Finding],
) -> Option<CrossValidation> {
    let (found, noise) = (&search.found, &search.noise_after);
    let chunk_s = chunk_s(found);
    let is_empty = |rows: Vec<Vec<bool>>| !rows.iter().flatten().any(|row| *row);
    if is_empty(held_out_rows(resolutions.fine, 0, chunk_s)) || is_empty(other_rows(resolutions.fine, 0, chunk_s)) {
        return None;
    }
    let mut before = Vec::new();
    let mut after = Vec::new();
    let all: Vec<Accepted> = found.iter().flat_map(|found| found.chosen.accepted()).collect();
    // by finding and fold: whether it is found again, and what the rows left out gain from it, as a share of what they leave
    let mut again = vec![Vec::new(); findings.len()];
    let mut gains = vec![Vec::new(); findings.len()];
    for fold in 0..FOLDS {
        let train = [resolutions.fine, resolutions.coarse].map(|model| other_rows(model, fold, chunk_s));
        let test = held_out_rows(resolutions.fine, fold, chunk_s);
        let masked = [resolutions.fine.with_rows(train[0].clone()), resolutions.coarse.with_rows(train[1].clone())];
        let masked = Resolutions { fine: &masked[0], coarse: &masked[1], cells: resolutions.cells };
        let searched = search_part(&masked, floors, families, (found, &search.contenders));
        let joint: Vec<Accepted> = searched.found.iter().flat_map(|found| found.chosen.accepted()).collect();
        let bare = Regression::new(resolutions.fine, noise, &[], &train[0]).residual_mm(&[]);
        let full = Regression::new(resolutions.fine, noise, &joint, &train[0]).residual_mm(&joint);
        before.extend(held_out(&bare, &test));
        after.extend(held_out(&full, &test));
        let unexplained = |residual_mm: &[Vec<f64>]| rms(held_out(residual_mm, &test).into_iter()).powi(2);
        let left = unexplained(&full);
        for (index, finding) in findings.iter().enumerate() {
            let is_again = |found: &SelectedEffect| is_found_again(resolutions, findings, finding, found);
            let left_by = |joint: &[Accepted]| match joint.is_empty() {
                true => unexplained(&bare),
                false => unexplained(&Regression::new(resolutions.fine, noise, joint, &train[0]).residual_mm(joint)),
            };
            again[index].push(searched.found.iter().any(is_again));
            if again[index][fold] {
                let others = searched.found.iter().filter(|found| !is_again(found));
                let others: Vec<Accepted> = others.flat_map(|found| found.chosen.accepted()).collect();
                gains[index].push(left_by(&others) / left - 1.0);
            } else {
                let own = finding.columns.iter().map(|&column| all[column].clone());
                gains[index].push(left / left_by(&joint.iter().cloned().chain(own).collect::<Vec<_>>()) - 1.0);
            }
        }
    }
    let thresholds = &resolutions.fine.thresholds;
    let judged = findings.iter().zip(again.iter().zip(&gains)).map(|(finding, (again, gains))| {
        let gained = |fold: usize| gains[fold] > thresholds.inexact;
        let passed = match again.iter().filter(|again| **again).count() {
            FOLDS => gains.iter().sum::<f64>() > thresholds.inexact,
            0 => false,
            _ => finding.gain > thresholds.sure_of_form && (0..FOLDS).all(gained),
        };
        let confirmed = (0..FOLDS).filter(|&fold| again[fold] && gained(fold)).count();
        // what is left changes by a factor in each fold
        let gained_in_all = gains.iter().map(|gain| (1.0 + gain).ln()).sum::<f64>();
        HeldOut { passed, is_refuted: confirmed == 0 && gained_in_all < thresholds.inexact, confirmed }
    });
    let findings = judged.collect();
    Some(CrossValidation { before_um: 1e3 * rms(before.into_iter()), after_um: 1e3 * rms(after.into_iter()), findings })
}

/// Share of a finding's probability from which a rival of another kind stands for the same class.
const LEAST_SHARE_OF_A_RIVAL: f64 = 0.5;

/// Whether a fold found what a finding says, or a stated rival where the fewer readings of a fold may favour it: of static
/// poses any, of sweeps one of the same kind or nearly as likely.
fn is_found_again(resolutions: &Resolutions, findings: &[Finding], finding: &Finding, found: &SelectedEffect) -> bool {
    let machine = resolutions.fine.context.machine();
    let effect = &found.chosen.effect;
    let is_near = |(rival, probability): &&(Cause, f64)| {
        !resolutions.fine.has_sweeps()
            || rival.effect == finding.cause.effect
            || *probability > LEAST_SHARE_OF_A_RIVAL * finding.probability
    };
    let rivals = finding.rivals.iter().filter(is_near).map(|(rival, _)| rival);
    let says = |cause: &Cause| {
        let same_place = effect.place.name(machine) == cause.place;
        same_place && (effect.kind == cause.effect || is_a(&cause.effect, Signature::FreeCurve))
    };
    // a rival that is another finding counts for that one
    let is_other = findings.iter().any(|other| !std::ptr::eq(other, finding) && says(&other.cause));
    // play as one axis reverses is no play as another one does
    let drives = |effect: &Effect| effect.parameter("of").cloned();
    let is_driven_alike = finding.effects.first().is_none_or(|own| drives(own) == drives(effect));
    says(&finding.cause) && is_driven_alike || !is_other && rivals.into_iter().any(says)
}

fn held_out(residual_mm: &[Vec<f64>], rows: &[Vec<bool>]) -> Vec<f64> {
    residual_mm
        .iter()
        .zip(rows)
        .flat_map(|(residual, rows)| residual.iter().zip(rows).filter(|(_, keep)| **keep).map(|(value, _)| *value))
        .collect()
}

/// Kept rows inside the chunks of a fold, each of about `chunk_s` seconds.
///
/// A sweep has an odd number of chunks, and a repeat in the same setup, the same sweep back among them, has them the other
/// way round: so what happens as sweeps begin is in both folds, and so is every place of an axis that goes there and back
/// at a steady speed. Setups take turns with the fold that begins.
pub fn held_out_rows(model: &LinearModel, fold: usize, chunk_s: f64) -> Vec<Vec<bool>> {
    kept_where(model, chunk_s, |held_in| held_in == Some(fold))
}

/// Kept rows outside the chunks of a fold, as [`held_out_rows`] has them.
fn other_rows(model: &LinearModel, fold: usize, chunk_s: f64) -> Vec<Vec<bool>> {
    kept_where(model, chunk_s, |held_in| held_in != Some(fold))
}

/// Kept rows of which the fold that holds them out is wanted; `None` stands for rows that none does.
fn kept_where(model: &LinearModel, chunk_s: f64, is_wanted: impl Fn(Option<usize>) -> bool) -> Vec<Vec<bool>> {
    let turns = turns(model);
    (0..model.tests())
        .map(|test| {
            let time = model.context.motion(test).time_s.as_ref();
            let ends = time.and_then(|time| Some((*time.first()?, *time.last()?)));
            let chunks = ends.map_or(1, |(begins, ends)| odd_chunks((ends - begins) / chunk_s));
            let chunk = |row: usize| match (time, ends) {
                (Some(time), Some((begins, ends))) => {
                    let share = (time[row] - begins) / (ends - begins).max(f64::MIN_POSITIVE);
                    ((share * chunks as f64) as usize).min(chunks - 1)
                }
                // every test has rows in each fold: the place of a socket is not known from other sockets
                _ => row / CHUNK_POSES.min(model.kept[test].len() / LEAST_CHUNKS).max(1),
            };
            let reading = &model.context.session().tests[test].reading;
            // the numbers of one reading are held together; what was stated of sockets is never held
            let turn = if reading.part().is_some() { 0 } else { turns[test] };
            let held_in = |row: usize| (!reading.is_gap()).then(|| (chunk(row) + turn) % FOLDS);
            (0..model.kept[test].len()).map(|row| model.kept[test][row] && is_wanted(held_in(row))).collect()
        })
        .collect()
}

/// Odd number of chunks near a number, three at least.
fn odd_chunks(near: f64) -> usize {
    2 * ((0.5 * (near - 1.0)).round() as usize).max(1) + 1
}

/// By test, whether its chunks are the other way round: how often its setup was swept before, and which setup it is, in time.
fn turns(model: &LinearModel) -> Vec<usize> {
    let session = model.context.session();
    let mut turns = vec![0; model.tests()];
    let mut setups: Vec<(usize, usize)> = Vec::new();
    for &test in model.context.order() {
        let known = setups.iter().position(|(first, _)| session.tests[*first].is_repeat_of(&session.tests[test]));
        let setup = known.unwrap_or_else(|| {
            setups.push((test, 0));
            setups.len() - 1
        });
        turns[test] = setup + setups[setup].1;
        setups[setup].1 += 1;
    }
    turns
}
