//! Lines in the spectrum of residuals over time. What makes them is for others to say.

use std::ops::Range;

use crate::chain::sines_and_cosines;
use crate::diagnose::model::linear_model::LinearModel;
use crate::statistics::mean;

/// A frequency at which the traces together are louder than beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    pub hz: f64,
    /// Power over that of its neighbourhood: noise is louder at low frequencies.
    pub prominence: f64,
}

/// Frequencies searched per trace at most.
const MOST_FREQUENCIES: usize = 1200;
/// Cycles that the longest trace must show.
const LEAST_IN_LONGEST: f64 = 12.0;
/// Frequencies on each side that make a neighbourhood.
const FREQUENCIES_BESIDE: usize = 15;
/// Frequencies nearer than this belong to one line.
const ONE_LINE: usize = 3;

/// Lines of the power spectrum in time, summed over all traces, the most prominent first; the trend of neighbouring rows is
/// taken off before.
pub fn lines(model: &LinearModel, residual_mm: &[Vec<f64>]) -> Vec<Line> {
    let traces = traces(model, residual_mm);
    let longest = traces.iter().map(Trace::length_s).fold(0.0, f64::max);
    let finest = traces.iter().map(|trace| trace.step_s).fold(f64::MAX, f64::min);
    if traces.is_empty() || longest <= 0.0 {
        return Vec::new();
    }
    let lowest = LEAST_IN_LONGEST / longest;
    let highest = 0.48 / finest;
    let count = (((highest - lowest) * 2.0 * longest) as usize).clamp(1, MOST_FREQUENCIES);
    let frequency = |k: usize| lowest + (highest - lowest) * k as f64 / count as f64;
    let all: Vec<f64> = (0..count).map(frequency).collect();
    let mut power = vec![0.0; count];
    for trace in &traces {
        power.iter_mut().zip(trace.powers(&all)).for_each(|(sum, own)| *sum += own);
    }
    let prominence = |k: usize| {
        let mut near = power[k.saturating_sub(FREQUENCIES_BESIDE)..(k + FREQUENCIES_BESIDE + 1).min(count)].to_vec();
        near.sort_by(f64::total_cmp);
        power[k] / near[near.len() / 2].max(f64::MIN_POSITIVE)
    };
    let mut order: Vec<(usize, f64)> = (0..count).map(|k| (k, prominence(k))).collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut chosen: Vec<(usize, f64)> = Vec::new();
    for (k, prominence) in order {
        let is_fast = traces.iter().all(|trace| trace.cycles(frequency(k)) > LEAST_CYCLES);
        if is_fast && chosen.iter().all(|(other, _)| other.abs_diff(k) > ONE_LINE) {
            chosen.push((k, prominence));
        }
    }
    chosen.into_iter().map(|(k, prominence)| Line { hz: frequency(k), prominence }).collect()
}

/// Readings per second of the tests that are long enough for a spectrum.
pub fn rates_of_tests(model: &LinearModel) -> Vec<f64> {
    traces(model, &model.residual_mm).iter().map(|trace| 1.0 / trace.step_s).collect()
}

/// Frequencies that look like another one at one of the sampling rates, that which shows there among them, and fast enough in
/// every trace.
pub fn aliases(model: &LinearModel, hz: f64) -> Vec<f64> {
    let traces = traces(model, &model.residual_mm);
    let rates = different(traces.iter().map(|trace| 1.0 / trace.step_s), SAME_RATE);
    let folded = rates.iter().flat_map(|&rate| [(rate - hz).abs(), rate + hz, shown_at(rate, hz)]);
    let is_fast = |hz: &f64| *hz < HIGHEST_HZ && traces.iter().all(|trace| trace.cycles(*hz) > LEAST_CYCLES);
    different(folded.filter(is_fast).filter(|alias| *alias != hz), SAME_LINE)
}

/// Frequency that a sampling rate shows of another one, Hz.
pub fn shown_at(rate: f64, hz: f64) -> f64 {
    (hz - rate * (hz / rate).round()).abs()
}

/// Share by which two aliases may differ and be one.
const SAME_LINE: f64 = 1e-4;

/// The first of all that lie within a share of each other.
fn different(all: impl Iterator<Item = f64>, share: f64) -> Vec<f64> {
    let mut kept: Vec<f64> = Vec::new();
    for one in all {
        if kept.iter().all(|other| (one / other - 1.0).abs() > share) {
            kept.push(one);
        }
    }
    kept
}

/// Traces of the tests that are long enough for a spectrum.
fn traces(model: &LinearModel, residual_mm: &[Vec<f64>]) -> Vec<Trace> {
    (0..model.tests()).filter_map(|test| Trace::of(model, residual_mm, test)).collect()
}

/// Ratio of two sampling rates from which they are two.
const OTHER_RATE: f64 = 1.1;
/// Highest frequency that is looked for where there are several rates, in units of the highest one, and in Hz.
const HIGHEST_ALIAS: f64 = 1.5;
const HIGHEST_HZ: f64 = 60.0;
/// Frequencies by which a line may lie elsewhere from trace to trace: its phase wanders.
const WANDERS: usize = 2;
/// Steps by which a line is looked up between two frequencies.
const FINER: usize = 8;

/// Frequencies that all traces together may be aliases of, the loudest first, and those of which one of `lines` is one; none where all
/// are sampled at one rate, which does not show which alias is the true frequency.
pub fn aliased(model: &LinearModel, residual_mm: &[Vec<f64>], lines: &[f64]) -> Vec<f64> {
    let traces = traces(model, residual_mm);
    let longest = traces.iter().map(Trace::length_s).fold(0.0, f64::max);
    let finest = traces.iter().map(|trace| trace.step_s).fold(f64::MAX, f64::min);
    let slowest = traces.iter().map(|trace| trace.step_s).fold(0.0, f64::max);
    if traces.is_empty() || longest <= 0.0 || slowest < OTHER_RATE * finest {
        return Vec::new();
    }
    // from where the slowest one folds to the first fold of the finest one and beyond
    let (lowest, highest) = (0.5 / slowest, (HIGHEST_ALIAS / finest).min(HIGHEST_HZ).max(0.48 / finest));
    let count = (((highest - lowest) * 2.0 * longest) as usize).clamp(1, MOST_FREQUENCIES);
    let frequency = |place: f64| lowest + (highest - lowest) * place / count as f64;
    let mut loudness = vec![0.0; count];
    let all: Vec<f64> = (0..count).map(|k| frequency(k as f64)).collect();
    for trace in &traces {
        let power = trace.powers_or_aliases(&all);
        for (k, sum) in loudness.iter_mut().enumerate() {
            *sum += power[k.saturating_sub(WANDERS)..(k + WANDERS + 1).min(count)].iter().fold(0.0, |a, b| b.max(a));
        }
    }
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|a, b| loudness[*b].total_cmp(&loudness[*a]));
    let mut chosen: Vec<usize> = Vec::new();
    // one that the highest rate shows as a lower frequency, and all others as well, is told by that one
    let is_new = |hz: f64| {
        let lower = (hz - (hz * finest).round() / finest).abs();
        traces.iter().any(|trace| (trace.cycles(hz) - trace.cycles(lower)).abs() > LEAST_CYCLES) || lower == hz
    };
    let is_fast = |hz: f64| is_new(hz) && traces.iter().all(|trace| trace.cycles(hz) > LEAST_CYCLES);
    for k in order {
        if chosen.len() < MOST_ALIASES
            && is_fast(frequency(k as f64))
            && chosen.iter().all(|other| other.abs_diff(k) > 2 * WANDERS)
        {
            chosen.push(k);
        }
    }
    let total = |hz: f64| traces.iter().map(|trace| trace.power_or_alias(hz)).sum::<f64>();
    let reach = (2 * WANDERS * FINER) as f64;
    let sharpened = |k: usize| {
        let places = (0..=2 * reach as usize).map(|j| frequency(k as f64 + (j as f64 - reach) / FINER as f64));
        let loudest = places.map(|hz| (hz, total(hz))).max_by(|a, b| a.1.total_cmp(&b.1));
        loudest.map_or(frequency(k as f64), |(hz, _)| hz)
    };
    let rates = different(traces.iter().map(|trace| 1.0 / trace.step_s), SAME_RATE);
    let multiples = rates.iter().flat_map(|rate| (1..=MOST_FOLDS).map(move |fold| f64::from(fold) * rate));
    // in a line's own band it is seen best
    let step = 0.5 / longest / FINER as f64;
    let in_band = |hz: &f64| {
        let near = (0..=4 * FINER).map(|j| hz + step * (j as f64 - 2.0 * FINER as f64));
        let power = |hz: f64| traces.iter().map(|trace| trace.power(hz)).sum::<f64>();
        let best = near.map(|hz| (hz, power(hz))).max_by(|a, b| a.1.total_cmp(&b.1));
        best.map_or(*hz, |(hz, _)| hz)
    };
    let shown: Vec<f64> = lines.iter().map(in_band).collect();
    let folded = shown.iter().flat_map(|hz| multiples.clone().flat_map(move |rate| [rate - hz, rate + hz]));
    let mut folded: Vec<(f64, f64)> =
        folded.filter(|hz| (lowest..highest).contains(hz) && is_fast(*hz)).map(|hz| (hz, total(hz))).collect();
    folded.sort_by(|a, b| b.1.total_cmp(&a.1));
    let folded = folded.into_iter().take(MOST_ALIASES).map(|(hz, _)| hz);
    // as sharp as they are their aliases
    chosen.into_iter().map(sharpened).chain(folded).chain(shown).collect()
}

/// Share by which the rates of two traces may differ and be one.
const SAME_RATE: f64 = 0.01;
/// How often a frequency may be folded at a sampling rate.
const MOST_FOLDS: u32 = 3;

/// Most frequencies that are told of those that aliases may have.
const MOST_ALIASES: usize = 3;

/// Cycles that a trace must show of a vibration: drift and gravity are no vibration near a multiple of its sampling rate.
const LEAST_CYCLES: f64 = 2.5;
/// Rows over which a rotation goes on without being renewed.
const RENEWED: usize = 64;
/// Shortest trace that is looked at, rows.
const SHORTEST: usize = 60;

/// Steps from which there is a gap between rows: readings are missing, or held out.
const GAP_IN_STEPS: f64 = 1.5;

/// A trace in time without its trend.
struct Trace {
    time_s: Vec<f64>,
    value: Vec<f64>,
    /// Sum of the squares of the values.
    squares: f64,
    /// Time from row to row, s.
    step_s: f64,
}

impl Trace {
    /// `None` for static poses and very short traces.
    fn of(model: &LinearModel, residual_mm: &[Vec<f64>], test: usize) -> Option<Trace> {
        let time = model.context.motion(test).time_s.as_ref()?;
        let residual = &residual_mm[test];
        let rows: Vec<usize> = (0..residual.len()).filter(|&row| model.kept[test][row]).collect();
        if rows.len() < SHORTEST {
            return None;
        }
        let mut steps: Vec<f64> = rows.windows(2).map(|rows| time[rows[1]] - time[rows[0]]).collect();
        steps.sort_by(f64::total_cmp);
        let median_s = steps[steps.len() / 2];
        // from row to row without gaps: those would make the steps longer than they are
        let whole = steps.into_iter().filter(|step| *step < GAP_IN_STEPS * median_s);
        let step_s = mean(whole).unwrap_or(median_s);
        let whole = rows.windows(3).filter(|rows| time[rows[2]] - time[rows[0]] < 2.0 * GAP_IN_STEPS * step_s);
        let second = |rows: &[usize]| residual[rows[1]] - 0.5 * (residual[rows[0]] + residual[rows[2]]);
        let (time_s, value): (Vec<f64>, Vec<f64>) = whole.map(|rows| (time[rows[1]], second(rows))).unzip();
        let squares = value.iter().map(|value| value * value).sum();
        let trace = Trace { time_s, value, squares, step_s };
        (trace.value.len() > 1).then_some(trace)
    }

    fn length_s(&self) -> f64 {
        self.time_s[self.time_s.len() - 1] - self.time_s[0]
    }

    /// Cycles of a frequency that the trace shows as it is sampled.
    fn cycles(&self, hz: f64) -> f64 {
        shown_at(1.0 / self.step_s, hz) * self.length_s()
    }

    /// Power at a frequency, in units of the trace's variance.
    fn power(&self, hz: f64) -> f64 {
        self.powers(&[hz])[0]
    }

    /// The same at several.
    fn powers(&self, hz: &[f64]) -> Vec<f64> {
        let shown: Vec<f64> = hz.iter().copied().filter(|hz| *hz <= 0.5 / self.step_s).collect();
        let mut powers = self.powers_or_aliases(&shown).into_iter();
        hz.iter().map(|hz| if *hz > 0.5 / self.step_s { 1.0 } else { powers.next().unwrap_or(1.0) }).collect()
    }

    /// The same also at a frequency that the trace is sampled too slowly for: that of what it shows instead.
    fn power_or_alias(&self, hz: f64) -> f64 {
        self.powers_or_aliases(&[hz])[0]
    }

    /// The same at several.
    fn powers_or_aliases(&self, hz: &[f64]) -> Vec<f64> {
        let arch = pulp::Arch::new();
        let runs = self.runs();
        let of_lanes = |hz: &[f64]| {
            let lanes: [f64; LANES] = std::array::from_fn(|k| hz[k.min(hz.len() - 1)]);
            let squares = arch.dispatch(|| self.squares(&runs, lanes));
            squares.into_iter().take(hz.len()).map(|square| square / self.squares.max(f64::MIN_POSITIVE))
        };
        hz.chunks(LANES).flat_map(of_lanes).collect()
    }

    /// Runs of rows over which a rotation goes on: rows are near enough to even spacing for one that is renewed now and then, and
    /// behind every gap.
    fn runs(&self) -> Vec<Range<usize>> {
        let is_new = |row: &usize| {
            row.is_multiple_of(RENEWED)
                || self.time_s[*row] - self.time_s[row.saturating_sub(1)] > GAP_IN_STEPS * self.step_s
        };
        let begins: Vec<usize> = (0..self.value.len()).filter(is_new).collect();
        let ends = begins.iter().skip(1).copied().chain([self.value.len()]);
        begins.iter().copied().zip(ends).map(|(from, to)| from..to).collect()
    }

    /// Squared amplitudes at some frequencies, side by side.
    #[inline(always)]
    fn squares(&self, runs: &[Range<usize>], hz: [f64; LANES]) -> [f64; LANES] {
        let (mut re, mut im) = ([0.0; LANES], [0.0; LANES]);
        let omega = hz.map(|hz| std::f64::consts::TAU * hz);
        let (ds, dc) = sines_and_cosines(&omega.map(|omega| omega * self.step_s));
        let angles: Vec<f64> = runs.iter().flat_map(|run| omega.map(|omega| omega * self.time_s[run.start])).collect();
        let (sines, cosines) = sines_and_cosines(&angles);
        for (run, (sine, cosine)) in runs.iter().zip(sines.chunks_exact(LANES).zip(cosines.chunks_exact(LANES))) {
            let mut s: [f64; LANES] = std::array::from_fn(|k| sine[k]);
            let mut c: [f64; LANES] = std::array::from_fn(|k| cosine[k]);
            for v in &self.value[run.clone()] {
                for k in 0..LANES {
                    re[k] += v * c[k];
                    im[k] += v * s[k];
                }
                for k in 0..LANES {
                    (s[k], c[k]) = (s[k] * dc[k] + c[k] * ds[k], c[k] * dc[k] - s[k] * ds[k]);
                }
            }
        }
        std::array::from_fn(|k| re[k] * re[k] + im[k] * im[k])
    }
}

/// Frequencies that are looked up side by side.
const LANES: usize = 8;
