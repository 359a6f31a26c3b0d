//! Readings that another program averaged over neighbouring rows: their noise lacks the frequencies of which such a mean leaves nothing.
//!
//! A mean of n rows leaves `D = (sin πfn / (n·sin πf))²` of the power of noise at f cycles per row, and nothing at multiples of 1/n. Power of
//! all recordings together is exponentially distributed about its mean S (Whittle's likelihood). Without a mean `S = c + a/(1 + (f/g)²)^p`: a floor,
//! and what is slower than g, however steeply it falls off; with one `S = c + D·(w + a/(1 + (f/g)²))`: the floor is that of the digits, and
//! the noise of the gauge is averaged.

use super::quiet::scatter_mm;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::{DataFault, RECORDER};
use crate::diagnose::selection::shapes::judged_shape::PARAMETER_COST;
use crate::machine::AxisKind;
use crate::session::{Session, Test};
use crate::statistics::{median, minimise_few};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// Scatter from row to row below which readings may have been averaged, mm: half of what gauges resolve.
const QUIET_MM: f64 = 5e-5;

/// Rows of which a mean may have been taken: one of fewer moves no reading by more than noise.
const AVERAGED: RangeInclusive<usize> = 9..=101;

/// Log odds from which readings are told to be averaged: as of a first effect.
const LEAST_LOG_ODDS: f64 = 15.0;

/// Rows of a piece whose spectrum is taken, and of the shortest one.
const PIECE: usize = 256;
const SHORTEST: usize = 96;

/// Cycles of a piece below which its curve takes up the noise.
const LEAST_CYCLES: usize = 6;

/// Highest frequency that is looked at, cycles per row: a mean of nine rows has left nothing twice below it.
const HIGHEST: f64 = 0.25;

/// Bands of frequencies in which power is summed, and how many of them a vibration may fill.
const BANDS: usize = 120;
const ONE_LINE: usize = 3;

/// How steeply noise may fall off: powers of that of a gauge with one time constant.
const STEEPNESS: [i32; 4] = [1, 2, 3, 4];

/// Recordings that were averaged, all of them: where only some were, they scatter less than the others.
pub(super) fn averaged(session: &Session) -> Option<DataFault> {
    let scatter_mm = median(session.tests.iter().filter_map(scatter_mm)).filter(|mm| *mm < QUIET_MM)?;
    let bands = bands(session);
    if bands.len() < BANDS / 4 {
        return None;
    }
    let as_read = STEEPNESS.map(|power| bands_without(&bands, power));
    let as_read = as_read.into_iter().max_by(|a, b| a.iter().sum::<f64>().total_cmp(&b.iter().sum()))?;
    let tried = AVERAGED.step_by(2).count() as f64;
    let log_odds = |rows: usize| {
        let gains: Vec<f64> =
            bands_with(&bands, rows).iter().zip(&as_read).map(|(with, without)| with - without).collect();
        // a vibration may fill some bands, and what gains there alone says nothing
        let of_a_line = gains.windows(ONE_LINE).map(|line| line.iter().sum::<f64>()).fold(0.0, f64::max);
        gains.iter().sum::<f64>() - of_a_line - PARAMETER_COST - tried.ln()
    };
    let of_rows = AVERAGED.step_by(2).map(|rows| (log_odds(rows), rows));
    let (_, rows) = of_rows.filter(|(odds, _)| *odds > LEAST_LOG_ODDS).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let says = format!(
        "readings scatter by {:.3} µm from row to row, and their noise lacks what a mean over about {rows} rows takes away: they were averaged by \
         another program, which moves them most at the ends of arcs; export them as the gauge took them",
        1e3 * scatter_mm
    );
    let mut fault = DataFault::seen(FaultKind::ReadingsProcessed, RECORDER, Vec::new(), says);
    fault.components = vec!["length".into()];
    Some(fault)
}

/// Power of noise of some frequencies.
struct Band {
    /// Cycles per row.
    frequency: f64,
    /// Sum over so many frequencies and pieces, µm².
    power_um2: f64,
    count: f64,
}

fn bands(session: &Session) -> Vec<Band> {
    let mut bands: Vec<Band> = (0..BANDS)
        .map(|k| Band { frequency: HIGHEST * (k as f64 + 0.5) / BANDS as f64, power_um2: 0.0, count: 0.0 })
        .collect();
    for (lengths_mm, angles) in session.tests.iter().filter_map(|test| rows(session, test)) {
        let pieces = (lengths_mm.len() / PIECE).max(1);
        let size = lengths_mm.len() / pieces;
        for from in (0..pieces).map(|piece| piece * size) {
            let angles = angles.as_ref().map(|angles| &angles[from..from + size]);
            let Some(left_um) = tapered_um(&lengths_mm[from..from + size], angles) else { continue };
            // neighbouring frequencies of a tapered piece say the same
            for cycles in (LEAST_CYCLES..(HIGHEST * size as f64) as usize).step_by(2) {
                let band = &mut bands[(cycles as f64 / size as f64 / HIGHEST * BANDS as f64) as usize];
                band.power_um2 += power(&left_um, cycles);
                band.count += 1.0;
            }
        }
    }
    bands.retain(|band| band.count > 0.0 && band.power_um2 > 0.0);
    bands
}

/// Readings of a recording in time, and angles of the rotary axis that moves in it, rad.
fn rows<'s>(session: &'s Session, test: &'s Test) -> Option<(&'s [f64], Option<Vec<f64>>)> {
    let recording = test.recording.as_ref().filter(|recording| recording.time_s().is_some())?;
    let is_whole = recording.len() >= SHORTEST && recording.length_mm.iter().all(|length| length.is_finite());
    let is_rotary = |axis: &usize| session.machine.axes[*axis].kind == AxisKind::Rotary;
    let column = recording.axes.iter().position(is_rotary).map(|column| recording.positions[column].clone());
    is_whole.then_some((&recording.length_mm, column))
}

/// What a smooth curve over rows and angles leaves of a piece, µm, faded in and out, by readings as loud as those of power 1.
fn tapered_um(lengths_mm: &[f64], angles: Option<&[f64]>) -> Option<Vec<f64>> {
    let count = lengths_mm.len();
    let weight = |row: usize| (PI * (row as f64 + 0.5) / count as f64).sin().powi(2);
    let along = |row: usize| 2.0 * row as f64 / (count - 1) as f64 - 1.0;
    let harmonics: [fn(f64) -> f64; 4] = [f64::cos, f64::sin, |a| (2.0 * a).cos(), |a| (2.0 * a).sin()];
    let at = |row: usize, k: usize| match (k.checked_sub(4), angles) {
        (Some(harmonic), Some(angles)) => harmonics[harmonic](angles[row]),
        _ => along(row).powi(k as i32),
    };
    let functions = if angles.is_some() { 4 + harmonics.len() } else { 4 };
    let columns = DMatrix::from_fn(count, functions, |row, k| weight(row).sqrt() * at(row, k));
    let middle = lengths_mm.iter().sum::<f64>() / count as f64;
    let read = DVector::from_fn(count, |row, _| weight(row).sqrt() * 1e3 * (lengths_mm[row] - middle));
    // short arcs hardly tell the functions apart
    let normal = columns.tr_mul(&columns) + DMatrix::identity(functions, functions) * 1e-9;
    let fitted = normal.cholesky()?.solve(&columns.tr_mul(&read));
    let left = read - columns * fitted;
    let loudness = (0..count).map(|row| weight(row).powi(2)).sum::<f64>().sqrt();
    Some((0..count).map(|row| left[row] * weight(row).sqrt() / loudness).collect())
}

/// Power at so many cycles of a piece.
fn power(piece: &[f64], cycles: usize) -> f64 {
    let (sin, cos) = (2.0 * PI * cycles as f64 / piece.len() as f64).sin_cos();
    // a pointer that turns from row to row
    let mut pointer = (1.0, 0.0);
    let mut sum = (0.0, 0.0);
    for value in piece {
        sum = (sum.0 + value * pointer.0, sum.1 + value * pointer.1);
        pointer = (pointer.0 * cos - pointer.1 * sin, pointer.0 * sin + pointer.1 * cos);
    }
    sum.0 * sum.0 + sum.1 * sum.1
}

/// Log likelihood of each band by a spectrum, less a constant.
fn log_likelihoods(bands: &[Band], spectrum: impl Fn(f64) -> f64) -> Vec<f64> {
    let of = |band: &Band| {
        let expected = spectrum(band.frequency).max(f64::MIN_POSITIVE);
        -band.count * expected.ln() - band.power_um2 / expected
    };
    bands.iter().map(of).collect()
}

/// Logarithms of a spectrum's level at its upper and lower end, from where it is fitted.
fn levels(bands: &[Band]) -> (f64, f64) {
    let level = |bands: &[Band]| median(bands.iter().map(|band| (band.power_um2 / band.count).ln())).unwrap_or(0.0);
    (level(&bands[bands.len() - bands.len() / 4..]), level(&bands[..ONE_LINE]))
}

/// Frequencies at which noise of a gauge begins to fall off, from which they are fitted.
const FALLS_OFF: [f64; 2] = [0.02, 0.005];

/// Log likelihoods of the bands where readings are as they were taken, with noise that falls off as the power of that of one time constant.
fn bands_without(bands: &[Band], power: i32) -> Vec<f64> {
    let (floor, slow) = levels(bands);
    let spectrum = |[c, a, g]: [f64; 3], f: f64| c.exp() + a.exp() / (1.0 + (f / g.exp()).powi(2)).powi(power);
    let all = |x: &[f64; 3]| log_likelihoods(bands, |f| spectrum(*x, f));
    let fits = FALLS_OFF.map(|from| all(&minimise_few([floor, slow, from.ln()], 1.0, |x| -all(x).iter().sum::<f64>())));
    likelier(fits)
}

/// The same where each is a mean of so many rows.
fn bands_with(bands: &[Band], rows: usize) -> Vec<f64> {
    let (floor, slow) = levels(bands);
    let left = |f: f64| ((PI * f * rows as f64).sin() / (rows as f64 * (PI * f).sin())).powi(2);
    let spectrum =
        |[c, w, a, g]: [f64; 4], f: f64| c.exp() + left(f) * (w.exp() + a.exp() / (1.0 + (f / g.exp()).powi(2)));
    let all = |x: &[f64; 4]| log_likelihoods(bands, |f| spectrum(*x, f));
    let fits = FALLS_OFF
        .map(|from| all(&minimise_few([floor, slow - 1.0, slow, from.ln()], 1.0, |x| -all(x).iter().sum::<f64>())));
    likelier(fits)
}

fn likelier([one, other]: [Vec<f64>; 2]) -> Vec<f64> {
    if one.iter().sum::<f64>() >= other.iter().sum::<f64>() { one } else { other }
}
