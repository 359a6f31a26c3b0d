//! Distance between two convex sets: closed forms where they exist, parry's GJK elsewhere. One pair at a time.
//!
//! For a point or segment against a box or cylinder the squared distance along the segment, f(t), is convex with a
//! continuous, monotone derivative: its zero is found between the kinks (box, exact) or by bracketing (cylinder).

use nalgebra::{Matrix3, Vector3};
use parry3d::math::{Pose as ParryPose, Vector};
use parry3d::query::gjk::{self, CsoPoint, GJKResult, VoronoiSimplex};
use parry3d::shape::SharedShape;

use super::convex::{Convex, Core, Placed};
use crate::chain::Pose;

/// Distance of two sets, mm; negative by the overlap of the roundings, −roundings when the cores overlap.
pub fn distance(one: &Convex, one_link: &Pose, other: &Convex, other_link: &Pose) -> f64 {
    distance_below(one, one_link, other, other_link, f64::MAX)
}

/// As [`distance`], but may stop with any value ≥ `limit_mm` once the distance is known to be at least that.
pub fn distance_below(one: &Convex, one_link: &Pose, other: &Convex, other_link: &Pose, limit_mm: f64) -> f64 {
    // the other set seen in the first one's link
    let rotation = one_link.rotation.tr_mul(&other_link.rotation);
    let translation = one_link.rotation.tr_mul(&(other_link.translation_mm - one_link.translation_mm));
    distance_in_link(one, other, &(rotation * other.rotation), &(rotation * other.centre + translation), limit_mm)
}

/// As [`distance_below`] with the other core's frame given in the first one's link.
pub fn distance_in_link(
    one: &Convex,
    other: &Convex,
    rotation: &Matrix3<f64>,
    centre: &Vector3<f64>,
    limit_mm: f64,
) -> f64 {
    let round = one.round_mm + other.round_mm;
    // the other core in the first core's own frame
    let centre = one.rotation.tr_mul(&(centre - one.centre));
    let axis = || one.rotation.tr_mul(&rotation.column(2));
    let core = match (&one.core, &other.core) {
        (Core::Point, Core::Point) => centre.norm(),
        (Core::Box { half }, Core::Point) => point_box(&centre, half),
        (Core::Cylinder { radius, half }, Core::Point) => point_cylinder(&centre, *radius, *half),
        (Core::Box { half: edge }, Core::Segment { half }) => segment_box(&centre, &(axis() * *half), edge),
        (Core::Cylinder { radius, half: height }, Core::Segment { half }) => {
            segment_cylinder(&centre, &(axis() * *half), *radius, *height)
        }
        (Core::Segment { half }, Core::Point) => {
            Vector3::new(centre.x, centre.y, (centre.z.abs() - half).max(0.0)).norm()
        }
        (Core::Segment { half: mine }, Core::Segment { half }) => segment_segment(*mine, &centre, &(axis() * *half)),
        (Core::Hull { .. }, Core::Point) => {
            gjk_distance(&one.core, &other.core, &Matrix3::identity(), &centre, limit_mm + round)
        }
        _ => {
            let rotation = one.rotation.tr_mul(rotation);
            match (&one.core, &other.core) {
                // the closed forms have the simpler set second
                (Core::Point | Core::Segment { .. }, Core::Box { .. } | Core::Cylinder { .. })
                | (Core::Point, Core::Segment { .. }) => {
                    let back = -rotation.tr_mul(&centre);
                    let axis = rotation.row(2).transpose();
                    match (&one.core, &other.core) {
                        (Core::Point, Core::Box { half }) => point_box(&back, half),
                        (Core::Point, Core::Cylinder { radius, half }) => point_cylinder(&back, *radius, *half),
                        (Core::Segment { half }, Core::Box { half: edge }) => segment_box(&back, &(axis * *half), edge),
                        (Core::Segment { half }, Core::Cylinder { radius, half: height }) => {
                            segment_cylinder(&back, &(axis * *half), *radius, *height)
                        }
                        (_, Core::Segment { half }) => {
                            Vector3::new(back.x, back.y, (back.z.abs() - half).max(0.0)).norm()
                        }
                        _ => gjk_distance(&one.core, &other.core, &rotation, &centre, limit_mm + round),
                    }
                }
                _ => gjk_distance(&one.core, &other.core, &rotation, &centre, limit_mm + round),
            }
        }
    };
    core - round
}

#[inline]
fn point_box(p: &Vector3<f64>, half: &Vector3<f64>) -> f64 {
    (p.abs() - half).sup(&Vector3::zeros()).norm()
}

#[inline]
fn point_cylinder(p: &Vector3<f64>, radius: f64, half: f64) -> f64 {
    let across = ((p.x * p.x + p.y * p.y).sqrt() - radius).max(0.0);
    let above = (p.z.abs() - half).max(0.0);
    (across * across + above * above).sqrt()
}

/// Distance of the segment `centre ± v` from the box, mm.
pub(super) fn segment_box(centre: &Vector3<f64>, v: &Vector3<f64>, half: &Vector3<f64>) -> f64 {
    // slope of half the squared distance at centre + t·v
    let slope = |t: f64| {
        let mut sum = 0.0;
        for k in 0..3 {
            let x = centre[k] + t * v[k];
            sum += (x - x.clamp(-half[k], half[k])) * v[k];
        }
        sum
    };
    let at = |t: f64| point_box(&(centre + v * t), half);
    let (low_slope, high_slope) = (slope(-1.0), slope(1.0));
    if low_slope >= 0.0 {
        return at(-1.0);
    }
    if high_slope <= 0.0 {
        return at(1.0);
    }
    // shrink the bracket to a piece without a kink, where the slope is a straight line
    let (mut low, mut high, mut f_low, mut f_high) = (-1.0, 1.0, low_slope, high_slope);
    for k in 0..3 {
        if v[k].abs() < 1e-300 {
            continue;
        }
        for side in [-half[k], half[k]] {
            let t = (side - centre[k]) / v[k];
            if t > low && t < high {
                let f = slope(t);
                if f < 0.0 {
                    (low, f_low) = (t, f);
                } else {
                    (high, f_high) = (t, f);
                }
            }
        }
    }
    at(low + (high - low) * (f_low / (f_low - f_high)))
}

/// Distance of the segment `centre ± v` from the cylinder along z, mm.
fn segment_cylinder(centre: &Vector3<f64>, v: &Vector3<f64>, radius: f64, half: f64) -> f64 {
    let slope = |t: f64| {
        let p = centre + v * t;
        let r = (p.x * p.x + p.y * p.y).sqrt();
        let across = if r > radius { (1.0 - radius / r) * (p.x * v.x + p.y * v.y) } else { 0.0 };
        across + (p.z - p.z.clamp(-half, half)) * v.z
    };
    let at = |t: f64| point_cylinder(&(centre + v * t), radius, half);
    let (mut low, mut high) = (-1.0, 1.0);
    let (mut f_low, mut f_high) = (slope(low), slope(high));
    if f_low >= 0.0 {
        return at(low);
    }
    if f_high <= 0.0 {
        return at(high);
    }
    // Illinois: a bracketed secant; the distance is flat at its minimum, so 1e-7 of the segment gives far below 1 nm
    let mut side = 0;
    for _ in 0..60 {
        let t = (low * f_high - high * f_low) / (f_high - f_low);
        let f = slope(t);
        if f == 0.0 || high - low < 1e-7 {
            return at(t);
        }
        if f < 0.0 {
            (low, f_low) = (t, f);
            if side == -1 {
                f_high *= 0.5;
            }
            side = -1;
        } else {
            (high, f_high) = (t, f);
            if side == 1 {
                f_low *= 0.5;
            }
            side = 1;
        }
        if f.abs() < 1e-10 {
            return at(t);
        }
    }
    at(0.5 * (low + high))
}

/// Distance of the segment `±half` along z from the segment `centre ± v`, mm.
fn segment_segment(half: f64, centre: &Vector3<f64>, v: &Vector3<f64>) -> f64 {
    // for the point at t of the second segment the nearest of the first is clamped z: a box without width
    segment_box(centre, v, &Vector3::new(0.0, 0.0, half))
}

fn gjk_distance(one: &Core, other: &Core, rotation: &Matrix3<f64>, centre: &Vector3<f64>, limit: f64) -> f64 {
    let placed = Placed { core: other, rotation: *rotation, centre: *centre };
    let identity = ParryPose::IDENTITY;
    let direction = Vector::new(-centre.x, -centre.y, -centre.z);
    let direction = if direction.length_squared() > 1e-18 { direction.normalize() } else { Vector::X };
    let mut simplex = VoronoiSimplex::new();
    simplex.reset(CsoPoint::from_shapes(&identity, one, &placed, direction));
    match gjk::closest_points(&identity, one, &placed, limit.max(0.0), true, &mut simplex) {
        // not converged counts as touching: never as clear
        GJKResult::Intersection => 0.0,
        GJKResult::ClosestPoints(p, q, _) => (p - q).length(),
        GJKResult::Proximity(_) => 0.0,
        GJKResult::NoIntersection(_) => limit.max(0.0),
    }
}

/// Depth by which two overlapping sets penetrate, mm (positive); `None` when they are apart or the depth is unknown.
pub fn penetration(one: &Convex, one_link: &Pose, other: &Convex, other_link: &Pose) -> Option<f64> {
    let (shape, pose) = parry_shape(one, one_link)?;
    let (other_shape, other_pose) = parry_shape(other, other_link)?;
    let contact = parry3d::query::contact(&pose, &*shape.0, &other_pose, &*other_shape.0, 0.0).ok()??;
    (contact.dist < 0.0).then_some(-contact.dist)
}

/// The set as parry knows it, in the bed frame: for depths and, in tests, for distances by other means.
pub fn parry_shape(set: &Convex, link: &Pose) -> Option<(SharedShape, ParryPose)> {
    let vector = |v: &Vector3<f64>| Vector::new(v.x, v.y, v.z);
    let shape = match &set.core {
        Core::Point => SharedShape::ball(set.round_mm),
        Core::Segment { half } => SharedShape::capsule_z(*half, set.round_mm),
        Core::Box { half } => SharedShape::cuboid(half.x, half.y, half.z),
        Core::Cylinder { radius, half } => SharedShape::cylinder(*half, *radius),
        Core::Hull { corners } => SharedShape::convex_hull(&corners.iter().map(vector).collect::<Vec<_>>())?,
    };
    // parry's cylinder runs along y: z of ours becomes its y
    let z_from_y = Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0);
    let own = match set.core {
        Core::Cylinder { .. } => set.rotation * z_from_y,
        _ => set.rotation,
    };
    let rotation = link.rotation * own;
    let columns: Vec<Vector> = (0..3).map(|k| vector(&rotation.column(k).into_owned())).collect();
    let matrix = parry3d::math::Matrix::from_cols(columns[0], columns[1], columns[2]);
    let rotation = parry3d::math::Rotation::from_mat3(&matrix).normalize();
    Some((shape, ParryPose::from_parts(vector(&link.point(&set.centre)), rotation)))
}
