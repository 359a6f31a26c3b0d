//! Link poses, pairs that may collide, and the least clearance at one pose; sweeps are in `sweep`.

use nalgebra::{Matrix3, Vector3};

use super::convex::{Convex, half_box};
use super::distance::{distance_in_link, penetration};
use crate::bodies::Bodies;
use crate::chain::{Branch, Chain, LinkId, Pose};
use crate::machine::AxisKind;

/// Solids nearer than this with all axes at zero are taken to touch by design, mm.
const TOUCHES_MM: f64 = 0.5;

/// A convex part on a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    pub name: String,
    /// Index of the carrying frame: a link, or the bar.
    pub frame: usize,
    pub convex: Convex,
    /// Box in the frame: middle is the core's centre.
    pub(super) half: Vector3<f64>,
}

impl Part {
    /// A part with its box.
    pub fn new(name: impl Into<String>, frame: usize, convex: Convex) -> Part {
        let half = convex.half_box();
        Part { name: name.into(), frame, convex, half }
    }
}

/// Machine bodies beside the chain, with the pairs among them that may collide.
#[derive(Debug, Clone)]
pub struct World {
    pub(super) chain: Chain,
    pub(super) parts: Vec<Part>,
    /// Body (by index in `Bodies`) of each part: a mesh is several parts.
    pub(super) body_of: Vec<usize>,
    pub(super) pairs: Vec<(usize, usize)>,
    /// Pairs left out because they touch with all axes at zero, by name.
    pub touching: Vec<(String, String)>,
}

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
    pub(super) frames: Vec<Pose>,
    views: Vec<(Vector3<f64>, Vector3<f64>, f64)>,
    relative: Vec<Option<(Matrix3<f64>, Vector3<f64>)>>,
    bounds: Vec<f64>,
}

impl World {
    /// The machine's bodies; `Err` names a body whose link does not exist.
    pub fn new(chain: &Chain, bodies: &Bodies) -> Result<World, String> {
        let mut parts = Vec::new();
        let mut body_of = Vec::new();
        for (index, body) in bodies.bodies.iter().enumerate() {
            let link = chain
                .link(&body.link)
                .ok_or_else(|| format!("body '{}' is on link '{}', which the machine has not", body.name, body.link))?;
            for solid in &body.solids {
                let convex = Convex::of(solid, body.at.rotation, body.at.translation_mm);
                parts.push(Part::new(body.name.clone(), frame_of(chain, link), convex));
                body_of.push(index);
            }
        }
        let mut world = World { chain: chain.clone(), parts, body_of, pairs: Vec::new(), touching: Vec::new() };
        let mut frames = Vec::new();
        world.link_frames(&vec![0.0; chain.axis_count()], &mut frames);
        for i in 0..world.parts.len() {
            for j in i + 1..world.parts.len() {
                let (one, other) = (&world.parts[i], &world.parts[j]);
                if !world.may_meet(one.frame, other.frame) {
                    continue;
                }
                let at_zero = super::distance(&one.convex, &frames[one.frame], &other.convex, &frames[other.frame]);
                if at_zero < TOUCHES_MM {
                    world.touching.push((one.name.clone(), other.name.clone()));
                } else {
                    world.pairs.push((i, j));
                }
            }
        }
        Ok(world)
    }

    /// The chain beside which the world stands.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// Leaves machine bodies unchecked against each other, for when only the instrument is of interest.
    pub fn forget_machine_pairs(&mut self) {
        self.pairs.clear();
    }

    /// Number of parts of the machine; a scene's instrument parts follow them.
    pub fn part_count(&self) -> usize {
        self.parts.len()
    }

    /// Number of link frames; the bar's frame follows them.
    pub fn frame_count(&self) -> usize {
        1 + self.chain.axis_count()
    }

    /// Frame of a link.
    pub fn frame(&self, link: LinkId) -> usize {
        frame_of(&self.chain, link)
    }

    /// Two links that more than one joint separates.
    fn may_meet(&self, one: usize, other: usize) -> bool {
        self.axes_between(one, other).len() > 1
    }

    /// Axes between two link frames.
    pub(super) fn axes_between(&self, one: usize, other: usize) -> Vec<usize> {
        let path = |frame: usize| -> &[usize] { self.chain.path(link_of(&self.chain, frame)) };
        let (one, other) = (path(one), path(other));
        let mut axes: Vec<usize> = one.iter().copied().filter(|axis| !other.contains(axis)).collect();
        axes.extend(other.iter().filter(|axis| !one.contains(axis)));
        axes
    }

    /// Pose of every link of the nominal machine, into `frames`.
    pub(super) fn link_frames(&self, positions: &[f64], frames: &mut Vec<Pose>) {
        frames.clear();
        frames.resize(self.frame_count(), Pose::identity());
        for branch in [Branch::Workpiece, Branch::Tool] {
            let mut pose = Pose::identity();
            for (depth, &axis) in self.chain.branch(branch).iter().enumerate() {
                let joint = self.chain.joint(axis);
                let q = joint.sign * positions[axis];
                match joint.kind {
                    AxisKind::Linear => pose.translation_mm += pose.rotation * joint.direction * q,
                    AxisKind::Rotary => {
                        let turn = rotation_about(&joint.direction, q);
                        pose.translation_mm += pose.rotation * (joint.origin - turn * joint.origin);
                        pose.rotation *= turn;
                    }
                }
                frames[frame_of(&self.chain, LinkId { branch, depth: depth + 1 })] = pose;
            }
        }
    }

    /// A scene without instrument.
    pub fn scene(&self) -> Scene<'_> {
        Scene::new(self, Vec::new(), Vec::new(), None, Vec::new())
    }
}

/// Rotation matrix about a unit vector (Rodrigues).
fn rotation_about(u: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let (s, c) = angle.sin_cos();
    let v = 1.0 - c;
    Matrix3::new(
        c + u.x * u.x * v,
        u.x * u.y * v - u.z * s,
        u.x * u.z * v + u.y * s,
        u.y * u.x * v + u.z * s,
        c + u.y * u.y * v,
        u.y * u.z * v - u.x * s,
        u.z * u.x * v - u.y * s,
        u.z * u.y * v + u.x * s,
        c + u.z * u.z * v,
    )
}

fn frame_of(chain: &Chain, link: LinkId) -> usize {
    match (link.branch, link.depth) {
        (_, 0) => 0,
        (Branch::Workpiece, depth) => depth,
        (Branch::Tool, depth) => chain.branch(Branch::Workpiece).len() + depth,
    }
}

fn link_of(chain: &Chain, frame: usize) -> LinkId {
    let workpiece = chain.branch(Branch::Workpiece).len();
    if frame <= workpiece {
        LinkId { branch: Branch::Workpiece, depth: frame }
    } else {
        LinkId { branch: Branch::Tool, depth: frame - workpiece }
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
            if matches!(parts[pair.1].convex.core, super::convex::Core::Hull { .. }) {
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

    /// The world with parts of any instrument: `pairs` refer to world parts first, then `parts`; cups have no cones.
    pub fn with_parts(
        world: &'a World,
        parts: Vec<Part>,
        pairs: Vec<(usize, usize)>,
        bar: Option<BarEnds>,
    ) -> Scene<'a> {
        Scene::new(world, parts, pairs, bar, Vec::new())
    }

    /// Moves the pivot ball and the parts that stand with it: instrument part and its centre relative to the ball, mm.
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
        &scratch.frames
    }

    pub(super) fn place(&self, positions: &[f64], scratch: &mut Scratch) {
        self.world.link_frames(positions, &mut scratch.frames);
        if let Some(bar) = &self.bar {
            let from = scratch.frames[bar.pivot.0].point(&bar.pivot.1);
            let way = scratch.frames[bar.spindle.0].point(&bar.spindle.1) - from;
            let axis = way.try_normalize(1e-12).unwrap_or_else(Vector3::z);
            scratch.frames.push(Pose { rotation: crate::bodies::frame_along(&axis), translation_mm: from });
        }
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
            let spare = cone.spare_mm(self.bar.as_ref(), &scratch.frames);
            if spare < 0.0 && spare < clearance.mm {
                clearance = Clearance { mm: spare, pair: ("bar".into(), cone.name.into()) };
            }
        }
        clearance
    }

    /// The depth of an overlap in place of the roundings' share of it.
    pub(super) fn signed(&self, pair: (usize, usize), scratch: &Scratch, mm: f64) -> f64 {
        let (one, other) = (&self.parts[pair.0], &self.parts[pair.1]);
        let depth = penetration(&one.convex, &scratch.frames[one.frame], &other.convex, &scratch.frames[other.frame]);
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
        if self.cones.iter().any(|cone| cone.spare_mm(self.bar.as_ref(), &scratch.frames) < 0.0) {
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
        let frames = scratch.frames.len();
        scratch.relative.clear();
        scratch.relative.resize(frames * frames, None);
        scratch.views.clear();
        for &(frame, part) in &self.views {
            let part = &self.parts[part];
            let slot = frame * frames + part.frame;
            let (rotation, translation) = *scratch.relative[slot].get_or_insert_with(|| {
                let (seen_from, carried_by) = (&scratch.frames[frame], &scratch.frames[part.frame]);
                (
                    seen_from.rotation.tr_mul(&carried_by.rotation),
                    seen_from.rotation.tr_mul(&(carried_by.translation_mm - seen_from.translation_mm)),
                )
            });
            let half = match &part.convex.core {
                super::convex::Core::Point => Vector3::zeros(),
                super::convex::Core::Hull { .. } => rotation.abs() * part.half,
                core => half_box(core, &(rotation * part.convex.rotation)),
            };
            scratch.views.push((rotation * part.convex.centre + translation, half, part.convex.round_mm));
        }
        scratch.bounds.clear();
        for (&(one, _), &view) in self.pairs.iter().zip(&self.view_of) {
            let one = &self.parts[one];
            let (centre, half, round) = &scratch.views[view];
            let gap = ((centre - one.convex.centre).abs() - half - one.half).sup(&Vector3::zeros());
            scratch.bounds.push(gap.norm() - round - one.convex.round_mm);
        }
    }

    /// Distance of a pair with the parts placed; any value ≥ `limit_mm` when it is at least that.
    pub(super) fn pair_distance(&self, index: usize, scratch: &Scratch, limit_mm: f64) -> f64 {
        let (one, other) = self.pairs[index];
        let (one, other) = (&self.parts[one], &self.parts[other]);
        let (seen_from, carried_by) = (&scratch.frames[one.frame], &scratch.frames[other.frame]);
        let rotation = seen_from.rotation.tr_mul(&carried_by.rotation);
        let translation = seen_from.rotation.tr_mul(&(carried_by.translation_mm - seen_from.translation_mm));
        distance_in_link(
            &one.convex,
            &other.convex,
            &(rotation * other.convex.rotation),
            &(rotation * other.convex.centre + translation),
            limit_mm,
        )
    }
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
