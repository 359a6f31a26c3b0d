//! Sines and cosines of many angles at once, in registers; one by one for angles beyond [`LARGEST_ANGLE_RAD`].
//!
//! Reduction to |r| ≤ π/4 by three parts of π/2 (Cody and Waite), then the minimax polynomials of fdlibm's `k_sin` and
//! `k_cos`. The first two parts have 33 bits, so that their products with the quadrant are exact with or without
//! fused multiplication.

use pulp::{Arch, Simd, WithSimd};

use super::lanes::{Lanes, SIDE_BY_SIDE};

/// Quadrant numbers up to here keep the products of the reduction exact: 2²⁰·π/2 ≈ 1.6e6.
pub const LARGEST_ANGLE_RAD: f64 = 1.0e6;

/// Adding this to a number below 2⁵¹ leaves the nearest integer in the low bits (1.5·2⁵²).
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// π/2 in parts of 33, 33 and 53 bits (fdlibm `e_rem_pio2`: pio2_1, pio2_2, pio2_2t).
const HALF_PI_PARTS: [f64; 3] = [
    f64::from_bits(0x3FF9_21FB_5440_0000),
    f64::from_bits(0x3DD0_B461_1A60_0000),
    f64::from_bits(0x3BA3_198A_2E03_7073),
];

/// Coefficients of r³, r⁵ … r¹³ of the sine (fdlibm `k_sin`).
const SINE: [f64; 6] = [
    f64::from_bits(0xBFC5_5555_5555_5549),
    f64::from_bits(0x3F81_1111_1110_F8A6),
    f64::from_bits(0xBF2A_01A0_19C1_61D5),
    f64::from_bits(0x3EC7_1DE3_57B1_FE7D),
    f64::from_bits(0xBE5A_E5E6_8A2B_9CEB),
    f64::from_bits(0x3DE5_D93A_5ACF_D57C),
];

/// Coefficients of r⁴, r⁶ … r¹⁴ of the cosine (fdlibm `k_cos`).
const COSINE: [f64; 6] = [
    f64::from_bits(0x3FA5_5555_5555_554C),
    f64::from_bits(0xBF56_C16C_16C1_5177),
    f64::from_bits(0x3EFA_01A0_19CB_1590),
    f64::from_bits(0xBE92_7E4F_809C_52AD),
    f64::from_bits(0x3E21_EE9E_BDB4_B1C4),
    f64::from_bits(0xBDA8_FAE9_BE88_38D4),
];

/// Sine and cosine of `angle`, rad.
#[inline(always)]
pub(super) fn sin_cos<S: Simd, const U: usize>(
    lanes: Lanes<S, U>,
    angle: [S::f64s; U],
) -> ([S::f64s; U], [S::f64s; U]) {
    let simd = lanes.simd;
    let biased = lanes.add_scaled(lanes.splat(ROUNDER), std::f64::consts::FRAC_2_PI, angle);
    let quadrant = lanes.sub(biased, lanes.splat(ROUNDER));
    let mut r = angle;
    for part in HALF_PI_PARTS {
        r = lanes.add_scaled(r, -part, quadrant);
    }
    let square = lanes.mul(r, r);
    let sine = lanes.add_product(r, lanes.mul(r, square), polynomial(lanes, square, &SINE));
    let cosine = lanes.add_product(
        lanes.add_scaled(lanes.splat(1.0), -0.5, square),
        lanes.mul(square, square),
        polynomial(lanes, square, &COSINE),
    );
    let (mut out_sine, mut out_cosine) = (sine, cosine);
    let (zero, one, two) = (simd.splat_u64s(0), simd.splat_u64s(1), simd.splat_u64s(2));
    let sign_bit = simd.splat_u64s(1 << 63);
    for u in 0..U {
        let bits = simd.transmute_u64s_f64s(biased[u]);
        let even = simd.equal_u64s(simd.and_u64s(bits, one), zero);
        // the sine is negative in quadrants 2 and 3, the cosine in 1 and 2
        let upper = simd.equal_u64s(simd.and_u64s(bits, two), zero);
        let right = simd.equal_u64s(simd.and_u64s(simd.add_u64s(bits, one), two), zero);
        let (s, c) = (simd.transmute_u64s_f64s(sine[u]), simd.transmute_u64s_f64s(cosine[u]));
        let s_here = simd.select_u64s(even, s, c);
        let c_here = simd.select_u64s(even, c, s);
        let s_sign = simd.select_u64s(upper, zero, sign_bit);
        let c_sign = simd.select_u64s(right, zero, sign_bit);
        out_sine[u] = simd.transmute_f64s_u64s(simd.xor_u64s(s_here, s_sign));
        out_cosine[u] = simd.transmute_f64s_u64s(simd.xor_u64s(c_here, c_sign));
    }
    (out_sine, out_cosine)
}

/// `c₀ + c₁x + … + c₅x⁵`.
#[inline(always)]
fn polynomial<S: Simd, const U: usize>(lanes: Lanes<S, U>, x: [S::f64s; U], c: &[f64; 6]) -> [S::f64s; U] {
    let mut sum = lanes.splat(c[5]);
    for k in (0..5).rev() {
        sum = lanes.add_product(lanes.splat(c[k]), sum, x);
    }
    sum
}

/// Sines and cosines of angles in rad, accurate to about one unit of the last place; beyond [`LARGEST_ANGLE_RAD`] by the
/// standard library.
pub fn sines_and_cosines(angles_rad: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut sine, mut cosine) = (vec![0.0; angles_rad.len()], vec![0.0; angles_rad.len()]);
    Arch::new().dispatch(SinesCosines { angles: angles_rad, sine: &mut sine, cosine: &mut cosine });
    for (angle, (s, c)) in angles_rad.iter().zip(sine.iter_mut().zip(&mut cosine)) {
        if angle.abs() > LARGEST_ANGLE_RAD {
            (*s, *c) = angle.sin_cos();
        }
    }
    (sine, cosine)
}

struct SinesCosines<'a> {
    angles: &'a [f64],
    sine: &'a mut [f64],
    cosine: &'a mut [f64],
}

impl WithSimd for SinesCosines<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let lanes = Lanes::<S, SIDE_BY_SIDE> { simd };
        let count = Lanes::<S, SIDE_BY_SIDE>::COUNT;
        let out = self.sine.chunks_mut(count).zip(self.cosine.chunks_mut(count));
        for (angles, (sine, cosine)) in self.angles.chunks(count).zip(out) {
            let (s, c) = sin_cos(lanes, lanes.load(angles));
            lanes.store(sine, s);
            lanes.store(cosine, c);
        }
    }
}
