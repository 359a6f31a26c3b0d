//! Noise of the recordings whatever physics is missing: fitted beside a free smooth curve per trace, so that effects do not count as noise.

use crate::statistics::{
    NOISE_FLOOR_MM, NoiseModel, Whitener, add_products, fit_noise, log_determinant, mean, median, minimise_smooth,
    misfit, rms,
};
use nalgebra::{Cholesky, DMatrix, DVector};

use super::spectrum::lines;
use crate::diagnose::model::linear_model::LinearModel;

/// Half waves of the free curve of a trace.
const HALF_WAVES: usize = 12;
/// Traces used at most.
const MOST_TRACES: usize = 14;
/// Share of the traces in which no fast effect acts, as long as none is known, and when all are.
const QUIETER_SHARE: f64 = 0.5;
const COMMON_SHARE: f64 = 0.75;
/// Noise of most traces over that of the quieter ones, at most: more is something that acts in some of them.
const MOST_LOUDER: f64 = 1.3;
/// Readings of a trace from which noise is learnt: twice the functions of a free curve that follows lines.
const SHORTEST: usize = 2 * (HALF_WAVES + 1 + 2 * MOST_LINES * (LINE_HALF_WAVES + 1));
/// Prominence from which a line of the spectrum is no noise: an instrument has none, and correlated noise would take it in.
const STANDS_OUT: f64 = 12.0;
/// Such lines that the free curves follow at most.
const MOST_LINES: usize = 3;
/// Half waves in which the amplitude and phase of a line change within a trace.
const LINE_HALF_WAVES: usize = 2;
/// Drift of a trace that the free curves hide, as a share of the rest of the noise.
const DRIFT_SHARE: f64 = 0.7;
/// Offset of a whole trace that they hide as well: the gauge's zero wanders from test to test.
const OFFSET_SHARE: f64 = 0.4;
/// Noise of a reading among all of a session over that within its trace, whose drift is in both: √(1 + 0.4²).
const WITH_OFFSETS: f64 = 1.077;

/// Noise floor of every test. Static poses have no order in time from which it could be told from missing physics:
/// for them it is the white noise of the residual itself.
pub fn noise_floor(model: &LinearModel, residual_mm: &[Vec<f64>]) -> Vec<NoiseModel> {
    noise_of(model, residual_mm, &quietest(&traces_by_noise(model, residual_mm)))
}

/// Noise of a reading in a session whose effects are in the residual no more, mm: of all traces but those in which
/// something else may act, with the wander of the gauge's zero from test to test.
pub fn noise_left_mm(model: &LinearModel, residual_mm: &[Vec<f64>]) -> f64 {
    let traces = traces_by_noise(model, residual_mm);
    let rms_mm = |chosen: &[&Trace]| mean_noise_mm2(&noise_of(model, residual_mm, chosen)).sqrt();
    WITH_OFFSETS * rms_mm(&most(&traces)).min(MOST_LOUDER * rms_mm(&quietest(&traces)))
}

/// Residual of a test, NaN where a row takes no part.
pub fn masked(model: &LinearModel, residual_mm: &[Vec<f64>], test: usize) -> Vec<f64> {
    only_kept(&residual_mm[test], &model.kept[test])
}

/// Values of the rows that are kept, NaN in the others.
pub(crate) fn only_kept(values: &[f64], kept: &[bool]) -> Vec<f64> {
    values.iter().zip(kept).map(|(value, kept)| if *kept { *value } else { f64::NAN }).collect()
}

/// Traces from which noise is learnt, the quietest first.
fn traces_by_noise(model: &LinearModel, residual_mm: &[Vec<f64>]) -> Vec<Trace> {
    let readings = |test: usize| model.kept[test].iter().filter(|kept| **kept).count();
    let is_sweep = |test: &usize| model.context.motion(*test).time_s.is_some() && readings(*test) >= SHORTEST;
    let sweeps = (0..residual_mm.len()).filter(is_sweep);
    let standing_out = lines(model, residual_mm).into_iter().filter(|line| line.prominence > STANDS_OUT);
    let loud_hz: Vec<f64> = standing_out.take(MOST_LINES).map(|line| line.hz).collect();
    let time = |test: usize| model.context.motion(test).time_s.as_deref().unwrap_or_default();
    let mut traces: Vec<Trace> =
        sweeps.map(|test| Trace::new(masked(model, residual_mm, test), time(test), &loud_hz)).collect();
    traces.sort_by(|a, b| a.rough_mm.total_cmp(&b.rough_mm));
    traces
}

/// How many of the quieter traces a share of all is.
fn count(traces: &[Trace], share: f64) -> usize {
    ((share * traces.len() as f64).ceil() as usize).clamp(2.min(traces.len()), traces.len())
}

/// Share of the traces that last alike which are surely without a fast effect where any are, and how much louder than those
/// traces are that are not. A trace that is louder from row to row as well is a noisy one, with another bar or setup.
const SURELY_QUIET: f64 = 0.25;
const NOT_ALIKE: f64 = 1.6;

/// The quieter traces, the quietest where they are many.
fn quietest(traces: &[Trace]) -> Vec<&Trace> {
    let quieter = &traces[..count(traces, QUIETER_SHARE).min(MOST_TRACES)];
    let is_alike = |trace: &&Trace| {
        let alike: Vec<&Trace> = traces.iter().filter(|other| other.duration() == trace.duration()).collect();
        let sure = &alike[..((SURELY_QUIET * alike.len() as f64).ceil() as usize).max(2).min(alike.len())];
        let mean = |of: fn(&Trace) -> f64| mean(sure.iter().map(|trace| of(trace))).unwrap_or(f64::NAN);
        let is_loud = |of: fn(&Trace) -> f64| of(trace) > NOT_ALIKE * mean(of);
        !is_loud(|trace| trace.rough_mm) || is_loud(|trace| trace.step_mm)
    };
    quieter.iter().filter(is_alike).collect()
}

/// Most traces, evenly drawn where they are many.
fn most(traces: &[Trace]) -> Vec<&Trace> {
    let all = count(traces, COMMON_SHARE);
    let drawn = all.min(MOST_TRACES);
    (0..drawn).map(|k| &traces[k * all / drawn]).collect()
}

/// Noise of every test by what some traces say of sweeps.
fn noise_of(model: &LinearModel, residual_mm: &[Vec<f64>], chosen: &[&Trace]) -> Vec<NoiseModel> {
    let all = (0..residual_mm.len()).flat_map(|test| masked(model, residual_mm, test));
    let poses = NoiseModel::white(rms(all).max(NOISE_FLOOR_MM));
    if chosen.is_empty() {
        return vec![poses; residual_mm.len()];
    }
    let mut noise = fit(chosen);
    noise.drift_mm = DRIFT_SHARE * noise.rms_mm();
    noise.offset_mm = OFFSET_SHARE * noise.rms_mm();
    (0..residual_mm.len()).map(|test| if model.context.motion(test).time_s.is_some() { noise } else { poses }).collect()
}

/// The same noise with an offset of each test of a share of the rest at least.
pub fn wandering(noise: &NoiseModel, share: f64) -> NoiseModel {
    NoiseModel { offset_mm: noise.offset_mm.max(share * noise.rms_mm()), ..*noise }
}

/// Mean variance of a reading's noise over all tests, mm².
pub fn mean_noise_mm2(noise: &[NoiseModel]) -> f64 {
    mean(noise.iter().map(|noise| noise.rms_mm().powi(2))).unwrap_or(0.0)
}

/// Slow noise may be so many times the floor's rms: more is missing physics, not noise.
const MOST_SLOW_NOISE: f64 = 2.0;
/// Longest correlation of AR noise, per sample: beyond it is the offset of a whole trace, which instruments do not have.
const LONGEST_MEMORY: f64 = 0.993;

/// Noise within what an instrument with this floor can have.
fn bounded(noise: NoiseModel, floor: &[NoiseModel]) -> NoiseModel {
    let most = MOST_SLOW_NOISE * floor.iter().map(NoiseModel::rms_mm).fold(0.0, f64::max);
    NoiseModel {
        white_mm: noise.white_mm.min(most),
        ar_mm: noise.ar_mm.min(most),
        ar_rho: noise.ar_rho.min(LONGEST_MEMORY),
        drift_mm: noise.drift_mm.min(most),
        ..noise
    }
}

/// Most likely noise of the residuals as they are, within what the floor allows.
pub fn likely_noise(
    model: &LinearModel,
    residual_mm: &[Vec<f64>],
    start: &[NoiseModel],
    floor: &[NoiseModel],
) -> Vec<NoiseModel> {
    let mut sweeps = Vec::new();
    let mut poses = Vec::new();
    for test in 0..residual_mm.len() {
        let of_kind = if model.context.motion(test).time_s.is_some() { &mut sweeps } else { &mut poses };
        of_kind.push(masked(model, residual_mm, test));
    }
    let white = NoiseModel::white(rms(poses.iter().flatten().copied()).max(NOISE_FLOOR_MM));
    let from = (0..residual_mm.len()).find(|&test| model.context.motion(test).time_s.is_some()).map(|test| start[test]);
    let sweep = if sweeps.is_empty() { white } else { likeliest(&sweeps, from, floor) };
    (0..residual_mm.len()).map(|test| if model.context.motion(test).time_s.is_some() { sweep } else { white }).collect()
}

/// Most likely noise of traces within what the floor allows: from where the last one was, and anew where that ends worse
/// than either began.
fn likeliest(traces: &[Vec<f64>], from: Option<NoiseModel>, floor: &[NoiseModel]) -> NoiseModel {
    let mut known: Vec<NoiseModel> = from.into_iter().collect();
    known.extend(floor.iter().max_by(|a, b| a.ar_mm.total_cmp(&b.ar_mm)));
    let standing = |noise: NoiseModel| (misfit(&noise, traces), noise);
    let best = |one: (f64, NoiseModel), other: (f64, NoiseModel)| if other.0 < one.0 { other } else { one };
    let mut found = standing(bounded(fit_noise(traces, &[], from), floor));
    if known.iter().any(|noise| standing(*noise).0 < found.0) {
        found = best(found, standing(bounded(fit_noise(traces, &[], None), floor)));
    }
    known.into_iter().map(standing).fold(found, best).1
}

/// A trace with its free curve, which follows loud lines of the spectrum too.
struct Trace {
    present: Vec<bool>,
    /// Time from its first to its last row, s.
    length_s: f64,
    /// What white noise alone would leave beside the curve, mm.
    rough_mm: f64,
    /// How far a reading is from the middle of its neighbours, the median, mm.
    step_mm: f64,
    /// The curve's functions one after the other, the readings last.
    columns: Vec<f64>,
}

impl Trace {
    fn new(residual: Vec<f64>, time_s: &[f64], loud_hz: &[f64]) -> Trace {
        let rows = residual.len();
        let present = residual.iter().map(|value| value.is_finite()).collect();
        let wave = |k: usize, row: usize| (std::f64::consts::PI * k as f64 * (row as f64 + 0.5) / rows as f64).cos();
        let mut columns: Vec<f64> = (0..=HALF_WAVES).flat_map(|k| (0..rows).map(move |row| wave(k, row))).collect();
        for hz in loud_hz {
            for k in 0..=LINE_HALF_WAVES {
                let phase = |row: usize| std::f64::consts::TAU * hz * time_s[row];
                columns.extend((0..rows).map(|row| wave(k, row) * phase(row).cos()));
                columns.extend((0..rows).map(|row| wave(k, row) * phase(row).sin()));
            }
        }
        let length_s = time_s.last().zip(time_s.first()).map_or(0.0, |(last, first)| last - first);
        // the median: jumps are no noise
        let second = |rows: &[f64]| (rows[1] - 0.5 * (rows[0] + rows[2])).abs();
        let step_mm = median(residual.windows(3).map(second)).unwrap_or(0.0);
        columns.extend(residual.into_iter().map(|value| if value.is_finite() { value } else { 0.0 }));
        let mut trace = Trace { present, length_s, rough_mm: 0.0, step_mm, columns };
        trace.rough_mm = trace.rough_rms();
        trace
    }

    /// Traces that last alike, within a factor of about 1.4, have one number.
    fn duration(&self) -> i64 {
        (2.0 * self.length_s.max(1e-3).log2()).round() as i64
    }

    fn rough_rms(&self) -> f64 {
        let count = self.present.iter().filter(|present| **present).count();
        let functions = self.columns.len() / self.present.len() - 1;
        let (misfit, _) = self.reml(&NoiseModel::white(1.0));
        (misfit / count.saturating_sub(functions).max(1) as f64).sqrt()
    }

    /// Weighted sum of squares left by the curve, and the log determinants of the restricted likelihood.
    fn reml(&self, noise: &NoiseModel) -> (f64, f64) {
        Alike::of(&[self]).first().map_or((0.0, 0.0), |alike| alike.reml(noise))
    }
}

/// Traces with readings in the same rows and the same free curves: what the curves are among themselves is worked out once.
struct Alike<'t> {
    present: &'t [bool],
    traces: usize,
    /// The curves' functions one after the other, then the readings of each trace.
    columns: Vec<f64>,
}

impl<'t> Alike<'t> {
    fn of(traces: &[&'t Trace]) -> Vec<Alike<'t>> {
        let mut groups: Vec<Alike> = Vec::new();
        for trace in traces {
            let rows = trace.present.len();
            let (curves, readings) = trace.columns.split_at(trace.columns.len() - rows);
            let known = groups.iter_mut().find(|group| {
                group.present == trace.present && group.columns[..group.columns.len() - group.traces * rows] == *curves
            });
            match known {
                Some(group) => {
                    group.traces += 1;
                    group.columns.extend_from_slice(readings);
                }
                None => groups.push(Alike { present: &trace.present, traces: 1, columns: trace.columns.clone() }),
            }
        }
        groups
    }

    /// The same of all of them together.
    fn reml(&self, noise: &NoiseModel) -> (f64, f64) {
        let whitener = Whitener::new(noise, self.present);
        let rows = self.present.len();
        let mut columns = self.columns.clone();
        whitener.apply_all(&mut columns);
        let width = columns.len() / rows;
        let count = width - self.traces;
        let mut sums = vec![0.0; width * width];
        add_products(&columns, rows, width, &mut sums);
        // at half the sampling rate sine and cosine of a line are one
        let ridge = |i: usize, j: usize| if i == j { 1.0 + 1e-9 } else { 1.0 };
        let gram = DMatrix::from_fn(count, count, |i, j| ridge(i, j) * sums[i.max(j) * width + i.min(j)]);
        let traces = || (count..width).map(|k| &sums[k * width..k * width + k + 1]);
        let squares: f64 = traces().filter_map(|sums| sums.last()).sum();
        let many = self.traces as f64;
        match Cholesky::new(gram) {
            Some(factor) => {
                let taken = |sums: &[f64]| {
                    let right = DVector::from_column_slice(&sums[..count]);
                    right.dot(&factor.solve(&right))
                };
                let taken: f64 = traces().map(taken).sum();
                (squares - taken, many * (whitener.log_determinant + log_determinant(&factor)))
            }
            None => (squares, many * whitener.log_determinant),
        }
    }
}

/// Restricted maximum likelihood of white and AR(1) noise beside the free curves.
fn fit(traces: &[&Trace]) -> NoiseModel {
    let white = mean(traces.iter().map(|trace| trace.rough_mm)).unwrap_or(0.0);
    let white = white.max(NOISE_FLOOR_MM);
    let start = [(0.7 * white).ln(), (0.7 * white).ln(), (-(0.95f64.ln())).ln()];
    let unpack = |x: &[f64; 3]| NoiseModel {
        white_mm: x[0].exp().max(NOISE_FLOOR_MM),
        ar_mm: x[1].exp().max(NOISE_FLOOR_MM),
        ar_rho: (-(x[2].exp())).exp().clamp(0.5, 0.99),
        drift_mm: 0.0,
        offset_mm: 0.0,
    };
    let alike = Alike::of(traces);
    let best = minimise_smooth(start, |x| {
        let noise = unpack(x);
        alike.iter().map(|alike| alike.reml(&noise)).map(|(misfit, logs)| misfit + logs).sum()
    });
    unpack(&best)
}
