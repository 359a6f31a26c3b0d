//! Finds the physics that a fit left out: where, what, how much, how sure. It simulates through the same effects as every other room.
//!
//! To first order every effect adds columns `∂L/∂outlet · function` to the linear model of a fit. The search whitens
//! data and columns by the noise, projects out location errors, ball places and bars with their priors, and asks which
//! few blocks of columns the evidence demands; what is accepted joins the model and the question is asked again.

mod as_found;
mod blind;
mod cells;
mod choosing;
mod contest;
mod contradictions;
mod courses;
mod data_fault;
mod demand;
mod diagnosis;
mod doubts;
mod dwells;
mod examine;
mod exchanged;
mod exchanging;
mod finding;
mod fitted;
mod floor;
mod found;
mod ground;
mod grouping;
mod growing;
mod irregular;
mod lean;
mod library;
mod limits;
mod lines;
mod misplaced;
mod mistakes;
mod model;
mod naming;
mod next_test;
mod placebo;
mod places;
mod pose_floor;
mod pose_search;
mod preflight;
mod proof;
mod pulls;
mod recurring;
mod refining;
mod refit;
mod restated;
mod scan;
mod screening;
mod search;
mod shape_spread;
mod shapes;
mod size;
mod spectrum;
mod stage;
mod standing;
mod swinging;
mod thin;
mod told;
mod transfer;
mod verdict;
mod vibrating;
mod waves;
mod whitened;

pub use as_found::as_found;
pub use blind::Blind;
pub use cells::Cells;
pub use data_fault::{DataFault, Rival};
pub use diagnosis::{DiagnoseError, Diagnosis, Moved, TestBeforeAfter, Verdict};
pub use examine::{Examination, examine};
pub use finding::{Finding, RangeFound, SizeFound};
pub use floor::noise_floor;
pub use found::{Candidate, Found, Grounds, Search};
pub use ground::{Column, Ground, Term};
pub use lean::{Averaged, MOST_ROWS, lean};
pub use library::{Family, families, terms};
pub use naming::{Cause, MOST_RIVALS};
pub use next_test::NextTest;
pub use placebo::Placebo;
pub use pose_floor::Left;
pub use proof::{CHUNK_S, Proof, fold_rows};
pub use search::{search, search_unless};
pub use stage::{Accepted, Judgement, Stage};
pub use thin::thin;
pub use transfer::Transfer;
pub use whitened::{LastShape, Whitened};

use self::pose_floor::Poses;
use self::told::{STILL_THERE, Told, confirm, listen, propose};
use self::verdict::{temper, verdict};
use crate::chain::Chain;
use crate::effects::Context;
use crate::identify::{self, Options, Problem, Quantity, rms};
use crate::machine::Effect;
use crate::session::{Session, Setups};

/// Setups are given so many times their stated spread: a pivot that a knock moved by three sigmas is no missing physics.
const WIDER_SETUPS: f64 = 2.5;

/// Diagnoses a session.
pub fn diagnose(session: &Session, options: &Options) -> Result<Diagnosis, DiagnoseError> {
    let examination = examine::examined(session, options)?;
    if !examination.is_sound() {
        return Ok(Diagnosis::of_examination(examination));
    }
    let chain = Chain::of(&session.machine);
    let setups = Setups::of(session);
    let mut unknowns = options.unknowns(session, &setups);
    for unknown in unknowns.iter_mut().filter(|unknown| unknown.quantity.is_setup()) {
        unknown.prior_sigma *= WIDER_SETUPS;
    }
    let problem = Problem::new(session, &chain, &setups, unknowns)?;
    let fit = identify::fit(&problem)?;
    let values = fit.values();
    let context = Context::of(session, &chain)?;
    let ground = Ground::new(&context, &problem, &values, fit.kept_rows());
    let diagnosis = diagnose_ground(ground, &setups, &values, fit, true)?;
    Ok(Diagnosis { warnings: examination.warnings, ..diagnosis })
}

/// Diagnoses what a fit leaves of a session; `may_hide` as long as outliers may hide under what is found.
fn diagnose_ground(
    mut fine: Ground,
    setups: &Setups,
    values: &[f64],
    fit: identify::Fit,
    may_hide: bool,
) -> Result<Diagnosis, DiagnoseError> {
    let (problem, session) = (fine.problem, fine.context.session());
    let chain = problem.chain;
    let families = families(&fine);
    fine.prepare(families.iter().flat_map(|family| &family.outlets));
    let (thinned, groups) = thin(session, &fine.kept);
    let thin_context = Context::of(&thinned, chain)?;
    let mut coarse = fine.thinned(&thin_context, &groups);
    coarse.prepare(families.iter().flat_map(|family| &family.outlets));
    let cells = Cells::of(&coarse, &families);
    let grounds = Grounds { fine: &fine, coarse: &coarse, cells: &cells };
    let floors = search::floors(&grounds);
    let noise_um = 1e3 * floor::mean_noise_mm2(&floors[0]).sqrt();
    let readings: usize = fine.kept.iter().map(Vec::len).sum();
    let left_out = fit.tests.iter().map(|test| test.left_out.len()).sum::<usize>() as f64 / readings.max(1) as f64;
    let strain = refit::strain(problem, values, WIDER_SETUPS);
    let data_fault = preflight::preflight(session, 1e3 * fit.rms_mm, noise_um, left_out, strain)
        .or_else(|| contradictions::further_contradiction(session));
    let nothing = || search::nothing(&fine, &floors[0]);
    let is_certain = data_fault.as_ref().is_some_and(|fault| !fault.is_shift_of_single_tests());
    let without_hidden =
        |left_mm: &[Vec<f64>]| may_hide.then(|| without_hidden_outliers(problem, &fit, left_mm)).flatten();
    let mut cleaner = None;
    let hides = |left_mm: &[Vec<f64>]| {
        cleaner = without_hidden(left_mm);
        cleaner.is_some()
    };
    let mut search = if is_certain { nothing() } else { search_unless(&grounds, &floors, &families, hides) };
    if cleaner.is_none() && fine.has_sweeps() && !search.found.is_empty() {
        cleaner = without_hidden(&search.residual_mm);
    }
    if let Some(fit) = cleaner {
        let fine = fine.with_rows(fit.kept_rows());
        return diagnose_ground(fine, setups, values, fit, false);
    }
    let data_fault =
        data_fault.and_then(|fault| beside(&fine, &search, noise_um, fault)).or_else(|| shift_of_one_test(&search));
    if data_fault.is_some() {
        search = nothing();
    }
    let mut told = Told::of(&fine, &families, &search);
    let mut proof = None;
    if !told.findings.is_empty() {
        let proved = proof::prove(&grounds, &floors, &families, &search.found, &told.findings, &search.noise_after);
        // what static poses show was accepted by prediction already
        proof = proved.map(|proved| match fine.has_sweeps() {
            true => confirm(&fine, &families, &mut search, &mut told, proved, noise_um),
            false => proved,
        });
        proof = proof.filter(|_| !told.findings.is_empty());
    }
    if data_fault.is_none() && fine.has_sweeps() {
        listen(&fine, &families, &mut search, &mut told, &mut proof, noise_um);
    }
    let layout = next_test::Layout { session: &thinned, problem, values, kept: &coarse.kept, noise: &floors[1] };
    propose(&layout, &search, &mut told.findings);
    recurring::tell_as_one(&fine, &mut told.findings, &mut proof);
    // a fast effect in every recording counted as noise as long as it was not known
    let noise_um = match fine.has_sweeps() && data_fault.is_none() {
        true => 1e3 * floor::noise_left_mm(&fine, &told.left_mm).min(told.rms_mm(&fine)),
        false => noise_um,
    };
    let Told { columns, stage, left_mm, mut findings } = told;
    let placebos = placebo::placebos(&fine, &findings, &columns, &search.noise_after);
    let transfers = transfer::transfers(&fine, setups, &findings, &columns, &search.noise_after);
    // a wrong sense makes all numbers wrong: it stands first
    let mut blind_to = blind::unseen_senses(session, &fit)?;
    blind_to.extend(blind::blind_to(&coarse, &families, &Stage::new(&coarse, &floors[1], &[], &coarse.kept)));
    let left_out = fit.tests.iter().map(|test| test.left_out.len()).sum();
    let tests = before_and_after(&fit, left_mm);
    let pooled = |of: fn(&TestBeforeAfter) -> &[f64]| {
        let kept = tests.iter().flat_map(|test| of(test).iter().zip(&test.kept).filter(|(_, kept)| **kept));
        1e3 * rms(kept.map(|(value, _)| *value))
    };
    let (rms_before_um, rms_after_um) = match &data_fault {
        Some(fault) if fault.after_um.is_finite() => (fault.before_um, fault.after_um),
        _ => (pooled(|test| &test.before_mm), pooled(|test| &test.after_mm)),
    };
    let is_static = !fine.has_sweeps();
    let after: Vec<Vec<f64>> = tests.iter().map(|test| test.after_mm.clone()).collect();
    let left = is_static.then(|| Left::of(&fine, &Poses::of(&fine), &after)).flatten();
    let noise_um = if is_static { left.map(|left| left.readings_um) } else { Some(noise_um) };
    let verdict = match data_fault {
        Some(_) => Verdict::DataFault,
        None => verdict(&findings, rms_after_um, noise_um, proof.as_ref()),
    };
    let carries: Vec<bool> = transfers.iter().map(|one| one.as_ref().is_none_or(Transfer::is_right)).collect();
    temper(&mut findings, verdict, fine.has_sweeps(), proof.as_ref(), &carries);
    let location_errors = moved(problem, &fit, &stage);
    Ok(Diagnosis {
        verdict,
        findings,
        data_fault,
        unjudged: None,
        warnings: Vec::new(),
        left_out,
        proof,
        placebos,
        transfers,
        blind_to,
        rms_before_um,
        rms_after_um,
        noise_um,
        left,
        location_errors,
        tests,
        unknowns: problem.unknowns.clone(),
    })
}

/// Share of the readings that may hide as outliers under an effect: more is the rest of its form.
const MOST_HIDDEN: f64 = 0.005;

/// The fit without readings that are far off once an effect is taken from the residuals; `None` where there are none.
fn without_hidden_outliers(problem: &Problem, fit: &identify::Fit, left_mm: &[Vec<f64>]) -> Option<identify::Fit> {
    let mut fit = fit.clone();
    let (mut hidden, mut readings) = (0, 0);
    for (test, near) in fit.tests.iter_mut().zip(identify::kept_rows(problem, left_mm)) {
        readings += test.kept.len();
        for row in (0..near.len()).filter(|&row| !near[row]) {
            if test.kept[row] {
                hidden += 1;
                test.kept[row] = false;
                test.left_out.push(row);
            }
        }
        test.left_out.sort_unstable();
    }
    (hidden > 0 && (hidden as f64) < MOST_HIDDEN * readings as f64).then_some(fit)
}

/// Positions and lengths of one test that do not belong together.
fn is_shift_of_one_test(effect: &Effect) -> bool {
    effect.kind == "trigger-latency" && effect.tests.is_some()
}

/// Whether one effect explains what looks like the shift of a single test, and more than that test shows it. Two effects may
/// be a slip there and back, which is a shift.
fn explains_a_shift(fine: &Ground, search: &Search, noise_um: f64, fault: &DataFault) -> bool {
    let is_one = search.found.len() == 1;
    let is_seen = |test: usize| search.found[0].chosen.columns.iter().any(|column| !column.by_test[test].is_empty());
    let name = |test: usize| &fine.context.session().tests[test].name;
    if !is_one || !(0..fine.tests()).any(|test| is_seen(test) && !fault.tests.contains(name(test))) {
        return false;
    }
    let chosen = &search.found[0].chosen;
    !is_shift_of_one_test(&chosen.effect) && left_um(fine, search) < STILL_THERE * noise_um
}

/// A mistake beside what a search found: with the slip that says as much of the same tests; `None` where an effect explains
/// more than it.
fn beside(fine: &Ground, search: &Search, noise_um: f64, mut fault: DataFault) -> Option<DataFault> {
    if says_as_much(fine, search, &fault) {
        fault.causes.push(naming::cause(fine.context.machine(), &search.found[0].chosen, &[]));
        return Some(fault.shared_evenly());
    }
    (!explains_a_shift(fine, search, noise_um, &fault)).then_some(fault)
}

/// Residual with what a search found, µm.
fn left_um(fine: &Ground, search: &Search) -> f64 {
    1e3 * model::mean_square(fine, &search.residual_mm).sqrt()
}

/// Residual over that of another explanation up to which one is as near as the other.
const AS_NEAR: f64 = 1.1;

/// Whether the one thing found is an event that has the tests of a fault on one side and all others on the other, and leaves
/// as much: with amplitudes for each direction it says of these what one shift says.
fn says_as_much(fine: &Ground, search: &Search, fault: &DataFault) -> bool {
    let [Found { chosen: event, .. }] = &search.found[..] else { return false };
    let Some(time_s) = event.effect.number("time").filter(|_| event.is_event()) else { return false };
    let tests = &fine.context.session().tests;
    // an event is found a little before or behind the moment between two tests
    let is_before = |test: &usize| 0.5 * (tests[*test].started_at_s + fine.context.ends_at_s(*test)) < time_s;
    let (before, after): (Vec<usize>, Vec<usize>) = (0..tests.len()).partition(is_before);
    let are_its = |side: &[usize]| {
        side.len() == fault.tests.len() && side.iter().all(|test| fault.tests.contains(&tests[*test].name))
    };
    let ratio = fault.after_um / left_um(fine, search);
    (AS_NEAR.recip()..AS_NEAR).contains(&ratio) && (are_its(&before) || are_its(&after))
}

/// The shift of a single test that a search found.
fn shift_of_one_test(search: &Search) -> Option<DataFault> {
    let found = search.found.iter().find(|found| is_shift_of_one_test(&found.chosen.effect))?;
    let tests = found.chosen.effect.tests.clone().unwrap_or_default();
    let shift_ms = found.chosen.judgement.amplitudes.first().copied()?;
    let before_mm2 = search.residual_before_mm2;
    Some(DataFault::time_shift(
        shift_ms / 1e3,
        tests,
        1e3 * before_mm2.sqrt(),
        1e3 * (before_mm2 - found.fall_mm2).max(0.0).sqrt(),
    ))
}

/// Residuals of every test in the fit without effects and with them.
fn before_and_after(fit: &identify::Fit, left_mm: Vec<Vec<f64>>) -> Vec<TestBeforeAfter> {
    let told = |(test, after_mm): (&identify::TestFit, Vec<f64>)| TestBeforeAfter {
        name: test.name.clone(),
        before_mm: test.residual_mm.clone(),
        after_mm,
        kept: test.kept.clone(),
    };
    fit.tests.iter().zip(left_mm).map(told).collect()
}

/// Location errors of the fit with and without the effects.
fn moved(problem: &Problem, fit: &identify::Fit, stage: &Stage) -> Vec<Moved> {
    let covariance = stage.covariance();
    problem
        .unknowns
        .iter()
        .enumerate()
        .filter(|(_, unknown)| matches!(unknown.quantity, Quantity::Location { .. }))
        .map(|(k, unknown)| Moved {
            name: unknown.label.clone(),
            measure: unknown.measure,
            before: fit.estimates[k].value,
            after: fit.estimates[k].value + stage.nuisance(k) * unknown.prior_sigma,
            sigma: covariance[(k, k)].sqrt() * unknown.prior_sigma,
            determined: fit.estimates[k].determined,
        })
        .collect()
}
