//! A machine with its bodies as the YAML that people keep and `load` reads: one line for each axis, body and surface. Writes no file.

use std::fmt::Write as _;

use nalgebra::Vector3;

use super::yaml_text::text;
use crate::bodies::{Bodies, Body, Mount, Outline, Solid};
use crate::machine::{Machine, letter_axis};

/// The file; only upright cylinders and boxes along the axes of R, as templates have them, are written.
pub fn machine_file(head: &str, machine: &Machine, bodies: &Bodies) -> String {
    let mut out = String::new();
    for line in head.lines() {
        let _ = writeln!(out, "# {line}");
    }
    let _ = writeln!(out, "name: {}\ncode: \"{}\"", text(&machine.name), machine.code);
    if let Some(directions) = machine.directions {
        let _ = writeln!(out, "directions: {directions}");
    }
    out.push_str("axes:\n");
    for axis in &machine.axes {
        let mut parts = Vec::new();
        let usual = letter_axis(&axis.name).map(|(_, direction)| direction);
        if usual.is_none_or(|usual| (usual - axis.direction).norm() > 1e-12) {
            parts.push(format!("direction: {}", exact(&axis.direction)));
        }
        if axis.kind == crate::machine::AxisKind::Rotary {
            parts.push(format!("origin: {}", vector(&axis.origin)));
        }
        if let Some((from, to)) = axis.range {
            parts.push(format!(
                "range: [{}, {}]",
                round(axis.kind.to_file_unit(from)),
                round(axis.kind.to_file_unit(to))
            ));
        }
        let _ = writeln!(out, "  {}: {{{}}}", text(&axis.name), parts.join(", "));
    }
    out.push_str("caveats:\n");
    machine.caveats.iter().for_each(|caveat| {
        let _ = writeln!(out, "  - {}", text(caveat));
    });
    out.push_str("bodies:\n");
    bodies.bodies.iter().for_each(|body| body_line(&mut out, body));
    if !bodies.touching.is_empty() {
        out.push_str("# Joined by bearings and guideways; all other pairs are compared.\ntouching:\n");
        bodies.touching.iter().for_each(|(one, other)| {
            let _ = writeln!(out, "  - [{}, {}]", text(one), text(other));
        });
    }
    out.push_str("# Surfaces that take a cup.\nmounts:\n");
    bodies.mounts.iter().for_each(|mount| mount_line(&mut out, mount));
    if let Some(spindle) = &machine.spindle {
        let mut parts = vec![format!("nose: {}", vector(&spindle.nose))];
        // the last axis carries the spindle, and it is upright over R, unless it is said
        if (spindle.direction - Vector3::z()).norm() > 1e-12 {
            parts.push(format!("direction: {}", exact(&spindle.direction)));
        }
        let _ = writeln!(out, "spindle: {{{}}}", parts.join(", "));
        if (spindle.nose.dot(&spindle.direction) - spindle.gauge_length_mm).abs() > 1e-9 {
            let _ = writeln!(out, "gauge_length: {}", round(spindle.gauge_length_mm));
        }
    }
    out
}

fn body_line(out: &mut String, body: &Body) {
    let at = &body.at.translation_mm;
    for solid in &body.solids {
        let shape = match solid {
            Solid::Box { half_mm } => format!("box: {{at: {}, size: {}}}", vector(at), vector(&(half_mm * 2.0))),
            Solid::Cylinder { radius_mm, half_mm } => {
                let along = body.at.rotation * Vector3::z() * *half_mm;
                format!(
                    "cylinder: {{from: {}, to: {}, radius: {}}}",
                    vector(&(at - along)),
                    vector(&(at + along)),
                    round(*radius_mm)
                )
            }
            Solid::Ball { radius_mm } => format!("ball: {{at: {}, radius: {}}}", vector(at), round(*radius_mm)),
            Solid::Capsule { .. } | Solid::Hull { .. } => continue,
        };
        let _ = writeln!(out, "  - {{name: {}, link: {}, {shape}}}", text(&body.name), text(&body.link));
    }
}

fn mount_line(out: &mut String, mount: &Mount) {
    let outline = match mount.outline {
        Outline::Disc { inner_radius_mm, radius_mm } => {
            format!("disc: [{}, {}]", round(inner_radius_mm), round(radius_mm))
        }
        Outline::Rectangle { size_mm: [one, other] } => format!("rectangle: [{}, {}]", round(one), round(other)),
    };
    let _ = writeln!(
        out,
        "  - {{name: {}, link: {}, at: {}, normal: {}, along: {}, {outline}}}",
        text(&mount.name),
        text(&mount.link),
        vector(&mount.middle),
        vector(&mount.normal),
        vector(&mount.along)
    );
}

/// A direction with all its digits.
fn exact(value: &Vector3<f64>) -> String {
    format!("[{}, {}, {}]", value.x, value.y, value.z)
}

fn vector(value: &Vector3<f64>) -> String {
    format!("[{}, {}, {}]", round(value.x), round(value.y), round(value.z))
}

/// To a tenth of a micrometre: a data sheet has no more.
fn round(value: f64) -> f64 {
    (value * 1e4).round() / 1e4 + 0.0
}
