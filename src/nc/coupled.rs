//! Steps of runs in which several axes move: linear axes following a rotary one, and planar circles. Ways to them and rests are `test_steps`'s.
//!
//! Where the slides of a following run draw a circle in a coordinate plane, arcs carry the rotary axis along: the control
//! draws the very path and keeps its feed. Else a run is many short straight blocks, each with the time that it takes (G93,
//! FT): a feed in mm/min would mean something else on every control when a rotary axis moves along. A block is so short
//! that its chord keeps the bar's length to [`CHORD_MM`]. Run-in and run-out go on along the same curve.

use super::coordinates::Coordinates;
use super::step::{Curves, Step};
use crate::chain::{Chain, Geometry};
use crate::machine::{AxisKind, Machine};
use crate::plan::{CHORD_MM, GRID_DEG, PLANES, PlannedTest, bare_session, beyond_path};
use crate::session::{Motion, Path, Test, way_mm};

/// Longest arc of a circle in one block, deg, where no word counts whole turns: centre and sense say which way is meant, an
/// end near the start might be read as a whole turn.
const ARC_DEG: f64 = 300.0;
/// An arc that ends no nearer to its start than this, deg, is read with the whole turns that its block states.
const CLEAR_OF_START_DEG: f64 = 1.0;

/// The path of one direction with run-in and run-out.
struct Course {
    /// Where the run-in and the arc begin and the run-out ends, deg of the path.
    from: f64,
    begin: f64,
    to: f64,
    /// Step of the session's rows, deg.
    step: f64,
}

impl Course {
    fn of(machine: &Machine, test: &Test) -> Option<Course> {
        let path = test.path.as_ref()?;
        let [from, to] = path.ends();
        let motion = Motion::of(&bare_session(machine), &Chain::of(machine), test).ok()?;
        let [before, after] = beyond_path(machine, test, &motion)?;
        let way = (to - from).signum();
        Some(Course { from: from - way * before, begin: from, to: to + way * after, step: path.step().abs() })
    }
}

/// One block of arcs: where it begins and ends, deg of the path, and the whole turns that it counts.
struct Piece {
    from: f64,
    to: f64,
    turns: u32,
}

impl Course {
    /// The arcs of run-in, arc and run-out: one where the control counts turns, for it slows down between two.
    fn pieces(&self, curves: Curves) -> Vec<Piece> {
        let whole = (self.to - self.from).abs();
        let past_turns = whole % 360.0;
        if curves == Curves::Winding && (CLEAR_OF_START_DEG..360.0 - CLEAR_OF_START_DEG).contains(&past_turns) {
            return vec![Piece { from: self.from, to: self.to, turns: (whole / 360.0) as u32 }];
        }
        let count = (whole / ARC_DEG).ceil().max(1.0) as usize;
        let at = |k: usize| self.from + (self.to - self.from) * k as f64 / count as f64;
        (0..count).map(|k| Piece { from: at(k), to: at(k + 1), turns: 0 }).collect()
    }
}

/// Rows of the path between two of its places in so many equal steps, run from the first to the last.
fn between(machine: &Machine, test: &Test, from: f64, to: f64, steps: f64) -> Option<Motion> {
    let path = test.path.as_ref()?.between(from, to).in_steps(steps.max(1.0));
    Motion::of(&bare_session(machine), &Chain::of(machine), &Test { path: Some(path), ..test.clone() }).ok()
}

/// One direction of a following run from the start of its run-in: rising, or falling.
pub(super) fn follow(
    machine: &Machine,
    planned: &PlannedTest,
    test: &Test,
    coordinates: &Coordinates,
    curves: Curves,
) -> Vec<Step> {
    let Some((course, motion)) = whole(machine, test) else { return Vec::new() };
    let round = match curves {
        Curves::Carrying | Curves::Winding => Round::of(machine, planned.axis, &motion),
        Curves::Plain => None,
    };
    match round {
        Some(round) => arcs_with_turn(machine, planned.axis, test, (&course, curves), &round),
        None => straight_blocks(machine, test, coordinates, (&course, curves), &motion),
    }
}

/// The path of one direction and its motion at the session's steps, or a little smaller ones that are whole in it.
fn whole(machine: &Machine, test: &Test) -> Option<(Course, Motion)> {
    let course = Course::of(machine, test)?;
    let long = (course.to - course.from).abs();
    let count = (long / course.step - 1e-6).ceil().max(1.0);
    let motion = between(machine, test, course.from, course.to, count)?;
    Some((Course { step: long / count, ..course }, motion))
}

/// Straight blocks over run-in, arc and run-out.
fn straight_blocks(
    machine: &Machine,
    test: &Test,
    coordinates: &Coordinates,
    (course, curves): (&Course, Curves),
    whole: &Motion,
) -> Vec<Step> {
    let chain = Chain::of(machine);
    let geometry = Geometry::nominal(&chain);
    let rows = whole.rows();
    let Some(run_s) = whole.time_s.as_ref().and_then(|time_s| time_s.last().copied()) else { return Vec::new() };
    let per_deg_ms = 1e3 * run_s / (course.to - course.from).abs();
    let longest_ms = per_deg_ms * longest_deg(&geometry, test, whole, course.step);
    // all that moves in the run; the rest stands where the way to the start has brought it
    let moving: Vec<usize> = (0..whole.axis_count)
        .filter(|&k| (0..rows).any(|row| (whole.row(row)[k] - whole.row(0)[k]).abs() > STANDS))
        .collect();
    let mut steps = Vec::new();
    for Cut { from, to, count } in cuts(course, 1e3 * run_s, longest_ms, curves) {
        let Some(motion) = between(machine, test, from, to, count) else { continue };
        let blocks_ms = times_ms(&motion, per_deg_ms * (to - from).abs(), curves);
        let mut ends = on_grid(machine, coordinates, &motion);
        // the run-out ends where the other direction and the way back begin
        if let Some(last) = ends.last_mut().filter(|_| to == course.to) {
            *last = motion.row(motion.rows() - 1).to_vec();
        }
        steps.extend(
            ends.iter()
                .skip(1)
                .zip(blocks_ms)
                .map(|(end, ms)| Step::Move { to: place(machine, coordinates, &moving, end), minutes: ms / 60_000.0 }),
        );
    }
    steps
}

/// Rows moved along the path to readings that programs can write in full, so that no rotary digit is lost: the slides then
/// stand where they belong to the turn that is written.
fn on_grid(machine: &Machine, coordinates: &Coordinates, motion: &Motion) -> Vec<Vec<f64>> {
    let rows = motion.rows();
    let Some(turning) = motion.moving.iter().copied().find(|&k| machine.axes[k].kind == AxisKind::Rotary) else {
        return (0..rows).map(|row| motion.row(row).to_vec()).collect();
    };
    (0..rows)
        .map(|row| {
            let here = motion.row(row);
            let (one, other) = if row + 1 < rows { (row, row + 1) } else { (rows.saturating_sub(2), row) };
            let (from, to) = (motion.row(one), motion.row(other));
            let reading = coordinates.reading(machine, turning, here[turning]);
            let off = ((reading / GRID_DEG).round() * GRID_DEG - reading).to_radians();
            let turn = to[turning] - from[turning];
            let part = if turn == 0.0 { 0.0 } else { off / turn };
            here.iter().zip(from.iter().zip(to)).map(|(q, (from, to))| q + (to - from) * part).collect()
        })
        .collect()
}

/// Positions that differ by less are the same, mm or rad: programs state tens of nanometres.
const STANDS: f64 = 1e-7;

/// Longest block, deg, whose chord changes the bar by no more than [`CHORD_MM`], and no longer than a step of the session.
fn longest_deg(geometry: &Geometry, test: &Test, motion: &Motion, step: f64) -> f64 {
    let Ok(links) = test.links(geometry.chain()) else { return step };
    let bar = |q: &[f64]| test.bar(geometry, links, q).norm();
    let middle = |row: usize| -> f64 {
        let (from, to) = (motion.row(row - 1), motion.row(row));
        let half: Vec<f64> = from.iter().zip(to).map(|(from, to)| 0.5 * (from + to)).collect();
        (bar(&half) - 0.5 * (bar(from) + bar(to))).abs()
    };
    let worst = (1..motion.rows()).map(middle).fold(0.0, f64::max);
    // a chord leaves its circle by the square of its length
    step * (CHORD_MM / worst.max(1e-12)).sqrt().min(1.0)
}

/// Cycle of a control, ms, as fine as `FT` states a time; and what a block takes beyond whole cycles where feeds are stated by
/// time: one that ended within a cycle would give the rest of it away, and its neighbours would be joined at up to 1.1 of the
/// feed (LinuxCNC).
const CYCLE_MS: f64 = 1.0;
const BEYOND_MS: f64 = 0.02;
/// Parts of a cycle that are rounding.
const ROUNDING: f64 = 1e-6;

/// What a block takes beyond whole cycles, ms.
fn beyond_ms(curves: Curves) -> f64 {
    if curves == Curves::Plain { 0.0 } else { BEYOND_MS }
}

/// A stretch of a run that is cut into so many equal blocks, between two places, deg of the path.
#[derive(Debug, PartialEq)]
struct Cut {
    from: f64,
    to: f64,
    count: f64,
}

/// A run in blocks that last whole cycles, none longer than `longest_ms` if that is a cycle, such that all together take the
/// time that the feed says. What whole blocks leave of the run goes with one of them into the first two, where the axes come to
/// speed: none is shorter than half of the others.
fn cuts(course: &Course, run_ms: f64, longest_ms: f64, curves: Curves) -> Vec<Cut> {
    let beyond = beyond_ms(curves);
    let whole_cycles = |ms: f64| ((ms - beyond) / CYCLE_MS + ROUNDING).floor().max(1.0) * CYCLE_MS + beyond;
    let block_ms = whole_cycles(longest_ms);
    let whole = (run_ms / block_ms + ROUNDING).floor();
    let at = |ms: f64| course.from + (course.to - course.from) * ms / run_ms;
    let rest_ms = run_ms - whole * block_ms;
    if whole < 1.0 || rest_ms < ROUNDING * CYCLE_MS {
        return vec![Cut { from: course.from, to: course.to, count: whole.max(1.0) }];
    }
    let (first, second) = (at(whole_cycles(0.5 * (block_ms + rest_ms))), at(block_ms + rest_ms));
    let cut = |from: f64, to: f64, count: f64| Cut { from, to, count };
    let begin = [cut(course.from, first, 1.0), cut(first, second, 1.0)];
    begin.into_iter().chain((whole > 1.0).then(|| cut(second, course.to, whole - 1.0))).collect()
}

/// Times of the blocks of a motion that takes `whole_ms`, ms: whole cycles that together last as long, and less than one more.
fn times_ms(motion: &Motion, whole_ms: f64, curves: Curves) -> Vec<f64> {
    let (Some(time_s), beyond) = (&motion.time_s, beyond_ms(curves)) else { return Vec::new() };
    let lasts_s = time_s.last().copied().unwrap_or(0.0).max(f64::MIN_POSITIVE);
    let gone = |row: usize| {
        let ms = whole_ms * time_s[row] / lasts_s - beyond * row as f64;
        (ms / CYCLE_MS - ROUNDING).ceil()
    };
    (1..time_s.len()).map(|row| (gone(row) - gone(row - 1)).max(1.0) * CYCLE_MS + beyond).collect()
}

/// A circle of two slides on which a rotary axis is carried along.
struct Round {
    /// The slides of a coordinate plane in its order, by index.
    slides: [usize; 2],
    centre: [f64; 2],
    radius_mm: f64,
    /// Angle in the plane where the rotary axis stands at zero, rad, and its sense as that axis rises.
    zero: f64,
    sense: f64,
}

/// Most that rows may lie off a circle that is drawn by arcs, mm.
const ROUND_MM: f64 = 1e-6;

impl Round {
    /// The circle of a motion in which nothing but two slides of a plane and one rotary axis move, angle for angle.
    fn of(machine: &Machine, axis: usize, motion: &Motion) -> Option<Round> {
        let rows = motion.rows();
        if machine.axes[axis].kind != AxisKind::Rotary || rows < 3 {
            return None;
        }
        let moves = |k: usize| (0..rows).any(|row| (motion.row(row)[k] - motion.row(0)[k]).abs() > STANDS);
        let moving: Vec<usize> = (0..motion.axis_count).filter(|&k| k != axis && moves(k)).collect();
        let slides = PLANES
            .iter()
            .filter_map(|names| Some([machine.axis_index(names[0])?, machine.axis_index(names[1])?]))
            .find(|plane| moving.len() == 2 && moving.iter().all(|k| plane.contains(k)))?;
        let at = |row: usize| slides.map(|k| motion.row(row)[k]);
        let turned = |row: usize| motion.row(row)[axis];
        let (first, last) = (at(0), at(rows - 1));
        [1.0, -1.0].into_iter().find_map(|sense| {
            // places a and b of a circle, seen under the turn t: m = (a + b)/2 + cot(t/2)/2 · (b - a) turned left
            let middle_row = rows / 2;
            let (other, turn) = (at(middle_row), sense * (turned(middle_row) - turned(0)));
            let half_cot = 0.5 / (0.5 * turn).tan();
            let centre = [
                0.5 * (first[0] + other[0]) - half_cot * (other[1] - first[1]),
                0.5 * (first[1] + other[1]) + half_cot * (other[0] - first[0]),
            ];
            let radius_mm = (first[0] - centre[0]).hypot(first[1] - centre[1]);
            let zero = (first[1] - centre[1]).atan2(first[0] - centre[0]) - sense * turned(0);
            let round = Round { slides, centre, radius_mm, zero, sense };
            let off = |row: usize| {
                let (on, is) = (round.at(turned(row)), at(row));
                (on[0] - is[0]).hypot(on[1] - is[1])
            };
            let fits = last.iter().all(|q| q.is_finite()) && (0..rows).all(|row| off(row) < ROUND_MM);
            fits.then_some(round)
        })
    }

    /// Place of the slides at a turn of the rotary axis, rad.
    fn at(&self, turned: f64) -> [f64; 2] {
        let (sin, cos) = (self.zero + self.sense * turned).sin_cos();
        [self.centre[0] + self.radius_mm * cos, self.centre[1] + self.radius_mm * sin]
    }
}

/// Arcs that carry the rotary axis along, from the start of the run-in to the end of the run-out.
fn arcs_with_turn(
    machine: &Machine,
    axis: usize,
    test: &Test,
    (course, curves): (&Course, Curves),
    round: &Round,
) -> Vec<Step> {
    let chain = Chain::of(machine);
    let (Ok(links), geometry) = (test.links(&chain), Geometry::nominal(&chain)) else { return Vec::new() };
    let feed = test.feed();
    // the slides' way for that of the ball, from any small turn
    let Some(small) = between(machine, test, course.begin, course.begin + course.step, 1.0) else { return Vec::new() };
    let ball = way_mm(&geometry, test, links, small.row(0), small.row(1));
    let share = 2.0 * round.radius_mm * (0.5 * course.step.to_radians()).sin() / ball;
    let names = round.slides.map(|k| machine.axes[k].name.clone());
    course
        .pieces(curves)
        .into_iter()
        .map(|Piece { from, to, turns }| {
            let (start, end) = (round.at(from.to_radians()), round.at(to.to_radians()));
            Step::Arc {
                axes: names.clone(),
                centre: [round.centre[0] - start[0], round.centre[1] - start[1]],
                end: [end[0] - start[0], end[1] - start[1]],
                counter_clockwise: (to > from) == (round.sense > 0.0),
                turns,
                turn: Some((machine.axes[axis].name.clone(), to - from)),
                feed_mm_per_min: feed * share,
            }
        })
        .collect()
}

/// One direction of a circle from the start of its run-in: arcs over run-in, arc and run-out, straight blocks where the
/// control draws no arc in that plane.
pub(super) fn circle(machine: &Machine, test: &Test, coordinates: &Coordinates, curves: Curves) -> Vec<Step> {
    let Some(Path::Circle { plane, radius_mm, .. }) = &test.path else { return Vec::new() };
    let Some((course, motion)) = whole(machine, test) else { return Vec::new() };
    let names = [plane.first, plane.second].map(|axis| machine.axes[axis].name.as_str());
    if curves == Curves::Plain && names == ["Z", "X"] {
        return straight_blocks(machine, test, coordinates, (&course, Curves::Plain), &motion);
    }
    let on = |deg: f64| [radius_mm * deg.to_radians().cos(), radius_mm * deg.to_radians().sin()];
    course
        .pieces(curves)
        .into_iter()
        .map(|Piece { from, to, turns }| {
            let (start, end) = (on(from), on(to));
            Step::Arc {
                axes: [plane.first, plane.second].map(|axis| machine.axes[axis].name.clone()),
                centre: [-start[0], -start[1]],
                end: [end[0] - start[0], end[1] - start[1]],
                counter_clockwise: course.to > course.from,
                turns,
                turn: None,
                feed_mm_per_min: test.feed(),
            }
        })
        .collect()
}

/// What the control reads, mm or deg, for the axes of a run: linear ones first.
fn place(machine: &Machine, coordinates: &Coordinates, moving: &[usize], row: &[f64]) -> Vec<(String, f64)> {
    let shown = |k: &usize| (machine.axes[*k].name.clone(), coordinates.reading(machine, *k, row[*k]));
    let is_linear = |k: &&usize| machine.axes[**k].kind == AxisKind::Linear;
    let (linear, rotary): (Vec<&usize>, Vec<&usize>) = moving.iter().partition(is_linear);
    linear.into_iter().chain(rotary).map(shown).collect()
}
