//! Lengths of one bar over many poses, several poses at a time in SIMD registers; derivatives are in `columns`.
//!
//! The instruction set is chosen when the program runs (AVX-512, AVX2 with FMA, NEON, or plain code).

use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

use super::geometry::Geometry;
use super::lanes::{Lanes, SIDE_BY_SIDE, Wide, Wide3};
use super::link::LinkId;
use super::lower::{StepKind, Way};
use super::poses::Poses;
use super::trig;

/// A bar between two balls over given poses, with all that stands still folded into constants.
#[derive(Debug, Clone)]
pub struct Bar<'p> {
    pub(super) pivot: BoundWay<'p>,
    pub(super) spindle: BoundWay<'p>,
    pub(super) ways: [Way; 2],
    pub(super) poses: &'p Poses,
}

/// A way with its steps bound to the positions they read.
#[derive(Debug, Clone)]
pub(super) struct BoundWay<'p> {
    pub steps: Vec<BoundStep<'p>>,
    pub ball: [f64; 3],
}

#[derive(Debug, Clone)]
pub(super) struct BoundStep<'p> {
    pub offset: [f64; 3],
    pub kind: StepKind,
    pub read: Read<'p>,
}

/// What a step reads, one entry per pose.
#[derive(Debug, Clone, Copy)]
pub(super) enum Read<'p> {
    Position(&'p [f64]),
    SineCosine(&'p [f64], &'p [f64]),
}

impl<'p> BoundWay<'p> {
    fn of(way: &Way, poses: &'p Poses) -> BoundWay<'p> {
        let steps = way.steps.iter().map(|step| BoundStep {
            offset: step.offset,
            kind: step.kind.clone(),
            read: match (&step.kind, poses.turn(step.axis)) {
                (StepKind::Turn { .. }, Some(turn)) => Read::SineCosine(&turn.sine, &turn.cosine),
                _ => Read::Position(poses.positions(step.axis)),
            },
        });
        BoundWay { steps: steps.collect(), ball: way.ball }
    }
}

impl Geometry<'_> {
    /// The bar between two balls, each a link and a place on it, prepared for many poses. Component errors are zero.
    pub fn bar<'p>(
        &self,
        pivot: (LinkId, &Vector3<f64>),
        spindle: (LinkId, &Vector3<f64>),
        poses: &'p Poses,
    ) -> Bar<'p> {
        let ways = [Way::of(self, pivot, poses), Way::of(self, spindle, poses)];
        let [pivot, spindle] = [0, 1].map(|k| BoundWay::of(&ways[k], poses));
        Bar { pivot, spindle, ways, poses }
    }
}

impl Bar<'_> {
    /// Ball-to-ball distance at every pose, mm; `out` has one place per pose (further places stay as they are).
    pub fn lengths_into(&self, out: &mut [f64]) {
        let rows = self.poses.rows().min(out.len());
        Arch::new().dispatch(Lengths { bar: self, out: &mut out[..rows] });
    }

    /// Ball-to-ball distance at every pose, mm.
    pub fn lengths(&self) -> Vec<f64> {
        let mut out = vec![0.0; self.poses.rows()];
        self.lengths_into(&mut out);
        out
    }
}

struct Lengths<'a, 'p> {
    bar: &'a Bar<'p>,
    out: &'a mut [f64],
}

impl WithSimd for Lengths<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let lanes = Lanes::<S, SIDE_BY_SIDE> { simd };
        let count = Lanes::<S, SIDE_BY_SIDE>::COUNT;
        for (group, out) in self.out.chunks_mut(count).enumerate() {
            let at = group * count;
            let pivot = bed_point(lanes, &self.bar.pivot, at, out.len());
            let spindle = bed_point(lanes, &self.bar.spindle, at, out.len());
            let gap = lanes.sub3(pivot, spindle);
            lanes.store(out, lanes.sqrt(lanes.dot(gap, gap)));
        }
    }
}

/// Ball in the bed frame.
#[inline(always)]
fn bed_point<S: Simd, const U: usize>(lanes: Lanes<S, U>, way: &BoundWay, at: usize, count: usize) -> Wide3<S, U> {
    let mut point = lanes.splat3(&way.ball);
    for step in way.steps.iter().rev() {
        let (sine, cosine) = step.read(lanes, at, count);
        point = step.outward(lanes, point, sine, cosine);
    }
    point
}

impl BoundStep<'_> {
    /// Sine and cosine of a turn, or position of a slide (twice), for `count` poses from `at`.
    #[inline(always)]
    pub(super) fn read<S: Simd, const U: usize>(
        &self,
        lanes: Lanes<S, U>,
        at: usize,
        count: usize,
    ) -> (Wide<S, U>, Wide<S, U>) {
        match (&self.kind, self.read) {
            (_, Read::SineCosine(sine, cosine)) => {
                (lanes.load(&sine[at..at + count]), lanes.load(&cosine[at..at + count]))
            }
            (StepKind::Turn { .. }, Read::Position(angle)) => trig::sin_cos(lanes, lanes.load(&angle[at..at + count])),
            (StepKind::Slide { .. }, Read::Position(position)) => {
                let position = lanes.load(&position[at..at + count]);
                (position, position)
            }
        }
    }

    /// A point of the inner frame in the outer frame.
    #[inline(always)]
    pub(super) fn outward<S: Simd, const U: usize>(
        &self,
        lanes: Lanes<S, U>,
        point: Wide3<S, U>,
        sine: Wide<S, U>,
        cosine: Wide<S, U>,
    ) -> Wide3<S, U> {
        match &self.kind {
            StepKind::Slide { direction } => {
                let mut out = point;
                for k in 0..3 {
                    let moved = lanes.add_scaled(lanes.splat(self.offset[k]), direction[k], sine);
                    out[k] = lanes.add(point[k], moved);
                }
                out
            }
            StepKind::Turn { matrix } => {
                let x = lanes.difference_of_products(cosine, point[0], sine, point[1]);
                let y = lanes.add_product(lanes.mul(sine, point[0]), cosine, point[1]);
                let turned = [x, y, point[2]];
                [
                    lanes.combine(lanes.splat(self.offset[0]), matrix[0], turned),
                    lanes.combine(lanes.splat(self.offset[1]), matrix[1], turned),
                    lanes.combine(lanes.splat(self.offset[2]), matrix[2], turned),
                ]
            }
        }
    }
}
