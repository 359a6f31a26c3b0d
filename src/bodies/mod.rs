//! Bodies beside the kinematic model: solids on links, surfaces that take a pivot, the kit. It measures no distances.

mod kit;
mod mesh;
mod solid;

pub use kit::{Bar, Cup, Fixture, Kit, PivotStand};
pub(crate) use mesh::MAX_TRIANGLES;
pub use mesh::{MeshError, Triangle, convex_pieces};
pub use solid::{MAX_CORNERS, Solid, frame_along};

use nalgebra::Vector3;

use crate::chain::Pose;

/// A solid thing that a link carries.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Name for people: `table`, `spindle nose`.
    pub name: String,
    /// Name of the carrying link.
    pub link: String,
    /// Shape in the body's frame; a concave one is several convex ones.
    pub solids: Vec<Solid>,
    /// The body's frame in R with all axes at zero.
    pub at: Pose,
}

impl Body {
    /// A cylinder about R's z between two heights, mm.
    pub fn upright(name: &str, link: &str, low: f64, high: f64, radius_mm: f64) -> Body {
        let up = Vector3::z();
        Body {
            name: name.to_string(),
            link: link.to_string(),
            solids: vec![Solid::Cylinder { radius_mm, half_mm: 0.5 * (high - low) }],
            at: Pose { rotation: frame_along(&up), translation_mm: up * (0.5 * (low + high)) },
        }
    }
}

/// Outline of a mounting surface about its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outline {
    /// A disc or ring, mm.
    Disc { inner_radius_mm: f64, radius_mm: f64 },
    /// A rectangle; the first size runs along `Mount::along`, mm.
    Rectangle { size_mm: [f64; 2] },
}

/// A surface on which a pivot stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Mount {
    pub name: String,
    /// Name of the carrying link.
    pub link: String,
    /// Middle of the surface, mm, in R with all axes at zero.
    pub middle: Vector3<f64>,
    /// Outward normal, unit length; the pivot's stem runs along it.
    pub normal: Vector3<f64>,
    /// Direction in the surface, unit length: first side of a rectangle, direction of T-slots.
    pub along: Vector3<f64>,
    pub outline: Outline,
    /// Pitch of T-slots running along `along`, one of them through the middle, mm; `None` when a pivot stands anywhere.
    pub slot_pitch_mm: Option<f64>,
}

impl Mount {
    /// Point of the surface with coordinates (u along `along`, v across), mm.
    pub fn point(&self, u: f64, v: f64) -> Vector3<f64> {
        self.middle + self.along * u + self.across() * v
    }

    /// Direction in the surface across `along`, unit length.
    pub fn across(&self) -> Vector3<f64> {
        self.normal.cross(&self.along)
    }

    /// True when the point (u, v) lies on the surface with `edge_mm` to spare on all sides, and on a T-slot if there are any.
    pub fn holds(&self, u: f64, v: f64, edge_mm: f64) -> bool {
        let inside = match self.outline {
            Outline::Disc { inner_radius_mm, radius_mm } => {
                let r = u.hypot(v);
                r <= radius_mm - edge_mm + 1e-9 && (inner_radius_mm == 0.0 || r >= inner_radius_mm + edge_mm - 1e-9)
            }
            Outline::Rectangle { size_mm } => {
                u.abs() <= 0.5 * size_mm[0] - edge_mm + 1e-9 && v.abs() <= 0.5 * size_mm[1] - edge_mm + 1e-9
            }
        };
        let on_slot = self.slot_pitch_mm.is_none_or(|pitch| ((v / pitch).round() * pitch - v).abs() < 1e-6);
        inside && on_slot
    }

    /// Largest distance of a surface point from the middle, mm.
    pub fn extent_mm(&self) -> f64 {
        match self.outline {
            Outline::Disc { radius_mm, .. } => radius_mm,
            Outline::Rectangle { size_mm } => 0.5 * size_mm[0].hypot(size_mm[1]),
        }
    }
}

/// Everything solid about a machine.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bodies {
    pub bodies: Vec<Body>,
    pub mounts: Vec<Mount>,
    /// Pairs of bodies that touch by design, by name: a table in its bearing, a slide on its guideway. They are never compared.
    pub touching: Vec<(String, String)>,
}
