//! A machine as a robot description: its location errors stand in the origins and axes of the joints, exactly. Writes no file.

use std::fmt::Write as _;

use nalgebra::{Matrix3, Vector3};

use crate::chain::{Branch, Chain, Composition, Geometry, LinkId, Pose};
use crate::machine::{AxisKind, Machine};
use crate::report::wording::markup::escape;

/// Lengths in a robot description are m.
const M_PER_MM: f64 = 1e-3;

/// The description; what it cannot hold stands in a comment at its head. Links are `bed`, the axes' names, `workpiece` and `tool`.
/// The frame of an axis stands on its line, at the `origin` of the machine file; those of bed, workpiece and tool coincide with R
/// on a machine without errors and all axes at zero.
pub fn machine_urdf(machine: &Machine) -> String {
    let chain = Chain::of(machine);
    let geometry = Geometry::new(&chain, &machine.location_errors(), Composition::Exact);
    let mut out = String::from("<?xml version=\"1.0\"?>\n");
    if machine.location_errors().iter().flatten().any(|error| *error != 0.0) {
        out.push_str(
            "<!-- errors stand in origins and axes: balls of a session with this file are stated in R with all axes at zero where the \
             errors have put their links -->\n",
        );
    }
    for lost in not_held(machine) {
        let _ = writeln!(out, "<!-- not held here: {} -->", escape(&lost).replace("--", "- -"));
    }
    let _ = writeln!(out, "<robot name=\"{}\">\n  <link name=\"bed\"/>", escape(&machine.name));
    for (branch, end) in [(Branch::Workpiece, "workpiece"), (Branch::Tool, "tool")] {
        let mut before = ("bed".to_string(), Pose::identity());
        for &axis in chain.branch(branch) {
            let frame = joint(&mut out, machine, &geometry, (axis, chain.carried_by(axis)), &before);
            before = (machine.axes[axis].name.clone(), frame);
        }
        let at_end = geometry.pose(chain.end(branch), &vec![0.0; machine.axes.len()], None);
        let _ = writeln!(
            out,
            "  <link name=\"{end}\"/>\n  <joint name=\"to {end}\" type=\"fixed\"><parent link=\"{}\"/><child link=\"{end}\"/>{}</joint>",
            escape(&before.0),
            origin(&relative(&before.1, &at_end))
        );
    }
    out.push_str("</robot>\n");
    out
}

/// Writes link and joint of an axis; returns its frame in R with all axes at zero.
fn joint(
    out: &mut String,
    machine: &Machine,
    geometry: &Geometry,
    (index, link): (usize, LinkId),
    (parent, parent_frame): &(String, Pose),
) -> Pose {
    let axis = &machine.axes[index];
    let at = |position: f64| {
        let mut positions = vec![0.0; machine.axes.len()];
        positions[index] = position;
        geometry.pose(link, &positions, None)
    };
    let (zero, moved) = (at(0.0), at(1.0));
    let frame = Pose { rotation: zero.rotation, translation_mm: zero.point(&axis.origin) };
    let direction = match axis.kind {
        AxisKind::Linear => zero.rotation.transpose() * (moved.translation_mm - zero.translation_mm),
        AxisKind::Rotary => {
            let turn = zero.rotation.transpose() * moved.rotation;
            Vector3::new(turn[(2, 1)] - turn[(1, 2)], turn[(0, 2)] - turn[(2, 0)], turn[(1, 0)] - turn[(0, 1)])
        }
    }
    .normalize();
    let (kind, limit) = match (axis.kind, axis.range) {
        (AxisKind::Linear, Some((low, high))) => ("prismatic", Some((low * M_PER_MM, high * M_PER_MM))),
        (AxisKind::Linear, None) => ("prismatic", None),
        (AxisKind::Rotary, Some(range)) => ("revolute", Some(range)),
        (AxisKind::Rotary, None) => ("continuous", None),
    };
    let limit = match limit {
        Some((low, high)) => format!("<limit lower=\"{low}\" upper=\"{high}\" effort=\"0\" velocity=\"0\"/>"),
        // a slide without limits has some: the format demands them
        None if axis.kind == AxisKind::Linear => {
            "<limit lower=\"-100\" upper=\"100\" effort=\"0\" velocity=\"0\"/>".into()
        }
        None => String::new(),
    };
    let name = escape(&axis.name);
    let _ = writeln!(
        out,
        "  <link name=\"{name}\"/>\n  <joint name=\"{name}\" type=\"{kind}\"><parent link=\"{}\"/><child link=\"{name}\"/>{}<axis xyz=\"{}\"/>{limit}</joint>",
        escape(parent),
        origin(&relative(parent_frame, &frame)),
        words(&direction)
    );
    frame
}

/// What a robot description has no place for.
fn not_held(machine: &Machine) -> Vec<String> {
    let mut list = Vec::new();
    let moving: Vec<&str> =
        machine.axes.iter().filter(|axis| !axis.component_errors.is_empty()).map(|axis| axis.name.as_str()).collect();
    if !moving.is_empty() {
        list.push(format!("errors of motion over the position of {}", moving.join(", ")));
    }
    if !machine.effects.is_empty() {
        let names: Vec<&str> = machine.effects.iter().map(|effect| effect.kind.as_str()).collect();
        list.push(format!("effects: {}", names.join(", ")));
    }
    list
}

/// One pose in the frame of another.
fn relative(from: &Pose, to: &Pose) -> Pose {
    let back = from.rotation.transpose();
    Pose { rotation: back * to.rotation, translation_mm: back * (to.translation_mm - from.translation_mm) }
}

fn origin(pose: &Pose) -> String {
    format!(
        "<origin xyz=\"{}\" rpy=\"{}\"/>",
        words(&(pose.translation_mm * M_PER_MM)),
        words(&roll_pitch_yaw(&pose.rotation))
    )
}

/// Angles with `R = Rz(yaw)·Ry(pitch)·Rx(roll)`. Errors are small: the pitch stays away from ±90°.
fn roll_pitch_yaw(rotation: &Matrix3<f64>) -> Vector3<f64> {
    let flat = rotation[(2, 1)].hypot(rotation[(2, 2)]);
    Vector3::new(
        rotation[(2, 1)].atan2(rotation[(2, 2)]),
        (-rotation[(2, 0)]).atan2(flat),
        rotation[(1, 0)].atan2(rotation[(0, 0)]),
    )
}

/// Three numbers with all their digits.
fn words(value: &Vector3<f64>) -> String {
    let word = |part: f64| if part == 0.0 { "0".to_string() } else { format!("{part:e}") };
    format!("{} {} {}", word(value.x), word(value.y), word(value.z))
}
