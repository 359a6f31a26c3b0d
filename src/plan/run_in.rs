//! The motion of a test as the machine makes it: run-in and run-out beyond the capture arc included. Straight in axis space.

use crate::machine::{AxisKind, Machine};
use crate::session::{Follow, Motion, Path, Test};

/// Run-in and run-out when a test states none, deg or mm.
pub const RUN_IN: f64 = 4.0;
/// What plans keep off a software limit, deg or mm: a control stops, or refuses the block, where it comes to stand on it.
pub const OFF_LIMIT: f64 = 0.1;

/// Rows of axis positions of a test with run-in and run-out, ends clamped to the ranges; a plain sweep has two rows.
pub fn rows_with_run_in(machine: &Machine, test: &Test, motion: &Motion) -> Vec<Vec<f64>> {
    let way = corners(test, motion);
    match motion.time_s {
        Some(_) => with_run_in(machine, way, test.overshoot.unwrap_or(RUN_IN)),
        None => way,
    }
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

/// An end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RunEnd {
    Start,
    End,
}

/// What ranges cut from the run-in and run-out of a test.
pub fn cut_run_ins(machine: &Machine, test: &Test, motion: &Motion) -> Vec<CutRunIn> {
    let way = corners(test, motion);
    let (Some(_), [first, second, ..], [.., before, last]) = (&motion.time_s, &way[..], &way[..]) else {
        return Vec::new();
    };
    let run_in = test.overshoot.unwrap_or(RUN_IN);
    let cut = |end: RunEnd, from: &[f64], to: &[f64]| -> Vec<CutRunIn> {
        let wanted = straight_on(machine, from, to, run_in);
        let clamped = within_ranges(machine, to, &wanted);
        let pairs = wanted.into_iter().zip(clamped).enumerate();
        let all = pairs.map(|(axis, (wanted, limit))| CutRunIn { end, axis, wanted, limit });
        all.filter(|cut| (cut.wanted - cut.limit).abs() > HAIR).collect()
    };
    [cut(RunEnd::Start, second, first), cut(RunEnd::End, before, last)].concat()
}

/// Rounding of positions in files, mm or rad.
const HAIR: f64 = 1e-7;

/// Rows of a test's motion between which it is straight.
fn corners(test: &Test, motion: &Motion) -> Vec<Vec<f64>> {
    let rows = motion.rows();
    let straight = test.recording.is_none() && matches!(test.path, Some(Path::Sweep { follow: Follow::None, .. }));
    match straight && rows > 0 {
        true => vec![motion.row(0).to_vec(), motion.row(rows - 1).to_vec()],
        false => (0..rows).map(|row| motion.row(row).to_vec()).collect(),
    }
}

/// A way with a straight run-in and run-out, ends clamped to the ranges.
pub(super) fn with_run_in(machine: &Machine, mut way: Vec<Vec<f64>>, run_in: f64) -> Vec<Vec<f64>> {
    if way.len() < 2 {
        return way;
    }
    let beyond = |from: &[f64], to: &[f64]| within_ranges(machine, to, &straight_on(machine, from, to, run_in));
    let before = beyond(&way[1], &way[0]);
    let after = beyond(&way[way.len() - 2], &way[way.len() - 1]);
    way.insert(0, before);
    way.push(after);
    way
}

/// The straight line from `from` through `to` carried on until the fastest axis has gone `run_in` (deg or mm) farther.
fn straight_on(machine: &Machine, from: &[f64], to: &[f64], run_in: f64) -> Vec<f64> {
    let step = |k: usize| {
        let axis = &machine.axes[k];
        let unit = if axis.kind == AxisKind::Rotary { 1f64.to_radians() } else { 1.0 };
        ((to[k] - from[k]) / unit).abs()
    };
    let fastest = (0..to.len()).map(step).fold(0.0, f64::max);
    if fastest == 0.0 {
        return to.to_vec();
    }
    let scale = run_in / fastest;
    (0..to.len()).map(|k| to[k] + (to[k] - from[k]) * scale).collect()
}

/// What lies beyond the end of a run, kept inside the ranges.
fn within_ranges(machine: &Machine, end: &[f64], beyond: &[f64]) -> Vec<f64> {
    let clamped = |k: usize| {
        machine.axes[k].range.map_or(beyond[k], |(low, high)| beyond[k].clamp(low.min(end[k]), high.max(end[k])))
    };
    (0..end.len()).map(clamped).collect()
}
