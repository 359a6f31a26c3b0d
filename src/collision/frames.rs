//! Poses of all link frames of the nominal machine at some positions, with what is the same as before kept. It knows no solids.

use std::sync::atomic::{AtomicU64, Ordering};

use nalgebra::{Matrix3, Vector3};

use crate::chain::{Branch, Chain, LinkId, Pose};
use crate::machine::AxisKind;

/// Frames of a machine's links: the bed first, then the workpiece side, then the tool side from the bed outward.
#[derive(Debug, Clone)]
pub(super) struct Linkage {
    pub chain: Chain,
    /// Tells the poses kept in a [`Frames`] of one machine from those of another.
    id: u64,
    /// Axes between two frames, by `one * count + other`.
    between: Vec<Vec<usize>>,
}

/// Poses of the link frames at the last positions asked for.
#[derive(Debug, Clone, Default)]
pub(super) struct Frames {
    id: u64,
    positions: Vec<f64>,
    /// Motion of each joint.
    joints: Vec<Pose>,
    /// By frame; a frame that is no link's may follow.
    pub poses: Vec<Pose>,
}

/// Number of the last linkage made.
static LAST: AtomicU64 = AtomicU64::new(0);

impl Linkage {
    pub fn of(chain: &Chain) -> Linkage {
        let mut linkage =
            Linkage { chain: chain.clone(), id: LAST.fetch_add(1, Ordering::Relaxed) + 1, between: Vec::new() };
        let count = linkage.count();
        let pairs = (0..count).flat_map(|one| (0..count).map(move |other| (one, other)));
        linkage.between = pairs
            .map(|(one, other)| {
                let (one, other) = (chain.path(linkage.link(one)), chain.path(linkage.link(other)));
                let mut axes: Vec<usize> = one.iter().copied().filter(|axis| !other.contains(axis)).collect();
                axes.extend(other.iter().filter(|axis| !one.contains(axis)));
                axes
            })
            .collect();
        linkage
    }

    /// Number of link frames.
    pub fn count(&self) -> usize {
        1 + self.chain.axis_count()
    }

    /// Frame of a link.
    pub fn frame(&self, link: LinkId) -> usize {
        match (link.branch, link.depth) {
            (_, 0) => 0,
            (Branch::Workpiece, depth) => depth,
            (Branch::Tool, depth) => self.chain.branch(Branch::Workpiece).len() + depth,
        }
    }

    fn link(&self, frame: usize) -> LinkId {
        let workpiece = self.chain.branch(Branch::Workpiece).len();
        match frame <= workpiece {
            true => LinkId { branch: Branch::Workpiece, depth: frame },
            false => LinkId { branch: Branch::Tool, depth: frame - workpiece },
        }
    }

    /// Axes between two link frames.
    pub fn axes_between(&self, one: usize, other: usize) -> &[usize] {
        &self.between[one * self.count() + other]
    }

    /// Axes between two link frames, from the first one outward.
    pub fn axes_from(&self, one: usize, other: usize) -> Vec<usize> {
        let (one, other) = (self.chain.path(self.link(one)), self.chain.path(self.link(other)));
        let own = one.iter().rev().filter(|axis| !other.contains(axis));
        own.chain(other.iter().filter(|axis| !one.contains(axis))).copied().collect()
    }

    /// Poses at some positions, mm and rad; joints that stand where they stood are not computed again.
    pub fn place(&self, positions: &[f64], frames: &mut Frames) {
        let axes = self.chain.axis_count();
        if frames.id != self.id {
            // no position equals the kept one
            *frames = Frames {
                id: self.id,
                positions: vec![f64::NAN; axes],
                joints: vec![Pose::identity(); axes],
                poses: vec![Pose::identity(); self.count()],
            };
        }
        frames.poses.truncate(self.count());
        let mut frame = 0;
        for branch in [Branch::Workpiece, Branch::Tool] {
            let mut pose = Pose::identity();
            let mut is_moved = false;
            for &axis in self.chain.branch(branch) {
                frame += 1;
                if frames.positions[axis] != positions[axis] {
                    frames.positions[axis] = positions[axis];
                    frames.joints[axis] = self.motion(axis, positions[axis]);
                    is_moved = true;
                }
                if is_moved {
                    let joint = &frames.joints[axis];
                    let translation_mm = pose.point(&joint.translation_mm);
                    pose = Pose { rotation: pose.rotation * joint.rotation, translation_mm };
                    frames.poses[frame] = pose;
                } else {
                    pose = frames.poses[frame];
                }
            }
        }
    }

    fn motion(&self, axis: usize, position: f64) -> Pose {
        let joint = self.chain.joint(axis);
        let q = joint.sign * position;
        match joint.kind {
            AxisKind::Linear => Pose { rotation: Matrix3::identity(), translation_mm: joint.direction * q },
            AxisKind::Rotary => {
                let rotation = rotation_about(&joint.direction, q);
                Pose { rotation, translation_mm: joint.origin - rotation * joint.origin }
            }
        }
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
