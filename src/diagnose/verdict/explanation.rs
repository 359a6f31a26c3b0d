//! What a search found as it is told: fitted on all rows, worded, confirmed by readings held out. It searches nothing.

use super::irregular_motion;
use crate::diagnose::cause::Cause;
use crate::diagnose::findings::finding::Finding;
use crate::diagnose::findings::forming::findings;
use crate::diagnose::findings::next_test;
use crate::diagnose::findings::proposals::Layout;
use crate::diagnose::model::linear_model::LinearModel;
use crate::diagnose::model::regression::{Accepted, Regression};
use crate::diagnose::noise::noise_floor::mean_noise_mm2;
use crate::diagnose::selection::joint_fit::{mean_square, without_trends};
use crate::diagnose::selection::naming;
use crate::diagnose::selection::search;
use crate::diagnose::selection::selected::{Candidate, Floors, Resolutions, Search};
use crate::diagnose::validation::cross_validation::{CrossValidation, HeldOut, prove};
use crate::diagnose::verdict::recurring::tell_as_one;
use crate::effects::CandidateFamily;
use crate::effects::UNKNOWN;

/// What a search found, fitted on all rows and worded.
pub(crate) struct Explanation<'g, 'a> {
    pub(crate) columns: Vec<Accepted>,
    pub(crate) regression: Regression<'g, 'a>,
    /// Residual with the findings in the fit, mm.
    pub(crate) left_mm: Vec<Vec<f64>>,
    pub(crate) findings: Vec<Finding>,
}

impl<'g, 'a> Explanation<'g, 'a> {
    pub(crate) fn of(fine: &'g LinearModel<'a>, families: &[CandidateFamily], search: &Search) -> Explanation<'g, 'a> {
        let columns: Vec<Accepted> = search.found.iter().flat_map(|found| found.chosen.accepted()).collect();
        let all = [columns.clone(), search.beside.clone()].concat();
        let regression = Regression::new(fine, &search.noise_after, &all, &fine.kept);
        let findings = findings(fine, families, search, &regression, &columns);
        let left_mm = regression.residual_mm(&all);
        Explanation { columns, regression, left_mm, findings }
    }

    /// Rms of the residual over the rows that take part, mm.
    pub(crate) fn rms_mm(&self, model: &LinearModel) -> f64 {
        mean_square(model, &self.left_mm).sqrt()
    }
}

/// Tells what a search found, proved by readings held out, with the test that would settle what is open; `is_mistaken` where
/// a mistake in the files was found: nothing else is told then.
pub(crate) fn explain<'g, 'a>(
    resolutions: &Resolutions<'g, 'a>,
    floors: &Floors,
    families: &[CandidateFamily],
    search: &mut Search,
    layout: &Layout,
    is_mistaken: bool,
) -> (Explanation<'g, 'a>, Option<CrossValidation>) {
    let fine = resolutions.fine;
    let noise_um = 1e3 * mean_noise_mm2(&floors[0]).sqrt();
    let mut told = Explanation::of(fine, families, search);
    let mut proof = None;
    if !told.findings.is_empty() {
        let proved = prove(resolutions, floors, families, search, &told.findings);
        proof = proved.map(|proved| match fine.has_sweeps() {
            true => confirm(fine, families, search, &mut told, proved, noise_um),
            false => without_refuted(fine, families, search, &mut told, proved),
        });
        proof = proof.filter(|_| !told.findings.is_empty());
    }
    if !is_mistaken && fine.has_sweeps() {
        listen(fine, families, search, &mut told, &mut proof, noise_um);
    }
    propose(layout, search, &mut told.findings);
    tell_as_one(fine, (&told.columns, &told.regression), &mut told.findings, &mut proof);
    (told, proof)
}

/// Adds to every finding with rivals the test that would tell them apart.
fn propose(layout: &Layout, search: &Search, findings: &mut [Finding]) {
    let machine = &layout.session.machine;
    let timed = |test: &crate::session::Test| test.recording.as_ref().is_some_and(|r| r.time_s().is_some());
    if !layout.session.tests.iter().any(timed) {
        return;
    }
    for finding in findings.iter_mut().filter(|finding| !finding.rivals.is_empty()) {
        let mut column = 0;
        let lead = search.found.iter().find(|found| {
            let first = column;
            column += found.chosen.columns.len();
            finding.columns.first() == Some(&first)
        });
        let Some(lead) = lead else { continue };
        let named = |candidate| (naming::cause(machine, candidate, &[]), candidate);
        let candidates: Vec<(Cause, &Candidate)> =
            std::iter::once(named(&lead.chosen)).chain(lead.rivals.iter().map(|(rival, _)| named(rival))).collect();
        finding.next_test = next_test::next_test(layout, finding, &candidates);
    }
}

/// Drops what held-out readings do not confirm, by its name or by what they gain, the weakest first, unless too much stays
/// unexplained without it to be the rest of a form or chance: it then stays, marked as not proven. So does the first finding where one of
/// the folds confirms it: half of the readings show half as much. Single events cannot repeat.
///
/// Forms that predict other readings worse than none at all are not the right ones: the first is told as a place without
/// a form, the others not at all.
fn confirm<'g, 'a>(
    fine: &'g LinearModel<'a>,
    families: &[CandidateFamily],
    search: &mut Search,
    told: &mut Explanation<'g, 'a>,
    mut proof: CrossValidation,
    noise_um: f64,
) -> CrossValidation {
    let most_mm = fine.thresholds.explained * told.rms_mm(fine);
    // what predicts nothing stays only where something surely is there
    let most_of_refuted_mm = most_mm.max(1e-3 * fine.thresholds.surely_more * noise_um);
    let mut dropped: Vec<usize> = Vec::new();
    for (index, finding) in told.findings.iter().enumerate().rev() {
        // what the folds found under other names predicts as well
        if finding.single
            || proof.findings[index].passed
            || index == 0 && proof.findings[index].confirmed > 0
            || index == 0 && finding.gain > fine.thresholds.sure_of_form && proof.predicts(noise_um, &fine.thresholds)
        {
            continue;
        }
        let without: Vec<Accepted> = (0..told.columns.len())
            .filter(|column| !finding.columns.contains(column) && !dropped.contains(column))
            .map(|column| told.columns[column].clone())
            .chain(search.beside.iter().cloned())
            .collect();
        let left_mm = Regression::new(fine, &search.noise_after, &without, &fine.kept).residual_mm(&without);
        let most_mm = if proof.findings[index].is_refuted { most_of_refuted_mm } else { most_mm };
        if mean_square(fine, &left_mm).sqrt() <= most_mm {
            dropped.extend(&finding.columns);
        }
    }
    drop_columns(fine, families, search, told, &mut proof, &dropped);
    if proof.after_um > proof.before_um && !told.findings.is_empty() {
        let failed = |k: usize| proof.has_failed(k) && !told.findings[k].escapes();
        let others: Vec<usize> = (1..told.findings.len()).filter(|&k| failed(k)).collect();
        let others: Vec<usize> = others.into_iter().flat_map(|k| told.findings[k].columns.clone()).collect();
        if failed(0) {
            withdraw_form(search, told, 0);
        }
        drop_columns(fine, families, search, told, &mut proof, &others);
    }
    proof
}

/// Drops findings of static poses that no fold confirms and that predict nothing; the rest stands as it was proved.
fn without_refuted<'g, 'a>(
    fine: &'g LinearModel<'a>,
    families: &[CandidateFamily],
    search: &mut Search,
    told: &mut Explanation<'g, 'a>,
    mut proof: CrossValidation,
) -> CrossValidation {
    let refuted = told.findings.iter().zip(&proof.findings).filter(|(_, held_out)| held_out.is_refuted);
    let columns: Vec<usize> = refuted.flat_map(|(finding, _)| finding.columns.clone()).collect();
    drop_columns(fine, families, search, told, &mut proof, &columns);
    proof
}

/// Takes back the form by which a finding is told, now and when it is told anew.
fn withdraw_form(search: &mut Search, told: &mut Explanation, index: usize) {
    let finding = &mut told.findings[index];
    finding.cause.effect = UNKNOWN.name.into();
    let mut column = 0;
    for found in &mut search.found {
        found.form_withdrawn |= finding.columns.first() == Some(&column);
        column += found.chosen.columns.len();
    }
}

/// Takes effects out by the columns that they begin with, and tells the rest anew.
fn drop_columns<'g, 'a>(
    fine: &'g LinearModel<'a>,
    families: &[CandidateFamily],
    search: &mut Search,
    told: &mut Explanation<'g, 'a>,
    proof: &mut CrossValidation,
    dropped: &[usize],
) {
    if dropped.is_empty() {
        return;
    }
    let before: Vec<(Vec<usize>, HeldOut)> =
        told.findings.iter().map(|finding| finding.columns.clone()).zip(proof.findings.iter().copied()).collect();
    let mut column = 0;
    // columns as they were numbered before, of what stays
    let mut stays: Vec<usize> = Vec::new();
    search.found.retain(|found| {
        let own = column..column + found.chosen.columns.len();
        column = own.end;
        let is_kept = !dropped.contains(&own.start);
        stays.extend(own.filter(|_| is_kept));
        is_kept
    });
    *told = Explanation::of(fine, families, search);
    // told anew the findings may stand in another order
    let held_out = |finding: &Finding| {
        let column = finding.columns.first().map(|&column| stays[column]);
        let same = before.iter().find(|(columns, _)| column.is_some_and(|column| columns.contains(&column)));
        same.map_or(HeldOut::default(), |(_, held_out)| *held_out)
    };
    proof.findings = told.findings.iter().map(held_out).collect();
}

/// Tells an irregular motion where readings stay louder than their noise: in place of a form that only follows it, or alone
/// where nothing was found. A first finding at whose place readings scatter on has not the right form.
fn listen<'g, 'a>(
    fine: &'g LinearModel<'a>,
    families: &[CandidateFamily],
    search: &mut Search,
    told: &mut Explanation<'g, 'a>,
    proof: &mut Option<CrossValidation>,
    noise_um: f64,
) {
    let floor = search.floor.clone();
    let is_louder = |told: &Explanation, most: f64| 1e3 * told.rms_mm(fine) > most * noise_um;
    let first = told.findings.first().filter(|_| is_louder(told, fine.thresholds.explained));
    let scatter = first.and_then(|first| irregular_motion::left_scatter(fine, &told.left_mm, &floor, first));
    let is_there = |most: f64| scatter.as_ref().is_some_and(|scatter| scatter.share > most);
    let outshouts = is_there(1.0) && is_louder(told, fine.thresholds.surely_more);
    // a joint that seems to tip as a slide reverses, and it is that slide which makes readings scatter
    let is_driven =
        is_there(fine.thresholds.form_unknown) && scatter.as_ref().is_some_and(|scatter| scatter.is_driving);
    let has_failed = |k: usize| proof.as_ref().is_some_and(|proof| proof.has_failed(k));
    let stands_for = match is_there(fine.thresholds.form_unknown) {
        true => stood_for(fine, search, told),
        false => vec![false; told.findings.len()],
    };
    // jumps beside it, and forms that hold nowhere else or for which it stands, are its own
    let alone = told.findings.first().is_some_and(|first| !first.single)
        && (1..told.findings.len()).all(|k| told.findings[k].single || has_failed(k) || stands_for[k]);
    // many jumps that leave much are none, with one other finding at most beside them
    let jumps = told.findings.iter().filter(|finding| finding.single).count();
    let almost_all_jump = jumps > 1 && jumps + 1 >= told.findings.len();
    let are_no_jumps = almost_all_jump && is_louder(told, fine.thresholds.surely_more);
    if (outshouts || is_driven) && alone || are_no_jumps {
        // a form that follows an irregular motion here and there
        let bare = Explanation::of(fine, families, &search::nothing(fine, &floor));
        let located = irregular_motion::irregular(fine, &bare.left_mm, &floor);
        if let Some(irregular) = located.or_else(|| irregular_motion::irregular(fine, &told.left_mm, &floor)) {
            (*search, *told, *proof) = (search::nothing(fine, &floor), bare, None);
            told.findings.push(irregular);
            return;
        }
    }
    // the place is right, but its form alone tells held-out readings worse than no form
    let misleads = scatter.is_some()
        && told.findings.len() == 1
        && !told.findings[0].escapes()
        && proof.as_ref().is_some_and(|proof| proof.after_um > proof.before_um);
    if is_there(fine.thresholds.form_unknown) || are_no_jumps || misleads {
        let loud = is_louder(told, fine.thresholds.surely_more);
        let is_its_own = |k: usize, finding: &Finding| match finding.single {
            true => loud || shows_with(fine, finding, &told.findings[0]),
            false => has_failed(k) || stands_for[k],
        };
        let others = told.findings.iter().enumerate().skip(1).filter(|(k, finding)| is_its_own(*k, finding));
        let others: Vec<usize> = others.flat_map(|(_, finding)| finding.columns.clone()).collect();
        withdraw_form(search, told, 0);
        if let Some(proof) = proof {
            drop_columns(fine, families, search, told, proof, &others);
        }
    } else if told.findings.is_empty() && is_louder(told, fine.thresholds.explained) {
        // what changes from test to test alone is no irregular motion
        let within_mm2 = mean_square(fine, &without_trends(fine, &told.left_mm));
        if 1e3 * within_mm2.sqrt() > fine.thresholds.explained * noise_um {
            told.findings.extend(irregular_motion::irregular(fine, &told.left_mm, &floor));
        }
    }
}

/// By finding, whether the axis of the first one, were it to stand elsewhere in each test, explains more in its place, what so
/// many places cost taken off, and leaves it next to nothing.
fn stood_for(fine: &LinearModel, search: &Search, told: &Explanation) -> Vec<bool> {
    let standing = irregular_motion::standing(fine, &told.findings[0].cause.place);
    let misfit = |left_out: &[usize], standing: &[Accepted]| {
        let kept = (0..told.columns.len()).filter(|column| !left_out.contains(column));
        let kept: Vec<Accepted> = kept.map(|column| told.columns[column].clone()).collect();
        Regression::new(fine, &search.noise_after, &[&kept, &search.beside[..], standing].concat(), &fine.kept).misfit
    };
    let (whole, beside) = (misfit(&[], &[]), misfit(&[], &standing));
    let is_stood_for = |finding: &Finding| {
        let instead = misfit(&finding.columns, &standing);
        let own = misfit(&finding.columns, &[]) - whole;
        instead + fine.thresholds.stands_cost * (standing.len() as f64) < whole
            && instead - beside < fine.thresholds.stands_keeps * own
    };
    let is_its_place = |finding: &Finding| finding.cause.place == told.findings[0].cause.place;
    let stands_for = |(k, finding): (usize, &Finding)| k > 0 && (is_its_place(finding) || is_stood_for(finding));
    told.findings.iter().enumerate().map(stands_for).collect()
}

/// Whether a jump shows only where the axis of an irregular motion moves: it is one of its own jumps then.
fn shows_with(fine: &LinearModel, jump: &Finding, irregular: &Finding) -> bool {
    let session = fine.context.session();
    let axis = session.machine.axis_index(&irregular.cause.place);
    let moves = |test: usize| axis.is_some_and(|axis| fine.context.motion(test).moving.contains(&axis));
    (0..fine.tests()).filter(|&test| jump.tests.contains(&session.tests[test].name)).all(moves)
}
