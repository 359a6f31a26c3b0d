//! Convex solids in their own frames, mm. Concave ones are several; poses are the body's.

use nalgebra::{Matrix3, Vector3};
use parry3d::math::Vector;

/// A convex solid about its own origin.
#[derive(Debug, Clone, PartialEq)]
pub enum Solid {
    /// Half lengths of the edges along x, y, z.
    Box { half_mm: Vector3<f64> },
    /// Along its z from −half to +half.
    Cylinder { radius_mm: f64, half_mm: f64 },
    /// All points within the radius of the segment along z from −half to +half.
    Capsule { radius_mm: f64, half_mm: f64 },
    /// Convex hull of its corners; only corners of the hull are kept.
    Hull { corners: Vec<Vector3<f64>> },
}

impl Solid {
    /// Convex hull of some points; `None` when they lie in a plane.
    pub fn hull_of(points: &[Vector3<f64>]) -> Option<Solid> {
        hull(points.iter()).map(|(corners, _)| Solid::Hull { corners })
    }

    /// Radius of the ball about the frame's origin that holds the solid, mm.
    pub fn reach_mm(&self) -> f64 {
        match self {
            Solid::Box { half_mm } => half_mm.norm(),
            Solid::Cylinder { radius_mm, half_mm } => radius_mm.hypot(*half_mm),
            Solid::Capsule { radius_mm, half_mm } => radius_mm + half_mm,
            Solid::Hull { corners } => corners.iter().map(Vector3::norm).fold(0.0, f64::max),
        }
    }
}

/// Corners and volume (mm³) of the hull of some points; `None` when they lie in a plane.
pub(super) fn hull<'p>(points: impl Iterator<Item = &'p Vector3<f64>>) -> Option<(Vec<Vector3<f64>>, f64)> {
    let points: Vec<Vector> = points.map(|p| Vector::new(p.x, p.y, p.z)).collect();
    if points.len() < 4 {
        return None;
    }
    let (corners, faces) = parry3d::transformation::try_convex_hull(&points).ok()?;
    let volume: f64 = faces
        .iter()
        .map(|f| corners[f[0] as usize].dot(corners[f[1] as usize].cross(corners[f[2] as usize])) / 6.0)
        .sum();
    let corners = corners.iter().map(|c| Vector3::new(c.x, c.y, c.z)).collect();
    (volume.abs() > 1e-6).then_some((corners, volume.abs()))
}

/// Rotation whose third column is `axis` (unit length).
pub fn frame_along(axis: &Vector3<f64>) -> Matrix3<f64> {
    let other = if axis.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let first = other.cross(axis).normalize();
    Matrix3::from_columns(&[first, axis.cross(&first), *axis])
}
