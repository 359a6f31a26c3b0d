//! The generic setup: one ball on the line of a rotary axis, the other carried at ρ from it. It knows no mounts and no solids.
//!
//! The axis K has one of the two balls on its carried side at distance ρ from its line; the other ball stands still on
//! the line, h along it from the foot of the first. The bar is L = √(ρ² + h²): h = 0 shows where the line is,
//! h = ±√(L² − ρ²) shows in addition how it is inclined (thesis eq. 3.13 with D = h, eq. 7.1 with H_l = h); two places
//! along the axis are its chapter 6. The linear axes bring the balls there.

use nalgebra::{DMatrix, DVector, SymmetricEigen, Vector3};

use crate::chain::{Chain, Geometry, LinkId, Pose};
use crate::machine::{AxisKind, Machine};

/// Why a setup cannot be brought about.
#[derive(Debug, Clone, PartialEq)]
pub enum Unreachable {
    /// The linear axes do not span the motion that is needed.
    Singular,
    /// A linear axis would have to leave its range.
    Limit { axis: usize, at_mm: f64, beyond_mm: f64 },
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

/// The line of one axis with all axes at their start: what the setups of that start have in common.
#[derive(Debug, Clone)]
pub struct Stance<'a> {
    machine: &'a Machine,
    axis: usize,
    start: &'a [f64],
    /// A point on the line and its direction, in the bed frame.
    origin: Vector3<f64>,
    about: Vector3<f64>,
    poses: Vec<(LinkId, Pose)>,
}

/// How the linear axes bring the balls to their places, for the links of the two balls.
#[derive(Debug, Clone)]
pub struct Pull {
    slides: Vec<Slide>,
    /// Pseudo-inverse of JᵀJ, row by row.
    inverse: DMatrix<f64>,
    /// Some slide moves the carried ball nearer to the line or away from it: ρ may be chosen.
    pub changes_lever: bool,
}

/// What a millimetre of one linear axis does, in the bed frame.
#[derive(Debug, Clone)]
struct Slide {
    axis: usize,
    line: Vector3<f64>,
    carried: Vector3<f64>,
    still: Vector3<f64>,
}

impl Pull {
    /// Linear axes that move the carried ball relative to the still one, and by what per millimetre in the bed frame.
    pub fn ways(&self) -> impl Iterator<Item = (usize, Vector3<f64>)> {
        self.slides.iter().map(|slide| (slide.axis, slide.carried - slide.still)).filter(|(_, way)| way.norm() > 1e-9)
    }
}

impl<'a> Stance<'a> {
    /// The line of `axis` with all axes at `start`, mm and rad.
    pub fn new(machine: &'a Machine, geometry: &Geometry, axis: usize, start: &'a [f64]) -> Stance<'a> {
        let chain = geometry.chain();
        let joint = chain.joint(axis);
        let mut poses = vec![(LinkId::BED, Pose::identity())];
        for (_, link) in chain.links() {
            poses.push((link, geometry.pose(link, start, None)));
        }
        // a point on the line and the direction do not change with the axis's own motion
        let pose = geometry.pose(chain.carried_by(axis), start, None);
        let (origin, about) = (pose.point(&joint.origin), pose.rotation * joint.direction);
        Stance { machine, axis, start, origin, about, poses }
    }

    /// A ball's place in the bed frame, mm.
    pub fn point(&self, (link, at): (LinkId, &Vector3<f64>)) -> Vector3<f64> {
        self.poses.iter().find(|(other, _)| *other == link).map_or(*at, |(_, pose)| pose.point(at))
    }

    /// Distance of a carried ball (bed frame) from the line and its foot's place along the line, mm.
    pub fn lever(&self, carried: &Vector3<f64>) -> (f64, f64) {
        let from = carried - self.origin;
        let along = from.dot(&self.about);
        ((from - self.about * along).norm(), along)
    }

    /// Direction of the line in the bed frame.
    pub fn about(&self) -> &Vector3<f64> {
        &self.about
    }

    /// A point on the line in the bed frame, mm.
    pub fn origin(&self) -> &Vector3<f64> {
        &self.origin
    }

    /// A direction of a link as it stands in the bed frame.
    pub fn turned(&self, link: LinkId, direction: &Vector3<f64>) -> Vector3<f64> {
        let pose = self.poses.iter().find(|(other, _)| *other == link);
        pose.map_or(*direction, |(_, pose)| pose.rotation * direction)
    }

    /// The linear axes' pull for balls on these links.
    pub fn pull(&self, chain: &Chain, carried: LinkId, still: LinkId) -> Pull {
        let with_line = chain.carried_by(self.axis);
        let linear = self.machine.axes_of(AxisKind::Linear);
        let slides: Vec<Slide> = linear
            .map(|k| {
                let joint = chain.joint(k);
                // a slide moves what it carries along its direction as the axes before it turned it
                let turned = self.poses.iter().find(|(link, _)| *link == chain.carried_by(k));
                let way = turned.map_or(joint.direction, |(_, pose)| pose.rotation * joint.direction) * joint.sign;
                let moved = |link: LinkId| if chain.carries(k, link) { way } else { Vector3::zeros() };
                Slide { axis: k, line: moved(with_line), carried: moved(carried), still: moved(still) }
            })
            .collect();
        let normal = DMatrix::from_fn(slides.len(), slides.len(), |i, j| {
            self.off_line(&slides[i]).dot(&self.off_line(&slides[j]))
                + (slides[i].carried - slides[i].still).dot(&(slides[j].carried - slides[j].still))
        });
        let changes_lever = slides.iter().any(|slide| self.radial(&(slide.carried - slide.line)).norm() > 1e-9);
        Pull { inverse: pseudo_inverse(normal), slides, changes_lever }
    }

    /// The part of a vector across the line.
    fn radial(&self, vector: &Vector3<f64>) -> Vector3<f64> {
        vector - self.about * vector.dot(&self.about)
    }

    fn off_line(&self, slide: &Slide) -> Vector3<f64> {
        self.radial(&(slide.line - slide.still))
    }

    /// Places the still ball on the line and the carried one at ρ = `lever_mm` from it with the bar at its length; `sign` is
    /// that of h. Balls in the bed frame at the start; least motion from there.
    pub fn solve(
        &self,
        pull: &Pull,
        carried: &Vector3<f64>,
        still: &Vector3<f64>,
        lever_mm: f64,
        (bar_mm, sign): (f64, f64),
    ) -> Result<Solved, Unreachable> {
        if lever_mm > bar_mm + 1e-6 {
            return Err(Unreachable::BarShort { by_mm: lever_mm - bar_mm });
        }
        let h_mm = sign * (bar_mm * bar_mm - lever_mm * lever_mm).max(0.0).sqrt();
        let outward = self.radial(&(carried - self.origin));
        let outward =
            outward.try_normalize(1e-6).unwrap_or_else(|| self.about.cross(&any_across(&self.about)).normalize());
        // two demands, both linear in the slides: still ball on the line, and the wanted way from it to the carried ball
        let off_line = self.radial(&(self.origin - still));
        let off_way = (carried - still) - (outward * lever_mm - self.about * h_mm);
        let right = DVector::from_iterator(
            pull.slides.len(),
            pull.slides
                .iter()
                .map(|slide| self.off_line(slide).dot(&off_line) + (slide.carried - slide.still).dot(&off_way)),
        );
        let step = &pull.inverse * right;
        let (mut left_line, mut left_way) = (off_line, off_way);
        let mut along_mm = (still - self.origin).dot(&self.about);
        for (slide, step) in pull.slides.iter().zip(step.iter()) {
            left_line -= self.off_line(slide) * *step;
            left_way -= (slide.carried - slide.still) * *step;
            along_mm -= (slide.still - slide.line).dot(&self.about) * step;
        }
        if left_line.norm() > 1e-6 || left_way.norm() > 1e-6 {
            return Err(Unreachable::Singular);
        }
        let position = |(slide, step): (&Slide, &f64)| (slide.axis, self.start[slide.axis] - step);
        let overrun = |k: usize, q: f64| self.machine.axes[k].range.map_or(0.0, |(low, high)| (low - q).max(q - high));
        let moved = || pull.slides.iter().zip(step.iter()).map(position);
        let worst = moved().map(|(k, q)| (overrun(k, q), k, q)).max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((beyond_mm, axis, at_mm)) = worst.filter(|worst| worst.0 > 1e-9) {
            return Err(Unreachable::Limit { axis, at_mm, beyond_mm });
        }
        let mut positions = self.start.to_vec();
        moved().for_each(|(k, q)| positions[k] = q);
        Ok(Solved { positions, rho_mm: lever_mm, h_mm, along_mm })
    }
}

/// A vector that is not along `about`.
fn any_across(about: &Vector3<f64>) -> Vector3<f64> {
    if about.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() }
}

/// Pseudo-inverse of a symmetric matrix with eigenvalues of order one: directions that nothing moves stay still.
fn pseudo_inverse(matrix: DMatrix<f64>) -> DMatrix<f64> {
    let size = matrix.nrows();
    let eigen = SymmetricEigen::new(matrix);
    let mut inverse = DMatrix::zeros(size, size);
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if *value > 1e-9 {
            inverse += vector * vector.transpose() / *value;
        }
    }
    inverse
}
