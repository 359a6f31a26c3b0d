//! Which links of a robot description are bed, workpiece and tool: named by the user or found by name. No poses.

use super::tree::Tree;
use crate::load::LoadError;
use crate::load::checked_text::message::did_you_mean;

/// Links named by the user; those not named are found by name.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LinkChoice {
    /// The bed; otherwise the link that nothing carries.
    pub root: Option<String>,
    /// Where the pivot stands; otherwise a link called workpiece, work, table, …
    pub workpiece: Option<String>,
    /// What carries the spindle ball; otherwise a link called tool0, tool, spindle, …
    pub tool: Option<String>,
}

impl LinkChoice {
    /// True when no link is named.
    pub fn is_empty(&self) -> bool {
        *self == LinkChoice::default()
    }
}

/// Names under which a tool link is found, the first one present taken.
const TOOL_NAMES: [&str; 9] =
    ["tool", "tool0", "tcp", "tool_link", "spindle", "spindle_link", "flange", "ee_link", "end_effector"];
/// Names under which a workpiece link is found.
const WORKPIECE_NAMES: [&str; 5] = ["workpiece", "workpiece_link", "work", "table", "table_link"];

/// The ends of the chain, each as joints from the root.
pub struct Ends {
    pub workpiece_link: String,
    pub tool_link: String,
    /// Joints from the root to the workpiece link.
    pub workpiece: Vec<usize>,
    /// Joints from the root to the tool link.
    pub tool: Vec<usize>,
    /// Fixed joints between the root and the bed: the bed's frame is R.
    pub below_bed: Vec<usize>,
}

impl Ends {
    /// Chooses the ends of a tree.
    pub fn of(tree: &Tree, choice: &LinkChoice) -> Result<Ends, LoadError> {
        let below_bed = bed(tree, choice)?;
        let known = |option: &str, name: &Option<String>| match name {
            Some(name) => link(tree, option, name).map(Some),
            None => Ok(None),
        };
        let tool = known("--tool-link", &choice.tool)?.or_else(|| found(tree, &TOOL_NAMES));
        let workpiece = known("--workpiece-link", &choice.workpiece)?.or_else(|| found(tree, &WORKPIECE_NAMES));
        // ends of branches that move and are not spoken for
        let loose = |other: Option<&str>| -> Vec<&str> {
            let other_path = other.and_then(|link| tree.path(link)).unwrap_or_default();
            let moves = |link: &str| {
                let path = tree.path(link).unwrap_or_default();
                let own: Vec<usize> = path.into_iter().filter(|joint| tree.joints[*joint].moves()).collect();
                !own.is_empty() && !own.iter().any(|joint| other_path.contains(joint))
            };
            tree.leaves().into_iter().filter(|link| moves(link)).collect()
        };
        let tool = match tool {
            Some(tool) => tool,
            None => match loose(workpiece)[..] {
                [only] => only,
                _ => return Err(unnamed(tree, "tool", "--tool-link", &TOOL_NAMES)),
            },
        };
        let workpiece = match workpiece {
            Some(workpiece) => workpiece,
            None => match loose(Some(tool))[..] {
                // the pivot stands on the ground beside a robot
                [] => choice.root.as_deref().and_then(|root| link(tree, "--root-link", root).ok()).unwrap_or(tree.root),
                [only] => only,
                _ => return Err(unnamed(tree, "workpiece", "--workpiece-link", &WORKPIECE_NAMES)),
            },
        };
        Ok(Ends {
            workpiece_link: workpiece.to_string(),
            tool_link: tool.to_string(),
            workpiece: tree.path(workpiece).unwrap_or_default(),
            tool: tree.path(tool).unwrap_or_default(),
            below_bed,
        })
    }
}

/// Fixed joints between the root and the bed.
fn bed(tree: &Tree, choice: &LinkChoice) -> Result<Vec<usize>, LoadError> {
    let Some(name) = &choice.root else { return Ok(Vec::new()) };
    let path = tree.path(link(tree, "--root-link", name)?).unwrap_or_default();
    match path.iter().find(|&&joint| tree.joints[joint].moves()) {
        None => Ok(path),
        Some(&joint) => Err(LoadError::line(
            tree.file,
            tree.joints[joint].element.line,
            format!(
                "link '{name}' cannot be the bed: joint '{}' moves it; the bed is the root link '{}' or fixed to it",
                tree.joints[joint].joint.name, tree.root
            ),
        )),
    }
}

fn link<'a>(tree: &Tree<'a>, option: &str, name: &str) -> Result<&'a str, LoadError> {
    tree.links.iter().copied().find(|link| *link == name).ok_or_else(|| {
        let hint = did_you_mean(name, &tree.links);
        LoadError::file(
            tree.file,
            format!("no link is called '{name}' ({option}){hint} (links: {})", tree.links.join(" ")),
        )
    })
}

fn found<'a>(tree: &Tree<'a>, names: &[&str]) -> Option<&'a str> {
    names.iter().find_map(|name| tree.links.iter().copied().find(|link| link.eq_ignore_ascii_case(name)))
}

fn unnamed(tree: &Tree, role: &str, option: &str, names: &[&str]) -> LoadError {
    LoadError::file(
        tree.file,
        format!(
            "which link is the {role} is not clear; name it with {option} or call it {} (links: {})",
            names.join(", "),
            tree.links.join(" ")
        ),
    )
}
