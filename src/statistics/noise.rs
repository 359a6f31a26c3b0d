//! Noise of recordings as white + AR(1) + slow drift, its likelihood and the whitening filter; knows nothing of geometry.
//!
//! A reading's noise is `w_k + a_k + d_k`: white w, an AR(1) part `a_k = ρ a_{k−1} + …` of standard deviation σ_a,
//! and a random walk d that has standard deviation σ_d at the end of a trace; it starts at zero, or at an offset of the whole trace. A Kalman filter
//! with the two states (a, d) turns correlated residuals into independent ones of variance 1 (innovations).

use super::minimum::minimise_few;

/// Parameters of the noise, lengths in mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseModel {
    pub white_mm: f64,
    pub ar_mm: f64,
    /// Correlation of the AR(1) part from one sample to the next.
    pub ar_rho: f64,
    /// Standard deviation of the drift at the end of a trace.
    pub drift_mm: f64,
    /// Standard deviation of a whole trace: what a gauge drifts from one test to the next.
    pub offset_mm: f64,
}

impl NoiseModel {
    /// White noise alone.
    pub fn white(white_mm: f64) -> NoiseModel {
        NoiseModel { white_mm, ar_mm: 0.0, ar_rho: 0.0, drift_mm: 0.0, offset_mm: 0.0 }
    }

    /// Standard deviation of one reading in its trace, averaged over the trace, mm.
    pub fn rms_mm(&self) -> f64 {
        (self.white_mm.powi(2) + self.ar_mm.powi(2) + 0.5 * self.drift_mm.powi(2)).sqrt()
    }

    /// The same noise scaled.
    pub fn scaled(&self, factor: f64) -> NoiseModel {
        NoiseModel {
            white_mm: self.white_mm * factor,
            ar_mm: self.ar_mm * factor,
            drift_mm: self.drift_mm * factor,
            offset_mm: self.offset_mm * factor,
            ..*self
        }
    }
}

/// Whitening filter of one trace: gains worked out once, applied to any number of columns.
pub struct Whitener {
    /// Per row: gain of the AR state, gain of the drift state, 1/√(innovation variance); zero where there is no reading.
    gains: Vec<[f64; 3]>,
    rho: f64,
    /// Σ log(innovation variance) over the rows with a reading.
    pub log_determinant: f64,
}

impl Whitener {
    /// Filter for rows where `present` holds.
    pub fn new(noise: &NoiseModel, present: &[bool]) -> Whitener {
        let rho = noise.ar_rho;
        let drift_step = noise.drift_mm.powi(2) / present.len().max(1) as f64;
        let ar_step = noise.ar_mm.powi(2) * (1.0 - rho * rho);
        let white = noise.white_mm.powi(2);
        // covariance of (AR, drift) before the reading
        let (mut paa, mut pad, mut pdd) = (noise.ar_mm.powi(2), 0.0, noise.offset_mm.powi(2));
        let mut log_determinant = 0.0;
        let gains = present
            .iter()
            .map(|&present| {
                let mut gain = [0.0; 3];
                if present {
                    let s = paa + 2.0 * pad + pdd + white;
                    let (ka, kd) = ((paa + pad) / s, (pad + pdd) / s);
                    gain = [ka, kd, 1.0 / s.sqrt()];
                    log_determinant += s.ln();
                    let (a, d) = (paa + pad, pad + pdd);
                    paa -= ka * a;
                    pdd -= kd * d;
                    pad -= ka * d;
                }
                paa = rho * rho * paa + ar_step;
                pad *= rho;
                pdd += drift_step;
                gain
            })
            .collect();
        Whitener { gains, rho, log_determinant }
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

/// Columns that are filtered side by side: one alone waits for its own last row.
const SIDE_BY_SIDE: usize = 4;

impl Whitener {
    /// Whitens columns that lie one after the other, in place.
    pub fn apply_all(&self, columns: &mut [f64]) {
        let rows = self.gains.len();
        let mut groups = columns.chunks_exact_mut((SIDE_BY_SIDE * rows).max(1));
        for group in &mut groups {
            let (first, rest) = group.split_at_mut(rows);
            let (second, rest) = rest.split_at_mut(rows);
            let (third, fourth) = rest.split_at_mut(rows);
            let (mut a, mut d) = ([0.0; SIDE_BY_SIDE], [0.0; SIDE_BY_SIDE]);
            for (row, &[ka, kd, scale]) in self.gains.iter().enumerate() {
                let values = [first[row], second[row], third[row], fourth[row]];
                let mut white = [0.0; SIDE_BY_SIDE];
                if scale > 0.0 {
                    for k in 0..SIDE_BY_SIDE {
                        let innovation = values[k] - a[k] - d[k];
                        a[k] += ka * innovation;
                        d[k] += kd * innovation;
                        white[k] = innovation * scale;
                    }
                }
                for value in &mut a {
                    *value *= self.rho;
                }
                [first[row], second[row], third[row], fourth[row]] = white;
            }
        }
        for column in groups.into_remainder().chunks_exact_mut(rows.max(1)) {
            self.apply(column);
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

/// −2 log likelihood of residuals (NaN where there is none) under a noise model, pooled over traces.
pub fn misfit(noise: &NoiseModel, traces: &[Vec<f64>]) -> f64 {
    Lanes::of(traces).iter().map(|lanes| lanes.misfit(noise)).sum()
}

/// Traces that are filtered side by side: one alone waits for its own last row.
const LANES: usize = 8;

/// Some traces row by row, with 1 where there is a reading and 0 where there is none.
struct Lanes {
    /// Rows of each trace.
    rows: [f64; LANES],
    readings: Vec<([f64; LANES], [f64; LANES])>,
}

impl Lanes {
    fn of(traces: &[Vec<f64>]) -> Vec<Lanes> {
        // traces of similar length share lanes
        let mut order: Vec<&Vec<f64>> = traces.iter().collect();
        order.sort_by_key(|trace| std::cmp::Reverse(trace.len()));
        let lanes = |group: &[&Vec<f64>]| {
            let longest = group.iter().map(|trace| trace.len()).max().unwrap_or(0);
            let reading = |lane: usize, row: usize| group.get(lane).and_then(|trace| trace.get(row)).copied();
            let readings = (0..longest).map(|row| {
                let values: [Option<f64>; LANES] =
                    std::array::from_fn(|lane| reading(lane, row).filter(|value| value.is_finite()));
                (values.map(|value| value.unwrap_or(0.0)), values.map(|value| f64::from(value.is_some())))
            });
            let rows = std::array::from_fn(|lane| group.get(lane).map_or(1.0, |trace| trace.len().max(1) as f64));
            Lanes { rows, readings: readings.collect() }
        };
        order.chunks(LANES).map(lanes).collect()
    }

    /// −2 log likelihood of all of them.
    fn misfit(&self, noise: &NoiseModel) -> f64 {
        pulp::Arch::new().dispatch(|| self.filtered(noise))
    }

    #[inline(always)]
    fn filtered(&self, noise: &NoiseModel) -> f64 {
        let rho = noise.ar_rho;
        let drift_step = self.rows.map(|rows| noise.drift_mm.powi(2) / rows);
        let ar_step = noise.ar_mm.powi(2) * (1.0 - rho * rho);
        let white = noise.white_mm.powi(2);
        let mut paa = [noise.ar_mm.powi(2); LANES];
        let mut pdd = [noise.offset_mm.powi(2); LANES];
        let (mut pad, mut a, mut d) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let (mut sum, mut product, mut logs) = ([0.0; LANES], [1.0f64; LANES], 0.0);
        for group in self.readings.chunks(ROWS_A_LOGARITHM) {
            for (values, present) in group {
                for k in 0..LANES {
                    let s = paa[k] + 2.0 * pad[k] + pdd[k] + white;
                    let innovation = values[k] - a[k] - d[k];
                    let (ga, gd) = (paa[k] + pad[k], pad[k] + pdd[k]);
                    let weight = present[k] / s;
                    sum[k] += innovation * innovation * weight;
                    product[k] *= 1.0 + present[k] * (s * LOG_SCALE - 1.0);
                    let (ka, kd) = (ga * weight, gd * weight);
                    a[k] = rho * (a[k] + ka * innovation);
                    d[k] += kd * innovation;
                    paa[k] = rho * rho * (paa[k] - ka * ga) + ar_step;
                    pdd[k] += drift_step[k] - kd * gd;
                    pad[k] = rho * (pad[k] - ka * gd);
                }
            }
            for product in &mut product {
                logs += product.ln();
                *product = 1.0;
            }
        }
        let count: f64 = self.readings.iter().flat_map(|(_, present)| present).sum();
        sum.iter().sum::<f64>() + logs - count * LOG_SCALE_LN
    }
}

/// Innovation variances whose product has one logarithm: few enough that the product stays in range.
const ROWS_A_LOGARITHM: usize = 16;
/// Brings innovation variances of some 1e-8 mm² near 1.
const LOG_SCALE: f64 = 1e8;
const LOG_SCALE_LN: f64 = 18.420_680_743_952_367;

/// Smallest noise that a fit may find, mm: a twentieth of the last digit of a recording, so that ideal traces can be fitted.
pub const NOISE_FLOOR_MM: f64 = 5e-6;

/// Noise that a fit has absorbed in traces with the same rows: its covariance is the sum over `columns` of `u u'`, mm².
#[derive(Debug, Clone, PartialEq)]
pub struct Absorbed {
    /// Rows that took part.
    pub present: Vec<bool>,
    pub columns: Vec<Vec<f64>>,
}

/// What absorbed noise adds to the expected misfit: `Σ u'Σ⁻¹u`.
fn absorbed_misfit(noise: &NoiseModel, absorbed: &[Absorbed]) -> f64 {
    let mut column = Vec::new();
    absorbed
        .iter()
        .map(|group| {
            let whitener = Whitener::new(noise, &group.present);
            let squares = |values: &Vec<f64>| -> f64 {
                column.clone_from(values);
                whitener.apply(&mut column);
                column.iter().map(|value| value * value).sum()
            };
            group.columns.iter().map(squares).sum::<f64>()
        })
        .sum()
}

/// Most likely noise of residual traces (mm, NaN where there is none) from which a fit has absorbed some.
pub fn fit_noise(traces: &[Vec<f64>], absorbed: &[Absorbed], start: Option<NoiseModel>) -> NoiseModel {
    let (mut sum, mut count) = (0.0, 0usize);
    let (mut step_sum, mut step_count) = (0.0, 0usize);
    for trace in traces {
        for pair in trace.windows(2) {
            if pair[0].is_finite() && pair[1].is_finite() {
                step_sum += (pair[1] - pair[0]).powi(2);
                step_count += 1;
            }
        }
        for value in trace.iter().filter(|value| value.is_finite()) {
            sum += value * value;
            count += 1;
        }
    }
    let rms = (sum / count.max(1) as f64).sqrt().max(NOISE_FLOOR_MM);
    if step_count < 20 {
        return NoiseModel::white(rms);
    }
    let white = (0.5 * step_sum / step_count as f64).sqrt().max(NOISE_FLOOR_MM);
    let slow = (rms * rms - white * white).max(0.04 * white * white).sqrt();
    let own = NoiseModel { white_mm: white, ar_mm: slow, ar_rho: 0.95, drift_mm: 0.3 * slow, offset_mm: 0.0 };
    let start = start.unwrap_or(own);
    let pack = |noise: &NoiseModel| {
        [
            noise.white_mm.max(NOISE_FLOOR_MM).ln(),
            noise.ar_mm.max(NOISE_FLOOR_MM).ln(),
            // ρ from 0.3 to 0.9995 on a logarithmic scale of correlation length
            (-(noise.ar_rho.clamp(0.3, 0.9995)).ln()).ln(),
            noise.drift_mm.max(NOISE_FLOOR_MM).ln(),
        ]
    };
    let unpack = |x: &[f64; 4]| NoiseModel {
        white_mm: x[0].exp().max(NOISE_FLOOR_MM),
        ar_mm: x[1].exp().max(NOISE_FLOOR_MM),
        ar_rho: (-(x[2].exp())).exp().clamp(0.3, 0.9995),
        drift_mm: x[3].exp().max(NOISE_FLOOR_MM),
        offset_mm: start.offset_mm,
    };
    let lanes = Lanes::of(traces);
    let best = minimise_few(pack(&start), 0.5, |x| {
        let noise = unpack(x);
        lanes.iter().map(|lanes| lanes.misfit(&noise)).sum::<f64>() + absorbed_misfit(&noise, absorbed)
    });
    unpack(&best)
}
