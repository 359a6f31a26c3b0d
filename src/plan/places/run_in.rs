//! The motion of a test as the machine makes it: run-in and run-out beyond the capture arc included, on the path's own curve.

use crate::chain::Chain;
use crate::machine::{AxisKind, Machine};
use crate::session::{DEFAULT_RUN_IN, Follow, Motion, Path, RunEnd, Session, Spread, Test};

/// Run-in and run-out of planned tests, deg or mm.
pub const RUN_IN: f64 = DEFAULT_RUN_IN;
/// What plans keep off a software limit, deg or mm: a control stops, or refuses the block, where it comes to stand on it.
pub const OFF_LIMIT: f64 = 0.1;
/// Shortest capture arc worth running, deg.
pub const SHORTEST_DEG: f64 = 40.0;
/// The same as a part of an axis's travel, for one that travels little: a head that tilts by 30° to either side.
const SHORTEST_PART: f64 = 0.5;
/// A shorter arc hardly tells a shift of the pivot from a tilt, deg.
const SHORTEST_OF_ALL_DEG: f64 = 20.0;

/// Shortest capture arc of an axis, deg.
pub fn shortest_deg(machine: &Machine, axis: usize) -> f64 {
    let travel = machine.axes[axis].range.filter(|_| machine.axes[axis].kind == AxisKind::Rotary);
    let part = |(low, high): (f64, f64)| SHORTEST_PART * (high - low).to_degrees();
    travel.map_or(SHORTEST_DEG, |range| part(range).clamp(SHORTEST_OF_ALL_DEG, SHORTEST_DEG))
}

/// Readings of rotary axes that every control can write, deg: at 500 mm half of it is 0.4 um.
pub const GRID_DEG: f64 = 1e-4;

/// Rows of axis positions of a test with run-in and run-out, ends inside the ranges; a plain sweep has two rows.
pub fn rows_with_run_in(machine: &Machine, test: &Test, motion: &Motion) -> Vec<Vec<f64>> {
    let mut way = corners(test, motion);
    if motion.time_s.is_some()
        && let Some([start, end]) = ends(machine, test, motion, &way)
    {
        way.insert(0, start.at(start.run_in.kept));
        way.push(end.at(end.run_in.kept));
    }
    way
}

/// How far the run of a planned path goes beyond its first and last sample, deg or mm of the path; `None` for recordings.
pub fn beyond_path(machine: &Machine, test: &Test, motion: &Motion) -> Option<[f64; 2]> {
    test.path.as_ref().filter(|_| test.recording.is_none())?;
    let ends = ends(machine, test, motion, &corners(test, motion))?;
    Some(ends.map(|end| end.run_in.kept))
}

/// A run-in, or a run-out, that the range of an axis cuts short.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutRunIn {
    pub end: RunEnd,
    /// Axis, by index.
    pub axis: usize,
    /// Where the run-in was to begin, or the run-out to end, mm or rad.
    pub wanted: f64,
    /// The limit at which it does, mm or rad.
    pub limit: f64,
}

/// What ranges cut from the run-in and run-out of a test.
pub fn cut_run_ins(machine: &Machine, test: &Test, motion: &Motion) -> Vec<CutRunIn> {
    let (Some(_), Some(ends)) = (&motion.time_s, ends(machine, test, motion, &corners(test, motion))) else {
        return Vec::new();
    };
    let cut = |side: RunEnd, end: &End| -> Vec<CutRunIn> {
        let wanted = end.at(end.run_in.wanted);
        let here = end.at(0.0);
        let clamped = within_ranges(machine, &here, &wanted);
        let pairs = wanted.into_iter().zip(clamped).enumerate();
        let all = pairs.map(|(axis, (wanted, limit))| CutRunIn { end: side, axis, wanted, limit });
        all.filter(|cut| (cut.wanted - cut.limit).abs() > HAIR).collect()
    };
    let [start, end] = &ends;
    [cut(RunEnd::Start, start), cut(RunEnd::End, end)].concat()
}

/// Rounding of positions in files, mm or rad.
const HAIR: f64 = 1e-7;

/// How far a run goes on beyond its arc, deg or mm of the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RunIn {
    /// Until the fastest axis has gone so far as the run-in asks.
    pub wanted: f64,
    /// What the ranges leave of it.
    pub kept: f64,
}

/// Way, deg or mm of the path, over which the speed of the axes at the end of an arc is taken.
const NEXT: f64 = 1e-3;
/// Halvings by which a run-in is fitted into the ranges: 4 mm to a nanometre.
const HALVINGS: usize = 32;

impl RunIn {
    /// A run-in on a path whose positions `beyond` its end, deg or mm of the path, are given; zero is the end itself.
    pub fn of(machine: &Machine, run_in: f64, beyond: &dyn Fn(f64) -> Vec<f64>) -> RunIn {
        let (end, next) = (beyond(0.0), beyond(NEXT));
        let rate = |k: usize| machine.axes[k].kind.to_file_unit((next[k] - end[k]).abs()) / NEXT;
        let fastest = (0..end.len()).map(rate).fold(0.0, f64::max);
        if fastest == 0.0 {
            return RunIn { wanted: 0.0, kept: 0.0 };
        }
        let wanted = run_in / fastest;
        let inside = |reach: f64| {
            let at = beyond(reach);
            at == within_ranges(machine, &end, &at)
        };
        if inside(wanted) {
            return RunIn { wanted, kept: wanted };
        }
        let (mut kept, mut outside) = (0.0, wanted);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (kept + outside);
            if inside(middle) { kept = middle } else { outside = middle }
        }
        RunIn { wanted, kept }
    }
}

/// The last place on the way from an end, deg, that a program can write in full, and no farther than `kept`: where the slides
/// follow a long lever, a rotary digit that is lost bends the bar over the whole run.
pub(super) fn written(end: f64, way: f64, kept: f64) -> f64 {
    // a place that is one but for rounding stays
    let steps = (way * (end + way * kept) / GRID_DEG + 1e-6).floor();
    (steps * GRID_DEG - way * end).max(0.0)
}

/// One end of a run: what lies beyond it.
struct End {
    run_in: RunIn,
    /// Positions by the way beyond the end.
    beyond: Box<dyn Fn(f64) -> Vec<f64>>,
}

impl End {
    fn at(&self, reach: f64) -> Vec<f64> {
        (self.beyond)(reach)
    }
}

/// Start and end of a run; `None` for a single row.
fn ends(machine: &Machine, test: &Test, motion: &Motion, way: &[Vec<f64>]) -> Option<[End; 2]> {
    let ([first, second, ..], [.., before, last]) = (way, way) else { return None };
    let run_in = test.run_in();
    let planned = test.path.as_ref().filter(|_| test.recording.is_none());
    let curve = planned.filter(|path| !matches!(path, Path::Sweep { follow: Follow::None, .. }));
    let end = |beyond: Box<dyn Fn(f64) -> Vec<f64>>| End { run_in: RunIn::of(machine, run_in, &beyond), beyond };
    if let Some(path) = curve {
        let ([from, to], rows) = (path.ends(), motion.rows());
        let way = (to - from).signum();
        return Some([(from, -way, 0), (to, way, rows - 1)].map(|(from, way, row)| {
            let (session, test) = (bare_session(machine), test.clone());
            let (path, here) = (path.clone(), motion.row(row).to_vec());
            let turns = matches!(path, Path::Sweep { .. });
            let mut end = end(Box::new(move |reach: f64| {
                let test = Test { path: Some(path.between(from, from + way * reach)), ..test.clone() };
                let on = Motion::of(&session, &Chain::of(&session.machine), &test).ok();
                on.filter(|on| on.rows() > 1).map_or_else(|| here.clone(), |on| on.row(on.rows() - 1).to_vec())
            }));
            if turns {
                end.run_in.kept = written(from, way, end.run_in.kept);
            }
            end
        }));
    }
    // deg or mm of the fastest axis
    let straight = |from: &[f64], to: &[f64]| {
        let (from, to) = (from.to_vec(), to.to_vec());
        let step = |k: usize| machine.axes[k].kind.to_file_unit((to[k] - from[k]).abs());
        let fastest = (0..to.len()).map(step).fold(0.0, f64::max);
        let scale = if fastest > 0.0 { 1.0 / fastest } else { 0.0 };
        end(Box::new(move |reach: f64| (0..to.len()).map(|k| to[k] + (to[k] - from[k]) * scale * reach).collect()))
    };
    Some([straight(second, first), straight(before, last)])
}

/// A session of a machine without tests: what the motion of a test is computed in.
pub fn bare_session(machine: &Machine) -> Session {
    Session {
        name: String::new(),
        machine_file: String::new(),
        machine: machine.clone(),
        spread: Spread::default(),
        tests: Vec::new(),
    }
}

/// Rows of a test's motion between which it is straight.
fn corners(test: &Test, motion: &Motion) -> Vec<Vec<f64>> {
    let rows = motion.rows();
    let straight = test.recording.is_none() && matches!(test.path, Some(Path::Sweep { follow: Follow::None, .. }));
    match straight && rows > 0 {
        true => vec![motion.row(0).to_vec(), motion.row(rows - 1).to_vec()],
        false => (0..rows).map(|row| motion.row(row).to_vec()).collect(),
    }
}

/// What lies beyond the end of a run, kept inside the ranges.
fn within_ranges(machine: &Machine, end: &[f64], beyond: &[f64]) -> Vec<f64> {
    let clamped = |k: usize| {
        machine.axes[k].range.map_or(beyond[k], |(low, high)| beyond[k].clamp(low.min(end[k]), high.max(end[k])))
    };
    (0..end.len()).map(clamped).collect()
}
