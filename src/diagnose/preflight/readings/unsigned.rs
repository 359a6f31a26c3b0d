//! Sessions in which some deviations were written without their sign. Whether they were is for others to judge.

use super::figures::Linearised;
use super::processed::{NO_DIGIT_MM, deviations_mm};
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::model::decimate::{Sampled, keep_few_rows};
use crate::diagnose::preflight::data_fault::{RECORDER, listed};
use crate::diagnose::preflight::places::misplaced::names;
use crate::diagnose::preflight::suspicion::{Detail, Suspicion};
use crate::statistics::noise_of_rows;

/// Rows on either side of a place where a curve may turn at zero.
const ROWS_BESIDE: usize = 6;

/// How much steeper than by noise a curve must come to zero and leave it, in standard deviations of its slope.
const STEEP: f64 = 4.0;

/// Recordings with no deviation below zero, of which one turns there as only a curve without its sign does: signs put back as they
/// fit best.
pub(crate) fn unsigned(sampled: Sampled<'_>, linearised: &Linearised) -> Option<Suspicion> {
    let Sampled { few_rows: thinned, all_rows: session } = sampled;
    let deviations: Vec<Option<Vec<f64>>> = session
        .tests
        .iter()
        .map(|test| {
            let deviations = deviations_mm(test)?;
            let is_above = !deviations.iter().any(|deviation| *deviation < -NO_DIGIT_MM);
            (is_above && deviations.len() > 2 * ROWS_BESIDE).then_some(deviations)
        })
        .collect();
    let turns: Vec<Vec<usize>> =
        deviations.iter().map(|one| one.as_deref().map_or_else(Vec::new, turns_at_zero)).collect();
    if turns.iter().all(Vec::is_empty) {
        return None;
    }
    let mut undone = thinned.clone();
    let mut tests = Vec::new();
    for (test, deviations) in deviations.iter().enumerate() {
        let (Some(deviations), Some(bar_mm)) = (deviations, session.tests[test].bar_length_mm) else { continue };
        let signed = |first: f64| {
            let sign =
                |row: usize| if turns[test].partition_point(|turn| *turn <= row) % 2 == 0 { first } else { -first };
            let mut recording = session.tests[test].recording.clone()?;
            let read = recording.length_mm.iter_mut().zip(deviations).enumerate();
            read.for_each(|(row, (length, deviation))| *length = bar_mm + sign(row) * deviation);
            keep_few_rows(&mut recording);
            Some(recording)
        };
        let predicted_mm = linearised.predicted_mm(test);
        let left = |first: f64| {
            let few = signed(first)?;
            let residual: Vec<f64> = few.length_mm.iter().zip(predicted_mm).map(|(length, at)| length - at).collect();
            Some((linearised.left_with(test, &residual), few))
        };
        let (below, above) = (left(-1.0)?, left(1.0)?);
        if below.0 < above.0 || !turns[test].is_empty() {
            undone.tests[test].recording = Some(if below.0 < above.0 { below.1 } else { above.1 });
            tests.push(test);
        }
    }
    let names = names(session, &tests);
    let says = format!("the deviations of {} lost their sign: export them with it", listed(&names));
    let mut found = Suspicion::new(FaultKind::ReadingsProcessed, RECORDER, names, says, undone);
    (found.components, found.detail) = (vec!["length".into()], Detail::Way("sign lost"));
    Some(found)
}

/// Rows at which a curve comes down to zero and leaves it as steeply.
fn turns_at_zero(deviation_mm: &[f64]) -> Vec<usize> {
    let noise_mm = noise_of_rows(deviation_mm).max(NO_DIGIT_MM);
    // of a line through rows −n to −1 or 1 to n, by its end at the place itself
    let slope = |row: usize, sign: f64| {
        let rows = 1..=ROWS_BESIDE;
        let weight: f64 = rows.clone().map(|k| (k * k) as f64).sum();
        let at = |k: usize| deviation_mm[if sign > 0.0 { row + k } else { row - k }] - deviation_mm[row];
        rows.map(|k| k as f64 * at(k)).sum::<f64>() / weight
    };
    // the reading at the place is in all differences
    let (sum, squares) =
        (1..=ROWS_BESIDE).fold((0.0, 0.0), |(sum, squares), k| (sum + k as f64, squares + (k * k) as f64));
    let steep_mm = STEEP * noise_mm * (1.0 / squares + (sum / squares).powi(2)).sqrt();
    let mut turns: Vec<usize> = Vec::new();
    for row in ROWS_BESIDE..deviation_mm.len() - ROWS_BESIDE {
        let (before, after) = (slope(row, -1.0), slope(row, 1.0));
        let is_least = (row - ROWS_BESIDE..=row + ROWS_BESIDE).all(|other| deviation_mm[row] <= deviation_mm[other]);
        let is_at_zero = deviation_mm[row] < 0.6 * before.max(after) + NEAR_ZERO * noise_mm;
        let is_new = turns.last().is_none_or(|last| row - last > ROWS_BESIDE);
        if is_least && is_at_zero && is_new && before > steep_mm && after > steep_mm {
            turns.push(row);
        }
    }
    turns
}

/// Standard deviations of the noise within which a reading is zero.
const NEAR_ZERO: f64 = 3.0;
