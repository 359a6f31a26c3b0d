//! Derivatives of a bar's length over many poses with respect to chosen quantities; the single-pose form is `sensitivity`.
//!
//! `∂L/∂p = g·v(r)` in any frame of a ball's way: g the bar's direction there, r the ball, `v = W·r + c` the ball's
//! velocity per unit of p, with W and c constant. With exact composition W is antisymmetric, W·r = w × r, and
//! `g·v = w·(r × g) + c·g`: a dot product of six constants with the bar's force and moment. The first-order matrices
//! are not rotations and take the nine products g·r one by one.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::batch::{Bar, BoundWay};
use super::column::Column;
use super::geometry::{Composition, Geometry};
use super::lanes::{Lanes, SIDE_BY_SIDE, Wide, Wide3};
use super::lower::{StepKind, Velocity};

/// A bar with the columns to be computed, ready for blocks of poses.
#[derive(Debug, Clone)]
pub struct Derivatives<'b, 'p> {
    bar: &'b Bar<'p>,
    columns: usize,
    /// Per way (pivot, spindle), in the order of the frames.
    sums: [Vec<ColumnSum>; 2],
    /// Columns that no frame writes.
    untouched: Vec<usize>,
    composition: Composition,
}

/// One column: constants times products of the frame.
#[derive(Debug, Clone)]
struct ColumnSum {
    /// Frame in which the column is read off.
    frame: usize,
    column: usize,
    /// Product and its constant; the first `used` count.
    terms: [(usize, f64); MAX_TERMS],
    used: usize,
    /// Some products are those of point and force.
    takes_moments: bool,
    times_position_of: Option<usize>,
    write: Write,
}

/// Three of the force and nine of the first-order products.
const MAX_TERMS: usize = 12;

#[derive(Debug, Clone, Copy)]
enum Write {
    Replace,
    Add,
}

impl<'p> Bar<'p> {
    /// Prepares the derivatives with respect to `columns` in the geometry that the bar was made from.
    pub fn derivatives<'b>(&'b self, geometry: &Geometry, columns: &[Column]) -> Derivatives<'b, 'p> {
        let composition = geometry.composition();
        let mut sums = [0, 1].map(|_| Vec::with_capacity(columns.len()));
        let mut untouched = Vec::new();
        for (index, &column) in columns.iter().enumerate() {
            let mut write = Write::Replace;
            for (k, way) in self.ways.iter().enumerate() {
                // a ball's place moves that ball alone
                if matches!((k, column), (1, Column::Pivot(_)) | (0, Column::Spindle(_) | Column::SpindleReversed(_))) {
                    continue;
                }
                if let Some(velocity) = way.velocity(geometry, column, self.poses) {
                    sums[k].push(ColumnSum::of(index, &velocity, composition, write));
                    write = Write::Add;
                }
            }
            if matches!(write, Write::Replace) {
                untouched.push(index);
            }
        }
        sums.iter_mut().for_each(|sums| sums.sort_by_key(|sum| sum.frame));
        Derivatives { bar: self, columns: columns.len(), sums, untouched, composition }
    }
}

impl ColumnSum {
    fn of(column: usize, velocity: &Velocity, composition: Composition, write: Write) -> ColumnSum {
        let matrix = &velocity.matrix;
        let (mut terms, mut used) = ([(0, 0.0); MAX_TERMS], 0);
        let mut take = |product: usize, factor: f64| {
            if factor != 0.0 {
                terms[used] = (product, factor);
                used += 1;
            }
        };
        for k in 0..3 {
            take(k, velocity.constant[k]);
        }
        match composition {
            Composition::Exact => {
                for k in 0..3 {
                    let (a, b) = ((k + 1) % 3, (k + 2) % 3);
                    take(3 + k, 0.5 * (matrix[(b, a)] - matrix[(a, b)]));
                }
            }
            Composition::FirstOrder => {
                for k in 0..9 {
                    take(3 + k, matrix[(k / 3, k % 3)]);
                }
            }
        }
        ColumnSum {
            frame: velocity.frame,
            column,
            terms,
            used,
            takes_moments: terms[..used].iter().any(|term| term.0 >= 3),
            times_position_of: velocity.times_position_of,
            write,
        }
    }
}

impl Derivatives<'_, '_> {
    /// Lengths (mm) and derivatives at the poses `rows`. `derivatives` holds one column after the other, each as long
    /// as `lengths`, which is as long as `rows`.
    pub fn evaluate(&self, rows: Range<usize>, lengths: &mut [f64], derivatives: &mut [f64]) {
        let end = rows.end.min(self.bar.poses.rows());
        let start = rows.start.min(end);
        let count = (end - start).min(lengths.len());
        let stride = lengths.len();
        let derivatives = &mut derivatives[..stride * self.columns];
        for &column in &self.untouched {
            derivatives[column * stride..(column + 1) * stride].fill(0.0);
        }
        Arch::new().dispatch(Evaluation { of: self, start, stride, lengths: &mut lengths[..count], derivatives });
    }
}

struct Evaluation<'a, 'b, 'p> {
    of: &'a Derivatives<'b, 'p>,
    start: usize,
    stride: usize,
    lengths: &'a mut [f64],
    derivatives: &'a mut [f64],
}

/// A ball's way at one group of poses.
struct Tape<S: Simd, const U: usize> {
    /// The ball in every frame.
    points: Vec<Wide3<S, U>>,
    /// Sine and cosine of every step (slides: unused).
    turns: Vec<(Wide<S, U>, Wide<S, U>)>,
}

impl<S: Simd, const U: usize> Tape<S, U> {
    #[inline(always)]
    fn blank(lanes: Lanes<S, U>, way: &BoundWay) -> Self {
        let zero = lanes.splat(0.0);
        Tape { points: vec![[zero; 3]; way.steps.len() + 1], turns: vec![(zero, zero); way.steps.len()] }
    }

    /// Ball in the bed frame; its places in all frames are kept.
    #[inline(always)]
    fn record(&mut self, lanes: Lanes<S, U>, way: &BoundWay, at: usize, count: usize) -> Wide3<S, U> {
        let mut point = lanes.splat3(&way.ball);
        for (k, step) in way.steps.iter().enumerate().rev() {
            self.points[k + 1] = point;
            let turn = step.read(lanes, at, count);
            self.turns[k] = turn;
            point = step.outward(lanes, point, turn.0, turn.1);
        }
        self.points[0] = point;
        point
    }
}

impl WithSimd for Evaluation<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let lanes = Lanes::<S, SIDE_BY_SIDE> { simd };
        let count = Lanes::<S, SIDE_BY_SIDE>::COUNT;
        let bar = self.of.bar;
        let mut tapes = [Tape::blank(lanes, &bar.pivot), Tape::blank(lanes, &bar.spindle)];
        for (group, lengths) in self.lengths.chunks_mut(count).enumerate() {
            let row = group * count;
            let at = self.start + row;
            let pivot = tapes[0].record(lanes, &bar.pivot, at, lengths.len());
            let spindle = tapes[1].record(lanes, &bar.spindle, at, lengths.len());
            let gap = lanes.sub3(pivot, spindle);
            let square = lanes.dot(gap, gap);
            let length = lanes.sqrt(square);
            lanes.store(lengths, length);
            // balls that coincide have no direction: their derivatives are zero
            let mut inverse = lanes.div(lanes.splat(1.0), length);
            for u in 0..SIDE_BY_SIDE {
                let apart = simd.greater_than_f64s(length[u], simd.splat_f64s(0.0));
                inverse[u] = simd.select_f64s(apart, inverse[u], simd.splat_f64s(0.0));
            }
            let pull = lanes.mul3(gap, inverse);
            let opposite = lanes.sub3([lanes.splat(0.0); 3], pull);
            let mut output =
                Output { of: self.of, at, row, count: lengths.len(), stride: self.stride, into: self.derivatives };
            output.walk(lanes, &bar.pivot, &self.of.sums[0], &tapes[0], pull);
            output.walk(lanes, &bar.spindle, &self.of.sums[1], &tapes[1], opposite);
        }
    }
}

struct Output<'a, 'b, 'p> {
    of: &'a Derivatives<'b, 'p>,
    at: usize,
    row: usize,
    count: usize,
    stride: usize,
    into: &'a mut [f64],
}

impl Output<'_, '_, '_> {
    /// Carries the bar's pull from the bed to the ball and reads off the columns on the way.
    #[inline(always)]
    fn walk<S: Simd, const U: usize>(
        &mut self,
        lanes: Lanes<S, U>,
        way: &BoundWay,
        sums: &[ColumnSum],
        tape: &Tape<S, U>,
        pull: Wide3<S, U>,
    ) {
        let mut g = pull;
        let mut rest = sums;
        for k in 0..=way.steps.len() {
            let here = rest.iter().take_while(|sum| sum.frame == k).count();
            if here > 0 {
                self.write_frame(lanes, &rest[..here], g, &tape.points[k]);
                rest = &rest[here..];
            }
            if rest.is_empty() {
                return;
            }
            if let Some(step) = way.steps.get(k)
                && let StepKind::Turn { matrix } = &step.kind
            {
                g = inward(lanes, matrix, g, tape.turns[k]);
            }
        }
    }

    #[inline(always)]
    fn write_frame<S: Simd, const U: usize>(
        &mut self,
        lanes: Lanes<S, U>,
        sums: &[ColumnSum],
        g: Wide3<S, U>,
        r: &Wide3<S, U>,
    ) {
        match (self.of.composition, sums.iter().any(|sum| sum.takes_moments)) {
            (Composition::Exact, true) => {
                let m = lanes.cross(*r, g);
                self.write_sums(lanes, sums, &[g[0], g[1], g[2], m[0], m[1], m[2], m[2], m[2]]);
            }
            (Composition::FirstOrder, true) => {
                let (x, y, z) = (lanes.mul3(*r, g[0]), lanes.mul3(*r, g[1]), lanes.mul3(*r, g[2]));
                let (g0, g1, g2) = (g[0], g[1], g[2]);
                let products =
                    [g0, g1, g2, x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2], z[2], z[2], z[2], z[2]];
                self.write_sums(lanes, sums, &products);
            }
            (_, false) => self.write_sums(lanes, sums, &[g[0], g[1], g[2], g[2]]),
        }
    }

    /// `products`: g (3), then r × g (3) or the nine `g_i·r_j`; filled up to a power of two, to which indices are cut.
    #[inline(always)]
    fn write_sums<S: Simd, const U: usize, const N: usize>(
        &mut self,
        lanes: Lanes<S, U>,
        sums: &[ColumnSum],
        products: &[Wide<S, U>; N],
    ) {
        for sum in sums {
            let mut value = lanes.splat(0.0);
            for &(product, factor) in &sum.terms[..sum.used] {
                value = lanes.add_scaled(value, factor, products[product % N]);
            }
            if let Some(axis) = sum.times_position_of {
                let positions = &self.of.bar.poses.positions(axis)[self.at..self.at + self.count];
                value = lanes.mul(value, lanes.load(positions));
            }
            let start = sum.column * self.stride + self.row;
            let into = &mut self.into[start..start + self.count];
            match sum.write {
                Write::Replace => lanes.store(into, value),
                Write::Add => lanes.store(into, lanes.add(lanes.load(into), value)),
            }
        }
    }
}

/// The pull seen in the inner frame of a turn: `Rz(−q)·matrixᵀ·g`.
#[inline(always)]
fn inward<S: Simd, const U: usize>(
    lanes: Lanes<S, U>,
    matrix: &[[f64; 3]; 3],
    g: Wide3<S, U>,
    (sine, cosine): (Wide<S, U>, Wide<S, U>),
) -> Wide3<S, U> {
    let zero = lanes.splat(0.0);
    let x = lanes.combine(zero, [matrix[0][0], matrix[1][0], matrix[2][0]], g);
    let y = lanes.combine(zero, [matrix[0][1], matrix[1][1], matrix[2][1]], g);
    let z = lanes.combine(zero, [matrix[0][2], matrix[1][2], matrix[2][2]], g);
    [lanes.add_product(lanes.mul(cosine, x), sine, y), lanes.difference_of_products(cosine, y, sine, x), z]
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::Vector3;

    use super::*;
    use crate::chain::{Chain, Poses};

    /// Lengths and all columns of one bar on one instruction set.
    fn on<S: Simd>(simd: S, derivatives: &Derivatives, rows: usize) -> Vec<f64> {
        let mut lengths = vec![0.0; rows];
        let mut values = vec![0.0; rows * derivatives.columns];
        simd.vectorize(Evaluation {
            of: derivatives,
            start: 0,
            stride: rows,
            lengths: &mut lengths,
            derivatives: &mut values,
        });
        lengths.extend(values);
        lengths
    }

    /// The machine that runs the tests dispatches to one instruction set: the others must give the same.
    #[test]
    fn every_instruction_set_gives_the_same() {
        let yaml = "name: m\ncode: '[wCAYbXZt]'\naxes: {}\n";
        let machine = crate::load::machine_from_yaml(Path::new("m.yaml"), yaml.into()).unwrap();
        let chain = Chain::of(&machine);
        let errors = vec![[0.01, -0.02, 0.03, 1e-3, 2e-3, -1e-3]; 5];
        // 19 poses end inside every register and every group
        let columns = (0..5).map(|axis| (0..19).map(|row| f64::from(row * (axis + 2) % 7) * 0.7 - 2.0).collect());
        let poses = Poses::from_columns(columns);
        let (pivot, spindle) = (Vector3::new(80.0, 60.0, 5.0), Vector3::new(3.0, -2.0, 120.0));
        let all: Vec<Column> = (0..5)
            .flat_map(|axis| (0..6).map(move |component| Column::Location { axis, component }))
            .chain((0..3).map(Column::Pivot))
            .collect();
        for composition in [Composition::Exact, Composition::FirstOrder] {
            let geometry = Geometry::new(&chain, &errors, composition);
            let ends = (chain.link("w").unwrap(), chain.link("t").unwrap());
            let bar = geometry.bar((ends.0, &pivot), (ends.1, &spindle), &poses);
            let derivatives = bar.derivatives(&geometry, &all);
            let plain = on(pulp::Scalar, &derivatives, 19);
            let mut sets = vec![plain.clone()];
            #[cfg(target_arch = "x86_64")]
            {
                sets.extend(pulp::x86::V3::try_new().map(|simd| on(simd, &derivatives, 19)));
                sets.extend(pulp::x86::V4::try_new().map(|simd| on(simd, &derivatives, 19)));
            }
            println!("{} instruction sets", sets.len());
            for set in sets {
                for (one, other) in plain.iter().zip(&set) {
                    // fused and separate rounding of lengths and levers of some 100 mm
                    assert!((one - other).abs() < 1e-11, "{one} and {other}");
                }
            }
        }
    }
}
