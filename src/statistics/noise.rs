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
        // innovation variances since the last logarithm, as their product
        let (mut product, mut many) = (1.0f64, 0);
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
                    product *= s * LOG_SCALE;
                    many += 1;
                    if many == ROWS_A_LOGARITHM {
                        log_determinant += product.ln() - many as f64 * LOG_SCALE_LN;
                        (product, many) = (1.0, 0);
                    }
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
        log_determinant += product.ln() - many as f64 * LOG_SCALE_LN;
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

/// Innovation variances whose product has one logarithm: few enough that the product stays in range.
const ROWS_A_LOGARITHM: usize = 16;
/// Brings innovation variances of some 1e-8 mm² near 1.
const LOG_SCALE: f64 = 1e8;
const LOG_SCALE_LN: f64 = 18.420_680_743_952_367;

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

/// −2 log likelihood of residuals (NaN where there is none) under a noise model, pooled over traces.
pub fn misfit(noise: &NoiseModel, traces: &[Vec<f64>]) -> f64 {
    Pooled::of(traces).misfit(noise)
}

/// Traces that are filtered side by side: one alone waits for its own last row.
const LANES: usize = 8;
const ALIKE_LANES: usize = 16;

/// Traces with readings in the same rows from which on their filter is worked out once for all of them.
const LEAST_ALIKE: usize = 3;

/// Traces in lanes.
struct Pooled {
    alike: Vec<AlikeLanes>,
    others: Vec<Lanes>,
}

impl Pooled {
    fn of(traces: &[Vec<f64>]) -> Pooled {
        let mut groups: Vec<(Vec<bool>, Vec<&Vec<f64>>)> = Vec::new();
        for trace in traces {
            let present: Vec<bool> = trace.iter().map(|value| value.is_finite()).collect();
            match groups.iter_mut().find(|(rows, _)| *rows == present) {
                Some((_, group)) => group.push(trace),
                None => groups.push((present, vec![trace])),
            }
        }
        let (mut alike, mut others) = (Vec::new(), Vec::new());
        for (present, group) in &groups {
            match group.len() < LEAST_ALIKE {
                true => others.extend(group),
                false => alike.extend(group.chunks(ALIKE_LANES).map(|group| AlikeLanes::of(present, group))),
            }
        }
        Pooled { alike, others: Lanes::of(others) }
    }

    /// −2 log likelihood of all of them.
    fn misfit(&self, noise: &NoiseModel) -> f64 {
        let arch = pulp::Arch::new();
        let alike: f64 = self.alike.iter().map(|lanes| lanes.misfit(noise)).sum();
        alike + self.others.iter().map(|lanes| arch.dispatch(|| lanes.filtered(noise))).sum::<f64>()
    }
}

/// Some traces with readings in the same rows.
struct AlikeLanes {
    /// Number of traces.
    traces: usize,
    present: Vec<bool>,
    /// Readings row by row; zero where there is none.
    readings: Vec<[f64; ALIKE_LANES]>,
}

impl AlikeLanes {
    fn of(present: &[bool], traces: &[&Vec<f64>]) -> AlikeLanes {
        let reading = |lane: usize, row: usize| traces.get(lane).map_or(0.0, |trace| trace[row]);
        let row = |(row, present): (usize, &bool)| -> [f64; ALIKE_LANES] {
            std::array::from_fn(|lane| if *present { reading(lane, row) } else { 0.0 })
        };
        let readings = present.iter().enumerate().map(row).collect();
        AlikeLanes { traces: traces.len(), present: present.to_vec(), readings }
    }

    fn misfit(&self, noise: &NoiseModel) -> f64 {
        let whitener = Whitener::new(noise, &self.present);
        pulp::Arch::new().dispatch(|| self.squares(&whitener)) + self.traces as f64 * whitener.log_determinant
    }

    /// Sum of the squares of the innovations in units of their variances.
    #[inline(always)]
    fn squares(&self, whitener: &Whitener) -> f64 {
        let (mut a, mut d, mut sum) = ([0.0; ALIKE_LANES], [0.0; ALIKE_LANES], [0.0; ALIKE_LANES]);
        for (values, &[ka, kd, scale]) in self.readings.iter().zip(&whitener.gains) {
            let weight = scale * scale;
            for k in 0..ALIKE_LANES {
                let innovation = values[k] - a[k] - d[k];
                sum[k] += innovation * innovation * weight;
                a[k] = whitener.rho * (a[k] + ka * innovation);
                d[k] += kd * innovation;
            }
        }
        sum.iter().sum()
    }
}

/// Some traces row by row, with 1 where there is a reading and 0 where there is none.
struct Lanes {
    /// Rows of each trace.
    rows: [f64; LANES],
    readings: Vec<([f64; LANES], [f64; LANES])>,
}

impl Lanes {
    fn of(mut order: Vec<&Vec<f64>>) -> Vec<Lanes> {
        // traces of similar length share lanes
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
            column.clear();
            group.columns.iter().for_each(|values| column.extend_from_slice(values));
            Whitener::new(noise, &group.present).apply_all(&mut column);
            column.iter().map(|value| value * value).sum::<f64>()
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
    let pooled = Pooled::of(traces);
    let best = minimise_few(pack(&start), 0.5, |x| {
        let noise = unpack(x);
        pooled.misfit(&noise) + absorbed_misfit(&noise, absorbed)
    });
    unpack(&best)
}
