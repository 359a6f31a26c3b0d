//! A convex core with a rounding radius, and the box that holds it; no poses of links, no distances.

use nalgebra::{Matrix3, Vector3};
use parry3d::math::Vector;
use parry3d::shape::SupportMap;

use crate::bodies::Solid;

/// A convex set: all points within `round_mm` of the core.
#[derive(Debug, Clone, PartialEq)]
pub struct Convex {
    pub core: Core,
    pub round_mm: f64,
    /// The core's frame in its link.
    pub rotation: Matrix3<f64>,
    pub centre: Vector3<f64>,
}

/// A core about its own origin, mm.
#[derive(Debug, Clone, PartialEq)]
pub enum Core {
    Point,
    /// Along z, ± half.
    Segment {
        half: f64,
    },
    Box {
        half: Vector3<f64>,
    },
    /// Along z, ± half.
    Cylinder {
        radius: f64,
        half: f64,
    },
    Hull {
        corners: Vec<Vector3<f64>>,
    },
}

impl Convex {
    /// A solid with its frame in the link.
    pub fn of(solid: &Solid, rotation: Matrix3<f64>, centre: Vector3<f64>) -> Convex {
        let (core, round_mm, shift) = match solid {
            Solid::Ball { radius_mm } => (Core::Point, *radius_mm, Vector3::zeros()),
            Solid::Box { half_mm } => (Core::Box { half: *half_mm }, 0.0, Vector3::zeros()),
            Solid::Cylinder { radius_mm, half_mm } => {
                (Core::Cylinder { radius: *radius_mm, half: *half_mm }, 0.0, Vector3::zeros())
            }
            Solid::Capsule { radius_mm, half_mm } => (Core::Segment { half: *half_mm }, *radius_mm, Vector3::zeros()),
            Solid::Hull { corners } => {
                // about the middle of its box, so that boxes and bounds are tight
                let low = corners.iter().fold(Vector3::repeat(f64::MAX), |m, c| m.inf(c));
                let high = corners.iter().fold(Vector3::repeat(f64::MIN), |m, c| m.sup(c));
                let middle = (low + high) * 0.5;
                (Core::Hull { corners: corners.iter().map(|c| c - middle).collect() }, 0.0, middle)
            }
        };
        Convex { core, round_mm, rotation, centre: centre + rotation * shift }
    }

    /// A ball.
    pub fn ball(centre: Vector3<f64>, radius_mm: f64) -> Convex {
        Convex { core: Core::Point, round_mm: radius_mm, rotation: Matrix3::identity(), centre }
    }

    /// A capsule between two points.
    pub fn capsule(from: Vector3<f64>, to: Vector3<f64>, radius_mm: f64) -> Convex {
        let (rotation, half) = along(&from, &to);
        Convex { core: Core::Segment { half }, round_mm: radius_mm, rotation, centre: (from + to) * 0.5 }
    }

    /// A cylinder between the middles of its faces.
    pub fn cylinder(from: Vector3<f64>, to: Vector3<f64>, radius_mm: f64) -> Convex {
        let (rotation, half) = along(&from, &to);
        Convex { core: Core::Cylinder { radius: radius_mm, half }, round_mm: 0.0, rotation, centre: (from + to) * 0.5 }
    }

    /// Half edges of the core's box in the link's directions, mm; the rounding comes on top.
    pub fn half_box(&self) -> Vector3<f64> {
        half_box(&self.core, &self.rotation)
    }

    /// Farthest point along a direction of the link, mm from the link's origin.
    pub fn farthest_mm(&self, direction: &Vector3<f64>) -> f64 {
        let own = self.rotation.tr_mul(direction);
        self.centre.dot(direction) + own.dot(&self.core.support(&own)) + self.round_mm * direction.norm()
    }

    /// True for a solid of revolution about the z of its frame, or a ball.
    pub fn is_round(&self) -> bool {
        matches!(self.core, Core::Point | Core::Segment { .. } | Core::Cylinder { .. })
    }

    /// Largest distance of a point of the set from its centre, mm.
    pub fn reach_mm(&self) -> f64 {
        self.round_mm
            + match &self.core {
                Core::Point => 0.0,
                Core::Segment { half } => *half,
                Core::Box { half } => half.norm(),
                Core::Cylinder { radius, half } => radius.hypot(*half),
                Core::Hull { corners } => corners.iter().map(Vector3::norm).fold(0.0, f64::max),
            }
    }
}

fn along(from: &Vector3<f64>, to: &Vector3<f64>) -> (Matrix3<f64>, f64) {
    let way = to - from;
    let length = way.norm();
    let axis = if length > 1e-12 { way / length } else { Vector3::z() };
    (crate::bodies::frame_along(&axis), 0.5 * length)
}

/// Half edges of a core's box in a frame in which the core's frame is `rotation`.
pub fn half_box(core: &Core, rotation: &Matrix3<f64>) -> Vector3<f64> {
    let axis = rotation.column(2);
    match core {
        Core::Point => Vector3::zeros(),
        Core::Segment { half } => axis.abs() * *half,
        Core::Box { half } => rotation.abs() * half,
        Core::Cylinder { radius, half } => axis.map(|u| u.abs() * half + radius * (1.0 - u * u).max(0.0).sqrt()),
        Core::Hull { corners } => corners.iter().fold(Vector3::zeros(), |m, c| m.sup(&(rotation * c).abs())),
    }
}

/// A core with its frame, for the distance iteration.
pub struct Placed<'a> {
    pub core: &'a Core,
    pub rotation: Matrix3<f64>,
    pub centre: Vector3<f64>,
}

impl Core {
    /// The core's point farthest along a direction.
    #[inline]
    pub fn support(&self, d: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Core::Point => Vector3::zeros(),
            Core::Segment { half } => Vector3::new(0.0, 0.0, half.copysign(d.z)),
            Core::Box { half } => Vector3::new(half.x.copysign(d.x), half.y.copysign(d.y), half.z.copysign(d.z)),
            Core::Cylinder { radius, half } => {
                let across = (d.x * d.x + d.y * d.y).sqrt();
                let scale = if across > 0.0 { radius / across } else { 0.0 };
                Vector3::new(d.x * scale, d.y * scale, half.copysign(d.z))
            }
            Core::Hull { corners } => {
                let mut best = corners[0];
                let mut most = best.dot(d);
                for corner in &corners[1..] {
                    let here = corner.dot(d);
                    if here > most {
                        most = here;
                        best = *corner;
                    }
                }
                best
            }
        }
    }
}

impl SupportMap for Core {
    #[inline]
    fn local_support_point(&self, d: Vector) -> Vector {
        let p = self.support(&Vector3::new(d.x, d.y, d.z));
        Vector::new(p.x, p.y, p.z)
    }
}

impl SupportMap for Placed<'_> {
    #[inline]
    fn local_support_point(&self, d: Vector) -> Vector {
        let d = self.rotation.tr_mul(&Vector3::new(d.x, d.y, d.z));
        let p = self.rotation * self.core.support(&d) + self.centre;
        Vector::new(p.x, p.y, p.z)
    }
}
