//! Sweeps of one axis reduced to a few numbers without loss, for constant errors and white noise; no fit.
//!
//! Along a sweep of a turning axis the length is a smooth periodic function of the angle (exactly
//! `L² = a + b·cos θ + c·sin θ`), along a sliding axis a smooth function of the position (`L² = a + b·q + c·q²`),
//! whatever the constant errors and ball places. To far below a nanometre it therefore equals its interpolant through
//! M nodes, `L(θ) = Σ_m ℓ_m(θ)·L(θ_m)`, and the sum of squares over all samples is
//!
//! ```text
//! Σ_i (y_i − L(θ_i) − d)² = Σ y² − 2·fᵀv + vᵀWv,   v_m = L(θ_m) + d,   f_m = Σ_i ℓ_m(θ_i)·y_i,   W = Σ_i ℓℓᵀ
//! ```
//!
//! with y and v counted from a common constant. f, Σy² and the number of samples are all that the readings contribute,
//! W depends on the positions alone. Nothing is linearised: the same minimum, gradient and covariance come out as from
//! the samples. What is lost is everything that is not a constant error: direction, time and position dependence.

use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

use crate::chain::lanes::Lanes;
use crate::chain::{Chain, Geometry, LinkId, Poses, sines_and_cosines};
use crate::machine::AxisKind;

/// Largest length left out by the interpolation for errors up to [`MARGIN_MM`], mm: a picometre.
const TRUNCATION_MM: f64 = 1e-9;
/// Displacement of a ball up to which the truncation holds, mm: ten times a usual placement error.
const MARGIN_MM: f64 = 0.2;
/// Sweeps that need more harmonics are left as samples.
const MAX_HARMONICS: usize = 16;
/// Nodes at which harmonics are judged.
const FINE_NODES: usize = 64;
/// Harmonics that are judged: fewer than half the nodes, so that none is mistaken for another.
const JUDGED_HARMONICS: usize = 28;

/// Positions of a sweep in the form that turns readings into statistics.
#[derive(Debug, Clone)]
pub struct SweepBasis {
    /// Poses of the nodes.
    pub nodes: Poses,
    /// `W`, nodes × nodes.
    pub weight: Vec<f64>,
    harmonics: usize,
    /// cos θ of a turn, or the position scaled to −1…1 of a slide, by row.
    cosine: Vec<f64>,
    /// sin θ of a turn, empty for a slide.
    sine: Vec<f64>,
    /// Nodes × functions: value of `ℓ_m` as a sum over 1, cos kθ, sin kθ.
    cardinal: Vec<f64>,
}

/// What the readings of a sweep contribute.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepStatistics {
    /// `f`, one per node, of readings counted from `base_mm`.
    pub projected: Vec<f64>,
    /// Σ (y − base)², mm².
    pub squares: f64,
    pub base_mm: f64,
    pub samples: usize,
}

/// Where interpolation nodes lie and which functions interpolate.
#[derive(Debug, Clone, Copy)]
enum Family {
    /// cos kθ and sin kθ on the whole circle.
    Turn,
    /// Chebyshev polynomials between two positions.
    Slide { middle: f64, half: f64 },
}

impl Family {
    /// Angles of `count` nodes.
    fn angles(self, count: usize) -> Vec<f64> {
        let node = |m: usize| match self {
            Family::Turn => std::f64::consts::TAU * m as f64 / count as f64,
            Family::Slide { .. } => std::f64::consts::PI * (m as f64 + 0.5) / count as f64,
        };
        (0..count).map(node).collect()
    }

    fn position(self, angle: f64) -> f64 {
        match self {
            Family::Turn => angle,
            Family::Slide { middle, half } => middle + half * angle.cos(),
        }
    }

    fn node_count(self, harmonics: usize) -> usize {
        match self {
            Family::Turn => 2 * harmonics + 1,
            Family::Slide { .. } => harmonics + 1,
        }
    }
}

impl SweepBasis {
    /// Basis of a test's poses between two balls; `None` when not exactly one axis moves or its length varies too much.
    pub fn of(
        geometry: &Geometry,
        pivot: (LinkId, &Vector3<f64>),
        spindle: (LinkId, &Vector3<f64>),
        poses: &Poses,
    ) -> Option<SweepBasis> {
        let moving = poses.moving();
        let &[axis] = moving.as_slice() else { return None };
        let chain = geometry.chain();
        let positions = poses.positions(axis);
        let family = match chain.joint(axis).kind {
            AxisKind::Rotary => Family::Turn,
            AxisKind::Linear => {
                let (low, high) = range(positions);
                Family::Slide { middle: 0.5 * (low + high), half: 0.5 * (high - low) }
            }
        };
        let harmonics = harmonics_needed(geometry, pivot, spindle, poses, axis, family)?;
        let (sine, cosine) = match family {
            Family::Turn => sines_and_cosines(positions),
            Family::Slide { middle, half } => {
                (Vec::new(), positions.iter().map(|q| ((q - middle) / half).clamp(-1.0, 1.0)).collect())
            }
        };
        let angles = family.angles(family.node_count(harmonics));
        let cardinal = cardinal(&angles, harmonics, family);
        let nodes = node_poses(chain, poses, axis, family, &angles);
        let mut basis = SweepBasis { nodes, weight: Vec::new(), harmonics, cosine, sine, cardinal };
        basis.weight = basis.weights();
        Some(basis)
    }

    /// Reduces readings, one per row, to their statistics.
    pub fn compress(&self, reading_mm: &[f64]) -> SweepStatistics {
        let base_mm = reading_mm.first().copied().unwrap_or(0.0);
        let (sums, squares) = self.sums(reading_mm, base_mm, self.harmonics);
        let functions = sums.len();
        let projected = self
            .cardinal
            .chunks(functions)
            .map(|row| row.iter().zip(&sums).map(|(factor, sum)| factor * sum).sum())
            .collect();
        SweepStatistics { projected, squares, base_mm, samples: self.cosine.len() }
    }

    /// `Σ y`, `Σ y·cos kθ` for k = 1…, then `Σ y·sin kθ`, and `Σ y²`, y counted from `base`.
    fn sums(&self, values: &[f64], base: f64, harmonics: usize) -> (Vec<f64>, f64) {
        Arch::new().dispatch(Sums { values, base, cosine: &self.cosine, sine: &self.sine, harmonics })
    }

    /// `W = Σ ℓℓᵀ` from sums of products of cosines and sines.
    fn weights(&self) -> Vec<f64> {
        let ones = vec![1.0; self.cosine.len()];
        let k = self.harmonics;
        let (sums, _) = self.sums(&ones, 0.0, 2 * k);
        let cosine = |n: i64| sums[n.unsigned_abs() as usize];
        let sine = |n: i64| if n == 0 { 0.0 } else { sums[2 * k + n.unsigned_abs() as usize] * n.signum() as f64 };
        let functions = self.cardinal.len() / self.node_count();
        // function 0…K: cos, then sin 1…K
        let product = |i: usize, j: usize| {
            let (a, b) = ((if i > k { i - k } else { i }) as i64, (if j > k { j - k } else { j }) as i64);
            0.5 * match (i > k, j > k) {
                (false, false) => cosine(a + b) + cosine(a - b),
                (true, true) => cosine(a - b) - cosine(a + b),
                (true, false) => sine(a + b) + sine(a - b),
                (false, true) => sine(a + b) + sine(b - a),
            }
        };
        let nodes = self.node_count();
        let mut weight = vec![0.0; nodes * nodes];
        for m in 0..nodes {
            let row = &self.cardinal[m * functions..(m + 1) * functions];
            let through: Vec<f64> =
                (0..functions).map(|j| (0..functions).map(|i| row[i] * product(i, j)).sum()).collect();
            for n in 0..nodes {
                let other = &self.cardinal[n * functions..(n + 1) * functions];
                weight[m * nodes + n] = through.iter().zip(other).map(|(x, y)| x * y).sum();
            }
        }
        weight
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.nodes.rows()
    }
}

fn range(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &q| (low.min(q), high.max(q)))
}

/// Poses with the swept axis at the nodes and the others where they stand.
fn node_poses(chain: &Chain, poses: &Poses, axis: usize, family: Family, angles: &[f64]) -> Poses {
    let columns = (0..chain.axis_count()).map(|other| match poses.standing(other) {
        Some(q) if other != axis => vec![q; angles.len()],
        _ => angles.iter().map(|&angle| family.position(angle)).collect(),
    });
    Poses::from_columns(columns).with_sines(chain)
}

/// `ℓ_m = (1 + 2 Σ_k cos kθ_m·cos kθ [+ sin kθ_m·sin kθ])/M` as factors of the functions.
fn cardinal(angles: &[f64], harmonics: usize, family: Family) -> Vec<f64> {
    let share = 1.0 / angles.len() as f64;
    let mut factors = Vec::new();
    for angle in angles {
        factors.push(share);
        factors.extend((1..=harmonics).map(|k| 2.0 * share * (k as f64 * angle).cos()));
        if let Family::Turn = family {
            factors.extend((1..=harmonics).map(|k| 2.0 * share * (k as f64 * angle).sin()));
        }
    }
    factors
}

/// Harmonics after which the rest of the length is below [`TRUNCATION_MM`], for balls within [`MARGIN_MM`].
fn harmonics_needed(
    geometry: &Geometry,
    pivot: (LinkId, &Vector3<f64>),
    spindle: (LinkId, &Vector3<f64>),
    poses: &Poses,
    axis: usize,
    family: Family,
) -> Option<usize> {
    let angles = family.angles(FINE_NODES);
    let nodes = node_poses(geometry.chain(), poses, axis, family, &angles);
    let multiples: Vec<f64> =
        (1..=JUDGED_HARMONICS).flat_map(|k| angles.iter().map(move |angle| k as f64 * angle)).collect();
    let (sine, cosine) = sines_and_cosines(&multiples);
    let mut needed = 1;
    for direction in 0..6 {
        let mut place = *spindle.1;
        place[direction % 3] += if direction < 3 { MARGIN_MM } else { -MARGIN_MM };
        let mut lengths = geometry.bar(pivot, (spindle.0, &place), &nodes).lengths();
        // counted from the first value: rounding of a constant length is no harmonic
        let first = lengths[0];
        lengths.iter_mut().for_each(|length| *length -= first);
        let project = |table: &[f64]| lengths.iter().zip(table).map(|(length, factor)| length * factor).sum::<f64>();
        let mut rest = 0.0;
        let enough = (1..=JUDGED_HARMONICS).rev().find(|k| {
            let here = (k - 1) * FINE_NODES..k * FINE_NODES;
            let (c, s) = match family {
                Family::Turn => (project(&cosine[here.clone()]), project(&sine[here])),
                Family::Slide { .. } => (project(&cosine[here]), 0.0),
            };
            rest += 2.0 / FINE_NODES as f64 * c.hypot(s);
            rest > TRUNCATION_MM
        });
        needed = needed.max(enough.unwrap_or(0));
    }
    (needed <= MAX_HARMONICS).then_some(needed)
}

struct Sums<'a> {
    values: &'a [f64],
    base: f64,
    cosine: &'a [f64],
    sine: &'a [f64],
    harmonics: usize,
}

/// Most harmonics summed in one pass: twice those of a basis.
const MAX_SUMS: usize = 2 * MAX_HARMONICS + 1;

impl WithSimd for Sums<'_> {
    type Output = (Vec<f64>, f64);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> (Vec<f64>, f64) {
        // sums held in registers for the few harmonics that bars need, in memory for more
        match self.harmonics {
            0..=2 => self.pass::<S, 3>(simd),
            3 => self.pass::<S, 4>(simd),
            4 => self.pass::<S, 5>(simd),
            5 => self.pass::<S, 6>(simd),
            6..=8 => self.pass::<S, 9>(simd),
            _ => self.pass::<S, MAX_SUMS>(simd),
        }
    }
}

impl Sums<'_> {
    /// One pass over the values with room for `ROOM − 1` harmonics.
    #[inline(always)]
    fn pass<S: Simd, const ROOM: usize>(self, simd: S) -> (Vec<f64>, f64) {
        let lanes = Lanes::<S, 1> { simd };
        let count = S::F64_LANES;
        let zero = lanes.splat(0.0);
        let (mut cosine_sums, mut sine_sums) = ([zero; ROOM], [zero; ROOM]);
        let mut squares = zero;
        let rows = self.values.len().min(self.cosine.len());
        let mut row = 0;
        while row < rows {
            let end = (row + count).min(rows);
            let mut y = lanes.load(&self.values[row..end]);
            y = lanes.sub(y, lanes.splat(self.base));
            if end - row < count {
                // rows beyond the last count as zero
                let mut part = [0.0; 8];
                for (part, value) in part.iter_mut().zip(&self.values[row..end]) {
                    *part = value - self.base;
                }
                y = lanes.load(&part[..end - row]);
            }
            squares = lanes.add_product(squares, y, y);
            let c = lanes.load(&self.cosine[row..end]);
            let twice = lanes.add(c, c);
            cosine_sums[0] = lanes.add(cosine_sums[0], y);
            // y·cos kθ and y·sin kθ by cos(k+1)θ = 2 cos θ·cos kθ − cos(k−1)θ
            let (mut last, mut here) = (y, lanes.mul(y, c));
            for sum in &mut cosine_sums[1..] {
                *sum = lanes.add(*sum, here);
                let next = lanes.sub(lanes.mul(twice, here), last);
                (last, here) = (here, next);
            }
            if !self.sine.is_empty() {
                let (mut last, mut here) = (zero, lanes.mul(y, lanes.load(&self.sine[row..end])));
                for sum in &mut sine_sums[1..] {
                    *sum = lanes.add(*sum, here);
                    let next = lanes.sub(lanes.mul(twice, here), last);
                    (last, here) = (here, next);
                }
            }
            row = end;
        }
        let mut out = Vec::with_capacity(2 * self.harmonics + 1);
        for sum in &cosine_sums[..=self.harmonics] {
            out.push(simd.reduce_sum_f64s(sum[0]));
        }
        if !self.sine.is_empty() {
            for sum in &sine_sums[1..=self.harmonics] {
                out.push(simd.reduce_sum_f64s(sum[0]));
            }
        }
        (out, simd.reduce_sum_f64s(squares[0]))
    }
}
