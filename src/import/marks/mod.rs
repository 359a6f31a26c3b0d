//! The moves along the bar that a program makes around its runs, found in the readings: when each run began and ended, and the pace.
//!
//! A mark changes the length by tenths of a millimetre within half a second, which no run does. Where one lies is told by how
//! well its form explains the readings around it. When its moves ended is fitted in `moves`.

mod form;
mod moves;
mod outside;
mod stopped;

use self::form::{AROUND_S, Mark, NEAR_S, RAMPS_S, between, marks_of};
use self::moves::{SecondHalf, ends_of, ends_of_some};
pub(super) use self::outside::{Cut, cut};
use self::stopped::{Direction, longer};
use super::capture::Capture;
use super::seen_marks::Seen;
use super::timing::lag::Lag;
use crate::session::Marks;
use crate::statistics::median;

/// What a capture shows of marks.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Found {
    None,
    /// Fewer than the four of a program.
    Some(usize),
    All(Box<Seen>),
}

/// How alike a control counts two rests, s: two cycles of its motion.
const CYCLES_S: f64 = 2e-3;
/// How alike the axes of marks and of runs lag, s: servos are set alike where a machine cuts round circles.
const ALIKE_S: f64 = 1e-3;
/// How well a gauge's scale is known.
const SCALE: f64 = 3e-4;
/// What is left of a mark's way when the bar counts as at rest, mm: a fifth of what a gauge reads.
const TAIL_MM: f64 = 0.02e-3;
/// Least standard deviation of a level, mm.
const LEVEL_MM: f64 = 2e-4;

/// The marks of a program in a capture; `paces` are those thought possible.
pub(super) fn find(capture: &Capture, marks: &Marks, paces: [f64; 2]) -> Found {
    let rows: Vec<(f64, f64)> = capture.finite().collect();
    let mut best = Found::None;
    for ramp_s in RAMPS_S {
        match (found(capture, &rows, marks, paces, ramp_s), &best) {
            (all @ Found::All(_), _) => return all,
            (Found::Some(more), Found::Some(found)) if more <= *found => {}
            (Found::None, _) => {}
            (some, _) => best = some,
        }
    }
    best
}

/// What a capture shows of marks that come to speed in about this time.
fn found(capture: &Capture, rows: &[(f64, f64)], marks: &Marks, paces: [f64; 2], ramp_s: f64) -> Found {
    let mut kept = marks_of(rows, marks, paces, ramp_s);
    let mut begins_s: Vec<f64> = kept.iter().map(|mark| mark.begin_s).collect();
    begins_s.sort_by(f64::total_cmp);
    let found = begins_s.len();
    let last_four_s = begins_s.get(found.saturating_sub(4)).copied().unwrap_or(f64::NAN);
    kept.truncate(4);
    kept.sort_by(|one, other| one.begin_s.total_cmp(&other.begin_s));
    match <[Mark; 4]>::try_from(kept) {
        // of a mark whose return is cut off nothing is left to fit: three are whole
        Ok(four) => seen(rows, marks, &four, capture.noise_mm())
            .map_or(Found::Some(3), |seen| Found::All(Box::new(Seen { found, last_four_s, ..seen }))),
        Err(fewer) if fewer.is_empty() => Found::None,
        Err(fewer) => Found::Some(fewer.len()),
    }
}

/// What four marks tell; `None` where readings of one are missing.
fn seen(rows: &[(f64, f64)], marks: &Marks, four: &[Mark; 4], noise_mm: f64) -> Option<Seen> {
    let mut halves = Vec::new();
    let mut moves_mm = [f64::NAN; 4];
    for (k, mark) in four.iter().enumerate() {
        // the levels of a mark before a run are sought before it, of one after a run behind it
        let [foot, top] = levels(rows, marks, mark, k % 2 == 0);
        moves_mm[k] = foot.zip(top).map_or(f64::NAN, |(foot, top)| top - foot);
        // where readings of a level are missing, the programmed move leads from the other
        let foot_mm = foot.or(top.map(|top| top - marks.move_mm))?;
        let top_mm = top.unwrap_or(foot_mm + marks.move_mm);
        halves.extend(second_halves(rows, marks, mark, [foot_mm, top_mm])?);
    }
    let programmed = marks.feed_mm_per_min / 60.0;
    let pace = four.iter().map(|mark| mark.form.pace).sum::<f64>() / 4.0;
    let moves = ends_of(&halves, marks.move_mm, programmed * pace, noise_mm.max(LEVEL_MM))?;
    let way_s = marks.move_mm.abs() / moves.speed;
    // moves in order: each mark goes out, then back
    let out_begins = |mark: usize| moves.end_s[2 * mark] - way_s - moves.ramp_s();
    let is_back = |mark: usize| moves.end_s[2 * mark + 1];
    // a run begins a rest after the mark before it has come back, and ends a rest before the one after it goes out
    let run = |before: usize| [is_back(before) + marks.rest_s, out_begins(before + 1) - marks.rest_s];
    let sigma = |before: usize| {
        [moves.sigma(2 * before + 1, 0.0, 0.0), moves.sigma(2 * before + 2, way_s / moves.speed, -1.0)]
            .map(|sigma| sigma.hypot(CYCLES_S))
    };
    let (runs_s, run_sigma_s) = ([run(0), run(2)], [sigma(0), sigma(2)]);
    let direction = |k: usize| {
        let own = ends_of_some(&halves[4 * k..4 * k + 4], marks.move_mm, &moves, noise_mm.max(LEVEL_MM))?;
        let [begin_s, end_s] = runs_s[k];
        Some(Direction {
            run_s: end_s - begin_s,
            run_sigma_s: run_sigma_s[k][0].hypot(run_sigma_s[k][1]),
            pace: own.speed / programmed,
            pace_sigma: own.speed_sigma() / programmed,
        })
    };
    let longer = direction(0).zip(direction(1)).map(|(there, back)| longer([there, back]));
    Some(Seen {
        runs_s,
        run_sigma_s,
        longer_s: longer.map(|longer| longer.by_s),
        stopped_s: longer.and_then(|longer| longer.stopped_s),
        pace: moves.speed / programmed,
        pace_sigma: (moves.speed_sigma() / moves.speed).hypot(SCALE),
        lag_s: moves.lag_s(),
        lag_sigma_s: moves.lag_sigma_s().hypot(ALIKE_S),
        tail_s: Lag(moves.lag_s()).tail_s(moves.speed, TAIL_MM),
        gap_s: out_begins(2) - is_back(1),
        found: 4,
        last_four_s: four[0].begin_s,
        marks_s: [0, 1, 2, 3].map(|mark| [out_begins(mark), is_back(mark)]),
        moves_mm,
    })
}

/// The reading beside a mark and at its end, mm, where there are some.
fn levels(rows: &[(f64, f64)], marks: &Marks, mark: &Mark, stands_before: bool) -> [Option<f64>; 2] {
    let level = |from: f64, to: f64| median(between(rows, from, to).iter().map(|row| row.1));
    let out_s = mark.begin_s + mark.form.move_s;
    let back_s = out_s + marks.hold_s;
    let end_s = back_s + mark.form.move_s;
    let foot = match stands_before {
        true => level(mark.begin_s - AROUND_S, mark.begin_s - NEAR_S),
        false => level(end_s + NEAR_S, end_s + AROUND_S),
    };
    [foot, level(out_s + NEAR_S, back_s - NEAR_S)]
}

/// The second halves of a mark's two moves, between its two levels, with the rests behind them.
fn second_halves(
    rows: &[(f64, f64)],
    marks: &Marks,
    mark: &Mark,
    [foot_mm, top_mm]: [f64; 2],
) -> Option<[SecondHalf; 2]> {
    let move_s = mark.form.move_s;
    let out_s = mark.begin_s + move_s;
    let end_s = out_s + marks.hold_s + move_s;
    let sense = marks.move_mm.signum();
    let halves = [(sense, out_s, foot_mm, top_mm), (-sense, end_s, top_mm, foot_mm)];
    let halves = halves.map(|(sense, end_s, from_mm, to_mm)| {
        let (most, half) = (0.5 * marks.hold_s.min(marks.rest_s), 0.5 * (from_mm + to_mm));
        // some hundred readings tell as much as thousands
        let all = between(rows, end_s - move_s, end_s + most);
        let thin = (all.len() / 300).max(1);
        // from where the way is half done
        let first = all.iter().rposition(|row| (row.1 - half) * sense < 0.0).map_or(0, |last| last + 1);
        SecondHalf { rows: all[first..].iter().copied().step_by(thin).collect(), sense, end_s }
    });
    // end, level, and something of the slope
    halves.iter().all(|half| half.rows.len() >= 2).then_some(halves)
}

#[cfg(test)]
mod tests {
    use super::form::Form;
    use super::*;

    /// Four marks that come to speed in `ramp_s`, at rest between them.
    fn capture(marks: &Marks, ramp_s: f64, begins_s: &[f64]) -> Capture {
        let form = Form::of(marks, 1.0, ramp_s);
        let time_s: Vec<f64> = (0..2500).map(|k| 0.01 * f64::from(k)).collect();
        let reading = |time: &f64| begins_s.iter().map(|begin| marks.move_mm * form.out(time - begin)).sum::<f64>();
        let reading_mm = time_s.iter().map(reading).collect();
        Capture { time_s, reading_mm }
    }

    #[test]
    fn marks_of_slow_controls_are_seen() {
        let marks = Marks { move_mm: 0.4, feed_mm_per_min: 60.0, hold_s: 0.6, rest_s: 0.5, gap_s: 1.0, seen_mm: None };
        for ramp_s in [0.0, 0.1, 0.25, 0.29, 0.4, 0.5] {
            let begins_s = [3.0, 11.0, 14.0, 21.0];
            let Found::All(seen) = find(&capture(&marks, ramp_s, &begins_s), &marks, [0.9, 1.1]) else {
                panic!("{ramp_s} s: not seen");
            };
            for ([begin_s, _], due_s) in seen.marks_s.iter().zip(begins_s) {
                assert!((begin_s - due_s).abs() < 0.03, "{ramp_s} s: {begin_s} in place of {due_s}");
            }
        }
    }
}
