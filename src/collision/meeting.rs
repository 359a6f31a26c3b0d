//! Which bodies can meet over the whole travel of the axes between them: certified by halving ranges of positions. It knows no instrument.
//!
//! From the middle of a box of positions, where two sets are d apart, no pose of the box brings them nearer than d − m, when
//! no point of one moves by more than m relative to the other. Seen from one set, axis by axis outward from it with half
//! ranges h: a linear axis adds h, a rotary one min(h, 2)·(r + m so far), r being the largest distance of the set from its
//! line in the middle. The smaller m of both sets counts. Boxes that this does not certify are halved where most is moved.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

use super::distance::{distance, penetration};
use super::frames::Frames;
use super::world::World;
use crate::machine::{AxisKind, Machine};

/// Solids nearer than this are in contact, mm: coordinates in files are rounded to it.
const CONTACT_MM: f64 = 1e-3;
/// Poses looked at for parts with one joint between: sets half a metre off the line, apart by a hundredth of the margin.
const POSES_ONE_JOINT: usize = 20_000;
/// Poses looked at for parts with several joints between: what is certified at all mostly is so within a hundred.
const POSES_SEVERAL: usize = 300;
/// Poses looked at for all parts with several joints between: a tenth of a second.
const POSES_IN_ALL: usize = 200_000;
/// Places of one joint among which the deepest contact is sought.
const PLACES: usize = 361;

/// Two bodies that meet.
#[derive(Debug, Clone, PartialEq)]
pub struct Meeting {
    pub pair: (String, String),
    /// Axes between the two, and where they stand there, mm or rad.
    pub at: Vec<(usize, f64)>,
    /// Depth of the overlap, mm; zero for contact.
    pub depth_mm: f64,
}

/// What halving found of two parts.
enum Over {
    /// They stay farther apart than the limit.
    Apart,
    /// Positions of all axes at which they are not.
    Near(Vec<f64>),
    /// Neither, with the poses allowed.
    Open,
}

/// A box of positions of the axes between two parts.
struct Cell {
    mm: f64,
    middle: Vec<f64>,
    half: Vec<f64>,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Cell) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Cell {}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Cell) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cell {
    /// The nearest pose is the greatest: it is looked at first.
    fn cmp(&self, other: &Cell) -> Ordering {
        other.mm.total_cmp(&self.mm)
    }
}

impl World {
    /// The world without the pairs that no choice of poses could bring nearer than `margin_mm`, wherever the axes stand in
    /// their ranges, or take farther: a gap by design that one joint never closes is not the plan's to widen.
    pub fn without_settled_pairs(&self, machine: &Machine, margin_mm: f64) -> World {
        let mut poses = POSES_IN_ALL;
        let mut settled = |&(one, other): &(usize, usize)| {
            let mut stays_beyond =
                |limit_mm| matches!(self.over_travel(one, other, machine, limit_mm, &mut poses), Over::Apart);
            stays_beyond(margin_mm)
                || self.most_apart(one, other, machine).is_some_and(|most_mm| most_mm < margin_mm + CONTACT_MM)
                    && stays_beyond(CONTACT_MM)
        };
        let pairs = self.pairs.iter().copied().filter(|pair| !settled(pair)).collect();
        World { pairs, ..self.clone() }
    }

    /// Pairs of bodies that overlap or touch with all axes at zero; where zero is out of an axis's range, the pair never stands there.
    pub fn meetings_at_zero(&self, machine: &Machine) -> Vec<Meeting> {
        let mut frames = Frames::default();
        let zero = vec![0.0; self.chain().axis_count()];
        let mut found = Vec::new();
        for &(one, other) in &self.pairs {
            let axes = self.linkage.axes_from(self.parts[one].frame, self.parts[other].frame);
            let stands = |&axis: &usize| machine.axes[axis].range.is_none_or(|(low, high)| low <= 0.0 && high >= 0.0);
            if axes.iter().all(stands) && self.apart(one, other, &zero, &mut frames) < CONTACT_MM {
                keep_deepest(&mut found, self.meeting(one, other, &zero, &mut frames));
            }
        }
        found
    }

    /// `Err` says which pairs touch or overlap with all axes at zero, and what to do.
    pub fn refuse_overlaps(&self, machine: &Machine) -> Result<(), String> {
        let overlaps = self.meetings_at_zero(machine);
        if overlaps.is_empty() {
            return Ok(());
        }
        let told = |found: &Meeting| format!("{} – {} by {:.1} mm", found.pair.0, found.pair.1, found.depth_mm);
        let told: Vec<String> = overlaps.iter().map(told).collect();
        let listed: Vec<String> =
            overlaps.iter().map(|found| format!("[{}, {}]", found.pair.0, found.pair.1)).collect();
        Err(format!(
            "bodies overlap with all axes at zero: {}; mend their places and sizes, or, where a bearing or guideway joins them, write 'touching: [{}]'",
            told.join(", "),
            listed.join(", ")
        ))
    }

    /// `Err` names a pair that touches somewhere and is nowhere farther apart than the margin, and what to do.
    pub fn refuse_always_near(&self, machine: &Machine, margin_mm: f64) -> Result<(), String> {
        for &(one, other) in &self.pairs {
            let Some(most_mm) = self.most_apart(one, other, machine).filter(|most_mm| *most_mm < margin_mm) else {
                continue;
            };
            if !matches!(self.over_travel(one, other, machine, CONTACT_MM, &mut 0), Over::Apart) {
                let (one, other) = (&self.parts[one].name, &self.parts[other].name);
                return Err(format!(
                    "{one} – {other} can touch and are nowhere more than {most_mm:.1} mm apart, while {margin_mm} mm are to stay free: mend their places and sizes, ask for a smaller margin, or, where a bearing or guideway joins them, write 'touching: [[{one}, {other}]]'"
                ));
            }
        }
        Ok(())
    }

    /// Pairs of bodies that one joint connects and that meet somewhere on its travel, each with its deepest place.
    pub fn meetings_by_one_axis(&self, machine: &Machine) -> Vec<Meeting> {
        let mut frames = Frames::default();
        let mut found = Vec::new();
        for &(one, other) in &self.pairs {
            let &[axis] = self.linkage.axes_between(self.parts[one].frame, self.parts[other].frame) else { continue };
            let over = self.over_travel(one, other, machine, CONTACT_MM, &mut 0);
            let (Over::Near(mut positions), Some((low, high))) = (over, self.span(axis, machine)) else { continue };
            keep_deepest(&mut found, self.meeting(one, other, &positions, &mut frames));
            for k in 0..PLACES {
                positions[axis] = low + (high - low) * k as f64 / (PLACES - 1) as f64;
                if self.apart(one, other, &positions, &mut frames) < CONTACT_MM {
                    keep_deepest(&mut found, self.meeting(one, other, &positions, &mut frames));
                }
            }
        }
        found
    }

    /// Pairs of bodies that several joints connect and that can meet, each with some place; what a short search does not find is left out.
    pub fn meetings_by_several_axes(&self, machine: &Machine) -> Vec<Meeting> {
        let mut frames = Frames::default();
        let mut poses = POSES_IN_ALL;
        let mut found = Vec::new();
        for &(one, other) in &self.pairs {
            if self.linkage.axes_between(self.parts[one].frame, self.parts[other].frame).len() > 1
                && let Over::Near(positions) = self.over_travel(one, other, machine, CONTACT_MM, &mut poses)
            {
                keep_deepest(&mut found, self.meeting(one, other, &positions, &mut frames));
            }
        }
        found
    }

    /// Largest distance that the one joint between two parts brings about, at places over its travel, mm; `None` for several joints.
    fn most_apart(&self, one: usize, other: usize, machine: &Machine) -> Option<f64> {
        let &[axis] = self.linkage.axes_between(self.parts[one].frame, self.parts[other].frame) else { return None };
        let (low, high) = self.span(axis, machine)?;
        let mut frames = Frames::default();
        let mut positions = vec![0.0; self.chain().axis_count()];
        let at = |k: usize| {
            positions[axis] = low + (high - low) * k as f64 / (PLACES - 1) as f64;
            self.apart(one, other, &positions, &mut frames)
        };
        Some((0..PLACES).map(at).fold(f64::MIN, f64::max))
    }

    /// Positions that show all poses of an axis, mm or rad; `None` for a linear axis without limits.
    fn span(&self, axis: usize, machine: &Machine) -> Option<(f64, f64)> {
        match (self.chain().joint(axis).kind, machine.axes[axis].range) {
            (AxisKind::Linear, range) => range,
            (AxisKind::Rotary, None) => Some((-PI, PI)),
            (AxisKind::Rotary, Some((low, high))) if high - low <= 2.0 * PI => Some((low, high)),
            (AxisKind::Rotary, Some((low, high))) if low <= -PI && high >= PI => Some((-PI, PI)),
            (AxisKind::Rotary, Some((low, _))) => Some((low, low + 2.0 * PI)),
        }
    }

    fn apart(&self, one: usize, other: usize, positions: &[f64], frames: &mut Frames) -> f64 {
        self.linkage.place(positions, frames);
        let (one, other) = (&self.parts[one], &self.parts[other]);
        distance(&one.convex, &frames.poses[one.frame], &other.convex, &frames.poses[other.frame])
    }

    fn meeting(&self, one: usize, other: usize, positions: &[f64], frames: &mut Frames) -> Meeting {
        let mm = self.apart(one, other, positions, frames);
        let (one, other) = (&self.parts[one], &self.parts[other]);
        let (pose, other_pose) = (&frames.poses[one.frame], &frames.poses[other.frame]);
        let depth_mm = penetration(&one.convex, pose, &other.convex, other_pose).unwrap_or(0.0).max(-mm).max(0.0);
        let mut at: Vec<usize> = self.linkage.axes_between(one.frame, other.frame).to_vec();
        at.sort_unstable();
        Meeting {
            pair: (one.name.clone(), other.name.clone()),
            at: at.into_iter().map(|axis| (axis, positions[axis])).collect(),
            depth_mm,
        }
    }

    /// Whether two parts come nearer than the limit anywhere in the ranges; `poses` is what all pairs of several axes may still take.
    fn over_travel(&self, one: usize, other: usize, machine: &Machine, limit_mm: f64, poses: &mut usize) -> Over {
        let (frame, other_frame) = (self.parts[one].frame, self.parts[other].frame);
        let axes = self.linkage.axes_between(frame, other_frame);
        let Some(spans) = axes.iter().map(|&axis| self.span(axis, machine)).collect::<Option<Vec<_>>>() else {
            return Over::Open;
        };
        let most = if axes.len() == 1 { POSES_ONE_JOINT } else { POSES_SEVERAL.min(*poses) };
        let outward = [self.linkage.axes_from(frame, other_frame), self.linkage.axes_from(other_frame, frame)];
        let mut frames = Frames::default();
        let mut positions = vec![0.0; self.chain().axis_count()];
        let mut half_of = vec![0.0; positions.len()];
        let mut looked_at = 0;
        let mut cells = BinaryHeap::new();
        let mut next = vec![Cell {
            mm: f64::MAX,
            middle: spans.iter().map(|(low, high)| 0.5 * (low + high)).collect(),
            half: spans.iter().map(|(low, high)| 0.5 * (high - low)).collect(),
        }];
        let over = loop {
            for mut cell in next.drain(..) {
                axes.iter().zip(&cell.middle).for_each(|(&axis, &middle)| positions[axis] = middle);
                axes.iter().zip(&cell.half).for_each(|(&axis, &half)| half_of[axis] = half);
                cell.mm = self.apart(one, other, &positions, &mut frames);
                looked_at += 1;
                if cell.mm <= limit_mm {
                    return Over::Near(positions);
                }
                let moves = [one, other].into_iter().zip(&outward);
                let moves = moves.map(|(part, axes)| self.moves_mm(part, axes, &half_of, &frames));
                if cell.mm - moves.fold(f64::MAX, f64::min) <= limit_mm {
                    cells.push(cell);
                }
            }
            if looked_at > most {
                break Over::Open;
            }
            let Some(cell) = cells.pop() else { break Over::Apart };
            axes.iter().zip(&cell.middle).for_each(|(&axis, &middle)| positions[axis] = middle);
            self.linkage.place(&positions, &mut frames);
            let moves = |k: usize| {
                half_of.fill(0.0);
                half_of[axes[k]] = cell.half[k];
                self.moves_mm(one, &outward[0], &half_of, &frames).min(self.moves_mm(
                    other,
                    &outward[1],
                    &half_of,
                    &frames,
                ))
            };
            let moved: Vec<f64> = (0..axes.len()).map(moves).collect();
            let Some(widest) = (0..axes.len()).max_by(|&a, &b| moved[a].total_cmp(&moved[b])) else { break Over::Open };
            next.extend([-0.5, 0.5].map(|side| {
                let (mut middle, mut half) = (cell.middle.clone(), cell.half.clone());
                middle[widest] += side * half[widest];
                half[widest] *= 0.5;
                Cell { mm: f64::MAX, middle, half }
            }));
        };
        if axes.len() > 1 {
            *poses -= looked_at.min(*poses);
        }
        over
    }

    /// Largest way of a point of a part relative to the link beyond `axes` (the nearest first), from the poses in `frames`, mm.
    fn moves_mm(&self, part: usize, axes: &[usize], half_of: &[f64], frames: &Frames) -> f64 {
        let part = &self.parts[part];
        let centre = frames.poses[part.frame].point(&part.convex.centre);
        let reach = part.convex.reach_mm();
        let mut moved = 0.0;
        for &axis in axes {
            let joint = self.chain().joint(axis);
            if joint.kind == AxisKind::Linear {
                moved += half_of[axis];
                continue;
            }
            let carried = &frames.poses[self.frame(self.chain().carried_by(axis))];
            let about = carried.rotation * joint.direction;
            let off_line = about.cross(&(centre - carried.point(&joint.origin))).norm();
            let along = frames.poses[part.frame].rotation * part.convex.rotation.column(2);
            if moved == 0.0 && off_line < 1e-9 && part.convex.is_round() && along.cross(&about).norm() < 1e-12 {
                continue;
            }
            moved += half_of[axis].min(2.0) * (off_line + reach + moved);
        }
        moved
    }
}

/// Of each pair of bodies, the deepest meeting is kept.
fn keep_deepest(found: &mut Vec<Meeting>, meeting: Meeting) {
    match found.iter_mut().find(|known| known.pair == meeting.pair) {
        Some(known) if known.depth_mm < meeting.depth_mm => *known = meeting,
        Some(_) => {}
        None => found.push(meeting),
    }
}
