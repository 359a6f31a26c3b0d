//! The motion of a test as the machine makes it: run-in and run-out beyond the capture arc included. Straight in axis space.

use crate::machine::{AxisKind, Machine};
use crate::session::{Follow, Motion, Path, Test};

/// Run-in and run-out when a test states none, deg or mm.
pub const RUN_IN: f64 = 4.0;
/// What plans keep off a software limit, deg or mm: a control stops, or refuses the block, where it comes to stand on it.
pub const OFF_LIMIT: f64 = 0.1;

/// Rows of axis positions of a test with run-in and run-out, ends clamped to the ranges; a plain sweep has two rows.
pub fn rows_with_run_in(machine: &Machine, test: &Test, motion: &Motion) -> Vec<Vec<f64>> {
    let rows = motion.rows();
    if rows == 0 {
        return Vec::new();
    }
    let straight = test.recording.is_none() && matches!(test.path, Some(Path::Sweep { follow: Follow::None, .. }));
    let way: Vec<Vec<f64>> = match straight {
        true => vec![motion.row(0).to_vec(), motion.row(rows - 1).to_vec()],
        false => (0..rows).map(|row| motion.row(row).to_vec()).collect(),
    };
    if motion.time_s.is_none() {
        return way;
    }
    with_run_in(machine, way, test.overshoot.unwrap_or(RUN_IN))
}

/// A way with a straight run-in and run-out, ends clamped to the ranges.
pub(super) fn with_run_in(machine: &Machine, mut way: Vec<Vec<f64>>, run_in: f64) -> Vec<Vec<f64>> {
    if way.len() < 2 {
        return way;
    }
    let before = beyond(machine, &way[1], &way[0], run_in);
    let after = beyond(machine, &way[way.len() - 2], &way[way.len() - 1], run_in);
    way.insert(0, before);
    way.push(after);
    way
}

/// The straight line from `from` through `to` carried on until the fastest axis has gone `run_in` (deg or mm) farther.
fn beyond(machine: &Machine, from: &[f64], to: &[f64], run_in: f64) -> Vec<f64> {
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
    (0..to.len())
        .map(|k| {
            let q = to[k] + (to[k] - from[k]) * scale;
            machine.axes[k].range.map_or(q, |(low, high)| q.clamp(low.min(to[k]), high.max(to[k])))
        })
        .collect()
}
