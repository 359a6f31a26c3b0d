//! Readings outside of the four marks of a program at which the bar did not rest: it was off, was mounted, or was moved by hand. They are
//! cut off; nothing between the marks is. What a program does there is nothing, so that nothing of it is lost.

use super::form::{AROUND_S, Mark, NEAR_S, RAMPS_S, between, marks_of};
use crate::import::capture::Capture;
use crate::session::Marks;
use crate::statistics::median;

/// A capture of which something was cut off.
#[derive(Debug, Clone, PartialEq)]
pub struct Cut {
    pub capture: Capture,
    /// How much before the first mark and after the last, s.
    pub cut_s: [f64; 2],
}

/// Distance from the reading beside a mark from which on the bar did not rest, mm: warming moves a bar at rest by some µm in minutes, and
/// whoever takes hold of it by far more.
const MOVED_MM: f64 = 0.02;
/// Readings cut off beside these, s: a gauge's filter still hides what began there.
const BESIDE_S: f64 = 0.1;

/// The capture from before the first of four marks to after the last where the bar moved beyond, and where only four marks in a row
/// leave times for a program: a run, the gap, a run, s. `None` where that is not so.
pub fn cut(capture: &Capture, marks: &Marks, paces: [f64; 2], may_be: impl Fn([f64; 3]) -> bool) -> Option<Cut> {
    let rows: Vec<(f64, f64)> = capture.finite().collect();
    RAMPS_S.iter().find_map(|&ramp_s| {
        let mut all = marks_of(&rows, marks, paces, ramp_s);
        all.sort_by(|one, other| one.begin_s.total_cmp(&other.begin_s));
        let mut fours = all.windows(4).filter(|four| may_be(times_between(four)));
        let four = fours.next().filter(|_| fours.next().is_none())?;
        beside(capture, &rows, &four[0], &four[3])
    })
}

/// Times from the end of each mark to the begin of the next, s.
fn times_between(four: &[Mark]) -> [f64; 3] {
    [0, 1, 2].map(|k| four[k + 1].begin_s - four[k].end_s())
}

/// What lies from where the bar came to rest before the first mark to where it left its rest after the last.
fn beside(capture: &Capture, rows: &[(f64, f64)], first: &Mark, last: &Mark) -> Option<Cut> {
    let (begin_s, end_s) = (first.begin_s, last.end_s());
    let level = |from_s: f64, to_s: f64| median(between(rows, from_s, to_s).iter().map(|row| row.1));
    let before_mm = level(begin_s - AROUND_S, begin_s - NEAR_S)?;
    let after_mm = level(end_s + NEAR_S, end_s + AROUND_S)?;
    let spikes = capture.spikes();
    let moved = |level_mm: f64| {
        let rows = capture.time_s.iter().zip(&capture.reading_mm).zip(&spikes);
        rows.filter(move |((_, reading), spike)| (*reading - level_mm).abs() > MOVED_MM && !**spike)
            .map(|((time, _), _)| *time)
    };
    let from_s = moved(before_mm).take_while(|time| *time < begin_s - AROUND_S).last();
    let to_s = moved(after_mm).find(|time| *time > end_s + AROUND_S);
    if from_s.is_none() && to_s.is_none() {
        return None;
    }
    let from_s = from_s.map_or(f64::NEG_INFINITY, |time| time + BESIDE_S);
    let to_s = to_s.map_or(f64::INFINITY, |time| time - BESIDE_S);
    let kept = capture.between(from_s, to_s);
    let ((first_s, last_s), (from_s, to_s)) = (capture.ends_s(), kept.ends_s());
    Some(Cut { capture: kept, cut_s: [from_s - first_s, last_s - to_s] })
}
