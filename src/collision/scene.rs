//! The machine with an instrument at one pose: the least clearance and whether anything is closer than asked. Sweeps are in `sweep`.

use nalgebra::{Matrix3, Vector3};

use super::convex::{Core, half_box};
use super::distance::{distance_in_link, penetration};
use super::frames::Frames;
use super::world::{Part, World};
use crate::chain::Pose;

/// What one test adds: instrument parts and their pairs.
#[derive(Debug, Clone)]
pub struct Scene<'a> {
    pub(super) world: &'a World,
    pub(super) parts: Vec<Part>,
    /// Every pair that may collide; indices of `parts`.
    pub(super) pairs: Vec<(usize, usize)>,
    /// Views that the pairs need: part seen in frame.
    views: Vec<(usize, usize)>,
    /// For each pair: index of the view of its second part in the first part's frame.
    view_of: Vec<usize>,
    pub(super) bar: Option<BarEnds>,
    pub(super) cones: Vec<Cone>,
}

/// Balls of the bar: frames and places.
#[derive(Debug, Clone, PartialEq)]
pub struct BarEnds {
    pub pivot: (usize, Vector3<f64>),
    pub spindle: (usize, Vector3<f64>),
}

/// The cone in which a cup lets the bar swivel.
#[derive(Debug, Clone, PartialEq)]
pub struct Cone {
    pub name: &'static str,
    /// Frame of the cup.
    pub frame: usize,
    /// From the cup outward, unit length, in the frame.
    pub axis: Vector3<f64>,
    /// Half angle, rad.
    pub half_angle_rad: f64,
    /// True when the cup is the pivot's: the bar leaves it towards the spindle ball.
    pub at_pivot: bool,
    /// Distance from the ball at which cup and bar would meet, mm: turns angles into clearances.
    pub lever_mm: f64,
}

/// The least clearance at a pose and between whom.
#[derive(Debug, Clone, PartialEq)]
pub struct Clearance {
    /// Negative by the depth of the overlap, mm.
    pub mm: f64,
    pub pair: (String, String),
}

/// Working memory of the queries; keep one per thread.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    pub(super) frames: Frames,
    views: Vec<(Vector3<f64>, Vector3<f64>, f64)>,
    relative: Vec<Option<(Matrix3<f64>, Vector3<f64>)>>,
    bounds: Vec<f64>,
    /// Reference point of a mover, axis, lever in mm per rad or mm; the second one seen from the other body.
    pub(super) levers: Vec<(usize, usize, [f64; 2])>,
}

impl World {
    /// A scene without instrument.
    pub fn scene(&self) -> Scene<'_> {
        Scene::new(self, Vec::new(), Vec::new(), None, Vec::new())
    }
}

impl<'a> Scene<'a> {
    /// The world with instrument parts; `added` pairs refer to world parts first, then `instrument`.
    pub(super) fn new(
        world: &'a World,
        instrument: Vec<Part>,
        added: Vec<(usize, usize)>,
        bar: Option<BarEnds>,
        cones: Vec<Cone>,
    ) -> Scene<'a> {
        let mut parts = world.parts.clone();
        parts.extend(instrument);
        let mut pairs = world.pairs.clone();
        pairs.extend(added);
        // the part with the plainer box is looked at from the other's frame
        for pair in &mut pairs {
            if matches!(parts[pair.1].convex.core, Core::Hull { .. }) {
                *pair = (pair.1, pair.0);
            }
        }
        let mut views: Vec<(usize, usize)> = Vec::new();
        let view_of = pairs
            .iter()
            .map(|&(i, j)| {
                let view = (parts[i].frame, j);
                views.iter().position(|other| *other == view).unwrap_or_else(|| {
                    views.push(view);
                    views.len() - 1
                })
            })
            .collect();
        Scene { world, parts, pairs, views, view_of, bar, cones }
    }

    /// The world with parts of any instrument: `pairs` refer to world parts first, then `parts`; cups have no cones. The
    /// bench of this room and its test build their bar by it.
    pub fn with_parts(
        world: &'a World,
        parts: Vec<Part>,
        pairs: Vec<(usize, usize)>,
        bar: Option<BarEnds>,
    ) -> Scene<'a> {
        Scene::new(world, parts, pairs, bar, Vec::new())
    }

    /// Moves the pivot ball and the parts that stand with it: instrument part and its centre relative to the ball, mm.
    /// The bench of this room and its test go from pose to pose by it.
    pub fn move_pivot(&mut self, pivot: &Vector3<f64>, parts: &[(usize, Vector3<f64>)]) {
        if let Some(bar) = &mut self.bar {
            bar.pivot.1 = *pivot;
        }
        let first = self.world.parts.len();
        for (part, offset) in parts {
            self.parts[first + part].convex.centre = pivot + offset;
        }
    }

    /// Names of a pair's parts.
    pub(super) fn names(&self, pair: (usize, usize)) -> (String, String) {
        (self.parts[pair.0].name.clone(), self.parts[pair.1].name.clone())
    }

    /// All parts: machine bodies first.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Pairs that may collide, as indices of [`Scene::parts`].
    pub fn pairs(&self) -> &[(usize, usize)] {
        &self.pairs
    }

    /// Outline of a part seen along a direction, as a polygon in the plane of `right` and `up` of the bed frame, mm.
    pub fn outline(&self, part: usize, frames: &[Pose], right: &Vector3<f64>, up: &Vector3<f64>) -> Vec<[f64; 2]> {
        const CORNERS: usize = 48;
        let part = &self.parts[part];
        let pose = &frames[part.frame];
        (0..CORNERS)
            .map(|k| {
                let (s, c) = (std::f64::consts::TAU * k as f64 / CORNERS as f64).sin_cos();
                let toward = right * c + up * s;
                let own = part.convex.rotation.tr_mul(&pose.rotation.tr_mul(&toward));
                let in_link = part.convex.centre + part.convex.rotation * part.convex.core.support(&own);
                let point = pose.point(&in_link) + toward * part.convex.round_mm;
                [point.dot(right), point.dot(up)]
            })
            .collect()
    }

    /// Poses of all frames, the bar's last when there is one.
    pub fn frames<'s>(&self, positions: &[f64], scratch: &'s mut Scratch) -> &'s [Pose] {
        self.place(positions, scratch);
        &scratch.frames.poses
    }

    pub(super) fn place(&self, positions: &[f64], scratch: &mut Scratch) {
        self.world.linkage.place(positions, &mut scratch.frames);
        self.place_bar(scratch);
    }

    /// The bar's frame after the links'.
    fn place_bar(&self, scratch: &mut Scratch) {
        let Some(bar) = &self.bar else { return };
        let frames = &mut scratch.frames.poses;
        let from = frames[bar.pivot.0].point(&bar.pivot.1);
        let way = frames[bar.spindle.0].point(&bar.spindle.1) - from;
        let axis = way.try_normalize(1e-12).unwrap_or_else(Vector3::z);
        frames.push(Pose { rotation: crate::bodies::frame_along(&axis), translation_mm: from });
    }

    /// Places what one pair needs: the links, and the bar where it is of the pair.
    pub(super) fn place_pair(&self, index: usize, positions: &[f64], scratch: &mut Scratch) {
        self.world.linkage.place(positions, &mut scratch.frames);
        let (one, other) = self.pairs[index];
        let bar = self.world.frame_count();
        if self.parts[one].frame == bar || self.parts[other].frame == bar {
            self.place_bar(scratch);
        }
    }

    /// Places the links alone.
    pub(super) fn place_links(&self, positions: &[f64], scratch: &mut Scratch) {
        self.world.linkage.place(positions, &mut scratch.frames);
    }

    /// Least clearance over all pairs at a pose, cones included.
    pub fn clearance(&self, positions: &[f64], scratch: &mut Scratch) -> Clearance {
        let (mm, pair) = self.least(positions, scratch);
        let mut clearance = match pair {
            Some(pair) => Clearance { mm, pair: self.names(pair) },
            None => Clearance { mm: f64::INFINITY, pair: (String::new(), String::new()) },
        };
        if let Some(pair) = pair.filter(|_| clearance.mm <= 0.0) {
            clearance.mm = self.signed(pair, scratch, clearance.mm);
        }
        for cone in &self.cones {
            let spare = cone.spare_mm(self.bar.as_ref(), &scratch.frames.poses);
            if spare < 0.0 && spare < clearance.mm {
                clearance = Clearance { mm: spare, pair: ("bar".into(), cone.name.into()) };
            }
        }
        clearance
    }

    /// The depth of an overlap in place of the roundings' share of it.
    pub(super) fn signed(&self, pair: (usize, usize), scratch: &Scratch, mm: f64) -> f64 {
        let (one, other) = (&self.parts[pair.0], &self.parts[pair.1]);
        let depth = penetration(
            &one.convex,
            &scratch.frames.poses[one.frame],
            &other.convex,
            &scratch.frames.poses[other.frame],
        );
        depth.map_or(mm, |depth| mm.min(-depth))
    }

    /// Least distance over all pairs (roundings overlapping count negative) and the pair; frames stay in `scratch`.
    pub fn least(&self, positions: &[f64], scratch: &mut Scratch) -> (f64, Option<(usize, usize)>) {
        self.place(positions, scratch);
        self.bounds(scratch);
        let mut best = f64::MAX;
        let mut nearest = None;
        while let Some((index, bound)) = lowest(&scratch.bounds) {
            if bound >= best {
                break;
            }
            scratch.bounds[index] = f64::MAX;
            let d = self.pair_distance(index, scratch, best);
            if d < best {
                best = d;
                nearest = Some(self.pairs[index]);
            }
        }
        (best, nearest)
    }

    /// True when some pair is closer than the limit, or a cone is left.
    pub fn closer_than(&self, positions: &[f64], limit_mm: f64, scratch: &mut Scratch) -> bool {
        self.place(positions, scratch);
        if self.cones.iter().any(|cone| cone.spare_mm(self.bar.as_ref(), &scratch.frames.poses) < 0.0) {
            return true;
        }
        self.bounds(scratch);
        while let Some((index, bound)) = lowest(&scratch.bounds) {
            if bound > limit_mm {
                return false;
            }
            scratch.bounds[index] = f64::MAX;
            if self.pair_distance(index, scratch, limit_mm + 1e-9) <= limit_mm {
                return true;
            }
        }
        false
    }

    /// Lower bounds of all pairs from boxes in the first part's frame; parts are placed before.
    fn bounds(&self, scratch: &mut Scratch) {
        let frames = scratch.frames.poses.len();
        scratch.relative.clear();
        scratch.relative.resize(frames * frames, None);
        scratch.views.clear();
        for &(frame, part) in &self.views {
            let part = &self.parts[part];
            let slot = frame * frames + part.frame;
            let (rotation, translation) = *scratch.relative[slot].get_or_insert_with(|| {
                let (seen_from, carried_by) = (&scratch.frames.poses[frame], &scratch.frames.poses[part.frame]);
                (
                    seen_from.rotation.tr_mul(&carried_by.rotation),
                    seen_from.rotation.tr_mul(&(carried_by.translation_mm - seen_from.translation_mm)),
                )
            });
            let half = half_seen(part, &rotation);
            scratch.views.push((rotation * part.convex.centre + translation, half, part.convex.round_mm));
        }
        scratch.bounds.clear();
        for (&(one, _), &view) in self.pairs.iter().zip(&self.view_of) {
            let (centre, half, round_mm) = &scratch.views[view];
            scratch.bounds.push(gap(&self.parts[one], centre, half, *round_mm));
        }
    }

    /// The second part's link seen from the first one's, parts placed.
    fn relative(&self, index: usize, scratch: &Scratch) -> (Matrix3<f64>, Vector3<f64>) {
        let (one, other) = self.pairs[index];
        let (seen_from, carried_by) =
            (&scratch.frames.poses[self.parts[one].frame], &scratch.frames.poses[self.parts[other].frame]);
        (
            seen_from.rotation.tr_mul(&carried_by.rotation),
            seen_from.rotation.tr_mul(&(carried_by.translation_mm - seen_from.translation_mm)),
        )
    }

    /// Distance of a pair with the parts placed; any value ≥ `limit_mm` when it is at least that.
    pub(super) fn pair_distance(&self, index: usize, scratch: &Scratch, limit_mm: f64) -> f64 {
        let (one, other) = self.pairs[index];
        let (one, other) = (&self.parts[one].convex, &self.parts[other].convex);
        let (rotation, translation) = self.relative(index, scratch);
        distance_in_link(one, other, &(rotation * other.rotation), &(rotation * other.centre + translation), limit_mm)
    }

    /// A lower bound of a pair's distance from boxes in the first part's frame, parts placed.
    pub(super) fn pair_bound(&self, index: usize, scratch: &Scratch) -> f64 {
        let (one, other) = self.pairs[index];
        let (one, other) = (&self.parts[one], &self.parts[other]);
        let (rotation, translation) = self.relative(index, scratch);
        let half = half_seen(other, &rotation);
        gap(one, &(rotation * other.convex.centre + translation), &half, other.convex.round_mm)
    }
}

/// Half edges of a part's box in a frame that sees the part's link turned by `rotation`; the rounding comes on top.
fn half_seen(part: &Part, rotation: &Matrix3<f64>) -> Vector3<f64> {
    match &part.convex.core {
        Core::Point => Vector3::zeros(),
        Core::Hull { .. } => rotation.abs() * part.half,
        core => half_box(core, &(rotation * part.convex.rotation)),
    }
}

/// Distance of a part's box from another box in the part's frame, roundings taken off, mm.
fn gap(one: &Part, centre: &Vector3<f64>, half: &Vector3<f64>, round_mm: f64) -> f64 {
    let gap = ((centre - one.convex.centre).abs() - half - one.half).sup(&Vector3::zeros());
    gap.norm() - round_mm - one.convex.round_mm
}

impl Cone {
    /// What is left of the cone at the present frames, mm at the lever.
    pub(super) fn spare_mm(&self, bar: Option<&BarEnds>, frames: &[Pose]) -> f64 {
        let Some(bar) = bar else { return f64::INFINITY };
        let pivot = frames[bar.pivot.0].point(&bar.pivot.1);
        let spindle = frames[bar.spindle.0].point(&bar.spindle.1);
        let way = if self.at_pivot { spindle - pivot } else { pivot - spindle };
        let axis = frames[self.frame].rotation * self.axis;
        let angle = axis.cross(&way).norm().atan2(axis.dot(&way));
        (self.half_angle_rad - angle) * self.lever_mm
    }
}

fn lowest(bounds: &[f64]) -> Option<(usize, f64)> {
    let mut best = (usize::MAX, f64::MAX);
    for (index, &bound) in bounds.iter().enumerate() {
        if bound < best.1 {
            best = (index, bound);
        }
    }
    (best.0 != usize::MAX).then_some(best)
}
