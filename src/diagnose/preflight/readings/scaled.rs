//! Sessions whose readings are held the other way round, in another unit or from another zero. Which mistake was made is for others to judge.
//!
//! A gauge shows how much longer the bar is than calibrated. Files hold that deviation or the whole length; whoever converts one
//! into the other may take the wrong sign or unit, and whoever zeroes the gauge at the start of a run moves its zero.

use super::figures::{Figure, Linearised};
use super::processed::{deviations_mm, own_zeros};
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::model::decimate::Sampled;
use crate::diagnose::preflight::data_fault::{RECORDER, listed};
use crate::diagnose::preflight::places::exchanged::repeats;
use crate::diagnose::preflight::places::misplaced::names;
use crate::diagnose::preflight::quick_fit::Refit;
use crate::diagnose::preflight::suspicion::{Detail, OFTEN, RARELY, SOMETIMES, Suspicion};
use crate::diagnose::selection::shapes::judged_shape::PARAMETER_COST;
use crate::identify::{Quantity, Unknown};
use crate::session::{FREE_ZERO_MM, Session, Setups, Test, Zero};
use crate::units::MM_PER_INCH;

/// Factors that a conversion may have left on the deviations, with words.
pub(crate) const FACTORS: [(f64, &str); 7] = [
    (-1.0, "have the wrong sign: turn it"),
    (
        2.0,
        "are about 2.00 times what they should be: a diameter was taken for a radius, or a gain was applied twice; export them again, without a factor",
    ),
    (
        0.5,
        "are about 0.50 times what they should be: a radius was taken for a diameter, or a gain was lost; export them again, without a factor",
    ),
    (10.0, "are ten times too large: look at their unit"),
    (0.1, "are a tenth of what they should be: look at their unit"),
    (MM_PER_INCH, "are 25.4 times too large: they were converted from inches twice, or are in mm where inches are due"),
    (1.0 / MM_PER_INCH, "are 25.4 times too small: they are in inches"),
];

/// Deviations of all tests, and of some groups of them, with a factor undone.
pub(crate) fn scaled(session: &Session, groups: &[Vec<usize>]) -> Vec<Suspicion> {
    let with_bar = |tests: &[usize]| tests.iter().all(|&test| session.tests[test].bar_length_mm.is_some());
    let every = every(session);
    let all = std::iter::once(&every).chain(groups.iter().filter(|group| group.len() < every.len()));
    let mut list = Vec::new();
    for tests in all.filter(|tests| !tests.is_empty() && with_bar(tests)) {
        let is_all = tests.len() == every.len();
        // a factor common to all changes every error and no residual in its proportion: only a sign can be told
        let factors = FACTORS.iter().filter(|(factor, _)| *factor < 0.0 || !is_all);
        list.extend(factors.map(|&(factor, _)| Suspicion {
            weight: if is_all { OFTEN } else { SOMETIMES },
            ..with_factor(session, tests, factor)
        }));
    }
    list
}

/// Deviations of some tests with a factor undone.
pub(super) fn with_factor(session: &Session, tests: &[usize], factor: f64) -> Suspicion {
    let every = every(session);
    let names: Vec<String> = if tests.len() == every.len() { Vec::new() } else { names(session, tests) };
    let share = readings(session, tests) as f64 / readings(session, &every).max(1) as f64;
    let words = FACTORS.iter().find(|(known, _)| is_near(factor, *known)).map(|(_, words)| (*words).to_string());
    let words = words.unwrap_or_else(|| {
        let times = if factor < 0.1 { format!("{factor:.1e}") } else { format!("{factor:.2}") };
        format!("are about {times} times what they should be: export them again, without a factor")
    });
    let says = format!("the deviations from the bar's length in {} {words}", listed(&names));
    let kind = if factor < 0.0 { FaultKind::ReadingSign } else { FaultKind::Unit };
    let found = Suspicion::new(kind, RECORDER, names, says, with_deviations(session, tests, factor.recip()));
    Suspicion {
        components: vec!["length".into()],
        detail: Detail::sizes(&[factor], 1e-4),
        diminished: factor.abs().powf(share),
        ..found
    }
}

/// Factors nearer to 1 are for calibrations, and nearer to one of those above for its words.
const LEAST_FACTOR: f64 = 0.03;

/// Deviations of some groups of tests that are too large or too small by any factor.
pub(crate) fn scaled_by_any(session: &Session, linearised: &Linearised, groups: &[Vec<usize>]) -> Vec<Suspicion> {
    let of = |tests: &Vec<usize>| {
        let deviations = |&test: &usize| Some((test, deviations_mm(&session.tests[test])?));
        let figure = [Figure { by_test: tests.iter().map(deviations).collect::<Option<Vec<_>>>()? }];
        let sizes = linearised.fitted(&figure)?;
        let factor = 1.0 / (1.0 + sizes[0].value);
        let is_other = factor > 0.0 && factor.is_finite() && !is_near(factor, 1.0);
        if !is_other || is_known(factor) {
            return None;
        }
        let found = with_factor(session, tests, factor);
        Some(Suspicion { log_figures: -PARAMETER_COST, weight: RARELY, ..found })
    };
    groups.iter().filter(|group| group.len() < session.tests.len()).filter_map(of).collect()
}

/// Length of bar to which software states deviations, mm.
const STATED_PER_MM: f64 = 100.0;

/// Deviations that software stated per 100 mm of bar, with that undone; none where all bars are of one length, which no residual tells.
pub(crate) fn per_100_mm(session: &Session) -> Option<Suspicion> {
    let bars: Option<Vec<f64>> = session.tests.iter().map(|test| test.bar_length_mm).collect();
    let bars = bars.filter(|bars| bars.iter().any(|bar| bar.round() != bars[0].round()))?;
    let mut undone = session.clone();
    let (mut log_diminished, mut count) = (0.0, 0);
    for (test, bar_mm) in bars.iter().enumerate() {
        let times = bar_mm / STATED_PER_MM;
        multiply_deviations(&mut undone.tests[test], times);
        let own = readings(session, &[test]);
        log_diminished -= own as f64 * times.ln();
        count += own;
    }
    let says = "deviations are stated per 100 mm of bar: multiply them by the bar's length over 100 mm, or export them as they were read";
    let found = Suspicion::new(FaultKind::Unit, RECORDER, Vec::new(), says.into(), undone);
    let diminished = (log_diminished / count.max(1) as f64).exp();
    Some(Suspicion {
        components: vec!["length".into()],
        detail: Detail::Way("per 100 mm"),
        weight: RARELY,
        diminished,
        ..found
    })
}

fn is_near(factor: f64, other: f64) -> bool {
    (factor / other - 1.0).abs() < LEAST_FACTOR
}

/// Whether a factor is none but a calibration.
pub(super) fn is_near_one(factor: f64) -> bool {
    is_near(factor, 1.0)
}

/// Whether a factor is one that conversions are known to leave.
pub(super) fn is_known(factor: f64) -> bool {
    FACTORS.iter().any(|(known, _)| is_near(factor, *known))
}

fn every(session: &Session) -> Vec<usize> {
    (0..session.tests.len()).collect()
}

/// Readings of some tests.
fn readings(session: &Session, tests: &[usize]) -> usize {
    let recordings = tests.iter().filter_map(|&test| session.tests[test].recording.as_ref());
    recordings.map(|recording| recording.length_mm.iter().filter(|length| length.is_finite()).count()).sum()
}

/// The session with the deviations of some tests multiplied.
fn with_deviations(session: &Session, tests: &[usize], factor: f64) -> Session {
    let mut undone = session.clone();
    tests.iter().for_each(|&test| multiply_deviations(&mut undone.tests[test], factor));
    undone
}

fn multiply_deviations(test: &mut Test, factor: f64) {
    if let (Some(bar_mm), Some(recording)) = (test.bar_length_mm, &mut test.recording) {
        recording.length_mm.iter_mut().for_each(|length| *length = bar_mm + factor * (*length - bar_mm));
    }
}

/// Groups of tests in which the gauge was zeroed for itself.
pub(crate) fn zeroed(session: &Session, groups: &[Vec<usize>]) -> Vec<Suspicion> {
    let of = |tests: &Vec<usize>| {
        let names = names(session, tests);
        let mut undone = session.clone();
        for &test in tests {
            undone.tests[test].bar_setup = Some("zeroed for itself".into());
            undone.tests[test].zero = Zero::Free;
        }
        let says = format!(
            "the gauge had a zero of its own in {}: state 'bar_setup' and 'zero: free' there, and zero it once a session",
            listed(&names)
        );
        Suspicion { is_found: true, ..Suspicion::new(FaultKind::ReadingZero, "bar", names, says, undone) }
    };
    groups.iter().filter(|group| group.len() < session.tests.len()).map(of).collect()
}

/// The same readings as they would be if they had been written otherwise in all tests, which no residual tells.
pub(crate) struct HeldOtherwise {
    pub(crate) session: Session,
    pub(crate) kind: FaultKind,
    pub(crate) says: String,
}

/// Nominal lengths of bars are whole millimetres within this, mm.
const FROM_NOMINAL_MM: f64 = 0.2;

/// All ways in which deviations of all tests may have been written, where the files hold deviations; lengths may be nominal ones
/// with a deviation added.
pub(crate) fn held_otherwise(session: &Session) -> Vec<HeldOtherwise> {
    if session.tests.iter().any(|test| test.bar_length_mm.is_none() || test.recording.is_none()) {
        return Vec::new();
    }
    // what all recordings have alike by software needs no other explanation
    let own_zeros = own_zeros(Sampled { few_rows: session, all_rows: session });
    if !own_zeros.is_empty() {
        let held = |one: Suspicion| HeldOtherwise { session: one.undone, kind: one.kind, says: one.says };
        return own_zeros.into_iter().map(held).collect();
    }
    let every = every(session);
    let is_deviation = |test: &Test| test.recording.as_ref().is_some_and(|recording| recording.column.is_deviation());
    let mut list = Vec::new();
    if session.tests.iter().all(is_deviation) {
        let turned = with_deviations(session, &every, -1.0);
        let says = "the deviations from the bars' lengths have the wrong sign: turn it".to_string();
        list.push(HeldOtherwise { session: turned, kind: FaultKind::ReadingSign, says });
    }
    let mut nominal = session.clone();
    let mut offsets: Vec<f64> = Vec::new();
    for test in &mut nominal.tests {
        let (Some(bar), Some(recording)) = (test.bar_length_mm, &mut test.recording) else { continue };
        let off = bar.round() - bar;
        if off.abs() > FROM_NOMINAL_MM {
            return list;
        }
        if !offsets.contains(&off) {
            offsets.push(off);
        }
        recording.length_mm.iter_mut().for_each(|length| *length += off);
    }
    // what brings one bar back may be a slip or growth as well
    if offsets.len() > 1 {
        let says = "deviations were counted from the bars' nominal lengths and not from the calibrated ones that the session states: \
                    state whole millimetres as bar_length, or correct the readings"
            .to_string();
        list.push(HeldOtherwise { session: nominal, kind: FaultKind::ReadingZero, says });
    }
    list
}

/// Zero of a gauge in one direction of a program that is told from noise, mm: ten times what a good gauge scatters by.
const LEAST_ZERO_MM: f64 = 0.002;

/// The same in all directions of a program, mm: there a few micrometres may as well be errors of slides where they stand.
const LEAST_ZERO_OF_ALL_MM: f64 = 0.01;

/// How far the zero of some tests must be off to be one, mm.
pub(crate) fn least_zero_mm(session: &Session, suspicion: &Suspicion) -> f64 {
    let struck = |test: &usize| suspicion.tests.contains(&session.tests[*test].name);
    let first = (0..session.tests.len()).find(struck);
    let is_whole = first.is_none_or(|first| repeats(session, first).iter().all(struck));
    if is_whole { LEAST_ZERO_OF_ALL_MM } else { LEAST_ZERO_MM }
}

/// How far a gauge is off that was zeroed for itself in the tests of a mistake, mm.
pub(crate) fn own_zero_mm(refit: &Refit, suspicion: &Suspicion) -> f64 {
    let session = &suspicion.undone;
    let struck = (0..session.tests.len()).find(|&test| suspicion.tests.contains(&session.tests[test].name));
    let own = struck.and_then(|test| Setups::of(session).bar_of[test]);
    let is_own = |unknown: &Unknown| matches!(unknown.quantity, Quantity::Bar { setup } if Some(setup) == own);
    let bar = refit.unknowns.iter().zip(&refit.values).find(|(unknown, _)| is_own(unknown));
    bar.map_or(0.0, |(_, value)| value.abs())
}

/// Logarithm of how much likelier it is that a zero moved by so much, mm, where every size from noise to the stroke is as likely on a
/// logarithmic scale, than where it lies anywhere in the stroke, as its fit has it.
pub(crate) fn log_of_any_size(moved_mm: f64) -> f64 {
    let moved_mm = moved_mm.clamp(LEAST_ZERO_MM, FREE_ZERO_MM);
    let on_a_logarithmic_scale = 1.0 / (2.0 * moved_mm * (FREE_ZERO_MM / LEAST_ZERO_MM).ln());
    let in_the_stroke =
        (-0.5 * (moved_mm / FREE_ZERO_MM).powi(2)).exp() / (FREE_ZERO_MM * std::f64::consts::TAU.sqrt());
    (on_a_logarithmic_scale / in_the_stroke).ln()
}
