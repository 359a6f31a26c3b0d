//! Planar circles of two linear axes about a pivot, for squareness: which are reachable. With which of them a plan begins is in `circles`.

use super::candidate::{Avoid, Candidate, Candidates};
use super::drive::{Drive, Swing};
use super::run_in::SHORTEST_DEG;
use super::slides::{Slides, arc_within};
use super::solver::{Solved, Stance};
use super::starts::static_positions;
use crate::bodies::Bodies;
use crate::chain::Geometry;
use crate::machine::{AxisKind, Machine};
use crate::session::CirclePlane;

/// Planes by the names of their axes, the one that carries the cosine first (G17, G19 and G18 of a control).
pub const PLANES: [[&str; 2]; 3] = [["X", "Y"], ["Y", "Z"], ["Z", "X"]];
/// Bars tried, shortest first.
const BARS: usize = 2;
/// Most pivot places tried for one plane.
const MOST_SITES: usize = 60;
/// Slides within this of right angles and equal lengths draw a circle.
const SQUARE: f64 = 1e-9;

/// Circles in all planes that the machine's slides make.
pub(crate) fn circles(
    machine: &Machine,
    geometry: &Geometry,
    bodies: &Bodies,
    all: &Candidates,
    lengths_mm: &[f64],
    avoid: &Avoid,
) -> Vec<Candidate> {
    let chain = geometry.chain();
    let mut list = Vec::new();
    for names in PLANES {
        let [Some(first), Some(second)] = names.map(|name| linear_axis(machine, name)) else { continue };
        // rotary axes at the first of their static positions
        let Some(start) = static_positions(machine, chain, first, avoid).into_iter().next() else { continue };
        let stance = Stance::new(machine, geometry, first, &start);
        let step = all.sites.len().div_ceil(MOST_SITES).max(1);
        for (place_index, place) in all.places.iter().enumerate().filter(|(_, place)| place.aside_mm == 0.0) {
            for (site_index, site) in all.sites.iter().enumerate().step_by(step) {
                let Some(slides) = Slides::of(&stance, chain, place.link, site.link) else { continue };
                let (Some(u), Some(v)) = (slides.way(first), slides.way(second)) else { continue };
                if u.dot(&v).abs() > SQUARE || (u.norm() - 1.0).abs() > SQUARE || (v.norm() - 1.0).abs() > SQUARE {
                    continue;
                }
                let ball = stance.point((place.link, &place.at));
                let pivot = stance.point((site.link, &site.at));
                let positions = slides.moved(&start, &(pivot - ball));
                let normal = stance.turned(site.link, &bodies.mounts[site.mount].normal);
                for &bar_mm in lengths_mm.iter().take(BARS) {
                    let mut swing = Swing::none(start.len());
                    swing.cos[first] = bar_mm;
                    swing.sin[second] = bar_mm;
                    // a pivot cup opens to one side: the turn is taken about that side
                    let open = [u.dot(&normal), v.dot(&normal)];
                    let middle = if open[0].hypot(open[1]) < 0.1 {
                        std::f64::consts::PI
                    } else {
                        open[1].atan2(open[0]).to_degrees().round().to_radians()
                    };
                    let (from, to) = (middle - std::f64::consts::PI, middle + std::f64::consts::PI);
                    let arc = arc_within(machine, avoid, &positions, &swing, (from, to), SHORTEST_DEG);
                    let Some((from, to)) = arc else { continue };
                    list.push(Candidate {
                        axis: first,
                        site: site_index,
                        place: place_index,
                        bar_mm,
                        solved: Solved { positions: positions.clone(), rho_mm: bar_mm, h_mm: 0.0, along_mm: 0.0 },
                        from,
                        to,
                        drive: Drive::Circle(CirclePlane { first, second }, Box::new(swing)),
                    });
                }
            }
        }
    }
    list
}

/// The linear axis of this name that runs along its coordinate direction.
fn linear_axis(machine: &Machine, name: &str) -> Option<usize> {
    let axis = machine.axis_index(name)?;
    let along = "XYZ".find(name)?;
    let is_it = machine.axes[axis].kind == AxisKind::Linear && machine.axes[axis].coordinate_direction() == Some(along);
    is_it.then_some(axis)
}
