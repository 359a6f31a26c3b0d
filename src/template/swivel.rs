//! Solids about an inclined axis: a base below a table, a block above a spindle. None is a drawing.
//!
//! A solid that stands round the axis, beyond all that turns about it, is clear at every position: with a unit vector w along the axis from a
//! point P of it, a turn about the axis keeps `s = w·(p − P)` of every point p. Of an upright cylinder about the vertical through P, radius r,
//! heights z₁ … z₂ over P, the largest s is `r·|w_h| + max(w_z z₁, w_z z₂)`, with the level part w_h of w.

use nalgebra::Vector3;

use super::figures::GAUGE_MM;
use super::inclined::Inclined;
use super::parts::{GAP_MM, PLATE_MM, TABLE_MM, add, carrier};
use super::sizes::{Frame, Sizes};
use crate::bodies::{Bodies, Body, Solid, frame_along};
use crate::chain::Pose;

/// Length of the base along the axis, mm.
const BASE_MM: f64 = 140.0;
/// Radius of the swivel body and of its base, as a part of the table's.
const BASE_PART: f64 = 0.7;
/// Radius of the block of a head and its length, as parts of the spindle housing's radius.
const BLOCK_PARTS: (f64, f64) = (1.2, 2.0);
/// Height of the crown that carries a block, and of the ram over it, mm.
const CROWN_MM: f64 = 100.0;
const RAM_MM: f64 = 500.0;

/// Radius and heights over a point, mm: an upright cylinder about the vertical through it.
type Upright = (f64, [f64; 2]);

/// Whether a link is that of a level rotary axis.
fn is_level(link: &str) -> bool {
    matches!(link, "A" | "B")
}

/// Largest part along `way` of an upright cylinder.
fn farthest((radius, heights): Upright, way: &Vector3<f64>) -> f64 {
    radius * way.xy().norm() + heights.map(|height| way.z * height).into_iter().fold(f64::MIN, f64::max)
}

/// Radius of the ball about the point that holds it.
fn around((radius, heights): Upright) -> f64 {
    heights.map(|height| radius.hypot(height)).into_iter().fold(0.0, f64::max)
}

/// A cylinder round the axis.
struct Round {
    /// Point of the axis and unit vector from it to the cylinder.
    point: Vector3<f64>,
    way: Vector3<f64>,
    /// Both ends along the axis, mm.
    ends: [f64; 2],
    radius: f64,
}

impl Round {
    fn body(&self, name: &str, link: &str) -> Body {
        let [from, to] = self.ends;
        Body {
            name: name.to_string(),
            link: link.to_string(),
            solids: vec![Solid::Cylinder { radius_mm: self.radius, half_mm: 0.5 * (to - from) }],
            at: Pose { rotation: frame_along(&self.way), translation_mm: self.point + self.way * (0.5 * (from + to)) },
        }
    }

    /// Farthest level distance from the vertical through the point, and farthest height along the way, mm.
    fn reach(&self) -> (f64, f64) {
        let (level, upright) = (self.way.xy().norm(), self.way.z.abs());
        (self.ends[1] * level + self.radius * upright, self.ends[1] * upright + self.radius * level)
    }
}

/// What stands under an inclined table.
pub struct SwivelTable {
    pub base_link: String,
    base: Round,
    /// Radius of the swivel body under the table, with its heights in R; `None` where another axis tilts the table on it.
    body: Option<Upright>,
    letter: String,
    /// Height under the base that nothing which turns reaches, mm.
    pub floor: f64,
}

impl SwivelTable {
    /// Below the table whose axes are named from the workpiece on.
    pub fn of(sizes: &Sizes, frame: &Frame, inclined: &Inclined) -> SwivelTable {
        let turning = sizes.turning_on_table();
        let outward: Vec<String> = sizes.code.workpiece_side.iter().rev().cloned().collect();
        let base_link = carrier(&outward, &inclined.axis);
        let point = Vector3::z() * frame.table_tilt;
        let way = -inclined.upward();
        let swept = sizes.table.swept();
        let under = frame.table_top - TABLE_MM;
        let over = |low: f64, high: f64| [low - frame.table_tilt, high - frame.table_tilt];
        let table = (swept, over(under, frame.table_top));
        let is_tilted_on_it = turning.iter().take_while(|name| **name != inclined.axis).any(|name| is_level(name));
        let radius = BASE_PART * swept;
        let body = (!is_tilted_on_it).then_some((radius, [under - PLATE_MM, under]));
        let turned = body.map(|(radius, [low, high])| (radius, over(low, high)));
        let all = || std::iter::once(table).chain(turned);
        let swing = all().map(around).fold(0.0, f64::max);
        let far = match is_tilted_on_it {
            true => swing,
            false => all().map(|one| farthest(one, &way)).fold(0.0, f64::max),
        };
        let start = far + GAP_MM;
        let base = Round { point, way, ends: [start, start + BASE_MM], radius };
        let lowest = match base_link.as_str() {
            // a level axis swings the base too
            link if is_level(link) => swing.max(base.radius.hypot(base.ends[1])) + 2.0 * GAP_MM,
            _ => base.reach().1.max(swing + 2.0 * GAP_MM),
        };
        SwivelTable { base_link, base, body, letter: inclined.axis.clone(), floor: frame.table_tilt - lowest }
    }

    /// Farthest level distance of the base from the vertical, mm.
    pub fn reach(&self) -> f64 {
        self.base.reach().0
    }

    /// Adds it; returns the bodies that stand on what is under it.
    pub fn add(&self, all: &mut Bodies) -> Vec<String> {
        if let Some((radius, [low, high])) = self.body {
            all.bodies.push(Body::upright("swivel body", &self.letter, low, high, radius));
            all.touching.push(("work table".into(), "swivel body".into()));
        }
        all.bodies.push(self.base.body("swivel base", &self.base_link));
        // one that a level axis swings stands on nothing
        if is_level(&self.base_link) { Vec::new() } else { vec!["swivel base".into()] }
    }
}

/// Adds the spindle housing on an inclined axis, the block above it that carries it, and what carries the block.
pub fn swivel_head(all: &mut Bodies, sizes: &Sizes, frame: &Frame, inclined: &Inclined) {
    let outward = &sizes.code.tool_side;
    let radius = 0.5 * sizes.housing;
    let (point, way) = (Vector3::z() * frame.head_tilt, inclined.upward());
    let (nose, top) = (GAUGE_MM, frame.head_tilt + radius);
    all.bodies.push(Body::upright("spindle housing", &inclined.axis, nose, top, radius));
    let housing = (radius, [nose - frame.head_tilt, radius]);
    let start = farthest(housing, &way) + GAP_MM;
    let (part, length) = BLOCK_PARTS;
    let block = Round { point, way, ends: [start, start + length * radius], radius: part * radius };
    let link = carrier(outward, &inclined.axis);
    all.bodies.push(block.body("swivel block", &link));
    let (aside, up) = block.reach();
    let low = frame.head_tilt + up;
    // over the block where a slide carries it; round the vertical where it turns about that
    let (ram_link, ram_low, half, middle) = match link.as_str() {
        link if is_level(link) => return,
        "C" => {
            all.bodies.push(Body::upright("head crown", &link, low, low + CROWN_MM, aside));
            all.touching.push(("head crown".into(), "ram".into()));
            (carrier(outward, "C"), low + CROWN_MM, aside, Vector3::zeros())
        }
        _ => {
            let level = Vector3::new(way.x, way.y, 0.0);
            (link, low, block.radius, level * block.ends[1])
        }
    };
    let middle = middle + Vector3::z() * (ram_low + 0.5 * RAM_MM);
    add(all, "ram", &ram_link, middle, Vector3::new(2.0 * half, 2.0 * half, RAM_MM));
}
