//! The machine's solids on its links and the pairs of them that may collide. Distances at a pose are the scene's, whole travels `meeting`'s.

use nalgebra::Vector3;

use super::convex::Convex;
use super::frames::Linkage;
use crate::bodies::Bodies;
use crate::chain::{Chain, LinkId};

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
    pub(super) linkage: Linkage,
    pub(super) parts: Vec<Part>,
    /// Body (by index in `Bodies`) of each part: a mesh is several parts.
    pub(super) body_of: Vec<usize>,
    /// All pairs of parts on different links, but for those of `touching`.
    pub(super) pairs: Vec<(usize, usize)>,
    /// Pairs left out because the machine file says that they touch by design, by name.
    pub touching: Vec<(String, String)>,
}

impl World {
    /// The machine's bodies; `Err` names a body whose link does not exist.
    pub fn new(chain: &Chain, bodies: &Bodies) -> Result<World, String> {
        let linkage = Linkage::of(chain);
        let mut parts = Vec::new();
        let mut body_of = Vec::new();
        for (index, body) in bodies.bodies.iter().enumerate() {
            let link = chain
                .link(&body.link)
                .ok_or_else(|| format!("body '{}' is on link '{}', which the machine has not", body.name, body.link))?;
            for solid in &body.solids {
                let convex = Convex::of(solid, body.at.rotation, body.at.translation_mm);
                parts.push(Part::new(body.name.clone(), linkage.frame(link), convex));
                body_of.push(index);
            }
        }
        let listed = |one: &str, other: &str| {
            bodies.touching.iter().any(|(a, b)| (a == one && b == other) || (a == other && b == one))
        };
        let count = parts.len();
        let pairs = (0..count).flat_map(|one| (one + 1..count).map(move |other| (one, other)));
        let pairs = pairs.filter(|&(one, other)| {
            let (one, other) = (&parts[one], &parts[other]);
            one.frame != other.frame && !listed(&one.name, &other.name)
        });
        let pairs = pairs.collect();
        Ok(World { linkage, parts, body_of, pairs, touching: bodies.touching.clone() })
    }

    /// The chain beside which the world stands.
    pub fn chain(&self) -> &Chain {
        &self.linkage.chain
    }

    /// Leaves machine bodies unchecked against each other, for when only the instrument is of interest: in the
    /// bench of this room and its test.
    pub fn forget_machine_pairs(&mut self) {
        self.pairs.clear();
    }

    /// Number of parts of the machine; a scene's instrument parts follow them.
    pub fn part_count(&self) -> usize {
        self.parts.len()
    }

    /// Number of link frames; the bar's frame follows them.
    pub fn frame_count(&self) -> usize {
        self.linkage.count()
    }

    /// Frame of a link.
    pub fn frame(&self, link: LinkId) -> usize {
        self.linkage.frame(link)
    }
}
