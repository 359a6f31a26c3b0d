//! The form of a program's mark, and where readings have it. When its moves ended exactly is fitted in `moves`.

use crate::session::{Marks, times_beside_readings};
use crate::statistics::mean;

/// Readings around a mark that tell its levels, s before and after it.
pub(super) const AROUND_S: f64 = 0.4;
/// Step of the search, s: a fifth of a move, where nine tenths of a mark's form are still explained.
const STEP_S: f64 = 0.05;
/// Ratio of one pace that is tried to the next.
const PACE_STEP: f64 = 1.1;
/// Share of the readings' scatter that a mark must explain.
const EXPLAINED: f64 = 0.9;
/// Least share of a mark's move that is seen around it.
const LEAST_SHARE_SEEN: f64 = 0.7;
/// Fewest readings in and around a mark.
const FEWEST: usize = 8;
/// Readings this near to a move are none of a level, s.
pub(super) const NEAR_S: f64 = 0.06;
/// Times in which marks come to speed, s, that are looked for in turn: at once, and in controls that accelerate slowly. Each stands
/// for those up to the middle between it and the next.
pub(super) const RAMPS_S: [f64; 3] = [0.0, 0.3, 0.5];

/// The form of a mark: out along the bar, a rest, back.
#[derive(Debug, Clone, Copy)]
pub(super) struct Form {
    /// Speed over the programmed one.
    pub pace: f64,
    /// Time of one move, s, and that in which it comes to speed and to rest.
    pub move_s: f64,
    ramp_s: f64,
    hold_s: f64,
}

impl Form {
    pub fn of(marks: &Marks, pace: f64, ramp_s: f64) -> Form {
        let move_s = marks.move_s() / pace + ramp_s;
        Form { pace, move_s, ramp_s: ramp_s.min(0.5 * move_s), hold_s: marks.hold_s }
    }

    fn lasts_s(&self) -> f64 {
        2.0 * self.move_s + self.hold_s
    }

    /// Part of its move that a mark has made, `since_s` after it began.
    pub fn out(&self, since_s: f64) -> f64 {
        self.made(since_s) - self.made(since_s - self.move_s - self.hold_s)
    }

    /// Part of one move that is made: the speed rises and falls evenly.
    fn made(&self, since_s: f64) -> f64 {
        let speed = 1.0 / (self.move_s - self.ramp_s);
        let ramped = |since_s: f64| 0.5 * speed * since_s * since_s / self.ramp_s;
        match since_s {
            since if since <= 0.0 => 0.0,
            since if since >= self.move_s => 1.0,
            since if since < self.ramp_s => ramped(since),
            since if since > self.move_s - self.ramp_s => 1.0 - ramped(self.move_s - since),
            since => speed * (since - 0.5 * self.ramp_s),
        }
    }
}

/// A mark in the readings, s and mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mark {
    pub begin_s: f64,
    /// The form that was found.
    pub form: Form,
    pub explained: f64,
}

impl Mark {
    pub fn end_s(&self) -> f64 {
        self.begin_s + self.form.lasts_s()
    }
}

/// Marks that come to speed in about this time, apart from each other, the best explained first.
pub(super) fn marks_of(rows: &[(f64, f64)], marks: &Marks, paces: [f64; 2], ramp_s: f64) -> Vec<Mark> {
    let mut all: Vec<Mark> = Vec::new();
    // a form a twentieth too long still explains nine tenths
    let mut pace = paces[0] * PACE_STEP.sqrt();
    while pace < paces[1] {
        all.extend(of_form(rows, marks, Form::of(marks, pace, ramp_s)));
        pace *= PACE_STEP;
    }
    all.sort_by(|one, other| other.explained.total_cmp(&one.explained));
    let mut kept: Vec<Mark> = Vec::new();
    for mark in all {
        if kept.iter().all(|other| (other.begin_s - mark.begin_s).abs() > mark.form.lasts_s()) {
            kept.push(mark);
        }
    }
    kept
}

/// Places whose readings have the form of a mark.
fn of_form(rows: &[(f64, f64)], marks: &Marks, form: Form) -> Vec<Mark> {
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else { return Vec::new() };
    let lasts_s = form.lasts_s();
    let mut found = Vec::new();
    let next_s = |time_s: f64| rows.get(rows.partition_point(|row| row.0 < time_s)).map(|row| row.0);
    for begin_s in times_beside_readings([first.0, last.0], STEP_S, [AROUND_S, lasts_s + AROUND_S], next_s) {
        let from = rows.partition_point(|row| row.0 < begin_s - AROUND_S);
        let to = rows.partition_point(|row| row.0 <= begin_s + lasts_s + AROUND_S);
        // some hundred readings show a form as well as thousands
        let thin = ((to - from) / 200).max(1);
        let near: Vec<(f64, f64)> = rows[from..to].iter().copied().step_by(thin).collect();
        let (low, high) = near.iter().fold((f64::MAX, f64::MIN), |(low, high), row| (low.min(row.1), high.max(row.1)));
        if near.len() < FEWEST || high - low < LEAST_SHARE_SEEN * marks.move_mm.abs() {
            continue;
        }
        let due = |row: &(f64, f64)| marks.move_mm * form.out(row.0 - begin_s);
        let scatter = |values: &[f64]| {
            let mean = mean(values.iter().copied()).unwrap_or(f64::NAN);
            values.iter().map(|value| (value - mean).powi(2)).sum::<f64>()
        };
        let flat = scatter(&near.iter().map(|row| row.1).collect::<Vec<f64>>());
        let left = scatter(&near.iter().map(|row| row.1 - due(row)).collect::<Vec<f64>>());
        let explained = 1.0 - left / flat;
        if explained > EXPLAINED {
            found.push(Mark { begin_s, form, explained });
        }
    }
    found
}

/// Rows from one time to another, s.
pub(super) fn between(rows: &[(f64, f64)], from: f64, to: f64) -> &[(f64, f64)] {
    let (from, to) = (rows.partition_point(|row| row.0 < from), rows.partition_point(|row| row.0 <= to));
    &rows[from.min(to)..to]
}
