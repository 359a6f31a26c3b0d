//! Sessions whose readings stand beside the wrong rows of one recording: from the other end, moved round, joined over a gap, or read while
//! the axis stood.
//! Which of it happened is for others to judge.

use super::figures::Linearised;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::model::decimate::{Sampled, keep_few_rows};
use crate::diagnose::preflight::data_fault::{RECORDER, listed};
use crate::diagnose::preflight::places::misplaced::names;
use crate::diagnose::preflight::suspicion::{Detail, RARELY, Suspicion};
use crate::diagnose::selection::shapes::judged_shape::PARAMETER_COST;
use crate::session::Recording;

/// All orders of the readings that are tried of some tests, and of groups of them.
pub(crate) fn out_of_order(
    sampled: Sampled<'_>,
    linearised: &Linearised,
    worst: &[usize],
    groups: &[Vec<usize>],
) -> Vec<Suspicion> {
    let alone = worst.iter().map(|&test| vec![test]);
    let mut list: Vec<Suspicion> =
        alone.chain(groups.iter().cloned()).filter_map(|tests| backwards(sampled, &tests)).collect();
    for &test in worst {
        list.extend(moved_round(sampled, linearised, test));
        list.extend(joined(sampled, linearised, test));
        list.extend(stood(sampled, linearised, test));
    }
    list
}

/// The session with other recordings of some tests, on few rows.
fn with_recordings(
    sampled: Sampled<'_>,
    tests: &[usize],
    says: String,
    other: impl Fn(&mut Recording),
) -> Option<Suspicion> {
    let Sampled { few_rows: thinned, all_rows: session } = sampled;
    let mut undone = thinned.clone();
    for &test in tests {
        let mut recording = session.tests[test].recording.clone().filter(|recording| recording.len() >= LEAST_ROWS)?;
        other(&mut recording);
        keep_few_rows(&mut recording);
        undone.tests[test].recording = Some(recording);
    }
    let mut found = Suspicion::new(FaultKind::ReadingsOrder, RECORDER, names(session, tests), says, undone);
    (found.components, found.weight) = (vec!["length".into()], RARELY);
    Some(found)
}

/// Rows below which an order of readings is not told, as fits of three unknowns and an order are possible by chance.
const LEAST_ROWS: usize = 24;

/// Readings written from the other end than the positions beside them.
fn backwards(sampled: Sampled<'_>, tests: &[usize]) -> Option<Suspicion> {
    let says = format!(
        "the readings of {} are written from the other end than the positions beside them: reverse the column of the readings",
        listed(&names(sampled.all_rows, tests))
    );
    let found = with_recordings(sampled, tests, says, |recording| recording.length_mm.reverse());
    found.map(|found| Suspicion { detail: Detail::Way("backwards"), ..found })
}

/// Rows by which readings are tried to have been moved round first: so many parts of a recording. A finer search follows.
const TURNS: usize = 60;

/// Readings moved round by some rows: those of the end stand at the beginning.
fn moved_round(sampled: Sampled<'_>, linearised: &Linearised, test: usize) -> Option<Suspicion> {
    let session = sampled.all_rows;
    let recording = session.tests[test].recording.as_ref()?;
    let rows = recording.len();
    let left = |by: usize| {
        let mut moved = recording.clone();
        moved.length_mm.rotate_left(by);
        keep_few_rows(&mut moved);
        let residual = moved.length_mm.iter().zip(linearised.predicted_mm(test)).map(|(length, at)| length - at);
        linearised.left_with(test, &residual.collect::<Vec<_>>())
    };
    let mut step = rows.div_ceil(TURNS);
    let mut best = (step..rows).step_by(step).map(|by| (left(by), by)).min_by(|a, b| a.0.total_cmp(&b.0))?;
    while step > 1 {
        step = step.div_ceil(2);
        let beside = [best.1.saturating_sub(step).max(1), (best.1 + step).min(rows - 1)];
        best = beside.into_iter().fold(best, |best, by| {
            let left = left(by);
            if left < best.0 { (left, by) } else { best }
        });
    }
    let by = best.1;
    let says = format!(
        "the readings of {} stand about {by} rows from the positions that belong to them, those of the end at the beginning: \
         export the recording again from its start",
        session.tests[test].name
    );
    let found = with_recordings(sampled, &[test], says, |recording| recording.length_mm.rotate_left(by));
    let detail = Detail::sizes(&[by as f64], 1.0);
    found.map(|found| Suspicion { detail, log_figures: -PARAMETER_COST, ..found })
}

/// Shares of a recording that are tried to have been lost, and places where.
const LOST: [f64; 7] = [0.01, 0.02, 0.04, 0.06, 0.09, 0.13, 0.18];
const PLACES: usize = 16;

/// Readings lost in one place, and those after it drawn over the gap: rows that are evenly spaced without being so.
fn joined(sampled: Sampled<'_>, linearised: &Linearised, test: usize) -> Option<Suspicion> {
    let Sampled { few_rows: thinned, all_rows: session } = sampled;
    let few = &thinned.tests[test].recording.as_ref()?.length_mm;
    let predicted_mm = linearised.predicted_mm(test);
    let left = |(from, lost): (f64, f64)| {
        let residual = few.iter().enumerate().map(|(row, length)| {
            let at = place_before((from, lost), row as f64 / (few.len() - 1) as f64);
            length - between(predicted_mm, at)
        });
        linearised.left_with(test, &residual.collect::<Vec<_>>())
    };
    let best = likeliest_gap(left)?;
    let rows = session.tests[test].recording.as_ref()?.len();
    let missing = (best.1 * rows as f64 / (1.0 - best.1)).round();
    let says = format!(
        "about {missing:.0} readings of {} are lost near row {:.0}, and the others were drawn over the gap: every reading after it stands \
         beside a wrong position; export the recording with its times or positions as read",
        session.tests[test].name,
        best.0 * rows as f64
    );
    let found = with_recordings(sampled, &[test], says, |recording| {
        let last = (recording.len() - 1) as f64;
        let read = recording.length_mm.clone();
        for (row, length) in recording.length_mm.iter_mut().enumerate() {
            *length = place_now(best, row as f64 / last, 1.0 / last).map_or(f64::NAN, |at| between(&read, at));
        }
    });
    let detail = Detail::sizes(&[missing, best.0 * rows as f64, 0.0], 1.0);
    found.map(|found| Suspicion { detail, log_figures: -2.0 * PARAMETER_COST, ..found })
}

/// Where a gap begins and how long it is, as shares of a recording, by what is left with it.
fn likeliest_gap(left: impl Fn((f64, f64)) -> f64) -> Option<(f64, f64)> {
    let grid = LOST.iter().flat_map(|&lost| (1..PLACES).map(move |place| (place as f64 / PLACES as f64, lost)));
    let (mut best, mut least) = grid.map(|gap| (gap, left(gap))).min_by(|a, b| a.1.total_cmp(&b.1))?;
    let mut step = (0.5 / PLACES as f64, 0.25 * best.1);
    for _ in 0..FINER {
        for (by, lost) in [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)] {
            let next = ((best.0 + by * step.0).clamp(0.0, 1.0), (best.1 + lost * step.1).clamp(0.002, 0.3));
            let left = left(next);
            (best, least) = if left < least { (next, left) } else { (best, least) };
        }
        step = (0.6 * step.0, 0.6 * step.1);
    }
    Some(best)
}

/// Rows in which the axis stood, with positions drawn over all rows as if it had gone on: those after it stand beside positions that come
/// too late.
fn stood(sampled: Sampled<'_>, linearised: &Linearised, test: usize) -> Option<Suspicion> {
    let Sampled { few_rows: thinned, all_rows: session } = sampled;
    let few = &thinned.tests[test].recording.as_ref()?.length_mm;
    let predicted_mm = linearised.predicted_mm(test);
    let dwell = likeliest_gap(|dwell| {
        let at = |row: usize| place_moved(dwell, row as f64 / (few.len() - 1) as f64);
        let residual = few.iter().enumerate().map(|(row, length)| length - between(predicted_mm, at(row)));
        linearised.left_with(test, &residual.collect::<Vec<_>>())
    })?;
    let recording = session.tests[test].recording.as_ref()?;
    let name = &session.tests[test].name;
    let rows = recording.len() as f64;
    let (from, count) = (dwell.0 * rows, (dwell.1 * rows).round());
    let says = format!(
        "the axis stood for about {count:.0} rows near row {from:.0} of {name}, over which its positions go on: a dwell was left in; cut those \
         rows and spread the positions over the others"
    );
    let moved = |recording: &mut Recording| {
        let last = (recording.len() - 1) as f64;
        for column in &mut recording.positions {
            let stated = column.clone();
            let place = |row: usize| place_moved(dwell, row as f64 / last);
            column.iter_mut().enumerate().for_each(|(row, value)| *value = between(&stated, place(row)));
        }
    };
    let found = with_recordings(sampled, &[test], says, moved)?;
    let detail = Detail::sizes(&[count, from, 1.0], 1.0);
    Some(Suspicion {
        kind: FaultKind::Dwell,
        components: Vec::new(),
        detail,
        log_figures: -2.0 * PARAMETER_COST,
        ..found
    })
}

/// Share of the way at which the axis is where it stood for a share of all rows, from a share of them on.
fn place_moved((from, stood): (f64, f64), at: f64) -> f64 {
    let moved = 1.0 - stood;
    (if at < from { at } else { (at - stood).max(from) } / moved).min(1.0)
}

/// Rounds in which a gap is brought nearer to its place and length.
const FINER: usize = 12;

/// Share of the way at which a row was read that stands at another share now, where a share of all was lost from a row on.
fn place_before((from, lost): (f64, f64), at: f64) -> f64 {
    let kept = 1.0 - lost;
    if at < from { at * kept } else { at * kept + lost }
}

/// The other way round; `None` where readings were lost, and within `beside` of the gap, where a row may have been drawn through it.
fn place_now((from, lost): (f64, f64), before: f64, beside: f64) -> Option<f64> {
    let (kept, begins) = (1.0 - lost, from * (1.0 - lost));
    match before {
        _ if before <= begins - beside => Some(before / kept),
        _ if before >= begins + lost + beside => Some((before - lost) / kept),
        _ => None,
    }
}

/// A column at a share of its way, between its rows.
fn between(column: &[f64], at: f64) -> f64 {
    let place = at.clamp(0.0, 1.0) * (column.len() - 1) as f64;
    let row = (place as usize).min(column.len().saturating_sub(2));
    let above = column.get(row + 1).copied().unwrap_or(column[row]);
    column[row] + (place - row as f64) * (above - column[row])
}
