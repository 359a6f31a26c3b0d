//! The machine's solids on its links and the pairs of them that may collide. Distances at a pose are the scene's.

use nalgebra::Vector3;

use super::convex::Convex;
use super::frames::{Frames, Linkage};
use super::scene::Scene;
use crate::bodies::Bodies;
use crate::chain::{Chain, LinkId};

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
    pub(super) linkage: Linkage,
    pub(super) parts: Vec<Part>,
    /// Body (by index in `Bodies`) of each part: a mesh is several parts.
    pub(super) body_of: Vec<usize>,
    pub(super) pairs: Vec<(usize, usize)>,
    /// Pairs left out because they touch with all axes at zero, by name.
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
        let mut world = World { linkage, parts, body_of, pairs: Vec::new(), touching: Vec::new() };
        let mut frames = Frames::default();
        world.linkage.place(&vec![0.0; chain.axis_count()], &mut frames);
        let frames = frames.poses;
        for i in 0..world.parts.len() {
            for j in i + 1..world.parts.len() {
                let (one, other) = (&world.parts[i], &world.parts[j]);
                if !world.may_meet(one.frame, other.frame) {
                    continue;
                }
                let at_zero = super::distance(&one.convex, &frames[one.frame], &other.convex, &frames[other.frame]);
                if at_zero < TOUCHES_MM {
                    let names = (one.name.clone(), other.name.clone());
                    if !world.touching.contains(&names) {
                        world.touching.push(names);
                    }
                } else {
                    world.pairs.push((i, j));
                }
            }
        }
        Ok(world)
    }

    /// The chain beside which the world stands.
    pub fn chain(&self) -> &Chain {
        &self.linkage.chain
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
        self.linkage.count()
    }

    /// Frame of a link.
    pub fn frame(&self, link: LinkId) -> usize {
        self.linkage.frame(link)
    }

    /// Two links that more than one joint separates.
    fn may_meet(&self, one: usize, other: usize) -> bool {
        self.linkage.axes_between(one, other).len() > 1
    }

    /// A scene without instrument.
    pub fn scene(&self) -> Scene<'_> {
        Scene::new(self, Vec::new(), Vec::new(), None, Vec::new())
    }
}
