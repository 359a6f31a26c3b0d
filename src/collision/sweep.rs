//! Certified clearance along a motion: conservative advancement on every pair. Poses in between are straight in axis space.
//!
//! Two sets at distance d cannot come closer than d − m after a motion in which no point of one moves by more than m
//! relative to the other. A rotary axis that turns by |Δq| moves a point at distance r from its line by at most |Δq|·r, a
//! linear axis by |Δq|; contributions of several axes add, with r taken larger by m where other axes move too. The bar lies
//! between its balls, so it moves by no more than the farther moving ball. From a pose with d the motion therefore goes on
//! unchecked until the sum reaches d − floor: nothing thinner than a sample step is missed.

use nalgebra::Vector3;

use super::convex::Core;
use super::instrument::CONE_MARGIN_RAD;
use super::scene::{Scene, Scratch};
use crate::machine::AxisKind;

/// Least clearance over a motion, within the tolerance asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepClearance {
    /// Least distance found, mm; the true one is at most the tolerance smaller. Negative on collision.
    pub mm: f64,
    pub pair: (String, String),
    /// Positions of all axes there, mm and rad.
    pub positions: Vec<f64>,
    /// Place along the motion: index of the row before plus fraction.
    pub at_row: f64,
    /// Poses evaluated over all pairs.
    pub evaluations: usize,
}

/// First place at which a pair comes closer than asked.
#[derive(Debug, Clone, PartialEq)]
pub struct Hit {
    pub mm: f64,
    pub pair: (String, String),
    pub positions: Vec<f64>,
    pub at_row: f64,
}

/// A motion certified clear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clear {
    /// Poses evaluated over all pairs.
    pub evaluations: usize,
}

/// How a set may move relative to another: one or two reference points with reach, on frames with the axes between.
struct Mover {
    /// (frame of the reference point, place, reach about it, axes to the other frame)
    points: Vec<(usize, Vector3<f64>, f64, Vec<usize>)>,
    /// The other set, when it may be the smaller lever: frame, centre, reach.
    other: Option<(usize, Vector3<f64>, f64)>,
}

/// A pair, or a cone that the bar must not leave.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Watch {
    Pair(usize),
    Cone(usize),
}

/// Least clearance over the polyline of axis positions `rows`, found within `tolerance_mm`.
///
/// A collision ends the search: `mm` is then negative by the depth at the place found, not the deepest one.
pub fn sweep_clearance(scene: &Scene, rows: &[Vec<f64>], tolerance_mm: f64, scratch: &mut Scratch) -> SweepClearance {
    let mut best = SweepClearance {
        mm: f64::INFINITY,
        pair: (String::new(), String::new()),
        positions: rows.first().cloned().unwrap_or_default(),
        at_row: 0.0,
        evaluations: 0,
    };
    // a good first minimum makes every later step longer
    for row in [0, rows.len() / 2, rows.len().saturating_sub(1)] {
        let Some(positions) = rows.get(row) else { return best };
        let here = scene.clearance(positions, scratch);
        if here.mm < best.mm {
            best = SweepClearance {
                mm: here.mm,
                pair: here.pair,
                positions: positions.clone(),
                at_row: row as f64,
                evaluations: best.evaluations,
            };
        }
    }
    let moving = moving_axes(rows);
    for watch in scene.watches() {
        let (mut row, mut fraction) = (0, 0.0);
        let mover = scene.mover(watch, &moving);
        if best.mm > 0.0 && scene.is_far(watch, &mover, rows, best.mm - tolerance_mm, scratch) {
            continue;
        }
        while best.mm > 0.0 {
            let target = best.mm - tolerance_mm;
            let positions = between(rows, row, fraction);
            let d = scene.watched(watch, &positions, scratch);
            best.evaluations += 1;
            let worse = match watch {
                Watch::Pair(_) => d < best.mm,
                Watch::Cone(_) => d < 0.0,
            };
            if worse {
                best.mm = d;
                best.pair = scene.watch_names(watch);
                best.at_row = row as f64 + fraction;
                if d <= 0.0
                    && let Watch::Pair(index) = watch
                {
                    best.mm = scene.signed(scene.pairs[index], scratch, d);
                }
                best.positions = positions;
                continue;
            }
            // a cone has no floor but its edge
            let slack = match watch {
                Watch::Pair(_) => d - target,
                Watch::Cone(_) => d.max(CONE_STEP_MM),
            };
            match advance(scene, &mover, rows, row, fraction, slack, scratch) {
                Some((next_row, next_fraction)) => (row, fraction) = (next_row, next_fraction),
                None => break,
            }
        }
    }
    best
}

/// The least that is left of the cones of both cups over a motion, margin included, rad; `None` without a bar. Found within
/// 0.02°: the shortest step seen from where bar and rim meet.
pub fn least_cone_rad(scene: &Scene, rows: &[Vec<f64>], scratch: &mut Scratch) -> Option<f64> {
    let moving = moving_axes(rows);
    let mut least: Option<f64> = None;
    for index in 0..scene.cones.len() {
        let watch = Watch::Cone(index);
        let mover = scene.mover(watch, &moving);
        let mut best = f64::INFINITY;
        let mut place = (!rows.is_empty()).then_some((0, 0.0));
        while let Some((row, fraction)) = place {
            let spare = scene.watched(watch, &between(rows, row, fraction), scratch);
            best = best.min(spare);
            place = advance(scene, &mover, rows, row, fraction, spare - best + CONE_STEP_MM, scratch);
        }
        let left = best / scene.cones[index].lever_mm + CONE_MARGIN_RAD;
        least = Some(least.map_or(left, |least| least.min(left)));
    }
    least.filter(|left| left.is_finite())
}

/// Shortest step when a bar lies at the edge of its cone, mm at the cup.
const CONE_STEP_MM: f64 = 0.01;
/// Shortest step when a pair lies at the limit, mm.
const SHORTEST_STEP_MM: f64 = 1e-3;

/// Certifies that no pair comes closer than `limit_mm` and no cone is left, or says where that happens first on some pair.
pub fn certify(scene: &Scene, rows: &[Vec<f64>], limit_mm: f64, scratch: &mut Scratch) -> Result<Clear, Hit> {
    let mut evaluations = 0;
    let moving = moving_axes(rows);
    for watch in scene.watches() {
        let (mut row, mut fraction) = (0, 0.0);
        let mover = scene.mover(watch, &moving);
        if scene.is_far(watch, &mover, rows, limit_mm, scratch) {
            continue;
        }
        loop {
            let positions = between(rows, row, fraction);
            let d = scene.watched(watch, &positions, scratch);
            evaluations += 1;
            let limit = match watch {
                Watch::Pair(_) => limit_mm,
                Watch::Cone(_) => 0.0,
            };
            if d < limit {
                let at_row = row as f64 + fraction;
                return Err(Hit { mm: d, pair: scene.watch_names(watch), positions, at_row });
            }
            match advance(scene, &mover, rows, row, fraction, (d - limit).max(SHORTEST_STEP_MM), scratch) {
                Some((next_row, next_fraction)) => (row, fraction) = (next_row, next_fraction),
                None => break,
            }
        }
    }
    Ok(Clear { evaluations })
}

/// Axes that move over the rows.
fn moving_axes(rows: &[Vec<f64>]) -> Vec<usize> {
    let Some(first) = rows.first() else { return Vec::new() };
    (0..first.len()).filter(|&axis| rows.iter().any(|row| row[axis] != first[axis])).collect()
}

/// Axis positions at a row and a fraction of the way to the next.
fn between(rows: &[Vec<f64>], row: usize, fraction: f64) -> Vec<f64> {
    match rows.get(row + 1) {
        Some(next) if fraction > 0.0 => rows[row].iter().zip(next).map(|(a, b)| a + (b - a) * fraction).collect(),
        _ => rows[row].clone(),
    }
}

/// The farthest place that a motion of at most `slack_mm` reaches; `None` when that is the end.
fn advance(
    scene: &Scene,
    mover: &Mover,
    rows: &[Vec<f64>],
    row: usize,
    fraction: f64,
    slack_mm: f64,
    scratch: &mut Scratch,
) -> Option<(usize, f64)> {
    scratch.levers.clear();
    for (point, (frame, at, reach, axes)) in mover.points.iter().enumerate() {
        let several = axes.len() > 1;
        for &axis in axes {
            let rotary = scene.world.linkage.chain.joint(axis).kind == AxisKind::Rotary;
            let grows_mm = if rotary && several { slack_mm } else { 0.0 };
            let own = scene.lever(axis, *frame, at, *reach, several, scratch) + grows_mm;
            let other = mover.other.as_ref().map_or(f64::INFINITY, |(frame, at, reach)| {
                scene.lever(axis, *frame, at, *reach, several, scratch) + grows_mm
            });
            scratch.levers.push((point, axis, [own, other]));
        }
    }
    let mut left = slack_mm;
    let (mut row, mut fraction) = (row, fraction);
    while row + 1 < rows.len() {
        // seen from either body alike; a sum of levers of both would not hold where several axes turn
        let mut moves = [[0.0; 2]; 2];
        for &(point, axis, [own, other]) in &scratch.levers {
            let step = (rows[row + 1][axis] - rows[row][axis]).abs();
            moves[point][0] += step * own;
            moves[point][1] += if step > 0.0 { step * other } else { 0.0 };
        }
        let [one, two] = moves.map(|[own, other]: [f64; 2]| own.min(other));
        let whole = one.max(two);
        let rest: f64 = whole * (1.0 - fraction);
        if rest > left {
            return Some((row, fraction + left / whole));
        }
        left -= rest;
        row += 1;
        fraction = 0.0;
    }
    None
}

impl Scene<'_> {
    fn watches(&self) -> impl Iterator<Item = Watch> {
        (0..self.pairs.len()).map(Watch::Pair).chain((0..self.cones.len()).map(Watch::Cone))
    }

    fn watch_names(&self, watch: Watch) -> (String, String) {
        match watch {
            Watch::Pair(index) => self.names(self.pairs[index]),
            Watch::Cone(index) => ("bar".into(), self.cones[index].name.into()),
        }
    }

    /// Distance of a pair or what is left of a cone, mm.
    fn watched(&self, watch: Watch, positions: &[f64], scratch: &mut Scratch) -> f64 {
        match watch {
            Watch::Pair(index) => {
                self.place_pair(index, positions, scratch);
                self.pair_distance(index, scratch, f64::MAX)
            }
            Watch::Cone(index) => {
                self.place_links(positions, scratch);
                self.cones[index].spare_mm(self.bar.as_ref(), &scratch.frames.poses)
            }
        }
    }

    /// True when the boxes of a pair are far enough apart at the first row for the whole motion; the boxes cost little.
    fn is_far(&self, watch: Watch, mover: &Mover, rows: &[Vec<f64>], limit_mm: f64, scratch: &mut Scratch) -> bool {
        let (Watch::Pair(index), Some(first)) = (watch, rows.first()) else { return false };
        self.place_pair(index, first, scratch);
        let slack_mm = self.pair_bound(index, scratch) - limit_mm;
        slack_mm > 0.0 && advance(self, mover, rows, 0, 0.0, slack_mm, scratch).is_none()
    }

    fn mover(&self, watch: Watch, moving: &[usize]) -> Mover {
        let between = |one: usize, other: usize| -> Vec<usize> {
            let axes = self.world.linkage.axes_between(one, other).iter();
            axes.copied().filter(|axis| moving.contains(axis)).collect()
        };
        let bar_frame = self.world.frame_count();
        match watch {
            Watch::Pair(index) => {
                let (one, other) = self.pairs[index];
                let (one, other) = (&self.parts[one], &self.parts[other]);
                let (mover, still) = if one.frame == bar_frame { (one, other) } else { (other, one) };
                if mover.frame == bar_frame {
                    let points = match &self.bar {
                        Some(bar) => [&bar.pivot, &bar.spindle]
                            .map(|(frame, at)| (*frame, *at, 0.0, between(*frame, still.frame)))
                            .to_vec(),
                        None => Vec::new(),
                    };
                    return Mover { points, other: None };
                }
                let axes = between(mover.frame, still.frame);
                Mover {
                    points: vec![(mover.frame, mover.convex.centre, mover.convex.reach_mm(), axes)],
                    other: Some((still.frame, still.convex.centre, still.convex.reach_mm())),
                }
            }
            Watch::Cone(index) => {
                let frame = self.cones[index].frame;
                let points = self.bar.iter().flat_map(|bar| [&bar.pivot, &bar.spindle]);
                let points = points.map(|(ball, at)| (*ball, *at, 0.0, between(*ball, frame))).collect();
                Mover { points, other: None }
            }
        }
    }

    /// Largest distance from the axis line of a set about a point of a frame, mm; 1 for linear axes (mm per mm).
    ///
    /// A solid of revolution that turns about its own axis does not move, unless another axis takes it off the line.
    fn lever(&self, axis: usize, frame: usize, at: &Vector3<f64>, reach: f64, several: bool, scratch: &Scratch) -> f64 {
        let joint = self.world.linkage.chain.joint(axis);
        if joint.kind == AxisKind::Linear {
            return 1.0;
        }
        let carried = &scratch.frames.poses[self.world.frame(self.world.linkage.chain.carried_by(axis))];
        let point = scratch.frames.poses[frame].point(at) - carried.point(&joint.origin);
        let about = carried.rotation * joint.direction;
        let off_line = about.cross(&point).norm();
        if !several && off_line < 1e-9 && reach > 0.0 && self.turns_in_itself(frame, at, &about, scratch) {
            return 0.0;
        }
        off_line + reach
    }

    /// True for a solid of revolution whose axis lies along `about` (its centre being on the line).
    fn turns_in_itself(&self, frame: usize, at: &Vector3<f64>, about: &Vector3<f64>, scratch: &Scratch) -> bool {
        self.parts.iter().filter(|part| part.frame == frame && part.convex.centre == *at).all(|part| {
            let axis = scratch.frames.poses[frame].rotation * part.convex.rotation.column(2);
            match part.convex.core {
                Core::Point => true,
                Core::Segment { .. } | Core::Cylinder { .. } => axis.cross(about).norm() < 1e-12,
                Core::Box { .. } | Core::Hull { .. } => false,
            }
        })
    }
}
