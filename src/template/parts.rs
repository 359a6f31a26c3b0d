//! What the solids of a machine share: thicknesses, gaps, bricks, and the link that carries an axis.

use nalgebra::{Matrix3, Vector3};

use crate::bodies::{Bodies, Body, Solid};
use crate::chain::Pose;

/// Thickness of a table, of a cradle's plate and of what lies under an inclined table, mm.
pub const TABLE_MM: f64 = 40.0;
pub const PLATE_MM: f64 = 60.0;
/// Between parts that pass each other, mm.
pub const GAP_MM: f64 = 15.0;

/// Link that carries an axis of a side, whose names run from the bed outward: the axis before it, or the bed.
pub fn carrier(outward: &[String], name: &str) -> String {
    match outward.iter().position(|other| other == name) {
        Some(place) if place > 0 => outward[place - 1].clone(),
        _ => "b".into(),
    }
}

/// Adds a box along the axes of R.
pub fn add(all: &mut Bodies, name: &str, link: &str, middle: Vector3<f64>, size: Vector3<f64>) {
    all.bodies.push(brick(name, link, [middle.x, middle.y, middle.z], [size.x, size.y, size.z]));
}

/// A box along the axes of R.
pub fn brick(name: &str, link: &str, middle: [f64; 3], size: [f64; 3]) -> Body {
    Body {
        name: name.to_string(),
        link: link.to_string(),
        solids: vec![Solid::Box { half_mm: Vector3::from(size) * 0.5 }],
        at: Pose { rotation: Matrix3::identity(), translation_mm: Vector3::from(middle) },
    }
}
