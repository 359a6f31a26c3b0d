//! The joint tree of a robot description as urdf-rs read it, each joint with its place in the file. Names only; no poses.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use urdf_rs::{Joint, JointType, Robot};

use super::places::Element;
use crate::load::LoadError;
use crate::load::checked_text::message::did_you_mean;

/// Links and joints by name, checked to be one tree.
pub struct Tree<'a> {
    pub file: &'a Path,
    pub links: Vec<&'a str>,
    pub joints: Vec<Branchlet<'a>>,
    /// Index of the joint that carries a link.
    carried_by: BTreeMap<&'a str, usize>,
    /// Name of the link that nothing carries.
    pub root: &'a str,
}

/// A joint with its place in the file.
pub struct Branchlet<'a> {
    pub joint: &'a Joint,
    pub element: &'a Element,
    pub index_in_file: usize,
}

impl Branchlet<'_> {
    /// True for joints that move; fixed ones are folded into the poses.
    pub fn moves(&self) -> bool {
        self.joint.joint_type != JointType::Fixed
    }
}

impl<'a> Tree<'a> {
    /// Links and joints of `robot`; `elements` are the file's elements in its order.
    pub fn of(file: &'a Path, robot: &'a Robot, elements: &'a [Element]) -> Result<Tree<'a>, LoadError> {
        let top = |name: &'static str| {
            elements.iter().enumerate().filter(move |(_, element)| element.depth == 1 && element.name == name)
        };
        let mut links: Vec<&str> = Vec::with_capacity(robot.links.len());
        let mut names: BTreeSet<&str> = BTreeSet::new();
        for (link, (_, element)) in robot.links.iter().zip(top("link")) {
            if !names.insert(link.name.as_str()) {
                return Err(LoadError::line(
                    file,
                    element.line,
                    format!("link '{}' stands twice; each link has its own name", link.name),
                ));
            }
            links.push(&link.name);
        }
        let joints: Vec<Branchlet> = robot
            .joints
            .iter()
            .zip(top("joint"))
            .map(|(joint, (index_in_file, element))| Branchlet { joint, element, index_in_file })
            .collect();
        let mut tree = Tree { file, links, joints, carried_by: BTreeMap::new(), root: "" };
        tree.connect()?;
        Ok(tree)
    }

    fn connect(&mut self) -> Result<(), LoadError> {
        let mut names: BTreeSet<&str> = BTreeSet::new();
        let links: BTreeSet<&str> = self.links.iter().copied().collect();
        for (index, entry) in self.joints.iter().enumerate() {
            let joint = entry.joint;
            let refuse = |message: String| Err(LoadError::line(self.file, entry.element.line, message));
            if !names.insert(joint.name.as_str()) {
                return refuse(format!("joint '{}' stands twice; each joint has its own name", joint.name));
            }
            for (role, link) in [("parent", &joint.parent.link), ("child", &joint.child.link)] {
                if !links.contains(link.as_str()) {
                    let hint = did_you_mean(link, &self.links);
                    return refuse(format!(
                        "joint '{}' has the {role} '{link}', which is no link of the file{hint}",
                        joint.name
                    ));
                }
            }
            if let Some(other) = self.carried_by.insert(&joint.child.link, index) {
                return refuse(format!(
                    "link '{}' is carried by joint '{}' and by joint '{}': the joints form a loop; a link has one parent",
                    joint.child.link, self.joints[other].joint.name, joint.name
                ));
            }
        }
        let roots: Vec<&str> = self.links.iter().copied().filter(|link| !self.carried_by.contains_key(link)).collect();
        self.root = match roots[..] {
            [root] => root,
            [] => return Err(self.loop_refusal()),
            _ => {
                return Err(LoadError::file(
                    self.file,
                    format!(
                        "links {} hang on nothing; one root link is allowed, join the others to it by joints",
                        roots.join(", ")
                    ),
                ));
            }
        };
        // a loop apart from the root's tree
        match self.links.iter().find(|link| self.path(link).is_none()) {
            Some(_) => Err(self.loop_refusal()),
            None => Ok(()),
        }
    }

    fn loop_refusal(&self) -> LoadError {
        let in_loop = self.joints.iter().find(|entry| self.path(&entry.joint.child.link).is_none());
        match in_loop {
            Some(entry) => LoadError::line(
                self.file,
                entry.element.line,
                format!(
                    "joint '{}' is part of a loop that reaches no root link; a robot description is a tree, remove one joint of the loop",
                    entry.joint.name
                ),
            ),
            None => LoadError::file(self.file, "has no link; a robot description has links and joints"),
        }
    }

    /// Indices of the joints from the root to a link; `None` for a link in a loop.
    pub fn path(&self, link: &str) -> Option<Vec<usize>> {
        let mut path = Vec::new();
        let mut link = link;
        while let Some(&index) = self.carried_by.get(link) {
            if path.len() > self.joints.len() {
                return None;
            }
            path.push(index);
            link = &self.joints[index].joint.parent.link;
        }
        path.reverse();
        Some(path)
    }

    /// Links that carry nothing.
    pub fn leaves(&self) -> Vec<&'a str> {
        let carries = |link: &str| self.joints.iter().any(|entry| entry.joint.parent.link == link);
        self.links.iter().copied().filter(|link| !carries(link)).collect()
    }
}
