//! Convex solids in their own frames, mm. Concave ones are several; poses are the body's.

use nalgebra::{Matrix3, Vector3};
use parry3d::math::Vector;

/// A convex solid about its own origin.
#[derive(Debug, Clone, PartialEq)]
pub enum Solid {
    Ball {
        radius_mm: f64,
    },
    /// Half lengths of the edges along x, y, z.
    Box {
        half_mm: Vector3<f64>,
    },
    /// Along its z from −half to +half.
    Cylinder {
        radius_mm: f64,
        half_mm: f64,
    },
    /// All points within the radius of the segment along z from −half to +half.
    Capsule {
        radius_mm: f64,
        half_mm: f64,
    },
    /// Convex hull of its corners.
    Hull {
        corners: Vec<Vector3<f64>>,
    },
}

impl Solid {
    /// Convex hull of some points; `None` when they lie in a plane.
    pub fn hull_of(points: &[Vector3<f64>]) -> Option<Solid> {
        hull(points.iter(), MAX_CORNERS).map(|hull| Solid::Hull { corners: hull.simplified() })
    }

    /// Radius of the ball about the frame's origin that holds the solid, mm.
    pub fn reach_mm(&self) -> f64 {
        match self {
            Solid::Ball { radius_mm } => *radius_mm,
            Solid::Box { half_mm } => half_mm.norm(),
            Solid::Cylinder { radius_mm, half_mm } => radius_mm.hypot(*half_mm),
            Solid::Capsule { radius_mm, half_mm } => radius_mm + half_mm,
            Solid::Hull { corners } => corners.iter().map(Vector3::norm).fold(0.0, f64::max),
        }
    }
}

/// A convex hull as it was computed.
#[derive(Debug, Clone)]
pub(super) struct Hull {
    pub corners: Vec<Vector3<f64>>,
    pub faces: Vec<[u32; 3]>,
    pub volume_mm3: f64,
}

/// Most corners of a hull: each distance looks at all of them some ten times. Public for the tests of meshes.
pub const MAX_CORNERS: usize = 256;
/// Hulls of less are flat, mm³.
const FLAT_MM3: f64 = 1e-6;

/// Points up to this many times the corners asked for are taken as they are.
const EXACT: usize = 6;

/// Hull of some points; `None` when they lie in a plane. Of very many points it is a somewhat larger one of at most `corners` corners.
pub(super) fn hull<'p>(points: impl Iterator<Item = &'p Vector3<f64>>, corners: usize) -> Option<Hull> {
    let mut points: Vec<Vector3<f64>> = points.copied().collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    points.dedup();
    if points.len() > EXACT * corners { Hull::around(&points, corners) } else { Hull::of(&points) }
}

impl Hull {
    fn of(points: &[Vector3<f64>]) -> Option<Hull> {
        if points.len() < 4 {
            return None;
        }
        let points: Vec<Vector> = points.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
        let (corners, faces) = parry3d::transformation::try_convex_hull(&points).ok()?;
        let corners: Vec<Vector3<f64>> = corners.iter().map(|c| Vector3::new(c.x, c.y, c.z)).collect();
        // about a corner: far from the origin the terms would cancel
        let from = |k: u32| corners[k as usize] - corners[0];
        let volume: f64 = faces.iter().map(|[a, b, c]| from(*a).dot(&from(*b).cross(&from(*c))) / 6.0).sum();
        (volume.abs() > FLAT_MM3).then(|| Hull { corners, faces, volume_mm3: volume.abs() })
    }

    /// Hull of the points farthest along `corners` directions, grown about its middle until it holds all points.
    fn around(points: &[Vector3<f64>], corners: usize) -> Option<Hull> {
        let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
        // directions spread evenly over the sphere
        let direction = |k: usize| {
            let z = 1.0 - (2.0 * k as f64 + 1.0) / corners as f64;
            let (s, c) = (golden * k as f64).sin_cos();
            let r = (1.0 - z * z).sqrt();
            Vector3::new(r * c, r * s, z)
        };
        let farthest = |direction: Vector3<f64>| {
            let farther = |best: (f64, usize), (k, p): (usize, &Vector3<f64>)| {
                let along = p.dot(&direction);
                if along > best.0 { (along, k) } else { best }
            };
            points.iter().enumerate().fold((f64::MIN, 0), farther).1
        };
        let mut extreme: Vec<usize> = (0..corners).map(|k| farthest(direction(k))).collect();
        extreme.sort_unstable();
        extreme.dedup();
        let mut inner = Hull::of(&extreme.into_iter().map(|k| points[k]).collect::<Vec<_>>())?;
        let middle = inner.middle();
        let growth = inner.planes().iter().fold(1.0f64, |growth, (normal, offset)| {
            let own = offset - normal.dot(&middle);
            let most = points.iter().map(|p| normal.dot(p)).fold(f64::MIN, f64::max) - normal.dot(&middle);
            if (most / own).is_finite() { growth.max(most / own) } else { growth }
        });
        for corner in &mut inner.corners {
            *corner = middle + (*corner - middle) * growth;
        }
        inner.volume_mm3 *= growth.powi(3);
        Some(inner)
    }

    /// Planes of the faces: outward unit normal and offset, mm; inside is `normal·p ≤ offset`. Slivers have no plane.
    pub fn planes(&self) -> Vec<(Vector3<f64>, f64)> {
        let middle = self.middle();
        let plane = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|k| self.corners[k as usize]);
            let normal = (b - a).cross(&(c - a)).try_normalize(1e-9)?;
            let outward = if normal.dot(&(a - middle)) < 0.0 { -normal } else { normal };
            Some((outward, outward.dot(&a)))
        };
        self.faces.iter().filter_map(plane).collect()
    }

    /// Diagonal of the box that holds the hull, mm.
    pub fn diagonal_mm(&self) -> f64 {
        let first = self.corners.first().copied().unwrap_or_default();
        let (low, high) = self.corners.iter().fold((first, first), |(low, high), c| (low.inf(c), high.sup(c)));
        (high - low).norm()
    }

    fn middle(&self) -> Vector3<f64> {
        self.corners.iter().sum::<Vector3<f64>>() / self.corners.len() as f64
    }

    /// The corners, or at most [`MAX_CORNERS`] of a somewhat larger hull that covers this one.
    pub fn simplified(self) -> Vec<Vector3<f64>> {
        match self.corners.len() <= MAX_CORNERS {
            true => self.corners,
            false => Hull::around(&self.corners, MAX_CORNERS).map_or(self.corners, |hull| hull.corners),
        }
    }
}

/// Rotation whose third column is `axis` (unit length).
pub fn frame_along(axis: &Vector3<f64>) -> Matrix3<f64> {
    let other = if axis.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let first = other.cross(axis).normalize();
    Matrix3::from_columns(&[first, axis.cross(&first), *axis])
}
