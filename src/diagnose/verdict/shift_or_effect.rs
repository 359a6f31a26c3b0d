//! Whether what looks like a mistake in single tests is one, or an effect. It looks for neither.

use crate::diagnose::model::linear_model::LinearModel;
use crate::diagnose::preflight::data_fault::DataFault;
use crate::diagnose::selection::joint_fit::mean_square;
use crate::diagnose::selection::naming::cause;
use crate::diagnose::selection::selected::{Search, SelectedEffect};

/// Whether one effect explains what looks like the shift of a single test, and more than that test shows it. Two effects may
/// be a slip there and back, which is a shift.
fn explains_a_shift(fine: &LinearModel, search: &Search, noise_um: f64, fault: &DataFault) -> bool {
    let is_one = search.found.len() == 1;
    let is_seen = |test: usize| search.found[0].chosen.columns.iter().any(|column| !column.by_test[test].is_empty());
    let name = |test: usize| &fine.context.session().tests[test].name;
    if !is_one || !(0..fine.tests()).any(|test| is_seen(test) && !fault.tests.contains(name(test))) {
        return false;
    }
    let chosen = &search.found[0].chosen;
    // near the noise, or as near as the mistake, which has balls or a clock of its own for that test
    let enough_um = (fine.thresholds.explained * noise_um).max(AS_NEAR * fault.after_um);
    !chosen.is_shift_of_one_test() && left_um(fine, search) < enough_um
}

/// Whether what was found are several jumps.
fn are_jumps(search: &Search) -> bool {
    search.found.iter().filter(|found| found.chosen.is_event()).count() > 1
}

/// Whether what was found leaves clearly less than undoing a mistake does, which leaves more than noise. Several jumps follow any
/// mistake in several tests.
fn explains_more(fine: &LinearModel, search: &Search, noise_um: f64, fault: &DataFault) -> bool {
    let leaves_something = fault.after_um > fine.thresholds.explained * noise_um;
    !search.found.is_empty()
        && !are_jumps(search)
        && leaves_something
        && AS_NEAR * left_um(fine, search) < fault.after_um
}

/// Whether what was found leaves no more than noise, or than undoing a mistake does.
fn explains_as_much(fine: &LinearModel, search: &Search, noise_um: f64, fault: &DataFault) -> bool {
    let enough_um = (fine.thresholds.explained * noise_um).max(AS_NEAR * fault.after_um);
    !search.found.is_empty() && !are_jumps(search) && left_um(fine, search) < enough_um
}

/// A mistake beside what a search found: with the slip that says as much of the same tests; `None` where effects explain
/// more than it.
pub(crate) fn beside(fine: &LinearModel, search: &Search, noise_um: f64, mut fault: DataFault) -> Option<DataFault> {
    if says_as_much(fine, search, &fault) {
        fault.causes.push(cause(fine.context.machine(), &search.found[0].chosen, &[]));
        return Some(fault.shared_evenly());
    }
    let is_physics = if fault.looks_like_an_effect() {
        explains_a_shift(fine, search, noise_um, &fault)
    } else if fault.may_be_a_slide() {
        explains_as_much(fine, search, noise_um, &fault)
    } else {
        explains_more(fine, search, noise_um, &fault)
    };
    (!is_physics).then_some(fault)
}

/// Residual with what a search found, µm.
fn left_um(fine: &LinearModel, search: &Search) -> f64 {
    1e3 * mean_square(fine, &search.residual_mm).sqrt()
}

/// Residual over that of another explanation up to which one is as near as the other.
const AS_NEAR: f64 = 1.1;

/// Whether the one thing found is an event that has the tests of a fault on one side and all others on the other, and leaves
/// as much: with amplitudes for each direction it says of these what one shift says.
fn says_as_much(fine: &LinearModel, search: &Search, fault: &DataFault) -> bool {
    let [SelectedEffect { chosen: event, .. }] = &search.found[..] else { return false };
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
pub(crate) fn shift_of_one_test(search: &Search) -> Option<DataFault> {
    let found = search.found.iter().find(|found| found.chosen.is_shift_of_one_test())?;
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
