//! Readings as a gauge wrote them, made fit for a search: spikes out, averaged to few, their noise. It knows no program.

use super::seen_marks::Seen;
use super::wander::{Filter, Wander};
use crate::statistics::{median, noise_of_rows};

/// Readings over the gauge's own time.
#[derive(Debug, Clone, PartialEq)]
pub struct Capture {
    /// Times, s, rising; the gauge's own zero.
    pub time_s: Vec<f64>,
    /// Absolute lengths or deviations, mm; NaN where nothing was read.
    pub reading_mm: Vec<f64>,
}

/// Averages of neighbouring readings.
#[derive(Debug, Clone)]
pub(super) struct Averages {
    pub time_s: Vec<f64>,
    /// About the median of the capture, mm.
    pub value_mm: Vec<f64>,
    /// Standard deviation of each by white noise, mm.
    pub white_mm: Vec<f64>,
    /// What wanders beside it, with the filter for both.
    pub wander: Wander,
    pub filter: Filter,
    /// What the program's marks tell; readings of marks are in no average.
    pub marks: Option<Seen>,
}

/// Readings that differ by less are one number: a hundredth of a gauge's step, mm.
const SAME_MM: f64 = 1e-6;
/// Least scatter about which readings are spikes, mm.
const SCATTER_MM: f64 = 0.2e-3;
/// Least white noise of an average, mm: gauges read in steps of 0.1 µm.
const STEP_NOISE_MM: f64 = 0.03e-3;
/// Readings farther from the median of their neighbours than so many scatters are spikes.
const SPIKE: f64 = 8.0;
/// Neighbours on either side of which the median is taken.
const NEIGHBOURS: usize = 3;

impl Capture {
    /// Finite readings with their times.
    pub(super) fn finite(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.time_s.iter().copied().zip(self.reading_mm.iter().copied()).filter(|(_, reading)| reading.is_finite())
    }

    /// What was read from one time to another, s.
    pub(super) fn between(&self, from_s: f64, to_s: f64) -> Capture {
        let within = self.time_s.iter().copied().zip(self.reading_mm.iter().copied());
        let (time_s, reading_mm) = within.filter(|(time, _)| (from_s..=to_s).contains(time)).unzip();
        Capture { time_s, reading_mm }
    }

    /// Share of readings that are the middle one to the last digit.
    pub(super) fn share_alike(&self) -> f64 {
        let middle = self.middle_mm();
        let (alike, all) = self.finite().fold((0usize, 0usize), |(alike, all), (_, reading)| {
            (alike + usize::from((reading - middle).abs() < SAME_MM), all + 1)
        });
        alike as f64 / all.max(1) as f64
    }

    /// Median of all readings, mm.
    pub fn middle_mm(&self) -> f64 {
        median(self.reading_mm.iter().copied()).unwrap_or(f64::NAN)
    }

    /// First and last time with a reading, s.
    pub fn ends_s(&self) -> (f64, f64) {
        let first = self.finite().next().map_or(0.0, |(time, _)| time);
        (first, self.finite().last().map_or(0.0, |(time, _)| time))
    }

    /// Noise of one reading, mm, which no slow motion reaches.
    pub fn noise_mm(&self) -> f64 {
        let values: Vec<f64> = self.finite().map(|(_, reading)| reading).collect();
        noise_of_rows(&values)
    }

    /// Share of readings that lie farther than `stroke_mm` from the median.
    pub fn share_outside(&self, stroke_mm: f64) -> f64 {
        let middle = self.middle_mm();
        let (mut outside, mut all) = (0usize, 0usize);
        for (_, reading) in self.finite() {
            all += 1;
            outside += usize::from((reading - middle).abs() > stroke_mm);
        }
        outside as f64 / all.max(1) as f64
    }

    /// True for readings that stand out of their neighbourhood.
    pub fn spikes(&self) -> Vec<bool> {
        let values = &self.reading_mm;
        let scatter = self.noise_mm().max(SCATTER_MM);
        (0..values.len())
            .map(|k| {
                let around = &values[k.saturating_sub(NEIGHBOURS)..(k + NEIGHBOURS + 1).min(values.len())];
                let near: Vec<f64> = around.iter().copied().filter(|value| value.is_finite()).collect();
                let steepest = near.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
                let middle = median(near.iter().copied()).unwrap_or(f64::NAN);
                // at few readings a second the neighbours themselves are far apart
                let (low, high) = near.iter().fold((f64::MAX, f64::MIN), |(a, b), &value| (a.min(value), b.max(value)));
                let steps = (high - low).max(0.0);
                let off = (values[k] - middle).abs();
                values[k].is_finite() && off > SPIKE * scatter && off > 0.8 * steps && steepest > SPIKE * scatter
            })
            .collect()
    }

    /// At most `most` averages over equal times, spikes and marks left out.
    pub(super) fn averages(&self, most: usize, marks: Option<Seen>) -> Averages {
        let (first, last) = self.ends_s();
        let spikes = self.spikes();
        let kept: Vec<(f64, f64)> = (self.time_s.iter().zip(&self.reading_mm).zip(&spikes))
            .filter(|((_, reading), spike)| reading.is_finite() && !**spike)
            .map(|((time, reading), _)| (*time, *reading))
            .filter(|(time, _)| !marks.is_some_and(|marks| marks.hide(*time)))
            .collect();
        let (middle, noise) = (self.middle_mm(), self.noise_mm());
        let width = ((last - first) / most as f64).max(1e-9);
        let (mut time_s, mut value_mm, mut white_mm) = (Vec::new(), Vec::new(), Vec::new());
        let mut at = 0;
        while at < kept.len() {
            let bin = ((kept[at].0 - first) / width).floor();
            let end = at + kept[at..].iter().take_while(|(time, _)| ((time - first) / width).floor() == bin).count();
            let part = &kept[at..end.max(at + 1)];
            let count = part.len() as f64;
            time_s.push(part.iter().map(|(time, _)| time).sum::<f64>() / count);
            value_mm.push(part.iter().map(|(_, reading)| reading - middle).sum::<f64>() / count);
            white_mm.push((noise / count.sqrt()).max(STEP_NOISE_MM));
            at = end.max(at + 1);
        }
        let wander = Wander::default();
        let filter = Filter::of(wander, &time_s, &white_mm);
        Averages { time_s, value_mm, white_mm, wander, filter, marks }
    }
}

impl Averages {
    /// The same with another wander.
    pub(super) fn with(&self, wander: Wander) -> Averages {
        Averages { wander, filter: Filter::of(wander, &self.time_s, &self.white_mm), ..self.clone() }
    }
}
