//! Recordings whose lengths begin or end before the axis moves, or run there and back, while the positions are spread over all of them. It repairs nothing.
//!
//! The lengths of a turning axis are a smooth curve, `a + b·cos θ + c·sin θ + d·cos 2θ + e·sin 2θ` to the second order of
//! what is small. A dwell that was left in bends it: the rows to cut are those with which such a curve fits best.

use crate::diagnose::fault_kind::FaultKind;
use crate::statistics::{mean, noise_of_rows, standard_deviation};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::data_fault::{RECORDER, listed};
use super::late_clock::between;
use super::nearer::{Sized, descended};
use super::quick_fit::{Refit, refit};
use super::suspicion::{Detail, RARELY, Suspicion};
use crate::diagnose::model::decimate::{Sampled, keep_few_rows};
use crate::diagnose::selection::shapes::judged_shape::PARAMETER_COST;
use crate::machine::AxisKind;
use crate::session::{Clock, Follow, Path, Recording, RunEnd, Session, Test};

/// Steps in which the ends of a recording are cut, as a share of its rows, and how many of them at most.
const STEPS: usize = 40;
const MOST_STEPS: usize = 16;

/// What the curve leaves of a whole recording, at least, in noises from row to row.
const LEAST_BEND_IN_NOISES: f64 = 3.0;

/// Rows that tell how well a curve fits.
const ROWS: usize = 72;

/// The curve fits so many times better without the dwell.
const LEAST_GAIN: f64 = 1.5;

/// Scatter of the readings of a dwell, at most, in noises from row to row (correlated noise adds to it), and in mm.
const MOST_SCATTER_IN_NOISES: f64 = 4.0;
const STILL_MM: f64 = 2e-4;

/// How the rows of a recording belong to its arc.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Rows {
    /// So many stand still before it and behind it.
    Between(usize, usize),
    /// The first half runs there and the second back.
    ThereAndBack,
}

/// Recordings with dwells, and those that run there and back, as they are without.
pub(crate) fn without_dwells(sampled: Sampled<'_>) -> Vec<Suspicion> {
    let Sampled { few_rows: thinned, all_rows: session } = sampled;
    let found: Vec<Option<Rows>> = session.tests.iter().map(|test| belonging(session, test)).collect();
    let mut list = Vec::new();
    for turns_back in [false, true] {
        let mut undone = thinned.clone();
        let mut tests = Vec::new();
        for (index, rows) in found.iter().enumerate() {
            let Some(rows) = rows.filter(|rows| (*rows == Rows::ThereAndBack) == turns_back) else { continue };
            undone.tests[index].recording =
                session.tests[index].recording.as_ref().map(|recording| cut(recording, rows));
            tests.push(session.tests[index].name.clone());
        }
        if tests.is_empty() {
            continue;
        }
        let which = listed(&tests);
        let (kind, says) = match turns_back {
            false => (
                FaultKind::Dwell,
                format!(
                    "lengths of {which} stand still at the ends while positions go on: a dwell was left in; cut those rows and spread the positions over the others"
                ),
            ),
            true => (
                FaultKind::BothDirections,
                format!("{which} hold a run there and the run back: make two tests of each, one a direction"),
            ),
        };
        list.push(Suspicion::new(kind, RECORDER, tests, says, undone));
    }
    list
}

/// Shares of a recording that are tried at an end, too many rows and too few; steps of a finer search as shares of the best of them.
const SHARES: [f64; 4] = [-0.08, -0.02, 0.02, 0.08];
const FINER: [f64; 6] = [0.5, 0.25, 0.125, 0.0625, 0.03125, 0.015625];

/// Fewer rows too many or too few are not told.
const LEAST_ROWS: f64 = 2.0;

/// Recordings with rows too many at an end, a dwell or a run-in, or with rows too few, over which the positions of the arc were spread all
/// the same: as many as leave least.
pub(crate) fn other_rows(sampled: Sampled<'_>, as_it_is: &Refit, tests: &[usize]) -> Vec<Suspicion> {
    let ends: Vec<(usize, RunEnd)> =
        tests.iter().flat_map(|&test| [RunEnd::Start, RunEnd::End].map(|end| (test, end))).collect();
    ends.into_par_iter().filter_map(|end| with_other_rows(sampled, as_it_is, end)).collect()
}

fn with_other_rows(sampled: Sampled<'_>, as_it_is: &Refit, (test, end): (usize, RunEnd)) -> Option<Suspicion> {
    let Sampled { few_rows: thinned, all_rows: session } = sampled;
    let recording = session.tests[test].recording.as_ref()?;
    if recording.time_s().is_none() || recording.len() < ROWS {
        return None;
    }
    let with = |rows: f64| {
        let mut undone = thinned.clone();
        let beside = match end {
            RunEnd::Start => [rows, 0.0],
            RunEnd::End => [0.0, rows],
        };
        let mut spread = spread_between(recording, beside);
        keep_few_rows(&mut spread);
        undone.tests[test].recording = Some(spread);
        Some(has_other_rows(&session.tests[test].name, rows, end, undone))
    };
    let misfit_um = |undone: &Session| Some(refit(undone, Some(&as_it_is.values))?.misfit_um);
    let of_share = |share: f64| {
        let (size, suspicion) = (share * recording.len() as f64, with(share * recording.len() as f64)?);
        Some(Sized { misfit_um: misfit_um(&suspicion.undone)?, size, suspicion })
    };
    let nearest = SHARES.into_iter().filter_map(of_share).filter(|tried| tried.misfit_um < as_it_is.misfit_um);
    let nearest = nearest.min_by(|one, other| one.misfit_um.total_cmp(&other.misfit_um))?;
    let steps = FINER.map(|share| share * nearest.size.abs());
    let found = descended((nearest.misfit_um, nearest.size), steps, with, misfit_um).unwrap_or(nearest);
    (found.size.abs() >= LEAST_ROWS).then_some(found.suspicion)
}

/// A recording with so many rows too many at an end, or too few where they are negative, with the session as it would be without.
fn has_other_rows(name: &str, rows: f64, end: RunEnd, undone: Session) -> Suspicion {
    let at = match end {
        RunEnd::Start => "start",
        RunEnd::End => "end",
    };
    let (kind, says) = match rows > 0.0 {
        true => (
            FaultKind::Dwell,
            format!(
                "about {rows:.0} rows at the {at} of {name} do not belong to its arc, over which its positions are spread: a dwell or a run-in was \
                 left in; cut those rows and spread the positions over the others"
            ),
        ),
        false => (
            FaultKind::ReadingsOrder,
            format!(
                "about {:.0} rows are missing at the {at} of {name}, and its positions are spread over those that are there: export it with its \
                 times or positions",
                -rows
            ),
        ),
    };
    let found = Suspicion::new(kind, RECORDER, vec![name.to_string()], says, undone);
    let detail = Detail::sizes(&[rows, f64::from(u8::from(end == RunEnd::Start))], 1.0);
    Suspicion { detail, weight: RARELY, log_figures: -PARAMETER_COST, ..found }
}

/// A recording whose positions belong to its rows but for so many at the start and at the end, which have no reading then; or to so many
/// more, where they are negative.
fn spread_between(recording: &Recording, [before, after]: [f64; 2]) -> Recording {
    let last = (recording.len().max(2) - 1) as f64;
    let share = |row: usize| (row as f64 - before) / (last - before - after);
    let rows: Vec<f64> = (0..recording.len()).map(|row| row as f64).collect();
    let mut spread = recording.clone();
    for (column, stated) in spread.positions.iter_mut().zip(&recording.positions) {
        for (row, value) in column.iter_mut().enumerate() {
            let place = share(row).clamp(0.0, 1.0) * last;
            let above = (place.floor() as usize + 1).min(rows.len() - 1);
            *value = between(&rows, stated, above, place);
        }
    }
    for (row, length) in spread.length_mm.iter_mut().enumerate() {
        if !(0.0..=1.0).contains(&share(row)) {
            *length = f64::NAN;
        }
    }
    spread
}

/// Angles by row of a test in which one rotary axis turns at an even rate.
fn angles(session: &Session, test: &Test) -> Option<Vec<f64>> {
    let recording = test.recording.as_ref()?;
    let is_rotary = |axis: usize| session.machine.axes[axis].kind == AxisKind::Rotary;
    match (&recording.clock, &test.path) {
        (Clock::TimeS(_), _) => {
            let [axis] = recording.axes[..] else { return None };
            is_rotary(axis).then(|| recording.positions[0].clone())
        }
        (Clock::Absent, Some(Path::Sweep { axis, from, to, follow: Follow::None, .. })) if is_rotary(*axis) => {
            let last = recording.len().max(2) - 1;
            let at = |row: usize| from + (to - from) * row as f64 / last as f64;
            Some((0..recording.len()).map(|row| at(row).to_radians()).collect())
        }
        _ => None,
    }
}

/// How rows belong to the arc, where not all of them do one after the other.
fn belonging(session: &Session, test: &Test) -> Option<Rows> {
    let angles = angles(session, test)?;
    let lengths = &test.recording.as_ref()?.length_mm;
    let rows = lengths.len();
    if rows < ROWS || lengths.iter().any(|length| !length.is_finite()) {
        return None;
    }
    let left = |how: Rows| left_mm(&angles, lengths, how);
    let noise_mm = noise_of_rows(lengths);
    let whole = left(Rows::Between(0, 0)).filter(|whole| *whole > LEAST_BEND_IN_NOISES * noise_mm)?;
    let mut best = (whole, Rows::Between(0, 0));
    let step = (rows / STEPS).max(1);
    for before in 0..=MOST_STEPS {
        for after in 0..=MOST_STEPS {
            let how = Rows::Between(before * step, after * step);
            best = less(best, left(how), how);
        }
    }
    // rows one by one about the best
    for _ in 0..2 {
        let Rows::Between(before, after) = best.1 else { break };
        for near in 0..=2 * step {
            let (one, other) = ((before + near).saturating_sub(step), (after + near).saturating_sub(step));
            for how in [Rows::Between(one, after), Rows::Between(before, other)] {
                best = less(best, left(how), how);
            }
        }
    }
    let still_mm = (MOST_SCATTER_IN_NOISES * noise_mm).max(STILL_MM);
    if let Rows::Between(before, after) = best.1 {
        let ends = [&lengths[..before], &lengths[rows - after..]];
        if !ends.iter().all(|end| standard_deviation(end) < still_mm) {
            best = (whole, Rows::Between(0, 0));
        }
    }
    best = less(best, left(Rows::ThereAndBack), Rows::ThereAndBack);
    (whole > LEAST_GAIN * best.0).then_some(best.1)
}

fn less(best: (f64, Rows), left: Option<f64>, how: Rows) -> (f64, Rows) {
    match left {
        Some(left) if left < best.0 => (left, how),
        _ => best,
    }
}

/// Angle of a row when the arc belongs to rows in such a way; `None` for rows outside it.
fn angle_at(angles: &[f64], row: usize, how: Rows) -> Option<f64> {
    let last = (angles.len() - 1) as f64;
    let share = match how {
        Rows::Between(before, after) => {
            let ending = angles.len().checked_sub(1 + after)?;
            if row < before || row > ending || ending <= before {
                return None;
            }
            (row - before) as f64 / (ending - before) as f64
        }
        Rows::ThereAndBack => 1.0 - (2.0 * row as f64 / last - 1.0).abs(),
    };
    let place = share * last;
    let below = (place.floor() as usize).min(angles.len() - 2);
    Some(angles[below] + (place - below as f64) * (angles[below + 1] - angles[below]))
}

/// What the smooth curve leaves of some rows, mm rms.
fn left_mm(angles: &[f64], lengths: &[f64], how: Rows) -> Option<f64> {
    let rows: Vec<(f64, f64)> = (0..lengths.len())
        .step_by((lengths.len() / ROWS).max(1))
        .filter_map(|row| angle_at(angles, row, how).map(|angle| (angle, lengths[row])))
        .collect();
    if rows.len() < ROWS / 3 {
        return None;
    }
    let functions: [fn(f64) -> f64; 5] = [|_| 1.0, f64::cos, f64::sin, |a| (2.0 * a).cos(), |a| (2.0 * a).sin()];
    let columns = DMatrix::from_fn(rows.len(), functions.len(), |row, k| functions[k](rows[row].0));
    let mean = mean(rows.iter().map(|(_, length)| *length))?;
    let read = DVector::from_iterator(rows.len(), rows.iter().map(|(_, length)| length - mean));
    // short arcs hardly tell the functions apart
    let normal = columns.tr_mul(&columns) + DMatrix::identity(functions.len(), functions.len()) * 1e-9;
    let fitted = normal.cholesky()?.solve(&columns.tr_mul(&read));
    let left = read - columns * fitted;
    Some((left.norm_squared() / (rows.len() - functions.len()) as f64).sqrt())
}

/// A few rows of a recording as they belong to its arc: of one with times the others stay, without a reading.
fn cut(recording: &Recording, how: Rows) -> Recording {
    if recording.time_s().is_some() {
        let mut undone = match how {
            Rows::Between(before, after) => spread_between(recording, [before as f64, after as f64]),
            Rows::ThereAndBack => there_and_back(recording),
        };
        keep_few_rows(&mut undone);
        return undone;
    }
    let rows: Vec<usize> = match how {
        Rows::Between(before, after) => (before..recording.len() - after).collect(),
        // the way there: lengths without positions go one way
        Rows::ThereAndBack => (0..recording.len().div_ceil(2)).collect(),
    };
    let pick = |column: &[f64]| -> Vec<f64> { rows.iter().map(|&row| column[row]).collect() };
    let spread = |column: &Vec<f64>| -> Vec<f64> {
        rows.iter().map(|&row| angle_at(column, row, how).unwrap_or(f64::NAN)).collect()
    };
    let mut undone = recording.clone();
    undone.positions = recording.positions.iter().map(spread).collect();
    undone.length_mm = pick(&recording.length_mm);
    undone.channels = recording.channels.iter().map(|(name, column)| (name.clone(), pick(column))).collect();
    undone.leading_texts = std::sync::Arc::default();
    undone
}

/// A recording that runs there and back, with the readings of the way there.
fn there_and_back(recording: &Recording) -> Recording {
    let mut undone = recording.clone();
    for (column, stated) in undone.positions.iter_mut().zip(&recording.positions) {
        let at = |row: usize| angle_at(stated, row, Rows::ThereAndBack).unwrap_or(f64::NAN);
        *column = (0..stated.len()).map(at).collect();
    }
    undone.length_mm.iter_mut().skip(recording.len().div_ceil(2)).for_each(|length| *length = f64::NAN);
    undone
}
