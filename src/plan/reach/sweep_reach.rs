//! How far an axis sweeps before something comes too close: coarse search, bisection, then a certified check. One candidate at a time.
//!
//! Samples cost a quarter of certifying, and no certified arc is longer than the sampled one: a search ranks by samples and
//! certifies what it is about to take.

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

/// The longest arc without a close sample, run-in included: no clear arc is longer, but for what lies between samples.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SampledArc {
    from_deg: f64,
    to_deg: f64,
    /// Pair that ends it at either side, if it is not the axis's range.
    ends: [Option<(String, String)>; 2],
}

impl SampledArc {
    /// The capture arc that is left of it, whole degrees.
    pub fn capture_deg(&self) -> (f64, f64) {
        ((self.from_deg + RUN_IN - 1e-9).ceil() + 0.0, (self.to_deg - RUN_IN + 1e-9).floor() + 0.0)
    }

    /// True when no pair ends it.
    pub fn is_whole(&self) -> bool {
        self.ends.iter().all(Option::is_none)
    }

    /// The pair that makes it too short.
    fn forbidding(self, scene: &Scene, candidate: &Candidate, scratch: &mut Scratch) -> (String, String) {
        let middle_deg = 0.5 * (self.from_deg + self.to_deg);
        self.ends.into_iter().flatten().next().unwrap_or_else(|| nearest(scene, candidate, middle_deg, scratch))
    }

    fn is_too_short(&self, machine: &Machine, candidate: &Candidate) -> bool {
        let (from_deg, to_deg) = self.capture_deg();
        to_deg - from_deg < shortest_deg(machine, candidate.axis)
    }
}

fn is_close(scene: &Scene, candidate: &Candidate, deg: f64, margin_mm: f64, scratch: &mut Scratch) -> bool {
    scene.closer_than(&candidate.pose(deg.to_radians()), margin_mm, scratch)
}

fn nearest(scene: &Scene, candidate: &Candidate, deg: f64, scratch: &mut Scratch) -> (String, String) {
    scene.clearance(&candidate.pose(deg.to_radians()), scratch).pair
}

/// The longest arc of samples that are clear, its ends to 0.2°, or what forbids one.
pub(crate) fn sampled_sweep(
    scene: &Scene,
    machine: &Machine,
    candidate: &Candidate,
    margin_mm: f64,
    scratch: &mut Scratch,
) -> Result<SampledArc, (String, String)> {
    let close = |deg: f64, scratch: &mut Scratch| is_close(scene, candidate, deg, margin_mm, scratch);
    let nearest = |deg: f64, scratch: &mut Scratch| nearest(scene, candidate, deg, scratch);
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
    let mut arc = SampledArc { from_deg: at(first), to_deg: at(last), ends: [None, None] };
    let edge = |inside: f64, outside: f64, scratch: &mut Scratch| {
        let (mut inside, mut outside) = (inside, outside);
        while (outside - inside).abs() > 0.2 {
            let middle = 0.5 * (inside + outside);
            if close(middle, scratch) { outside = middle } else { inside = middle }
        }
        (inside, outside)
    };
    if first > 0 {
        let (inside, outside) = edge(arc.from_deg, at(first - 1), scratch);
        arc.from_deg = inside;
        arc.ends[0] = Some(nearest(outside, scratch));
    }
    if last < count {
        let (inside, outside) = edge(arc.to_deg, at(last + 1), scratch);
        arc.to_deg = inside;
        arc.ends[1] = Some(nearest(outside, scratch));
    }
    match arc.is_too_short(machine, candidate) {
        true => Err(arc.forbidding(scene, candidate, scratch)),
        false => Ok(arc),
    }
}

/// The longest certified sweep within a sampled arc: what stands between two samples shortens it to the longer side.
pub(crate) fn certified_sweep(
    scene: &Scene,
    machine: &Machine,
    candidate: &Candidate,
    mut arc: SampledArc,
    margin_mm: f64,
    scratch: &mut Scratch,
) -> Result<ClearArc, (String, String)> {
    for _ in 0..6 {
        if arc.is_too_short(machine, candidate) {
            break;
        }
        let (from_deg, to_deg) = arc.capture_deg();
        let (rows, angles) = candidate.rows(machine, from_deg, to_deg);
        match certify(scene, &rows, margin_mm, scratch) {
            Ok(_) => return Ok(ClearArc { from_deg, to_deg, ends: arc.ends }),
            Err(hit) => {
                let deg = angle_at(&angles, hit.at_row);
                let close = |deg| is_close(scene, candidate, deg, margin_mm, scratch);
                if deg - arc.from_deg > arc.to_deg - deg {
                    arc.to_deg = beyond_hit(deg, -1.0, arc.from_deg, close);
                    arc.ends[1] = Some(hit.pair);
                } else {
                    arc.from_deg = beyond_hit(deg, 1.0, arc.to_deg, close);
                    arc.ends[0] = Some(hit.pair);
                }
            }
        }
    }
    Err(arc.forbidding(scene, candidate, scratch))
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
