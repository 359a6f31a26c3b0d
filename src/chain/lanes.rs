//! Arithmetic on `U` vectors of numbers at a time, in the widest registers of the machine; no memory, no geometry.
//!
//! No closures over vectors here or in the kernels: a closure is a function of its own, compiled without the
//! instruction set that was chosen at run time, and costs ten times the work it does.

use pulp::Simd;

/// Vectors worked on side by side: two hide most of the latency and still fit the registers.
pub(super) const SIDE_BY_SIDE: usize = 2;

/// `U` SIMD vectors side by side: enough independent work to hide the latency of one operation.
#[derive(Clone, Copy)]
pub(crate) struct Lanes<S: Simd, const U: usize> {
    pub simd: S,
}

/// `U` vectors of numbers.
pub(crate) type Wide<S, const U: usize> = [<S as Simd>::f64s; U];

/// Three coordinates, each `U` vectors of numbers.
pub(crate) type Wide3<S, const U: usize> = [Wide<S, U>; 3];

// loops over U unroll to single instructions; a copy function would be called
#[allow(clippy::manual_memcpy)]
impl<S: Simd, const U: usize> Lanes<S, U> {
    /// Numbers in all `U` vectors.
    pub const COUNT: usize = U * S::F64_LANES;

    #[inline(always)]
    pub fn splat(self, value: f64) -> Wide<S, U> {
        [self.simd.splat_f64s(value); U]
    }

    #[inline(always)]
    pub fn splat3(self, value: &[f64; 3]) -> Wide3<S, U> {
        [self.splat(value[0]), self.splat(value[1]), self.splat(value[2])]
    }

    /// Numbers from a slice; missing ones at its end are 0.
    #[inline(always)]
    pub fn load(self, from: &[f64]) -> Wide<S, U> {
        let mut out = self.splat(0.0);
        if from.len() == Self::COUNT {
            let (vectors, _) = S::as_simd_f64s(from);
            for u in 0..U {
                out[u] = vectors[u];
            }
        } else {
            for (u, part) in from.chunks(S::F64_LANES).enumerate().take(U) {
                out[u] = self.simd.partial_load_f64s(part);
            }
        }
        out
    }

    /// As many numbers as the slice holds.
    #[inline(always)]
    pub fn store(self, into: &mut [f64], values: Wide<S, U>) {
        if into.len() == Self::COUNT {
            let (vectors, _) = S::as_mut_simd_f64s(into);
            for u in 0..U {
                vectors[u] = values[u];
            }
        } else {
            for (part, value) in into.chunks_mut(S::F64_LANES).zip(values) {
                self.simd.partial_store_f64s(part, value);
            }
        }
    }

    #[inline(always)]
    pub fn add(self, a: Wide<S, U>, b: Wide<S, U>) -> Wide<S, U> {
        let mut out = a;
        for u in 0..U {
            out[u] = self.simd.add_f64s(a[u], b[u]);
        }
        out
    }

    #[inline(always)]
    pub fn sub(self, a: Wide<S, U>, b: Wide<S, U>) -> Wide<S, U> {
        let mut out = a;
        for u in 0..U {
            out[u] = self.simd.sub_f64s(a[u], b[u]);
        }
        out
    }

    #[inline(always)]
    pub fn mul(self, a: Wide<S, U>, b: Wide<S, U>) -> Wide<S, U> {
        let mut out = a;
        for u in 0..U {
            out[u] = self.simd.mul_f64s(a[u], b[u]);
        }
        out
    }

    #[inline(always)]
    pub fn div(self, a: Wide<S, U>, b: Wide<S, U>) -> Wide<S, U> {
        let mut out = a;
        for u in 0..U {
            out[u] = self.simd.div_f64s(a[u], b[u]);
        }
        out
    }

    #[inline(always)]
    pub fn sqrt(self, a: Wide<S, U>) -> Wide<S, U> {
        let mut out = a;
        for u in 0..U {
            out[u] = self.simd.sqrt_f64s(a[u]);
        }
        out
    }

    /// `sum + a·b`.
    #[inline(always)]
    pub fn add_product(self, sum: Wide<S, U>, a: Wide<S, U>, b: Wide<S, U>) -> Wide<S, U> {
        let mut out = sum;
        for u in 0..U {
            out[u] = self.simd.mul_add_e_f64s(a[u], b[u], sum[u]);
        }
        out
    }

    /// `sum + factor·a`.
    #[inline(always)]
    pub fn add_scaled(self, sum: Wide<S, U>, factor: f64, a: Wide<S, U>) -> Wide<S, U> {
        self.add_product(sum, self.splat(factor), a)
    }

    /// `a·b − c·d`.
    #[inline(always)]
    pub fn difference_of_products(self, a: Wide<S, U>, b: Wide<S, U>, c: Wide<S, U>, d: Wide<S, U>) -> Wide<S, U> {
        let mut out = a;
        for u in 0..U {
            out[u] = self.simd.negate_mul_add_e_f64s(c[u], d[u], self.simd.mul_f64s(a[u], b[u]));
        }
        out
    }

    #[inline(always)]
    pub fn dot(self, a: Wide3<S, U>, b: Wide3<S, U>) -> Wide<S, U> {
        self.add_product(self.add_product(self.mul(a[0], b[0]), a[1], b[1]), a[2], b[2])
    }

    #[inline(always)]
    pub fn cross(self, a: Wide3<S, U>, b: Wide3<S, U>) -> Wide3<S, U> {
        [
            self.difference_of_products(a[1], b[2], a[2], b[1]),
            self.difference_of_products(a[2], b[0], a[0], b[2]),
            self.difference_of_products(a[0], b[1], a[1], b[0]),
        ]
    }

    #[inline(always)]
    pub fn sub3(self, a: Wide3<S, U>, b: Wide3<S, U>) -> Wide3<S, U> {
        [self.sub(a[0], b[0]), self.sub(a[1], b[1]), self.sub(a[2], b[2])]
    }

    #[inline(always)]
    pub fn mul3(self, a: Wide3<S, U>, b: Wide<S, U>) -> Wide3<S, U> {
        [self.mul(a[0], b), self.mul(a[1], b), self.mul(a[2], b)]
    }

    /// `sum + x·a₀ + y·a₁ + z·a₂` with constants a.
    #[inline(always)]
    pub fn combine(self, sum: Wide<S, U>, a: [f64; 3], point: Wide3<S, U>) -> Wide<S, U> {
        let sum = self.add_scaled(sum, a[0], point[0]);
        self.add_scaled(self.add_scaled(sum, a[1], point[1]), a[2], point[2])
    }
}
