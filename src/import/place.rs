//! Whether the timing found is to be believed; refusals say what was found. How well it is known is in `uncertainty`. It reads no files.

use rayon::prelude::*;

use super::capture::Capture;
use super::course::{Course, Feeds, Pair, pairs};
use super::error::{ImportError, RunsDiffer};
use super::likelihood::{cost_at_rest, left_of_runs_mm, of_marks, residual_mm};
use super::marks::{Cut, Found, find};
use super::other_reading::{alike, forms, other_reading};
use super::refusals::{
    CERTAIN, GAP_OFF_S, allowed_mm, are_apart, may_run_between, may_wait, other_runs, refuse_at_bounds,
    refuse_by_marks, refuse_cut_off, refuse_other_runs,
};
use super::search::{
    Levels, first_look, nearly_as_likely, searched_finely, searched_roughly, settled_apart, settled_with_lost_motion,
    standing, starts,
};
use super::seen_marks::Seen;
use super::timing::Timing;
use super::trimmed::{within_marks, without_long_rests};
use super::uncertainty::{Known, apart, known};
use super::uneven::Uneven;
use super::variables::Candidate;
use crate::session::{Marks, Session};
use crate::statistics::{rms, standard_deviation};

/// A capture placed in time.
#[derive(Debug, Clone)]
pub struct Placement {
    pub pair: Pair,
    pub course: Course,
    pub timing: Timing,
    /// Standard deviations of the two starts, s, of the pace, and of the ramp's logarithm.
    pub sigma: [f64; 4],
    /// Standard deviation of the path position of a reading, root mean square over both arcs, deg or mm.
    pub position_sigma: f64,
    /// Averaged readings for a picture: time, s, reading and what the model leaves of it, mm.
    pub averages: Vec<[f64; 3]>,
    /// Begin and end of each mark, s: the averages leave it out.
    pub marks_s: Vec<[f64; 2]>,
    /// By direction: how much longer the bar got at the marks before and after its run, mm.
    pub marks_mm: [Option<[f64; 2]>; 2],
    /// What is left, mm, and the noise of one reading, mm.
    pub left_mm: f64,
    pub noise_mm: f64,
    /// True where the program's marks told when the runs began and ended.
    pub by_marks: bool,
    /// How much longer the second direction waited than programmed, s, where that is no control's cycle; 0 else.
    pub waited_s: f64,
    /// Log odds against the next best place in time, and against the next best pair of tests (none other: infinite).
    pub odds_place: f64,
    pub odds_tests: f64,
    /// A test whose readings are alike: only the wait between the directions speaks against it.
    pub alike: Option<Pair>,
    /// What was cut off before the first mark and after the last, where the bar did not rest, s.
    pub cut_s: [f64; 2],
    /// By how much longer the first run took than the second by their marks, with its standard deviation, s.
    pub longer_s: Option<[f64; 2]>,
    /// What is left of both runs' readings, mm: of both together and of each by itself, where they fit together far worse.
    pub runs_apart_mm: Option<[f64; 2]>,
}

/// Fewest readings of a capture.
const FEWEST: usize = 60;
/// Readings farther from the median than this are outside of any sweep of a planned pair, mm: half the stroke of usual bars.
const STROKE_MM: f64 = 1.0;
/// Share of readings that may be outside.
const OUTSIDE_SHARE: f64 = 0.1;
/// Share of readings that are one number to the last digit from which on the gauge read nothing: a machine that stands for as long as it
/// runs leaves half.
const MOST_ALIKE: f64 = 0.95;
/// Share of them from which on a capture that cannot be placed is said to have a bar that was off.
const FEW_OUTSIDE: f64 = 0.01;
/// Log odds against another test where marks were seen: 1 in 20. A capture whose readings speak for neither of two tests is taken
/// for the one whose gap it has to a hundredth of a second, and never where readings speak against it.
const CLEAR_OF_TESTS: f64 = 3.0;
/// What a file's name says for the test that it names, in log odds: one name in twenty is wrong.
const OF_NAME: f64 = 3.0;
/// Log odds against another place in time: 1 in 100.
const CLEAR: f64 = 4.6;
/// Least certainty of a position, deg or mm: 2° turn 3.5 % of an error into the one beside it. Beyond it the noise of a bar that
/// stands looks like a run too often.
const LIMIT: f64 = 2.0;

/// Places a capture on the best of some pairs of tests. With [`Feeds::Programmed`] a capture that fits at another feed alone
/// is refused: so does many a capture of another program.
pub fn place(session: &Session, among: &[Pair], capture: &Capture, feeds: Feeds) -> Result<Placement, ImportError> {
    place_named(session, among, capture, feeds, None)
}

/// The same for a capture whose file is named like a pair's test: evidence, but weak. What lies outside of four marks and is none of a
/// bar at rest is cut off where the whole capture is refused.
pub fn place_named(
    session: &Session,
    among: &[Pair],
    capture: &Capture,
    feeds: Feeds,
    named: Option<Pair>,
) -> Result<Placement, ImportError> {
    match placed_whole(session, among, capture, feeds, named) {
        Err(why) if why.is_of_readings() => {
            let Some(Cut { capture, cut_s }) = within_marks(session, among, capture, feeds) else { return Err(why) };
            placed_whole(session, among, &capture, feeds, named).map(|placed| Placement { cut_s, ..placed })
        }
        // between marks runs are known
        Ok(found) if !found.by_marks => match without_long_rests(capture, &found.course, &found.timing) {
            Some(shorter) => placed_whole(session, among, &shorter, feeds, named),
            None => Ok(found),
        },
        outcome => outcome,
    }
}

fn placed_whole(
    session: &Session,
    among: &[Pair],
    capture: &Capture,
    feeds: Feeds,
    named: Option<Pair>,
) -> Result<Placement, ImportError> {
    let readings = capture.reading_mm.iter().filter(|reading| reading.is_finite()).count();
    if readings < FEWEST {
        return Err(ImportError::TooFew { readings, due: FEWEST });
    }
    let alike = capture.share_alike();
    if alike > MOST_ALIKE {
        return Err(ImportError::Unchanging { percent: 100.0 * alike, reading_um: 1e3 * capture.middle_mm() });
    }
    let outside = capture.share_outside(STROKE_MM);
    if outside > OUTSIDE_SHARE {
        let off = ImportError::BarOff { percent: 100.0 * outside, stroke_mm: STROKE_MM };
        return Err(other_reading(session, among, capture, feeds).unwrap_or(off));
    }
    let placed = placed(session, among, capture, feeds, named);
    match (&placed, feeds) {
        // single magnets and touches leave fewer readings far off
        (Err(ImportError::MarksMissing { .. } | ImportError::NoMarks { .. } | ImportError::Unexplained { .. }), _)
            if outside > FEW_OUTSIDE =>
        {
            Err(ImportError::BarOff { percent: 100.0 * outside, stroke_mm: STROKE_MM })
        }
        (
            Err(
                ImportError::CutAtStart { .. }
                | ImportError::CutAtEnd { .. }
                | ImportError::Unexplained { .. }
                | ImportError::OtherRuns { .. }
                | ImportError::MarksMissing { .. }
                | ImportError::NoMarks { .. }
                | ImportError::FeedOfMarks { .. }
                | ImportError::AtBound { .. }
                | ImportError::TooShort { .. },
            ),
            Feeds::Programmed,
        ) => {
            let elsewhere = self::placed(session, among, capture, Feeds::Any, named);
            match elsewhere {
                Ok(found) if (found.timing.pace() - 1.0).abs() > 0.1 => Err(ImportError::OtherFeed {
                    test: session.tests[found.pair.tests[0]].name.clone(),
                    pace: found.timing.pace(),
                }),
                _ => placed,
            }
        }
        _ => placed,
    }
}

fn placed(
    session: &Session,
    among: &[Pair],
    capture: &Capture,
    feeds: Feeds,
    named: Option<Pair>,
) -> Result<Placement, ImportError> {
    let marked = marked(session, among, capture, feeds)?;
    let seen = marked.map(|(_, seen)| seen);
    refuse_by_marks(seen.as_ref(), feeds)?;
    let levels = &Levels::of(capture, seen);
    let placed = searched(session, &with_such_marks(session, among, marked), capture, feeds, levels)
        .and_then(|found| chosen(session, among, found, named, capture, levels));
    match (&placed, seen) {
        // runs lie between marks of one start; with marks of several, only a gap as programmed is believed
        (_, Some(seen))
            if seen.found > 4 && !placed.as_ref().is_ok_and(|placed| gap_is_kept(&placed.course, &seen)) =>
        {
            Err(ImportError::ManyMarks { found: seen.found, from_s: seen.last_four_s })
        }
        _ => placed,
    }
}

/// A test with the run that it makes and timings that explain the readings, the best first.
type Searched = (Pair, Course, Vec<Candidate>);

/// Log odds, by few readings with their own wander, beyond which a test is not looked at with all of them.
const LOG_ODDS_OF_FEW: f64 = 200.0;
/// The same by one search from one start, which may end elsewhere than the best does.
const LOG_ODDS_AT_FIRST: f64 = 2000.0;

/// Those whose cost lies within some log odds of the least.
fn near(tests: Vec<Searched>, far: f64, cost: impl Fn(&Course, &[Candidate]) -> f64 + Sync) -> Vec<Searched> {
    if tests.len() < 2 {
        return tests;
    }
    let costs: Vec<f64> = tests.par_iter().map(|(_, course, candidates)| cost(course, candidates)).collect();
    let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
    tests.into_iter().zip(costs).filter(|(_, cost)| 0.5 * (cost - least) < far).map(|(searched, _)| searched).collect()
}

/// The tests that the readings may be of, the best first.
fn searched(
    session: &Session,
    such: &[Pair],
    capture: &Capture,
    feeds: Feeds,
    levels: &Levels,
) -> Result<Vec<Searched>, ImportError> {
    let seen = levels.fine.marks;
    let (mut begun, mut why): (Vec<Searched>, _) = (Vec::new(), ImportError::NoPair);
    let (mut nearest_s, mut shortest_s, mut least_due_s) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
    let mut waits_less = None;
    for &pair in such {
        let course = Course::of(session, pair, feeds)?;
        let test = || session.tests[pair.tests[0]].name.clone();
        if let Some(seen) = seen.filter(|seen| !may_run_between(&course, seen)) {
            let off_s = (seen.runs_s[0][1] - seen.runs_s[0][0] - course.run_s).abs();
            if off_s < nearest_s {
                let difference = RunsDiffer::Takes { due_s: course.run_s };
                (why, nearest_s) = (other_runs(&test(), &seen, difference), off_s);
            }
            continue;
        }
        if let Some((own, seen)) = course.marks.zip(seen).filter(|(own, seen)| !may_wait(own, seen)) {
            // the one whose wait comes nearest
            if own.gap_s < least_due_s {
                least_due_s = own.gap_s;
                waits_less = Some(ImportError::WaitsLess { test: test(), seen_s: seen.gap_s, due_s: own.gap_s });
            }
            continue;
        }
        let starts = starts(&course, levels);
        if starts.is_empty() {
            let (first, last) = capture.ends_s();
            // the one that comes nearest
            if 2.0 * course.run_s < shortest_s {
                shortest_s = 2.0 * course.run_s;
                why = ImportError::TooShort { test: test(), lasts_s: last - first, due_s: shortest_s };
            }
            continue;
        }
        begun.push((pair, course, starts));
    }
    let searched = |(pair, course, begun): Searched, by: fn(&Course, &Levels, &[Candidate]) -> Vec<Candidate>| {
        let candidates = by(&course, levels, &begun);
        (pair, course, candidates)
    };
    let begun = near(begun, LOG_ODDS_AT_FIRST, |course, starts| first_look(course, levels, starts));
    let roughly: Vec<Searched> = begun.into_iter().map(|test| searched(test, searched_roughly)).collect();
    let likely = near(roughly, LOG_ODDS_OF_FEW, |course, rough| standing(course, levels, &rough[0]));
    let mut found: Vec<Searched> = likely.into_iter().map(|test| searched(test, searched_finely)).collect();
    found.sort_by(|one, other| one.2[0].cost.total_cmp(&other.2[0].cost));
    if found.is_empty() { Err(waits_less.unwrap_or(why)) } else { Ok(found) }
}

/// The test that explains the readings, where it is told from all others that were tried.
fn chosen(
    session: &Session,
    among: &[Pair],
    found: Vec<Searched>,
    named: Option<Pair>,
    capture: &Capture,
    levels: &Levels,
) -> Result<Placement, ImportError> {
    let name = |pair: &Pair| session.tests[pair.tests[0]].name.clone();
    let said = |pair: &Pair| if named == Some(*pair) { 2.0 * OF_NAME } else { 0.0 };
    let cost = |(pair, _, candidates): &Searched| candidates[0].cost - said(pair);
    let least = |among: &dyn Fn(&Pair) -> bool| {
        (0..found.len()).filter(|&k| among(&found[k].0)).min_by(|&i, &k| cost(&found[i]).total_cmp(&cost(&found[k])))
    };
    let (Some(best), asked) = (least(&|_| true), least(&|pair| among.contains(pair))) else {
        return Err(ImportError::NoPair);
    };
    let asked = match asked {
        // a test that was named needs only be as good as the best
        Some(asked) if asked == best || 0.5 * (cost(&found[asked]) - cost(&found[best])) < CLEAR => asked,
        _ => return Err(ImportError::OtherTest { test: name(&found[best].0) }),
    };
    let (pair, course, candidates) = &found[asked];
    let next = least(&|other| other != pair);
    let odds_tests = next.map_or(f64::INFINITY, |next| 0.5 * (cost(&found[next]) - cost(&found[asked])));
    let placement = judged(&name(pair), (*pair, course.clone()), candidates, capture, levels)?;
    let due = if levels.fine.marks.is_some() { CLEAR_OF_TESTS } else { CERTAIN };
    match next.filter(|&next| among.contains(&found[next].0)) {
        Some(next) if odds_tests < due => {
            Err(ImportError::TwoTests { one: name(pair), other: name(&found[next].0), odds: odds_tests, due })
        }
        _ => {
            let is_alike = |_: &usize| levels.fine.marks.is_some() && odds_tests < CERTAIN;
            let alike = next.filter(is_alike).map(|next| found[next].0);
            Ok(Placement { odds_tests, alike, ..placement })
        }
    }
}

/// True where the gap between the directions' marks is that of the program.
fn gap_is_kept(course: &Course, seen: &Seen) -> bool {
    course.marks.is_some_and(|own| (own.gap_s - seen.gap_s).abs() < GAP_OFF_S)
}

/// Log odds against the next best place in time; refused where one explains the readings alike.
fn odds_of_place(
    course: &Course,
    best: &Candidate,
    others: &[Candidate],
    position_sigma: f64,
) -> Result<f64, ImportError> {
    let mut odds_place = f64::INFINITY;
    for other in others {
        let apart = apart(course, &best.timing, &other.timing);
        let odds = 0.5 * (other.cost - best.cost);
        if apart < (4.0 * position_sigma).max(0.05) {
            continue;
        }
        odds_place = odds_place.min(odds);
        if odds < CLEAR {
            return Err(ImportError::TwoPlaces { apart, unit: course.unit, odds });
        }
    }
    Ok(odds_place)
}

/// Tests whose programs make the marks that were seen: all of that form, whatever their gap, for the second direction may have
/// waited. The gap is evidence among others.
fn with_such_marks(session: &Session, among: &[Pair], marked: Option<(Marks, Seen)>) -> Vec<Pair> {
    let Some((marks, _)) = marked else { return among.to_vec() };
    let is_such = |pair: &Pair| session.tests[pair.tests[0]].marks.is_some_and(|own| alike(&marks, &own));
    pairs(session).into_iter().filter(is_such).collect()
}

/// The marks of some of these tests' programs that the capture shows; `None` where it shows none at all.
fn marked(
    session: &Session,
    among: &[Pair],
    capture: &Capture,
    feeds: Feeds,
) -> Result<Option<(Marks, Seen)>, ImportError> {
    let (mut most, mut missing) = (0, None);
    // many tests make the same marks: which was meant is not known
    let asked = || if let [only] = among { Some(session.tests[only.tests[0]].name.clone()) } else { None };
    for marks in forms(session, among) {
        match find(capture, &marks, feeds.range()) {
            Found::All(seen) => return Ok(Some((marks, *seen))),
            Found::Some(found) if found > most => {
                most = found;
                missing = Some(ImportError::MarksMissing { test: asked(), found });
            }
            Found::Some(_) | Found::None => {}
        }
    }
    // marks are a thousand times the noise: without one the program did not run, or ran without them
    let of_all = among.iter().all(|pair| session.tests[pair.tests[0]].marks.is_some());
    let none = || ImportError::NoMarks { test: asked() };
    match missing.or_else(|| (of_all && !among.is_empty()).then(none)) {
        Some(why) => Err(other_reading(session, among, capture, feeds).unwrap_or(why)),
        None => Ok(None),
    }
}

/// Candidates whose columns are those of lost motion too, all of them, where the readings speak for it beyond doubt and it brings
/// the run nearer to its marks, as what a machine does must: other errors can look like lost motion at other times. It is for
/// programs that are known by their gap: what turns with the commands would bring runs of other tests and feeds near the readings.
fn with_lost_motion(course: &Course, levels: &Levels, plain: Vec<Candidate>) -> Vec<Candidate> {
    if course.lost_motion.forms.is_empty() {
        return plain;
    }
    let Some(with) = settled_with_lost_motion(course, &levels.fine, &plain) else { return plain };
    let odds = 0.5 * (plain[0].cost - with[0].cost);
    let [off_marks, plainly_off] = [&with[0], &plain[0]].map(|one| of_marks(course, &levels.fine, &one.timing));
    if odds > CERTAIN && off_marks < plainly_off { with } else { plain }
}

fn judged(
    test: &str,
    (pair, course): (Pair, Course),
    candidates: &[Candidate],
    capture: &Capture,
    levels: &Levels,
) -> Result<Placement, ImportError> {
    let is_known = levels.fine.marks.as_ref().is_some_and(|seen| gap_is_kept(&course, seen));
    let plain = settled_apart(&course, &levels.fine, candidates);
    let candidates = if is_known { with_lost_motion(&course, levels, plain) } else { plain };
    let mut likely = nearly_as_likely(&course, levels, &candidates[0]);
    let best = likely[0];
    let data = levels.fine.with(best.wander);
    let residual = residual_mm(&course, &data, &best.timing, best.freedom);
    let left_mm = rms(residual.iter().copied());
    let size_mm = standard_deviation(&data.value_mm);
    let noise_mm = capture.noise_mm();
    let odds = 0.5 * (cost_at_rest(&data) - best.cost);
    refuse_other_runs(test, &course, &data, &best.timing)?;
    // marks tell that the machine moved
    if odds < CERTAIN && data.marks.is_none() {
        return Err(ImportError::AtRest { odds });
    }
    if left_mm > allowed_mm(is_known, size_mm, noise_mm) {
        return Err(ImportError::Unexplained {
            test: test.into(),
            left_um: 1e3 * left_mm,
            size_um: 1e3 * size_mm,
            noise_um: 1e3 * noise_mm,
        });
    }
    let runs_apart_mm = left_of_runs_mm(&course, &data, &best.timing, &residual).filter(are_apart);
    refuse_at_bounds(test, &course, &best.timing)?;
    let uneven = Uneven::beside(&course, &levels.fine, &best, (left_mm, noise_mm));
    uneven.refuse(test, &course, &best)?;
    likely.extend(uneven.as_likely(&best));
    let Known { sigma, position_sigma } = known(&course, &data, &likely);
    let position_sigma = position_sigma.hypot(uneven.position_sigma);
    let unit = course.unit;
    refuse_cut_off(&course, &best.timing, capture, &sigma)?;
    if position_sigma > LIMIT {
        return Err(ImportError::TooFlat { sigma: position_sigma, limit: LIMIT, unit });
    }
    let gap_s = |seen: &Seen| seen.gap_s - course.marks.map_or(seen.gap_s, |own| own.gap_s);
    let waited_s = data.marks.as_ref().filter(|seen| !gap_is_kept(&course, seen)).map_or(0.0, gap_s);
    let odds_place = odds_of_place(&course, &best, &candidates[1..], position_sigma)?;
    Ok(Placement {
        pair,
        course,
        timing: best.timing,
        sigma,
        position_sigma,
        left_mm,
        noise_mm,
        by_marks: data.marks.is_some(),
        marks_s: data.marks.map_or_else(Vec::new, |seen| seen.marks_s.to_vec()),
        marks_mm: data.marks.map_or([None; 2], |seen| seen.by_direction_mm()),
        waited_s,
        averages: (data.time_s.iter().zip(&data.value_mm).zip(&residual))
            .map(|((time, value), left)| [*time, *value, *left])
            .collect(),
        odds_place,
        odds_tests: f64::INFINITY,
        alike: None,
        cut_s: [0.0; 2],
        longer_s: data.marks.and_then(|seen| seen.longer_s),
        runs_apart_mm,
    })
}
