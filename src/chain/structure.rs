//! Structure of the kinematic chain: joints in two branches from the bed outward. Immutable; holds no error values and no positions.

use nalgebra::Vector3;

use super::link::{Branch, LinkId};
use crate::machine::{AxisKind, Machine};

/// One joint as the chain needs it.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Linear or rotary.
    pub kind: AxisKind,
    /// Direction of motion of the carried part where `sign` is positive, unit vector in R at the zero position.
    pub direction: Vector3<f64>,
    /// Point on the axis line, mm, in R at the zero position.
    pub origin: Vector3<f64>,
    /// +1 or −1 by the machine's sense of axes: the motion is `sign · position`.
    pub sign: f64,
}

/// Two branches of joints from the bed outward; axis indices are those of the machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    joints: Vec<Joint>,
    names: Vec<String>,
    /// Axis indices from the bed outward: workpiece branch, tool branch.
    branches: [Vec<usize>; 2],
    extra_links: Vec<(String, Option<usize>)>,
}

impl Chain {
    /// Compiles the nominal chain of a machine.
    pub fn of(machine: &Machine) -> Chain {
        let joints = machine
            .axes
            .iter()
            .enumerate()
            .map(|(index, axis)| Joint {
                kind: axis.kind,
                direction: axis.direction,
                origin: axis.origin,
                sign: machine.motion_sign(index),
            })
            .collect();
        let workpiece_axes = machine.code.workpiece_side.len();
        Chain {
            joints,
            names: machine.axes.iter().map(|axis| axis.name.clone()).collect(),
            branches: [(0..workpiece_axes).rev().collect(), (workpiece_axes..machine.axes.len()).collect()],
            extra_links: machine.link_names.clone(),
        }
    }

    /// Number of axes.
    pub fn axis_count(&self) -> usize {
        self.joints.len()
    }

    /// Joint of an axis.
    pub fn joint(&self, axis: usize) -> &Joint {
        &self.joints[axis]
    }

    /// Axis indices of a branch from the bed outward.
    pub fn branch(&self, branch: Branch) -> &[usize] {
        &self.branches[branch as usize]
    }

    /// Link by name: an axis, `b` (bed), `w` or `t` (ends of the branches), or an extra name of the machine.
    pub fn link(&self, name: &str) -> Option<LinkId> {
        match name {
            "b" => return Some(LinkId::BED),
            "w" => return Some(self.end(Branch::Workpiece)),
            "t" => return Some(self.end(Branch::Tool)),
            _ => {}
        }
        if let Some(axis) = self.names.iter().position(|other| other == name) {
            return Some(self.carried_by(axis));
        }
        let (_, axis) = self.extra_links.iter().find(|(other, _)| other == name)?;
        Some(axis.map_or(LinkId::BED, |axis| self.carried_by(axis)))
    }

    /// Names that [`Chain::link`] knows, for messages.
    pub fn link_names(&self) -> Vec<&str> {
        let mut names = vec!["b", "w", "t"];
        names.extend(self.names.iter().map(String::as_str));
        names.extend(self.extra_links.iter().map(|(name, _)| name.as_str()));
        names
    }

    /// Every link once, from the workpiece over the bed to the tool, under the name of the axis that carries it.
    pub fn links(&self) -> Vec<(&str, LinkId)> {
        let workpiece = self.branch(Branch::Workpiece).iter().rev();
        let carried = |axis: &usize| (self.names[*axis].as_str(), self.carried_by(*axis));
        let tool = self.branch(Branch::Tool).iter().map(carried);
        workpiece.map(carried).chain([("b", LinkId::BED)]).chain(tool).collect()
    }

    /// Last link of a branch.
    pub fn end(&self, branch: Branch) -> LinkId {
        LinkId { branch, depth: self.branches[branch as usize].len() }
    }

    /// Link that an axis carries.
    pub fn carried_by(&self, axis: usize) -> LinkId {
        for branch in [Branch::Workpiece, Branch::Tool] {
            if let Some(place) = self.branch(branch).iter().position(|&other| other == axis) {
                return LinkId { branch, depth: place + 1 };
            }
        }
        LinkId::BED
    }

    /// Axes between the bed and a link, from the bed outward.
    pub fn path(&self, link: LinkId) -> &[usize] {
        &self.branches[link.branch as usize][..link.depth]
    }

    /// True when the axis carries the link.
    pub fn carries(&self, axis: usize, link: LinkId) -> bool {
        self.path(link).contains(&axis)
    }
}
