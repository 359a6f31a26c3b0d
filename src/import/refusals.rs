//! What stands against a timing: marks that leave no run of the test, readings that are cut off or not explained. It searches nothing.

use super::capture::{Averages, Capture};
use super::course::{Course, Feeds};
use super::error::{Bound, ImportError, RunsDiffer};
use super::likelihood::UNEVEN_S;
use super::seen_marks::Seen;
use super::timing::Timing;
use super::variables::RAMPS_S;
use crate::session::Marks;

/// Log odds from which on something is held for certain: 1 in 20,000.
pub(super) const CERTAIN: f64 = 10.0;
/// Share of the readings' own size, and size, mm, that a believed placement may leave.
const LEFT_SHARE: f64 = 0.25;
const LEFT_MM: f64 = 5e-3;
/// Size, mm, that it may leave where marks with a test's own gap say which program ran, and when: so much a machine errs beside
/// its location errors, which is for `diagnose` to explain. A bar that slips in its cup moves by more.
const LEFT_OF_MARKED_MM: f64 = 30e-3;
/// Size, mm, that any placement may leave.
const LEAST_LEFT_MM: f64 = 0.5e-3;
/// Multiple of the noise below which what is left is no misfit.
const NOISES: f64 = 3.0;
/// Most standard deviations by which a run may begin or end beside its marks.
const RUN_OFF: f64 = 6.0;
/// Most that a gap may differ from a test's to say for itself that its program ran, s: half of what tells tests apart, and three
/// standard deviations of a slow clock's cycle.
pub(super) const GAP_OFF_S: f64 = 0.12;
/// Standard deviations of a gap's own times that are allowed beside.
const GAP_SIGMAS: f64 = 3.0;
/// Share of a bound within which a pace is at it: a search that wants to go on ends so near.
const AT_BOUND: f64 = 2e-3;
/// Longest time in which a run comes to speed, s. At the feeds of a ball bar axes need some tenths of it; a longer one stands for a
/// pace, or an arc, that is not the program's.
pub(super) const LONGEST_RAMP_S: f64 = 1.1;

/// Refuses what the marks alone say: a run that was held on the way, and a feed that is not sought.
pub(super) fn refuse_by_marks(seen: Option<&Seen>, feeds: Feeds) -> Result<(), ImportError> {
    let Some(seen) = seen else { return Ok(()) };
    let range = feeds.range();
    let within = [range[0] - RUN_OFF * seen.pace_sigma, range[1] + RUN_OFF * seen.pace_sigma];
    if !(within[0]..within[1]).contains(&seen.pace) {
        let cure = match feeds {
            Feeds::Programmed => "where an override or the control changed it, say --any-feed",
            Feeds::Any => "record the test again nearer to its feed",
        };
        return Err(ImportError::FeedOfMarks { pace: seen.pace, range, cure });
    }
    // marks of several starts leave times of any length
    match seen.stopped_s.filter(|_| seen.found == 4) {
        Some(longer_s) => {
            Err(ImportError::Stopped { runs_s: seen.runs_s.map(|[begin_s, end_s]| end_s - begin_s), longer_s })
        }
        None => Ok(()),
    }
}

/// True where a run fits between marks at any pace and ramp that are searched.
pub(super) fn may_run_between(course: &Course, seen: &Seen) -> bool {
    let [slowest, fastest] = course.feeds.range();
    let slack_s = RUN_OFF * UNEVEN_S;
    seen.runs_s.iter().all(|[begin, end]| {
        let moving_s = end - begin;
        moving_s > course.run_s / fastest - slack_s && moving_s < course.run_s / slowest + RAMPS_S[1] + slack_s
    })
}

/// False where a program waits longer than its directions lay apart: no control waits less than it is told.
pub(super) fn may_wait(own: &Marks, seen: &Seen) -> bool {
    // the mark before the gap, and the one behind it
    let sigma_s = seen.run_sigma_s[0][1].hypot(seen.run_sigma_s[1][0]);
    seen.gap_s > own.gap_s - GAP_OFF_S.hypot(GAP_SIGMAS * sigma_s)
}

/// True for two runs of which much is left together and little of each by itself, mm: of one machine and one pair of tests both are the
/// same but for what hangs on the sense of motion.
pub(super) fn are_apart([together_mm, each_mm]: &[f64; 2]) -> bool {
    *together_mm > LEFT_MM && *each_mm < LEFT_SHARE * together_mm
}

/// Refuses a timing that lies where the search ends: what is at a bound is not fitted.
pub(super) fn refuse_at_bounds(test: &str, course: &Course, timing: &Timing) -> Result<(), ImportError> {
    let [slowest, fastest] = course.feeds.range();
    let is_at_bound = |pace: f64| pace < slowest * (1.0 + AT_BOUND) || pace > fastest * (1.0 - AT_BOUND);
    let bound = match timing.paces.into_iter().find(|pace| is_at_bound(*pace)) {
        Some(pace) => Bound::Pace { pace, range: [slowest, fastest] },
        None if timing.ramp_s > LONGEST_RAMP_S => Bound::Ramp { ramp_s: timing.ramp_s, most_s: LONGEST_RAMP_S },
        None => return Ok(()),
    };
    let cure = match course.feeds {
        Feeds::Programmed => {
            "where an override or the control slowed the program, say --any-feed; where the program was edited, plan it so and run it again"
        }
        Feeds::Any => "where the program was edited, plan it so and run it again; else record the test again",
    };
    Err(ImportError::AtBound { test: test.into(), bound, cure })
}

/// What a believed placement may leave, mm. Of a known program [`LEFT_OF_MARKED_MM`], else [`LEFT_SHARE`] of the signal within
/// [`LEAST_LEFT_MM`] and [`LEFT_MM`]; [`NOISES`] of noise at least.
pub(super) fn allowed_mm(program_is_known: bool, size_mm: f64, noise_mm: f64) -> f64 {
    let of_noise = NOISES * noise_mm;
    match program_is_known {
        true => of_noise.max(LEFT_OF_MARKED_MM),
        false => (LEFT_SHARE * size_mm).max(of_noise).min(LEFT_MM.max(of_noise)).max(LEAST_LEFT_MM),
    }
}

pub(super) fn refuse_cut_off(
    course: &Course,
    timing: &Timing,
    capture: &Capture,
    sigma: &[f64; 4],
) -> Result<(), ImportError> {
    let (first, last) = capture.ends_s();
    let before = first - timing.start_s[0];
    if before > 3.0 * sigma[0] && before > 0.02 {
        return Err(ImportError::CutAtStart { seconds: before });
    }
    let after = timing.start_s[1] + timing.moving_s(1, course.run_s) - last;
    if after > 3.0 * sigma[1] && after > 0.02 {
        return Err(ImportError::CutAtEnd { seconds: after });
    }
    Ok(())
}

/// Refuses marks between which the run of a test does not fit.
pub(super) fn refuse_other_runs(
    test: &str,
    course: &Course,
    data: &Averages,
    timing: &Timing,
) -> Result<(), ImportError> {
    let Some(seen) = &data.marks else { return Ok(()) };
    for direction in 0..2 {
        let start_s = timing.start_s[direction];
        let run = [start_s, start_s + timing.moving_s(direction, course.run_s)];
        let later_s = [0, 1].map(|k| run[k] - seen.runs_s[direction][k]);
        let most_s = [0, 1].map(|k| RUN_OFF * seen.run_sigma_s[direction][k].hypot(UNEVEN_S));
        if let Some(k) = (0..2).find(|&k| later_s[k].abs() > most_s[k]) {
            return Err(other_runs(test, seen, RunsDiffer::Lies { direction, later_s, most_s: most_s[k] }));
        }
    }
    Ok(())
}

pub(super) fn other_runs(test: &str, seen: &Seen, difference: RunsDiffer) -> ImportError {
    ImportError::OtherRuns { test: test.into(), seen_s: seen.runs_s.map(|[begin, end]| end - begin), difference }
}
