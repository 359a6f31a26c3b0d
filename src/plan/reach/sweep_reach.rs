//! How far an axis sweeps before something comes too close: coarse search, bisection, then a certified check. One candidate at a time.

use crate::collision::{Scene, Scratch, certify, sweep_clearance};
use crate::machine::Machine;
use crate::plan::places::candidate::Candidate;
use crate::plan::places::run_in::{RUN_IN, shortest_deg};

/// An arc certified clear with its run-in at the margin asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct ClearArc {
    /// Capture arc, whole degrees.
    pub from_deg: f64,
    pub to_deg: f64,
    /// Pair that ends the sweep at either side, if it is not the axis's range.
    pub ends: [Option<(String, String)>; 2],
}

/// A clear arc with its least clearance.
#[derive(Debug, Clone, PartialEq)]
pub struct ClearSweep {
    /// Capture arc, whole degrees.
    pub from_deg: f64,
    pub to_deg: f64,
    /// Least clearance over arc and run-in, mm.
    pub clearance_mm: f64,
    pub pair: (String, String),
    /// Pair that ends the sweep at either side, if it is not the axis's range.
    pub ends: [Option<(String, String)>; 2],
}

/// Step of the coarse search, deg.
const COARSE_DEG: f64 = 5.0;
/// Resolution of the least clearance reported, mm: with the rounding to 0.01 mm it is right to 0.05.
const TOLERANCE_MM: f64 = 0.04;

/// The least clearance over the rows of a clear arc: it takes as long as finding the arc, so only what is planned is measured.
pub fn measured(scene: &Scene, arc: &ClearArc, rows: &[Vec<f64>], scratch: &mut Scratch) -> ClearSweep {
    let least = sweep_clearance(scene, rows, TOLERANCE_MM, scratch);
    let ClearArc { from_deg, to_deg, ends } = arc.clone();
    ClearSweep { from_deg, to_deg, clearance_mm: least.mm, pair: least.pair, ends }
}

/// Longest certified sweep within the candidate's arc (the run-in lies outside), or what forbids one.
pub fn longest_sweep(
    scene: &Scene,
    machine: &Machine,
    candidate: &Candidate,
    margin_mm: f64,
    scratch: &mut Scratch,
) -> Result<ClearArc, (String, String)> {
    let close =
        |deg: f64, scratch: &mut Scratch| scene.closer_than(&candidate.pose(deg.to_radians()), margin_mm, scratch);
    let nearest = |deg: f64, scratch: &mut Scratch| scene.clearance(&candidate.pose(deg.to_radians()), scratch).pair;
    let (low, high) = (candidate.from.to_degrees() - RUN_IN, candidate.to.to_degrees() + RUN_IN);
    let count = ((high - low) / COARSE_DEG).ceil().max(1.0);
    let step = (high - low) / count;
    let at = |k: usize| low + step * k as f64;
    let count = count as usize;
    // most setups that fail do so nearly everywhere
    let probes = 5;
    if (0..=probes).all(|k| close(at(count * k / probes), scratch)) {
        return Err(nearest(at(count / 2), scratch));
    }
    let (mut best, mut start): (Option<(usize, usize)>, Option<usize>) = (None, None);
    for k in 0..=count {
        match (close(at(k), scratch), start) {
            (false, None) => start = Some(k),
            (true, Some(_)) => start = None,
            _ => {}
        }
        if let Some(first) = start
            && best.is_none_or(|(a, b)| k - first > b - a)
        {
            best = Some((first, k));
        }
    }
    let Some((first, last)) = best else { return Err(nearest(at(count / 2), scratch)) };
    let mut ends = [None, None];
    let edge = |inside: f64, outside: f64, scratch: &mut Scratch| {
        let (mut inside, mut outside) = (inside, outside);
        while (outside - inside).abs() > 0.2 {
            let middle = 0.5 * (inside + outside);
            if close(middle, scratch) { outside = middle } else { inside = middle }
        }
        (inside, outside)
    };
    let (mut a, mut b) = (at(first), at(last));
    if first > 0 {
        let (inside, outside) = edge(a, at(first - 1), scratch);
        a = inside;
        ends[0] = Some(nearest(outside, scratch));
    }
    if last < count {
        let (inside, outside) = edge(b, at(last + 1), scratch);
        b = inside;
        ends[1] = Some(nearest(outside, scratch));
    }
    // what stands between two coarse samples shortens the arc to the longer side
    for _ in 0..6 {
        let (from_deg, to_deg) = ((a + RUN_IN - 1e-9).ceil() + 0.0, (b - RUN_IN + 1e-9).floor() + 0.0);
        if to_deg - from_deg < shortest_deg(machine, candidate.axis) {
            break;
        }
        let (rows, angles) = candidate.rows(machine, from_deg, to_deg);
        match certify(scene, &rows, margin_mm, scratch) {
            Ok(_) => return Ok(ClearArc { from_deg, to_deg, ends }),
            Err(hit) => {
                let deg = angle_at(&angles, hit.at_row);
                if deg - a > b - deg {
                    b = beyond_hit(deg, -1.0, a, |deg| close(deg, scratch));
                    ends[1] = Some(hit.pair);
                } else {
                    a = beyond_hit(deg, 1.0, b, |deg| close(deg, scratch));
                    ends[0] = Some(hit.pair);
                }
            }
        }
    }
    Err(ends.into_iter().flatten().next().unwrap_or_else(|| nearest(0.5 * (a + b), scratch)))
}

/// The first place beyond a hit where nothing is close, a degree at a time: certifying costs a hundred poses.
fn beyond_hit(hit: f64, step: f64, end: f64, mut close: impl FnMut(f64) -> bool) -> f64 {
    let mut deg = hit + step;
    while (end - deg) * step > 0.0 && close(deg) {
        deg += step;
    }
    deg
}

/// The path's angle at a place between two rows, deg.
fn angle_at(angles: &[f64], at_row: f64) -> f64 {
    let row = (at_row as usize).min(angles.len().saturating_sub(2));
    match angles.get(row..row + 2) {
        Some([before, after]) => before + (after - before) * (at_row - row as f64),
        _ => angles.first().copied().unwrap_or(0.0),
    }
}
