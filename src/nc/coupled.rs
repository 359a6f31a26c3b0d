//! Steps of runs in which several axes move: linear axes following a rotary one, and planar circles. Words and ways to them are `steps`'s.
//!
//! A following run is many short straight blocks, since no control draws that curve by itself, each with the time that it
//! takes (G93, FT): a feed in mm/min would mean something else on every control when a rotary axis moves along. A block is
//! so short that its chord keeps the bar's length to [`CHORD_MM`]; rows of the session lie on ends of blocks.

use super::{Coordinates, Step};
use crate::chain::{Chain, Geometry};
use crate::machine::{AxisKind, Machine};
use crate::plan::{PlannedTest, rows_with_run_in};
use crate::session::{CirclePlane, Motion, Path, Session, Spread, Test, way_mm};

/// Most that a chord may change the bar's length, mm: the resolution of a ball bar.
const CHORD_MM: f64 = 1e-4;
/// Longest arc of a circle in one block, deg: no control asks which way an end that is not the start is meant.
const ARC_DEG: f64 = 180.0;
/// Feed when a test states none, mm/min.
const FEED_MM_PER_MIN: f64 = 500.0;

/// One direction of a following run from the start of its run-in: rising, or falling.
pub(super) fn follow(machine: &Machine, planned: &PlannedTest, test: &Test, coordinates: &Coordinates) -> Vec<Step> {
    let Some(Path::Sweep { axis, from, to, step, follow }) = &test.path else { return Vec::new() };
    let radius_mm = planned.way_radius_mm.max(1.0);
    let finest_deg = (8.0 * CHORD_MM / radius_mm).sqrt().to_degrees();
    let feed = test.feed_mm_per_min.unwrap_or(FEED_MM_PER_MIN);
    let step_ms = step.to_radians() * radius_mm / feed * 60_000.0;
    let step = step / parts(step_ms, (step / finest_deg).ceil().max(1.0));
    let fine =
        Test { path: Some(Path::Sweep { axis: *axis, from: *from, to: *to, step, follow: *follow }), ..test.clone() };
    let (Some((ends, _)), Some((_, motion))) = (rows(machine, test), rows(machine, &fine)) else { return Vec::new() };
    let (Some(first), Some(last), Some(time_s)) = (ends.first(), ends.last(), &motion.time_s) else {
        return Vec::new();
    };
    let mut steps = Vec::new();
    let count = motion.rows();
    let chain = Chain::of(machine);
    let (Ok(links), geometry) = (test.links(&chain), Geometry::nominal(&chain)) else { return Vec::new() };
    let straight = |from: &[f64], to: &[f64]| Step::Move {
        to: place(machine, coordinates, to),
        minutes: way_mm(&geometry, test, links, from, to) / feed,
    };
    steps.push(straight(first, motion.row(0)));
    steps.extend((1..count).map(|row| Step::Move {
        to: place(machine, coordinates, motion.row(row)),
        minutes: (time_s[row] - time_s[row - 1]) / 60.0,
    }));
    steps.push(straight(motion.row(count - 1), last));
    steps
}

/// Into how many blocks a step of the session is cut: as many as the chord asks for or up to twice that, so that a block
/// takes hardly less than whole milliseconds. That is as fine as `FT` states a time, and it is rounded up.
fn parts(step_ms: f64, fewest: f64) -> f64 {
    let slower = |parts: f64| (step_ms / parts).ceil() * parts / step_ms;
    (0..=fewest as usize)
        .map(|more| fewest + more as f64)
        .min_by(|a, b| slower(*a).total_cmp(&slower(*b)))
        .unwrap_or(fewest)
}

/// One direction of a circle from the start of its run-in.
pub(super) fn circle(machine: &Machine, test: &Test, coordinates: &Coordinates) -> Vec<Step> {
    let Some(Path::Circle { plane, radius_mm, from, to, .. }) = &test.path else { return Vec::new() };
    let Some((ends, _)) = rows(machine, test) else { return Vec::new() };
    let [before, start, .., end, after] = ends.as_slice() else { return Vec::new() };
    let feed = test.feed_mm_per_min.unwrap_or(FEED_MM_PER_MIN);
    let straight = |from: &[f64], to: &[f64]| {
        let way = from.iter().zip(to).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        Step::Move { to: place(machine, coordinates, to), minutes: way / feed }
    };
    let mut steps = vec![straight(before, start)];
    let count = ((to - from).abs() / ARC_DEG).ceil().max(1.0) as usize;
    let at = |k: usize| (from + (to - from) * k as f64 / count as f64).to_radians();
    steps.extend((0..count).map(|k| arc(machine, plane, *radius_mm, at(k), at(k + 1), feed)));
    steps.push(straight(end, after));
    steps
}

fn arc(machine: &Machine, plane: &CirclePlane, radius_mm: f64, from: f64, to: f64, feed_mm_per_min: f64) -> Step {
    let on = |angle: f64| [radius_mm * angle.cos(), radius_mm * angle.sin()];
    let (start, end) = (on(from), on(to));
    Step::Arc {
        axes: [plane.first, plane.second].map(|axis| machine.axes[axis].name.clone()),
        centre: [-start[0], -start[1]],
        end: [end[0] - start[0], end[1] - start[1]],
        counter_clockwise: to > from,
        feed_mm_per_min,
    }
}

/// Rows with run-in and run-out, and the motion on the arc.
fn rows(machine: &Machine, test: &Test) -> Option<(Vec<Vec<f64>>, Motion)> {
    let session = Session {
        name: String::new(),
        machine_file: String::new(),
        machine: machine.clone(),
        spread: Spread::default(),
        tests: Vec::new(),
    };
    let motion = Motion::of(&session, &Chain::of(machine), test).ok()?;
    Some((rows_with_run_in(machine, test, &motion), motion)).filter(|(rows, _)| rows.len() >= 4)
}

/// What the control reads, mm or deg, for every axis that can move in a coupled run: all, so that nothing is left to modality.
fn place(machine: &Machine, coordinates: &Coordinates, row: &[f64]) -> Vec<(String, f64)> {
    let shown = |k: usize| (machine.axes[k].name.clone(), coordinates.reading(machine, k, row[k]));
    let linear = (0..row.len()).filter(|&k| machine.axes[k].kind == AxisKind::Linear);
    let rotary = (0..row.len()).filter(|&k| machine.axes[k].kind == AxisKind::Rotary);
    linear.chain(rotary).map(shown).collect()
}
