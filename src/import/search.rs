//! The timing that explains a capture best, and the next best elsewhere: a grid, then Nelder–Mead on more readings. It judges nothing.

use rayon::prelude::*;

use super::capture::{Averages, Capture};
use super::course::Course;
use super::likelihood::{Freedom, cost};
use super::seen_marks::Seen;
use super::timing::Timing;
use super::timing::bend::Bend;
use super::uncertainty::covariance;
use super::variables::{Candidate, DIFFERENCES, RAMPS_S, VARIABLES, moved, units};
use super::wander::Wander;
use crate::statistics::{minimise_few, minimise_smooth};

/// Averages of the grid, of the first descent and of the last.
const ROUGH: usize = 120;
const MIDDLE: usize = 400;
const FINE: usize = 1000;
/// Steps of the grid over a capture: a start is then within a sixtieth, which is well inside the valley of any smooth form.
const STEPS: f64 = 60.0;
/// Ramp that the grid assumes, s.
const RAMP_S: f64 = 0.15;
/// Step of the grid in the logarithm of the pace.
const PACE_STEP: f64 = 0.02;
/// Share of a run that may lie outside the capture, so that one which was cut off is seen to be.
const OUTSIDE: f64 = 0.3;
/// Starts of descents where there are no marks, and places in time that are kept.
const STARTS: usize = 10;
const PLACES: usize = 3;

/// First steps of searches, in units of the variables: from starts, from where few readings led, where it is near, from ramps and
/// lags near by, and to where other freedoms or paces may lead.
const FROM_START: f64 = 0.7;
const FROM_FEW: f64 = 0.2;
const NEAR: f64 = 0.1;
const FROM_NEAR_BY: f64 = 0.3;
const ELSEWHERE: f64 = 0.5;
/// First steps of a search again, as a share of those before, and the gain for which it is worth its time: in twice the log likelihood.
const SMALLER: f64 = 0.4;
const WORTH_A_SEARCH: f64 = 0.05;

/// A capture at three finenesses.
pub(super) struct Levels {
    rough: Averages,
    middle: Averages,
    pub fine: Averages,
}

impl Levels {
    /// Averages of a capture in which these marks were seen, or none.
    pub fn of(capture: &Capture, marks: Option<Seen>) -> Levels {
        let [rough, middle, fine] = [ROUGH, MIDDLE, FINE].map(|most| capture.averages(most, marks));
        Levels { rough, middle, fine }
    }
}

/// Timings from which searches begin, the best first.
pub(super) fn starts(course: &Course, levels: &Levels) -> Vec<Candidate> {
    let mut starts = match &levels.rough.marks {
        Some(seen) => between_marks(course, &levels.rough, seen),
        None => grid(course, &levels.rough),
    };
    starts.sort_by(|one, other| one.cost.total_cmp(&other.cost));
    match &levels.rough.marks {
        Some(_) => starts,
        None => apart(course, starts, STARTS, APART_ON_GRID),
    }
}

/// Cost that the first of a test's starts leads to by few readings.
pub(super) fn first_look(course: &Course, levels: &Levels, starts: &[Candidate]) -> f64 {
    starts.first().map_or(f64::INFINITY, |start| searched_from(course, levels, start).cost)
}

/// Timings near the best ones, the best first, each in a valley of its own: by few readings.
pub(super) fn searched_roughly(course: &Course, levels: &Levels, starts: &[Candidate]) -> Vec<Candidate> {
    let mut best: Vec<Candidate> = starts.par_iter().map(|start| searched_from(course, levels, start)).collect();
    best.sort_by(|one, other| one.cost.total_cmp(&other.cost));
    apart(course, best, PLACES, APART_BY_FEW)
}

fn searched_from(course: &Course, levels: &Levels, start: &Candidate) -> Candidate {
    descend(course, &levels.middle, start.timing, Freedom::ALL[1], FROM_START)
}

/// Cost of a timing by few readings, with the wander that they show: how a test stands beside others.
pub(super) fn standing(course: &Course, levels: &Levels, near: &Candidate) -> f64 {
    settled(course, &levels.middle, near, NEAR).cost
}

/// Best timings, the best first, by all readings: from those near them.
pub(super) fn searched_finely(course: &Course, levels: &Levels, few: &[Candidate]) -> Vec<Candidate> {
    let mut fine: Vec<Candidate> = few
        .par_iter()
        .map(|start| descend(course, &levels.fine, start.timing, start.freedom, FROM_FEW))
        .map(|start| settled(course, &levels.fine, &start, NEAR))
        .collect();
    fine.sort_by(|one, other| one.cost.total_cmp(&other.cost));
    if let Some(first) = fine.first_mut() {
        *first = descend_apart(course, &levels.fine.with(first.wander), *first, ELSEWHERE);
    }
    fine.sort_by(|one, other| one.cost.total_cmp(&other.cost));
    apart(course, fine, PLACES, APART_BY_ALL)
}

/// Ramps from which searches between marks begin, s.
pub(super) const RAMPS: [f64; 4] = [0.04, 0.1, 0.25, 0.6];

/// Timings that begin and end as marks tell, by ramp.
fn between_marks(course: &Course, data: &Averages, seen: &Seen) -> Vec<Candidate> {
    let start_s = [seen.runs_s[0][0], seen.runs_s[1][0]];
    let each_s = seen.runs_s.map(|[begin, end]| end - begin);
    let moving_s = 0.5 * (each_s[0] + each_s[1]);
    // what the pace of the marks leaves of the time, and others where the run has a pace of its own
    let left_s = (moving_s - course.run_s / seen.pace).clamp(RAMPS_S[0], RAMPS_S[1]);
    [left_s]
        .into_iter()
        .chain(RAMPS)
        .filter(|ramp_s| each_s.iter().all(|moving_s| *moving_s > 2.0 * ramp_s))
        // directions at one pace, and each at its own
        .flat_map(|ramp_s| [[moving_s; 2], each_s].map(|moving_s| (ramp_s, moving_s)))
        .map(|(ramp_s, moving_s)| {
            let paces = moving_s.map(|moving_s| course.run_s / (moving_s - ramp_s));
            let timing = Timing { start_s, paces, ramp_s, lag_s: seen.lag_s, bends: [Bend::NONE; 2] };
            Candidate::of(course, data, timing, Freedom::NONE)
        })
        .collect()
}

fn grid(course: &Course, data: &Averages) -> Vec<Candidate> {
    let (first, last) = (data.time_s[0], data.time_s[data.time_s.len() - 1]);
    let step = (last - first) / STEPS;
    let paces = course.feeds.range();
    let count = ((paces[1] / paces[0]).ln() / PACE_STEP).ceil() as usize;
    let paces: Vec<f64> = (0..=count).map(|k| paces[0] * (PACE_STEP * k as f64).exp()).collect();
    paces
        .par_iter()
        .flat_map_iter(|&pace| {
            let moving = course.run_s / pace + RAMP_S;
            let outside = OUTSIDE * moving;
            let latest = last - moving + outside;
            let firsts = steps(first - outside, latest - moving, step);
            firsts.into_iter().flat_map(move |one| {
                steps(one + moving, latest, step).into_iter().map(move |other| {
                    let (start_s, paces, bends) = ([one, other], [pace; 2], [Bend::NONE; 2]);
                    let timing = Timing { start_s, paces, ramp_s: RAMP_S, lag_s: 0.0, bends };
                    Candidate::of(course, data, timing, Freedom::NONE)
                })
            })
        })
        .collect()
}

fn steps(from: f64, to: f64, step: f64) -> Vec<f64> {
    let count = ((to - from) / step).floor();
    if count < 0.0 { Vec::new() } else { (0..=count as usize).map(|k| from + step * k as f64).collect() }
}

/// Share of a run's time from which another start or pace is another place, and by what part of it candidates have to lie apart: on the
/// grid, by few readings, by all, and where others of one place are told from each other.
const ANOTHER_PLACE: f64 = 0.05;
const APART_ON_GRID: f64 = 2.0;
const APART_BY_FEW: f64 = 0.2;
const APART_BY_ALL: f64 = 0.05;
const APART_AT_ONE_PLACE: f64 = 0.02;

/// The first candidates that lie apart from all before, in a start or in the time of a run, by a share of what counts as another place.
fn apart(course: &Course, sorted: Vec<Candidate>, most: usize, share: f64) -> Vec<Candidate> {
    let near_s = share * ANOTHER_PLACE * course.run_s;
    let mut kept: Vec<Candidate> = Vec::new();
    for candidate in sorted {
        let is_far = |other: &Candidate| {
            let [a, b] = [0, 1].map(|k| (candidate.timing.start_s[k] - other.timing.start_s[k]).abs());
            let c = (0..2).any(|k| {
                let pace = other.timing.paces[k];
                (candidate.timing.paces[k] - pace).abs() / pace * course.run_s > near_s
            });
            a > near_s || b > near_s || c
        };
        if kept.iter().all(is_far) {
            kept.push(candidate);
        }
        if kept.len() == most {
            break;
        }
    }
    kept
}

/// Nelder–Mead from a start, again with smaller steps until it no longer gains.
fn descend(course: &Course, data: &Averages, start: Timing, freedom: Freedom, size: f64) -> Candidate {
    let mut best = Candidate::of(course, data, start, freedom);
    let mut size = size;
    for _ in 0..3 {
        let next = stepped(course, data, &best, size, DIFFERENCES[0]);
        let gain = best.cost - next.cost;
        if gain > 0.0 {
            best = next;
        }
        if gain < WORTH_A_SEARCH {
            break;
        }
        size *= SMALLER;
    }
    best
}

/// One search about a candidate, with first steps of `size` units and of a part of the run's time between directions.
fn stepped(course: &Course, data: &Averages, from: &Candidate, size: f64, difference: f64) -> Candidate {
    let mut units = units(course, data, from.timing.pace());
    units[4] *= difference / DIFFERENCES[0];
    let at = |x: &[f64; VARIABLES]| moved(course, &from.timing, &units, x);
    let timing = at(&minimise_few([0.0; VARIABLES], size, |x| cost(course, data, &at(x), from.freedom)));
    Candidate::of(course, data, timing, from.freedom)
}

/// The same for directions that ran at two paces, kept where the readings speak for it.
fn descend_apart(course: &Course, data: &Averages, from: Candidate, size: f64) -> Candidate {
    let apart = stepped(course, data, &from, size, DIFFERENCES[1]);
    // the two kinds of pace are two valleys: down to the ground of the other before they are compared
    let apart = descend(course, data, apart.timing, apart.freedom, SMALLER * size);
    if apart.cost < from.cost { apart } else { from }
}

/// A search from a start with the freedom that the readings speak for.
pub(super) fn descend_freely(start: &Candidate, descend: impl Fn(Timing, Freedom) -> Candidate) -> Candidate {
    let [first, others @ ..] = start.freedom.all();
    let best = descend(start.timing, first);
    others
        .into_iter()
        .map(|freedom| descend(best.timing, freedom))
        .fold(best, |best, next| if next.cost < best.cost { next } else { best })
}

/// A candidate with the wander that its readings show: what is left of each timing says how its own readings wander.
fn settled(course: &Course, fine: &Averages, start: &Candidate, size: f64) -> Candidate {
    let data = fine.with(wandering(course, fine, start));
    descend_freely(start, |timing, freedom| descend(course, &data, timing, freedom, size))
}

/// Candidates that cost so much more than the best stay as they were found: settling gains far less. By odds of e⁻⁵⁰.
const FAR: f64 = 100.0;

/// Candidates of one test once more, each by its own wander and with directions at two paces, the best first.
pub(super) fn settled_apart(course: &Course, fine: &Averages, candidates: &[Candidate]) -> Vec<Candidate> {
    let least = candidates.iter().map(|candidate| candidate.cost).fold(f64::INFINITY, f64::min);
    let again = |candidate: &Candidate| {
        if candidate.cost > least + FAR {
            return *candidate;
        }
        let data = fine.with(wandering(course, fine, candidate));
        let candidate = descend_freely(candidate, |start, freedom| {
            descend_by_covariance(course, &data, Candidate::of(course, &data, start, freedom))
        });
        let candidate = descend_apart(course, &data, candidate, ELSEWHERE);
        descend_by_covariance(course, &data, candidate)
    };
    let mut again: Vec<Candidate> = candidates.par_iter().map(again).collect();
    again.sort_by(|one, other| one.cost.total_cmp(&other.cost));
    again
}

/// Lags of servos, s, from which searches begin where no mark tells it.
const LAGS_S: [f64; 6] = [0.0, 0.008, 0.016, 0.028, 0.042, 0.06];

/// Candidates that cost so much more than the best are as good as impossible: by odds of e⁻¹⁰.
const IMPOSSIBLE: f64 = 20.0;

/// A candidate with others of its place that explain the readings nearly as well, the best first: sought from several lags, where no
/// mark tells it.
pub(super) fn nearly_as_likely(course: &Course, levels: &Levels, from: &Candidate) -> Vec<Candidate> {
    let fine = &levels.fine;
    let lags_s = if fine.marks.is_some() { vec![from.timing.lag_s] } else { LAGS_S.to_vec() };
    let few = levels.middle.with(from.wander);
    let sought = |lag_s: &f64| {
        let starts = near_by(course, Timing { lag_s: *lag_s, ..from.timing }).into_par_iter();
        let found: Vec<Candidate> =
            starts.map(|start| descend(course, &few, start, from.freedom, FROM_NEAR_BY)).collect();
        found.into_iter().min_by(|one, other| one.cost.total_cmp(&other.cost))
    };
    let data = fine.with(from.wander);
    let mut found: Vec<Candidate> = lags_s
        .par_iter()
        .filter_map(sought)
        .map(|one| descend_by_covariance(course, &data, Candidate::of(course, &data, one.timing, one.freedom)))
        .collect();
    found.push(*from);
    found.sort_by(|one, other| one.cost.total_cmp(&other.cost));
    let least = found[0].cost;
    found.retain(|one| one.cost < least + IMPOSSIBLE);
    // what is left of each says how readings wander
    let own_wander = |one: &Candidate| {
        (0..2).fold(*one, |one, _| {
            let data = fine.with(wandering(course, fine, &one));
            descend_by_covariance(course, &data, Candidate::of(course, &data, one.timing, one.freedom))
        })
    };
    let mut settled: Vec<Candidate> = found.par_iter().map(own_wander).collect();
    settled.sort_by(|one, other| one.cost.total_cmp(&other.cost));
    apart(course, settled, LAGS_S.len(), APART_AT_ONE_PLACE)
}

/// Timings near one from which others of its place are sought: directions at one pace, and ramps of several lengths whose runs take as
/// long or keep their pace, for a longer ramp and a higher pace do nearly the same.
fn near_by(course: &Course, timing: Timing) -> Vec<Timing> {
    let at_one_pace = timing.about_its_middles(course.run_s, [timing.pace(); 2], timing.ramp_s);
    let with_ramps = RAMPS.into_iter().flat_map(|ramp_s| {
        let moving_s = [0, 1].map(|direction| timing.moving_s(direction, course.run_s));
        let is_room = moving_s.iter().all(|moving_s| *moving_s > 2.0 * ramp_s);
        let paces = [moving_s.map(|moving_s| course.run_s / (moving_s - ramp_s)), timing.paces];
        let of_ramp = paces.map(|paces| timing.about_its_middles(course.run_s, paces, ramp_s));
        of_ramp.into_iter().filter(move |_| is_room)
    });
    [timing, at_one_pace].into_iter().chain(with_ramps).collect()
}

/// Searches along a narrow valley, at most.
const ALONG: usize = 8;

/// Down a narrow valley: by slopes along its own axes, each in its standard deviations, again from where it ends, for valleys are
/// bent.
pub(super) fn descend_by_covariance(course: &Course, data: &Averages, from: Candidate) -> Candidate {
    let mut best = from;
    for _ in 0..ALONG {
        let units = units(course, data, best.timing.pace());
        let Some(axes) = covariance(course, data, &best).cholesky().map(|factor| factor.unpack()) else { break };
        let at = |spreads: &[f64; VARIABLES]| {
            let by = std::array::from_fn(|k| (0..=k).map(|column| axes[(k, column)] * spreads[column]).sum());
            moved(course, &best.timing, &units, &by)
        };
        let timing = at(&minimise_smooth([0.0; VARIABLES], |x| cost(course, data, &at(x), best.freedom)));
        let next = Candidate::of(course, data, timing, best.freedom);
        let gain = best.cost - next.cost;
        if gain > 0.0 {
            best = next;
        }
        if gain < WORTH_A_SEARCH {
            break;
        }
    }
    best
}

/// The same with lost motion among what a machine may do; `None` where that explains the readings no better. Where it is at work, the
/// timing without it may be far off, and the first wander stands for what that leaves: found twice, and sought from where the marks
/// put the runs as well.
pub(super) fn settled_with_lost_motion(
    course: &Course,
    fine: &Averages,
    candidates: &[Candidate],
) -> Option<Vec<Candidate>> {
    let by_marks = fine.marks.iter().flat_map(|seen| between_marks(course, fine, seen));
    let by_marks = by_marks.min_by(|one, other| one.cost.total_cmp(&other.cost));
    let by_marks = by_marks.map(|start| Candidate { freedom: candidates[0].freedom, ..start });
    let starts: Vec<Candidate> = candidates.iter().copied().chain(by_marks).collect();
    let near: Vec<Candidate> = starts
        .par_iter()
        .map(|candidate| Candidate { freedom: candidate.freedom.with_lost_motion(), ..*candidate })
        .map(|candidate| settled(course, fine, &candidate, ELSEWHERE))
        .collect();
    let is_better = near.iter().any(|candidate| candidate.cost < candidates[0].cost);
    is_better.then(|| settled_apart(course, fine, &near))
}

/// The likeliest wander beside a timing.
pub(super) fn wandering(course: &Course, data: &Averages, best: &Candidate) -> Wander {
    let at = |x: &[f64; 2]| cost(course, &data.with(Wander::off(x)), &best.timing, best.freedom);
    Wander::off(&minimise_few(best.wander.spreads(), 0.5, at))
}
