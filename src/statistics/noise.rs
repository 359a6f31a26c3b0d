//! Likelihood of noise in recordings, and the most likely noise of residuals. A Kalman filter with the states of its AR(1) part and
//! of its drift turns correlated residuals into independent ones of variance 1 (innovations).

use super::minimum::minimise_smooth;
use super::noise_model::{NOISE_FLOOR_MM, NoiseModel};
use super::whitener::{LOG_SCALE, LOG_SCALE_LN, ROWS_A_LOGARITHM, Whitener};

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
        let rows: Vec<&[bool]> = self.alike.iter().map(|lanes| lanes.present.as_slice()).collect();
        let whiteners = Whitener::of_all(noise, &rows);
        let alike: f64 = self.alike.iter().zip(&whiteners).map(|(lanes, whitener)| lanes.misfit(whitener)).sum();
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

    fn misfit(&self, whitener: &Whitener) -> f64 {
        pulp::Arch::new().dispatch(|| self.squares(whitener)) + self.traces as f64 * whitener.log_determinant
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

/// Noise that a fit has absorbed in traces with the same rows: its covariance is the sum over `columns` of `u u'`, mm².
#[derive(Debug, Clone, PartialEq)]
pub struct Absorbed {
    /// Rows that took part.
    pub present: Vec<bool>,
    pub columns: Vec<Vec<f64>>,
}

/// What absorbed noise adds to the expected misfit: `Σ u'Σ⁻¹u`.
fn absorbed_misfit(noise: &NoiseModel, absorbed: &[Absorbed]) -> f64 {
    let mut columns = Vec::new();
    let rows: Vec<&[bool]> = absorbed.iter().map(|group| group.present.as_slice()).collect();
    let whiteners = Whitener::of_all(noise, &rows);
    absorbed
        .iter()
        .zip(&whiteners)
        .map(|(group, whitener)| {
            columns.clear();
            group.columns.iter().for_each(|values| columns.extend_from_slice(values));
            whitener.apply_all(&mut columns);
            columns.iter().map(|value| value * value).sum::<f64>()
        })
        .sum()
}

/// White noise of residuals and of what a fit has absorbed of it.
pub fn white_noise(residual_mm: impl Iterator<Item = f64>, absorbed: &[Absorbed]) -> NoiseModel {
    let (sum, count) = residual_mm
        .filter(|value| value.is_finite())
        .fold((0.0, 0usize), |(sum, count), value| (sum + value * value, count + 1));
    let absorbed: f64 = absorbed.iter().flat_map(|group| &group.columns).flatten().map(|value| value * value).sum();
    NoiseModel::white(((sum + absorbed) / count.max(1) as f64).sqrt().max(NOISE_FLOOR_MM))
}

/// Steps from reading to reading that tell noise with a memory from white noise.
const LEAST_STEPS: usize = 20;

/// Most likely noise of residual traces (mm, NaN where there is none) from which a fit has absorbed some.
pub fn fit_noise(traces: &[Vec<f64>], absorbed: &[Absorbed], start: Option<NoiseModel>) -> NoiseModel {
    let (mut sum, mut count) = (0.0, 0usize);
    let (mut step_sum, mut step_count) = (0.0, 0usize);
    for trace in traces {
        // rows without a reading are passed over
        let mut last: Option<f64> = None;
        for value in trace.iter().copied().filter(|value| value.is_finite()) {
            if let Some(last) = last {
                step_sum += (value - last).powi(2);
                step_count += 1;
            }
            sum += value * value;
            count += 1;
            last = Some(value);
        }
    }
    if step_count < LEAST_STEPS {
        return white_noise(traces.iter().flatten().copied(), absorbed);
    }
    let rms = (sum / count.max(1) as f64).sqrt().max(NOISE_FLOOR_MM);
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
    let best = minimise_smooth(pack(&start), |x| {
        let noise = unpack(x);
        pooled.misfit(&noise) + absorbed_misfit(&noise, absorbed)
    });
    unpack(&best)
}
