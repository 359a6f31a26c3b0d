//! What of a capture takes part: not what lies outside of its program's marks, nor long rests. It places nothing.

use super::capture::Capture;
use super::course::{Course, Feeds, Pair, pairs};
use super::marks::{Cut, cut};
use super::other_reading::{alike, forms};
use super::refusals::LONGEST_RAMP_S;
use super::timing::Timing;
use crate::session::Session;

/// Rest that is kept before the first run and after the last, s, and as a share of a run: beyond it a bar at rest tells nothing, and
/// averages over as much time are too long for a run.
const REST_KEPT_S: f64 = 12.0;
const REST_KEPT_SHARE: f64 = 0.25;

/// The capture without what rests long before and after runs that were found without marks; `None` where that is little.
pub(super) fn without_long_rests(capture: &Capture, course: &Course, timing: &Timing) -> Option<Capture> {
    let kept_s = REST_KEPT_S.max(REST_KEPT_SHARE * course.run_s);
    let (from, to) = (timing.start_s[0] - kept_s, timing.start_s[1] + timing.moving_s(1, course.run_s) + kept_s);
    let (first, last) = capture.ends_s();
    let is_long = first < from || last > to;
    is_long.then(|| capture.between(from, to))
}

/// Most by which the times between marks may be off where they were only found, not fitted, s: twice the step of that search, for each of
/// their ends, and what a control's rests last longer.
const SPACING_OFF_S: f64 = 0.3;
/// Share by which two runs of one program may take other times.
const RUNS_OFF: f64 = 0.02;

/// The capture without what lies outside of four marks and is none of a bar at rest, where they stand as a program of the session sets
/// them.
pub(super) fn within_marks(session: &Session, among: &[Pair], capture: &Capture, feeds: Feeds) -> Option<Cut> {
    let [slowest, fastest] = feeds.range();
    forms(session, among).iter().find_map(|marks| {
        let is_such = |pair: &Pair| session.tests[pair.tests[0]].marks.is_some_and(|own| alike(marks, &own));
        let courses = pairs(session).into_iter().filter(is_such).map(|pair| Course::of(session, pair, feeds));
        let programs: Vec<(f64, f64)> =
            courses.flatten().filter_map(|course| course.marks.map(|own| (course.run_s, own.gap_s))).collect();
        cut(capture, marks, feeds.range(), |[there_s, gap_s, back_s]| {
            let is_one_program = (there_s - back_s).abs() < SPACING_OFF_S + RUNS_OFF * there_s;
            let rests_s = 2.0 * marks.rest_s;
            is_one_program
                && programs.iter().any(|(run_s, own_gap_s)| {
                    let least_s = run_s / fastest + rests_s - SPACING_OFF_S;
                    let most_s = run_s / slowest + rests_s + LONGEST_RAMP_S + SPACING_OFF_S;
                    [there_s, back_s].iter().all(|time_s| (least_s..most_s).contains(time_s))
                        // two programs in one capture lie as far apart as anyone lets them
                        && (gap_s - own_gap_s).abs() < SPACING_OFF_S
                })
        })
    })
}
