//! What a positive command does to an axis, in words that an operator can check by eye. Says nothing of how far.
//!
//! The operator stands in front of the machine: up is against gravity, right is R's x (R's y where x runs along
//! gravity), and the view goes along up × right. With gravity along −z that is the stand at −y, looking to +y.
//!
//! Words follow from the motion of the carried part at given positions: a slide's velocity is `s·u`, a turn's angular
//! velocity `ω = s·u`, with u the axis's direction as the axes before it have turned it and s the sign of
//! [`Machine::motion_sign`]. A point at e from the line moves by ω × e, so the edge that rises most lies towards up × ω,
//! and a spindle whose nose looks along n swings its nose towards ω × n.

use nalgebra::Vector3;

use super::geometry::Geometry;
use super::link::Branch;
use super::structure::Chain;
use crate::machine::{AxisKind, Machine};

/// Parts of a direction below this are not named: 15° aside is hard to see in a short jog.
const LEAST_PART_NAMED: f64 = 0.2588;
/// Turns that tilt what they carry by less than this share of themselves are told as turns: within 30° of upright.
const TILTS: f64 = 0.5;
/// Turns about the tool's own direction, within 15°, do not swing the nose.
const SWINGS: f64 = 0.2588;

/// Where the operator stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Unit vectors of R.
    pub right: Vector3<f64>,
    pub away: Vector3<f64>,
    pub up: Vector3<f64>,
}

impl View {
    /// In front of a machine.
    pub fn of(machine: &Machine) -> View {
        let up = -machine.gravity;
        let aside = if up.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
        let right = (aside - up * up.dot(&aside)).normalize();
        View { right, away: up.cross(&right), up }
    }

    /// Parts of a direction to the right, away from the operator and up.
    fn parts(&self, direction: &Vector3<f64>) -> [f64; 3] {
        [direction.dot(&self.right), direction.dot(&self.away), direction.dot(&self.up)]
    }
}

/// What a positive command of an axis does with the axes at `positions` (mm, rad): `X+: the table goes left`.
///
/// Of a head's axis the way in which the nose swings, where the machine tells which way the tool looks.
pub fn sense_in_words(machine: &Machine, axis: usize, positions: &[f64]) -> String {
    let chain = Chain::of(machine);
    let geometry = Geometry::nominal(&chain);
    let view = View::of(machine);
    let joint = chain.joint(axis);
    let link = chain.carried_by(axis);
    // a joint's own motion leaves its direction where it is
    let rotation = geometry.pose(link, positions, None).rotation;
    let way = rotation * joint.direction * joint.sign;
    let name = &machine.axes[axis].name;
    match (joint.kind, link.branch) {
        (AxisKind::Linear, branch) => format!("{name}+: {} goes {}", part(branch), towards(&view, &way)),
        (AxisKind::Rotary, Branch::Workpiece) => table_turns(name, &view, &way),
        (AxisKind::Rotary, Branch::Tool) => match machine.tool_direction() {
            Some(tool) => format!("{name}+: {}", head_turns(&view, &way, &(rotation * tool))),
            None => format!("{name}+: {} turns {}", part(Branch::Tool), seen_from(&view, &way)),
        },
    }
}

/// What of a branch the operator looks at.
fn part(branch: Branch) -> &'static str {
    match branch {
        Branch::Workpiece => "the table",
        Branch::Tool => "the spindle",
    }
}

/// `A+ lifts the front edge of the table`, and how the table turns where that shows as well.
fn table_turns(name: &str, view: &View, turn: &Vector3<f64>) -> String {
    let rising = view.up.cross(turn);
    if rising.norm() < TILTS {
        return format!("{name}+: {} turns {}", part(Branch::Workpiece), seen_from_above(view, turn));
    }
    let edge = format!("{name}+ lifts the {} edge of the table", edge(view, &rising.normalize()));
    match turn.dot(&view.up).abs() < TILTS {
        true => edge,
        false => format!("{edge} and turns it {}", seen_from_above(view, turn)),
    }
}

/// `the spindle nose swings left`.
fn head_turns(view: &View, turn: &Vector3<f64>, tool: &Vector3<f64>) -> String {
    let nose = turn.cross(tool);
    match nose.norm() < SWINGS {
        true => format!("the spindle head turns {}", seen_from(view, turn)),
        false => format!("the spindle nose swings {}", towards(view, &nose.normalize())),
    }
}

/// `left`, `to the back and up`: the parts of a unit vector that an eye sees, the largest first.
fn towards(view: &View, way: &Vector3<f64>) -> String {
    named(view.parts(way), [["left", "right"], ["to the front", "to the back"], ["down", "up"]]).join(" and ")
}

/// `front`, `front left`: where a horizontal direction lies.
fn edge(view: &View, way: &Vector3<f64>) -> String {
    named(view.parts(way), [["left", "right"], ["front", "back"], ["lower", "upper"]]).join(" ")
}

/// Names of the parts that an eye sees, the largest first.
fn named(parts: [f64; 3], names: [[&'static str; 2]; 3]) -> Vec<&'static str> {
    let mut seen: Vec<usize> = (0..3).filter(|&k| parts[k].abs() >= LEAST_PART_NAMED).collect();
    // equal parts stay in the order right, away, up whatever the rounding
    seen.sort_by_key(|&k| (-parts[k].abs() * 1e6).round() as i64);
    seen.into_iter().map(|k| names[k][usize::from(parts[k] > 0.0)]).collect()
}

/// `clockwise seen from the right`: from above where the turn shows there at all, else from the side that it faces most.
fn seen_from(view: &View, turn: &Vector3<f64>) -> String {
    let [right, away, up] = view.parts(turn);
    if up.abs() >= TILTS {
        return seen_from_above(view, turn);
    }
    // a turn is right-handed, counter-clockwise for who looks against it
    match right.abs() >= away.abs() {
        true => format!("{} seen from the right", clock(right)),
        false => format!("{} seen from the front", clock(-away)),
    }
}

fn seen_from_above(view: &View, turn: &Vector3<f64>) -> String {
    format!("{} seen from above", clock(turn.dot(&view.up)))
}

/// How a turn looks whose part towards the eye is this.
fn clock(towards_eye: f64) -> &'static str {
    if towards_eye > 0.0 { "counter-clockwise" } else { "clockwise" }
}
