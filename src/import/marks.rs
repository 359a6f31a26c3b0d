//! The moves along the bar that a program makes around its runs, found in the readings: when each run began and ended, and the pace.
//!
//! A mark changes the length by tenths of a millimetre within half a second, which no run does. Where one lies is told by how
//! well its form explains the readings around it. Then each move is a straight line: it ends where that line meets the level at
//! which the bar stands afterwards, so lost motion, which delays a move's begin, shifts nothing. Its slope over all moves is the
//! pace of the control.

use super::capture::Capture;
use super::seen_marks::Seen;
use crate::session::Marks;
use crate::statistics::median;

/// What a capture shows of marks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Found {
    None,
    /// Fewer than the four of a program.
    Some(usize),
    All(Seen),
}

/// Readings around a mark that tell its levels, s before and after it.
const AROUND_S: f64 = 0.4;
/// Step of the search, s: a fifth of a move, where nine tenths of a mark's form are still explained.
const STEP_S: f64 = 0.05;
/// Ratio of one pace that is tried to the next.
const PACE_STEP: f64 = 1.1;
/// Share of the readings' scatter that a mark must explain.
const EXPLAINED: f64 = 0.9;
/// Least share of a mark's move that is seen around it.
const SEEN: f64 = 0.7;
/// Fewest readings in and around a mark.
const FEWEST: usize = 8;
/// Part of a move, from its lower to its upper level, whose readings lie on a straight line: ramps and filters round its ends.
const STRAIGHT: [f64; 2] = [0.12, 0.88];
/// Readings this near to a move are none of a level, s.
const NEAR_S: f64 = 0.06;
/// How alike a control counts two rests, s: two cycles of its motion.
const CYCLES_S: f64 = 2e-3;
/// How well a gauge's scale is known.
const SCALE: f64 = 3e-4;
/// Least standard deviation of a level, mm.
const LEVEL_MM: f64 = 2e-4;

/// A mark in the readings, s and mm.
#[derive(Debug, Clone, Copy)]
struct Mark {
    begin_s: f64,
    /// Pace at which its form was found.
    pace: f64,
    explained: f64,
}

/// The marks of a program in a capture; `paces` are those thought possible.
pub(super) fn find(capture: &Capture, marks: &Marks, paces: [f64; 2]) -> Found {
    let rows: Vec<(f64, f64)> = capture.finite().collect();
    let mut all: Vec<Mark> = Vec::new();
    // a form a twentieth too long still explains nine tenths
    let mut pace = paces[0] * PACE_STEP.sqrt();
    while pace < paces[1] {
        all.extend(of_pace(&rows, marks, pace));
        pace *= PACE_STEP;
    }
    all.sort_by(|one, other| other.explained.total_cmp(&one.explained));
    let mut kept: Vec<Mark> = Vec::new();
    for mark in all {
        let lasts = 2.0 * marks.move_s() / mark.pace + marks.hold_s;
        if kept.iter().all(|other| (other.begin_s - mark.begin_s).abs() > lasts) {
            kept.push(mark);
        }
    }
    kept.truncate(4);
    kept.sort_by(|one, other| one.begin_s.total_cmp(&other.begin_s));
    match <[Mark; 4]>::try_from(kept) {
        Ok(four) => seen(&rows, marks, &four, capture.noise_mm()).map_or(Found::Some(4), Found::All),
        Err(fewer) if fewer.is_empty() => Found::None,
        Err(fewer) => Found::Some(fewer.len()),
    }
}

/// Part of its move that a mark has made, `since_s` after it began.
fn form(marks: &Marks, pace: f64, since_s: f64) -> f64 {
    let move_s = marks.move_s() / pace;
    let back = since_s - move_s - marks.hold_s;
    (since_s / move_s).clamp(0.0, 1.0) - (back / move_s).clamp(0.0, 1.0)
}

/// Places whose readings have the form of a mark.
fn of_pace(rows: &[(f64, f64)], marks: &Marks, pace: f64) -> Vec<Mark> {
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else { return Vec::new() };
    let lasts_s = 2.0 * marks.move_s() / pace + marks.hold_s;
    let count = ((last.0 - first.0) / STEP_S) as usize;
    let mut found = Vec::new();
    for begin_s in (0..count).map(|k| first.0 + STEP_S * k as f64) {
        let from = rows.partition_point(|row| row.0 < begin_s - AROUND_S);
        let to = rows.partition_point(|row| row.0 <= begin_s + lasts_s + AROUND_S);
        // some hundred readings show a form as well as thousands
        let thin = ((to - from) / 200).max(1);
        let near: Vec<(f64, f64)> = rows[from..to].iter().copied().step_by(thin).collect();
        let (low, high) = near.iter().fold((f64::MAX, f64::MIN), |(low, high), row| (low.min(row.1), high.max(row.1)));
        if near.len() < FEWEST || high - low < SEEN * marks.move_mm.abs() {
            continue;
        }
        let due = |row: &(f64, f64)| marks.move_mm * form(marks, pace, row.0 - begin_s);
        let scatter = |values: &[f64]| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            values.iter().map(|value| (value - mean).powi(2)).sum::<f64>()
        };
        let flat = scatter(&near.iter().map(|row| row.1).collect::<Vec<f64>>());
        let left = scatter(&near.iter().map(|row| row.1 - due(row)).collect::<Vec<f64>>());
        let explained = 1.0 - left / flat;
        if explained > EXPLAINED {
            found.push(Mark { begin_s, pace, explained });
        }
    }
    found
}

/// A move's readings about their own mean: what a line through them is made of.
#[derive(Debug, Clone, Copy, Default)]
struct Line {
    count: f64,
    time_s: f64,
    value_mm: f64,
    /// Σ(t−t̄)², Σ(t−t̄)(y−ȳ).
    tt: f64,
    ty: f64,
}

/// A mark taken apart: levels before and at its end, its two moves.
#[derive(Debug, Clone, Copy)]
struct Parts {
    before_mm: f64,
    out_mm: f64,
    moves: [Line; 2],
}

/// What four marks tell; `None` where readings of one are missing.
fn seen(rows: &[(f64, f64)], marks: &Marks, four: &[Mark; 4], noise_mm: f64) -> Option<Seen> {
    // the levels of a mark before a run are sought before it, of one after a run behind it
    let mut parts = Vec::new();
    for (k, mark) in four.iter().enumerate() {
        parts.push(taken_apart(rows, marks, mark, k % 2 == 0)?);
    }
    let sign = marks.move_mm.signum();
    let signs = [sign, -sign];
    let lines: Vec<(Line, f64)> = parts.iter().flat_map(|part| part.moves.into_iter().zip(signs)).collect();
    let (tt, ty) = lines.iter().fold((0.0, 0.0), |(tt, ty), (line, sign)| (tt + line.tt, ty + sign * line.ty));
    let slope = ty / tt;
    let programmed = marks.feed_mm_per_min / 60.0;
    if !(slope > 0.0 && slope.is_finite()) {
        return None;
    }
    let noise_mm = noise_mm.max(LEVEL_MM);
    let pace = slope / programmed;
    let meets = |line: &Line, sign: f64, level_mm: f64| line.time_s + (level_mm - line.value_mm) / (sign * slope);
    let sigma = |line: &Line, level_mm: f64| -> f64 {
        let lever = (level_mm - line.value_mm) / slope;
        let of_line = noise_mm / (slope * line.count.sqrt());
        let of_slope = lever * noise_mm / (slope * tt.sqrt());
        (of_line.powi(2) + (LEVEL_MM / slope).powi(2) + of_slope.powi(2) + CYCLES_S.powi(2)).sqrt()
    };
    // a run begins a rest after the mark before it has come back, and ends a rest before the one after it goes out
    let begin = |part: &Parts| meets(&part.moves[1], -sign, part.before_mm) + marks.rest_s;
    let end = |part: &Parts| meets(&part.moves[0], sign, part.out_mm) - marks.move_s() / pace - marks.rest_s;
    let [a, b, c, d] = <[Parts; 4]>::try_from(parts).ok()?;
    // what of a mark lies outside of its run
    let goes_out = |part: &Parts| meets(&part.moves[0], sign, part.before_mm);
    let is_back = |part: &Parts| meets(&part.moves[1], -sign, part.before_mm);
    Some(Seen {
        runs_s: [[begin(&a), end(&b)], [begin(&c), end(&d)]],
        run_sigma_s: [
            [sigma(&a.moves[1], a.before_mm), sigma(&b.moves[0], b.out_mm)],
            [sigma(&c.moves[1], c.before_mm), sigma(&d.moves[0], d.out_mm)],
        ],
        pace,
        pace_sigma: (noise_mm / (slope * tt.sqrt())).hypot(SCALE),
        gap_s: goes_out(&c) - is_back(&b),
        marks_s: [&a, &b, &c, &d].map(|part| [goes_out(part), is_back(part)]),
    })
}

/// Levels and moves of a mark; the level at its foot is that of standing: before it, or after it where it follows a run.
fn taken_apart(rows: &[(f64, f64)], marks: &Marks, mark: &Mark, stands_before: bool) -> Option<Parts> {
    let move_s = marks.move_s() / mark.pace;
    let out_s = mark.begin_s + move_s;
    let back_s = out_s + marks.hold_s;
    let end_s = back_s + move_s;
    let near = |from: f64, to: f64| {
        let (from, to) = (rows.partition_point(|row| row.0 < from), rows.partition_point(|row| row.0 <= to));
        &rows[from.min(to)..to]
    };
    let level = |from: f64, to: f64| median(near(from, to).iter().map(|row| row.1));
    let foot = match stands_before {
        true => level(mark.begin_s - AROUND_S, mark.begin_s - NEAR_S),
        false => level(end_s + NEAR_S, end_s + AROUND_S),
    };
    let top = level(out_s + NEAR_S, back_s - NEAR_S);
    // where readings of a level are missing, the programmed move leads from the other
    let (before_mm, out_mm) = match (foot, top) {
        (Some(foot), Some(top)) => (foot, top),
        (Some(foot), None) => (foot, foot + marks.move_mm),
        (None, Some(top)) => (top - marks.move_mm, top),
        (None, None) => return None,
    };
    let [low, high] = STRAIGHT.map(|part| before_mm + part * (out_mm - before_mm));
    let line = |from: f64, to: f64| -> Line {
        let on: Vec<(f64, f64)> =
            near(from, to).iter().copied().filter(|row| row.1 > low.min(high) && row.1 < low.max(high)).collect();
        let count = on.len() as f64;
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| on.iter().map(of).sum::<f64>() / count;
        let (time_s, value_mm) = (mean(&|row| row.0), mean(&|row| row.1));
        Line {
            count,
            time_s,
            value_mm,
            tt: on.iter().map(|row| (row.0 - time_s).powi(2)).sum(),
            ty: on.iter().map(|row| (row.0 - time_s) * (row.1 - value_mm)).sum(),
        }
    };
    let half = 0.5 * marks.hold_s;
    let moves = [line(mark.begin_s - half, out_s + half), line(back_s - half, end_s + half)];
    // the move next to the run tells when it begins or ends
    let telling = if stands_before { &moves[1] } else { &moves[0] };
    if telling.count < 1.0 {
        return None;
    }
    let moves = moves.map(|line| if line.count < 1.0 { Line::default() } else { line });
    Some(Parts { before_mm, out_mm, moves })
}
