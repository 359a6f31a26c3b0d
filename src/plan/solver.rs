//! The generic setup: one ball on the line of a rotary axis, the other carried at ρ from it. It knows no mounts and no solids.
//!
//! The axis K has one of the two balls on its carried side at distance ρ from its line; the other ball stands still on
//! the line, h along it from the foot of the first. The bar is L = √(ρ² + h²): h = 0 shows where the line is,
//! h = ±√(L² − ρ²) shows in addition how it is inclined (thesis eq. 3.13 with D = h, eq. 7.1 with H_l = h); two places
//! along the axis are its chapter 6. The linear axes bring the balls there.

use nalgebra::{Matrix3, Vector3};

use crate::chain::{Chain, Geometry, LinkId};
use crate::machine::{AxisKind, Machine};

/// A ball: carrying link and place, mm.
pub type BallAt<'a> = (LinkId, &'a Vector3<f64>);

/// Why a setup cannot be brought about.
#[derive(Debug, Clone, PartialEq)]
pub enum Unreachable {
    /// A linear axis would have to leave its range.
    Limit { axis: usize, at_mm: f64, beyond_mm: f64 },
    /// The linear axes do not span the motion that is needed.
    Singular,
    /// The bar is shorter than the distance from the axis line.
    BarShort { by_mm: f64 },
}

/// Balls placed for the sweep of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Solved {
    /// Positions of all axes, mm and rad; the swept axis where the others were solved for.
    pub positions: Vec<f64>,
    /// Distance of the carried ball from the axis line, mm.
    pub rho_mm: f64,
    /// Along the axis direction from the carried ball's foot to the still ball, mm.
    pub h_mm: f64,
    /// Place of the still ball along the axis line, from the axis's origin, mm.
    pub along_mm: f64,
}

/// Distance of the carried ball from the line of `axis` and its foot's place along the line, mm.
pub fn lever(geometry: &Geometry, axis: usize, carried: BallAt, positions: &[f64]) -> (f64, f64) {
    let (origin, about) = line(geometry, axis, positions);
    let from = geometry.point(carried.0, carried.1, positions, None) - origin;
    let along = from.dot(&about);
    ((from - about * along).norm(), along)
}

/// Point and direction of an axis line in the bed frame.
fn line(geometry: &Geometry, axis: usize, positions: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
    let chain = geometry.chain();
    let joint = chain.joint(axis);
    let carried = chain.carried_by(axis);
    // a point on the line and the direction do not change with the axis's own motion
    let pose = geometry.pose(carried, positions, None);
    (pose.point(&joint.origin), pose.rotation * joint.direction)
}

/// Places the still ball on the line of `axis` with the bar at its length; `sign` is that of h, `start` gives the other axes.
pub fn solve(
    machine: &Machine,
    geometry: &Geometry,
    axis: usize,
    carried: BallAt,
    still: BallAt,
    (bar_mm, sign): (f64, f64),
    start: &[f64],
) -> Result<Solved, Unreachable> {
    let chain = geometry.chain();
    let mut q = start.to_vec();
    let (rho_mm, _) = lever(geometry, axis, carried, &q);
    if rho_mm > bar_mm + 1e-6 {
        return Err(Unreachable::BarShort { by_mm: rho_mm - bar_mm });
    }
    let h_mm = sign * (bar_mm * bar_mm - rho_mm * rho_mm).max(0.0).sqrt();
    // axes beyond the swept one would change ρ: they stay where they are
    let free: Vec<usize> = (0..machine.axes.len())
        .filter(|&k| machine.axes[k].kind == AxisKind::Linear && !is_between(chain, axis, k, carried.0))
        .collect();
    let gap = |q: &[f64]| {
        let (origin, about) = line(geometry, axis, q);
        let foot_along = (geometry.point(carried.0, carried.1, q, None) - origin).dot(&about);
        origin + about * (foot_along + h_mm) - geometry.point(still.0, still.1, q, None)
    };
    // the gap is linear in the positions of linear axes: one step solves, a second confirms
    for _ in 0..2 {
        let now = gap(&q);
        if now.norm() < 1e-9 {
            break;
        }
        let columns: Vec<Vector3<f64>> = free
            .iter()
            .map(|&k| {
                let mut stepped = q.clone();
                stepped[k] += 1.0;
                gap(&stepped) - now
            })
            .collect();
        // least motion: q += Jᵀ (J Jᵀ)⁻¹ (−gap)
        let gram: Matrix3<f64> = columns.iter().map(|c| c * c.transpose()).sum();
        let inverse = gram.try_inverse().filter(|_| gram.determinant() > 1e-6).ok_or(Unreachable::Singular)?;
        let pull = inverse * -now;
        for (&k, column) in free.iter().zip(&columns) {
            q[k] += column.dot(&pull);
        }
    }
    if gap(&q).norm() > 1e-6 {
        return Err(Unreachable::Singular);
    }
    let overrun = |k: usize| machine.axes[k].range.map_or(0.0, |(low, high)| (low - q[k]).max(q[k] - high));
    let worst = free.iter().copied().max_by(|&a, &b| overrun(a).total_cmp(&overrun(b)));
    if let Some(axis) = worst.filter(|&k| overrun(k) > 1e-9) {
        return Err(Unreachable::Limit { axis, at_mm: q[axis], beyond_mm: overrun(axis) });
    }
    let (origin, about) = line(geometry, axis, &q);
    let along_mm = (geometry.point(still.0, still.1, &q, None) - origin).dot(&about);
    Ok(Solved { positions: q, rho_mm, h_mm, along_mm })
}

/// True when `other` lies between `axis` and the link on the link's branch, so that it moves the link against the axis.
fn is_between(chain: &Chain, axis: usize, other: usize, link: LinkId) -> bool {
    let path = chain.path(link);
    let place = |k: usize| path.iter().position(|&a| a == k);
    matches!((place(axis), place(other)), (Some(a), Some(b)) if b > a)
}
