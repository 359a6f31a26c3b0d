//! The whitening filter of a trace under a noise: gains worked out once, applied to any number of columns. It fits nothing.

use super::noise_model::NoiseModel;

/// Whitening filter of one trace: gains worked out once, applied to any number of columns.
pub struct Whitener {
    /// Per row: gain of the AR state, gain of the drift state, 1/√(innovation variance); zero where there is no reading.
    pub(super) gains: Vec<[f64; 3]>,
    pub(super) rho: f64,
    /// Σ log(innovation variance) over the rows with a reading.
    pub log_determinant: f64,
}

impl Whitener {
    /// Filter for rows where `present` holds.
    pub fn new(noise: &NoiseModel, present: &[bool]) -> Whitener {
        let mut gains = Vec::with_capacity(present.len());
        let [log_determinant] = gains_of([present], noise, [&mut gains]);
        Whitener { gains, rho: noise.ar_rho, log_determinant }
    }

    /// The same for several traces at once: one alone waits for its own last row.
    pub fn of_all(noise: &NoiseModel, traces: &[&[bool]]) -> Vec<Whitener> {
        let arch = pulp::Arch::new();
        let mut all = Vec::with_capacity(traces.len());
        for group in traces.chunks(SIDE_BY_SIDE) {
            if let [alone] = group {
                all.push(Whitener::new(noise, alone));
                continue;
            }
            let none: &[bool] = &[];
            let present: [&[bool]; SIDE_BY_SIDE] = std::array::from_fn(|lane| *group.get(lane).unwrap_or(&none));
            let mut gains: [Vec<[f64; 3]>; SIDE_BY_SIDE] = present.map(|rows| Vec::with_capacity(rows.len()));
            let logs = arch.dispatch(|| gains_of(present, noise, gains.each_mut()));
            let whitener = |(gains, log_determinant)| Whitener { gains, rho: noise.ar_rho, log_determinant };
            all.extend(gains.into_iter().zip(logs).take(group.len()).map(whitener));
        }
        all
    }

    /// Whitens a column in place; rows without a reading become zero.
    pub fn apply(&self, column: &mut [f64]) {
        let (mut a, mut d) = (0.0, 0.0);
        for (value, &[ka, kd, scale]) in column.iter_mut().zip(&self.gains) {
            if scale > 0.0 {
                let innovation = *value - a - d;
                a += ka * innovation;
                d += kd * innovation;
                *value = innovation * scale;
            } else {
                *value = 0.0;
            }
            a *= self.rho;
        }
    }
}

/// Works out the gains of `N` traces side by side, and the log determinants of their covariances.
#[inline(always)]
fn gains_of<const N: usize>(present: [&[bool]; N], noise: &NoiseModel, gains: [&mut Vec<[f64; 3]>; N]) -> [f64; N] {
    let rho = noise.ar_rho;
    let drift_step = present.map(|rows| noise.drift_mm.powi(2) / rows.len().max(1) as f64);
    let ar_step = noise.ar_mm.powi(2) * (1.0 - rho * rho);
    let white = noise.white_mm.powi(2);
    // covariance of (AR, drift) before the reading
    let (mut paa, mut pad, mut pdd) = ([noise.ar_mm.powi(2); N], [0.0; N], [noise.offset_mm.powi(2); N]);
    // innovation variances since the last logarithm, as their product
    let (mut product, mut logs) = ([1.0f64; N], [0.0; N]);
    let rows = present.iter().map(|rows| rows.len()).max().unwrap_or(0);
    for row in 0..rows {
        let is_read: [bool; N] = std::array::from_fn(|k| present[k].get(row).copied().unwrap_or(false));
        let mut all = [[0.0; N]; 3];
        for k in 0..N {
            let s = paa[k] + 2.0 * pad[k] + pdd[k] + white;
            let (a, d) = (paa[k] + pad[k], pad[k] + pdd[k]);
            let read = if is_read[k] { 1.0 } else { 0.0 };
            let (ka, kd) = (read * (a / s), read * (d / s));
            product[k] *= if is_read[k] { s * LOG_SCALE } else { 1.0 };
            paa[k] = rho * rho * (paa[k] - ka * a) + ar_step;
            pdd[k] = pdd[k] - kd * d + drift_step[k];
            pad[k] = rho * (pad[k] - ka * d);
            (all[0][k], all[1][k], all[2][k]) = (ka, kd, read / s.sqrt());
        }
        for k in 0..N {
            if row < present[k].len() {
                gains[k].push([all[0][k], all[1][k], all[2][k]]);
            }
        }
        if row % ROWS_A_LOGARITHM == ROWS_A_LOGARITHM - 1 || row + 1 == rows {
            for k in 0..N {
                logs[k] += product[k].ln();
                product[k] = 1.0;
            }
        }
    }
    let counts = present.map(|rows| rows.iter().filter(|read| **read).count() as f64);
    std::array::from_fn(|k| logs[k] - counts[k] * LOG_SCALE_LN)
}

/// Innovation variances whose product has one logarithm: few enough that the product stays in range.
pub(super) const ROWS_A_LOGARITHM: usize = 16;
/// Brings innovation variances of some 1e-8 mm² near 1.
pub(super) const LOG_SCALE: f64 = 1e8;
pub(super) const LOG_SCALE_LN: f64 = 18.420_680_743_952_367;

/// Columns that are filtered side by side: one alone waits for its own last row.
const SIDE_BY_SIDE: usize = 8;

impl Whitener {
    /// Whitens columns that lie one after the other, in place.
    pub fn apply_all(&self, columns: &mut [f64]) {
        let rows = self.gains.len().max(1);
        let arch = pulp::Arch::new();
        for group in columns.chunks_mut(SIDE_BY_SIDE * rows) {
            match group.len() / rows {
                0 => {}
                1 => self.apply(group),
                2 => arch.dispatch(|| self.apply_to::<2>(group)),
                3 => arch.dispatch(|| self.apply_to::<3>(group)),
                4 => arch.dispatch(|| self.apply_to::<4>(group)),
                5 => arch.dispatch(|| self.apply_to::<5>(group)),
                6 => arch.dispatch(|| self.apply_to::<6>(group)),
                7 => arch.dispatch(|| self.apply_to::<7>(group)),
                _ => arch.dispatch(|| self.apply_to::<SIDE_BY_SIDE>(group)),
            }
        }
    }

    /// The same for so many columns side by side.
    #[inline(always)]
    fn apply_to<const N: usize>(&self, columns: &mut [f64]) {
        let rows = self.gains.len();
        let mut each = columns.chunks_exact_mut(rows);
        let columns: [&mut [f64]; N] = std::array::from_fn(|_| each.next().unwrap_or_default());
        let (mut a, mut d) = ([0.0; N], [0.0; N]);
        for (row, &[ka, kd, scale]) in self.gains.iter().enumerate() {
            // where there is no reading all gains are zero
            let values: [f64; N] = std::array::from_fn(|k| if scale > 0.0 { columns[k][row] } else { 0.0 });
            for k in 0..N {
                let innovation = values[k] - a[k] - d[k];
                a[k] = self.rho * (a[k] + ka * innovation);
                d[k] += kd * innovation;
                columns[k][row] = innovation * scale;
            }
        }
    }

    /// The transpose of the filter in place: `Σ u_k·(W c)_k = Σ (Wᵀ u)_k·c_k` for every column c.
    pub fn apply_transposed(&self, column: &mut [f64]) {
        let (mut a, mut d) = (0.0, 0.0);
        for (value, &[ka, kd, scale]) in column.iter_mut().zip(&self.gains).rev() {
            let a_next = self.rho * a;
            if scale > 0.0 {
                let innovation = scale * *value + ka * a_next + kd * d;
                *value = innovation;
                a = a_next - innovation;
                d -= innovation;
            } else {
                *value = 0.0;
                a = a_next;
            }
        }
    }
}
