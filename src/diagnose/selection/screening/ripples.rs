//! Ripples of residuals along an axis that wander with time. What makes them is for others to say.

use crate::chain::sines_and_cosines;
use crate::diagnose::model::linear_model::LinearModel;
use crate::effects::Ripple;
use crate::machine::Outlet;
use crate::statistics::{add_cross_products, mean};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::Range;

/// Readings of a test that are looked at.
const ROWS: usize = 160;
/// Ripples along the travel and beats within a recording that are tried at most, and steps of either per whole one.
const MOST_RIPPLES: usize = 45;
const MOST_BEATS: usize = 25;
const FINER: usize = 2;
/// Beats that the longest recording must show.
const LEAST_BEATS: f64 = 0.8;
/// Length of a session, in longest recordings, beyond which the phases of its tests say nothing of one frequency.
const LONGEST_SESSION: f64 = 1000.0;
/// Tests in which the axis must move: one alone cannot tell ripple from beat.
const LEAST_TESTS: usize = 3;
/// Ripples of which the phases are compared, ripples told at most, and rounds by which each is sharpened.
const LOUDEST: usize = 12;
const MOST_WAVES: usize = 2;
const SHARPENINGS: usize = 3;
/// Steps of the frequency, in beats over the whole session, by which one beat of all tests is looked for.
const PHASE_STEP: f64 = 0.2;

/// Rows of a test: positions, times of the session, and what a motion of the outlet has of the residual and of itself.
struct Rows {
    q: Vec<f64>,
    t: Vec<f64>,
    score: Vec<f64>,
    weight: f64,
    middle_s: f64,
}

/// The loudest ripples of an axis through one of its outlets, with the beat that all tests have in common.
pub fn ripples(model: &LinearModel, axis: usize, outlet: &Outlet) -> Vec<Ripple> {
    let gains = model.gains(outlet);
    let moves = |test: &usize| model.context.motion(*test).moving.contains(&axis) && !gains[*test].is_empty();
    let tests: Vec<Rows> =
        (0..model.tests()).filter(moves).filter_map(|test| rows(model, axis, &gains[test], test)).collect();
    if tests.len() < LEAST_TESTS {
        return Vec::new();
    }
    let ends = tests.iter().flat_map(|rows| &rows.q).fold((f64::MAX, f64::MIN), |(a, b), q| (a.min(*q), b.max(*q)));
    let longest = tests.iter().map(|rows| rows.t[rows.t.len() - 1] - rows.t[0]).fold(0.0, f64::max);
    let span = ends.1 - ends.0;
    if span <= 0.0 || longest <= 0.0 || session_s(&tests) > LONGEST_SESSION * longest {
        return Vec::new();
    }
    let (ripple, beat) = (TAU / span, 1.0 / longest);
    let (along, in_time) = (ripple / FINER as f64, beat / FINER as f64);
    let (ripples, beats) = (2 * FINER..MOST_RIPPLES * FINER, 1..MOST_BEATS * FINER + 1);
    let of_tests: Vec<Vec<f64>> = tests
        .par_iter()
        .map(|rows| loudness_of_all(rows, (ripples.clone(), along), (beats.clone(), TAU * in_time)))
        .collect();
    let mut loud = vec![0.0; ripples.len() * beats.len()];
    of_tests.iter().for_each(|own| loud.iter_mut().zip(own).for_each(|(sum, own)| *sum += own));
    let least_hz = LEAST_BEATS * beat;
    let waves = ripples.flat_map(|k| beats.clone().map(move |m| (k, m)));
    let wave = |(k, m): (usize, usize)| Ripple { per_unit: k as f64 * along, hz: m as f64 * in_time, least_hz };
    let mut cells: Vec<(Ripple, f64)> =
        waves.map(wave).zip(loud).filter(|(wave, _)| wave.hz >= wave.least_hz).collect();
    cells.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut chosen: Vec<Ripple> = Vec::new();
    for (wave, _) in cells {
        let is_near = |other: &Ripple| {
            (other.per_unit - wave.per_unit).abs() < 2.5 * ripple && (other.hz - wave.hz).abs() < 2.5 * beat
        };
        if !chosen.iter().any(is_near) {
            chosen.push(wave);
        }
        if chosen.len() == LOUDEST {
            break;
        }
    }
    // what is loud in every test by itself need not have one phase
    let mut waves: Vec<(Ripple, f64)> =
        chosen.into_iter().map(|wave| in_phase(&tests, sharpened(&tests, wave, ripple, beat), beat)).collect();
    waves.sort_by(|a, b| b.1.total_cmp(&a.1));
    // neighbours may be sharpened to one
    waves.dedup_by(|one, other| one.0 == other.0);
    waves.into_iter().take(MOST_WAVES).map(|(wave, _)| wave).collect()
}

/// Averaged readings of a test.
fn rows(model: &LinearModel, axis: usize, gain: &[f64], test: usize) -> Option<Rows> {
    let motion = model.context.motion(test);
    motion.time_s.as_ref()?;
    let kept: Vec<usize> = (0..motion.rows()).filter(|&row| model.kept[test][row]).collect();
    let residual = &model.residual_mm[test];
    let middle = mean(kept.iter().map(|&row| residual[row])).unwrap_or(0.0);
    let groups = kept.chunks((kept.len() / ROWS).max(1));
    let over = |value: &dyn Fn(usize) -> f64| -> Vec<f64> {
        groups.clone().filter_map(|rows| mean(rows.iter().map(|&row| value(row)))).collect()
    };
    let q = over(&|row| motion.row(row)[axis]);
    let t = over(&|row| model.context.session_time_s(test, row));
    let score = over(&|row| gain[row] * (residual[row] - middle));
    let weight: f64 = over(&|row| gain[row] * gain[row]).iter().sum();
    let middle_s = mean(t.iter().copied()).unwrap_or(0.0);
    (q.len() > 8 && weight > 0.0).then_some(Rows { q, t, score, weight, middle_s })
}

/// Amplitudes, as cosine and sine, of a wave that runs with the position in one test, and of one that runs against it.
fn amplitudes(rows: &Rows, wave: Ripple) -> [(f64, f64); 2] {
    let (ripple, turns) = (turned(&rows.q, wave.per_unit), turned(&rows.t, TAU * wave.hz));
    let (mut cc, mut ss, mut cs, mut sc) = (0.0, 0.0, 0.0, 0.0);
    let scores = rows.score.iter().zip(ripple.0.iter().zip(&ripple.1)).zip(turns.0.iter().zip(&turns.1));
    for ((score, (sin, cos)), (turn_sin, turn_cos)) in scores {
        cc += score * cos * turn_cos;
        ss += score * sin * turn_sin;
        cs += score * cos * turn_sin;
        sc += score * sin * turn_cos;
    }
    [(cc - ss, sc + cs), (cc + ss, sc - cs)]
}

/// Sines and cosines of so many radians per unit.
fn turned(places: &[f64], per_unit: f64) -> (Vec<f64>, Vec<f64>) {
    let angles: Vec<f64> = places.iter().map(|place| per_unit * place).collect();
    sines_and_cosines(&angles)
}

/// Sines of a test's readings by every multiple of a phase per unit, then their cosines, multiple after multiple.
fn phasors(places: &[f64], multiples: Range<usize>, per_unit: f64) -> Vec<f64> {
    let mut all = Vec::with_capacity(2 * multiples.len() * places.len());
    for m in multiples {
        let (sin, cos) = turned(places, m as f64 * per_unit);
        all.extend(sin);
        all.extend(cos);
    }
    all
}

/// [`loudness`] in a test of every ripple with every beat, ripple after ripple; both are multiples of a phase per unit.
fn loudness_of_all(
    rows: &Rows,
    (ripples, along): (Range<usize>, f64),
    (beats, in_time): (Range<usize>, f64),
) -> Vec<f64> {
    let count = rows.q.len();
    let mut scored = phasors(&rows.q, ripples.clone(), along);
    for column in scored.chunks_exact_mut(count) {
        column.iter_mut().zip(&rows.score).for_each(|(value, score)| *value *= score);
    }
    let turns = phasors(&rows.t, beats.clone(), in_time);
    let mut sums = vec![0.0; 4 * ripples.len() * beats.len()];
    add_cross_products(&scored, &turns, count, &mut sums);
    let width = 2 * beats.len();
    let of_ripple = |sums: &[f64]| -> Vec<f64> {
        let (sines, cosines) = sums.split_at(width);
        let squares = |m: usize| -> f64 {
            [sines[m], sines[m + 1], cosines[m], cosines[m + 1]].iter().map(|sum| sum * sum).sum()
        };
        // both directions: (cc - ss)² + (cs + sc)² and (cc + ss)² + (sc - cs)²
        (0..beats.len()).map(|m| 2.0 * squares(2 * m) / rows.weight).collect()
    };
    sums.chunks_exact(2 * width).flat_map(of_ripple).collect()
}

/// Squares of the amplitudes of both directions, each test with a phase of its own.
fn loudness(tests: &[Rows], wave: Ripple) -> f64 {
    let of_test =
        |rows: &Rows| amplitudes(rows, wave).iter().map(|(re, im)| re * re + im * im).sum::<f64>() / rows.weight;
    tests.iter().map(of_test).sum()
}

/// The loudest wave near one.
fn sharpened(tests: &[Rows], wave: Ripple, ripple: f64, beat: f64) -> Ripple {
    let mut best = (wave, loudness(tests, wave));
    let mut step = 0.5 / FINER as f64;
    for _ in 0..SHARPENINGS {
        for (along, in_time) in
            [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
        {
            let per_unit = best.0.per_unit + along * step * ripple;
            let hz = best.0.hz + in_time * step * beat;
            let trial = Ripple { per_unit, hz: hz.max(wave.least_hz), ..wave };
            let loud = loudness(tests, trial);
            if loud > best.1 {
                best = (trial, loud);
            }
        }
        step *= 0.5;
    }
    best.0
}

/// Time from the middle of the first test to that of the last, s.
fn session_s(tests: &[Rows]) -> f64 {
    let middles = || tests.iter().map(|rows| rows.middle_s);
    middles().fold(f64::MIN, f64::max) - middles().fold(f64::MAX, f64::min)
}

/// The frequency near that of a wave at which the amplitudes of all tests have one phase, and the square of their sum.
fn in_phase(tests: &[Rows], wave: Ripple, beat: f64) -> (Ripple, f64) {
    let session = session_s(tests);
    if session <= 0.0 {
        return (wave, 0.0);
    }
    let shown: Vec<[(f64, f64); 2]> = tests.iter().map(|rows| amplitudes(rows, wave)).collect();
    let together = |off: f64| -> f64 {
        let of_sign = |k: usize, sign: f64| {
            let sum = tests.iter().zip(&shown).fold((0.0, 0.0), |(re, im), (rows, shown)| {
                let (sin, cos) = (sign * TAU * off * rows.middle_s).sin_cos();
                let (a, b) = shown[k];
                (re + a * cos - b * sin, im + a * sin + b * cos)
            });
            sum.0 * sum.0 + sum.1 * sum.1
        };
        of_sign(0, 1.0) + of_sign(1, -1.0)
    };
    let step = PHASE_STEP / session;
    let reach = (0.5 * beat / step) as i64;
    let offs = (-reach..=reach).map(|k| k as f64 * step).filter(|off| wave.hz + off >= wave.least_hz);
    let best = offs.map(|off| (off, together(off))).max_by(|a, b| a.1.total_cmp(&b.1));
    let (off, loud) = best.unwrap_or((0.0, 0.0));
    (Ripple { hz: wave.hz + off, ..wave }, loud)
}
