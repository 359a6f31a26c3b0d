//! Sessions in which software took a mean, a trend or a circle's centre off some recordings before it wrote them. Whether it did is
//! for others to judge.
//!
//! What is taken off is gone: readings without a trend have a slope of zero to the last digit, where those of a gauge have one by
//! noise alone. That they agree so well is what speaks for it; what was taken off is fitted.

use super::figures::{Figure, Linearised, with_figures};
use super::processed::{NO_DIGIT_MM, deviations_mm};
use crate::chain::Chain;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::model::decimate::Sampled;
use crate::diagnose::preflight::data_fault::{DataFault, RECORDER, listed};
use crate::diagnose::preflight::places::misplaced::names;
use crate::diagnose::preflight::suspicion::{Detail, Suspicion};
use crate::machine::AxisKind;
use crate::session::{Motion, Session, Test};
use crate::statistics::noise_of_rows;
use nalgebra::{Cholesky, DMatrix, DVector};

/// What may have been taken off.
#[derive(Clone, Copy, PartialEq)]
enum TakenOff {
    Mean,
    Trend,
    TrendFromStart,
    TrendAndMean,
    Centre,
    CentreAndMean,
    Start,
    EndToEnd,
}

const ALL: [TakenOff; 8] = [
    TakenOff::CentreAndMean,
    TakenOff::Centre,
    TakenOff::TrendAndMean,
    TakenOff::Trend,
    TakenOff::TrendFromStart,
    TakenOff::Mean,
    TakenOff::EndToEnd,
    TakenOff::Start,
];

impl TakenOff {
    fn words(self) -> &'static str {
        match self {
            TakenOff::Mean => "the mean was taken off",
            TakenOff::Trend | TakenOff::TrendFromStart => "a trend over time was taken off",
            TakenOff::TrendAndMean => "mean and trend over time were taken off",
            TakenOff::Centre => "the centre of the circle was taken off",
            TakenOff::CentreAndMean => "centre and radius of the circle were taken off",
            TakenOff::Start => "the gauge was zeroed at the start of",
            TakenOff::EndToEnd => "a drift was taken off that brings the last reading to the first in",
        }
    }

    /// What was taken off with it already.
    fn includes(self, other: TakenOff) -> bool {
        match self {
            TakenOff::CentreAndMean => matches!(other, TakenOff::Centre | TakenOff::Mean),
            TakenOff::TrendAndMean => matches!(other, TakenOff::Trend | TakenOff::TrendFromStart | TakenOff::Mean),
            _ => false,
        }
    }

    /// Functions that were taken off: of time from −1 to 1, of an angle.
    fn taken(self, (time, angle): (&[f64], &[f64])) -> Vec<Vec<f64>> {
        let from_start = || vec![time.iter().map(|time| 0.5 * (1.0 + time)).collect()];
        match self {
            TakenOff::TrendFromStart | TakenOff::EndToEnd => from_start(),
            _ => {
                let (functions, count) = self.functions((time, angle));
                functions.into_iter().rev().take(count).collect()
            }
        }
    }

    /// Functions that were fitted together, with how many of them, from the last one on, are zero since.
    fn functions(self, (time, angle): (&[f64], &[f64])) -> (Vec<Vec<f64>>, usize) {
        let one = || vec![1.0; time.len()];
        let circle = || [f64::cos, f64::sin].map(|of| angle.iter().copied().map(of).collect::<Vec<f64>>());
        match self {
            TakenOff::Mean | TakenOff::Start => (vec![one()], 1),
            TakenOff::Trend | TakenOff::TrendFromStart | TakenOff::EndToEnd => (vec![one(), time.to_vec()], 1),
            TakenOff::TrendAndMean => (vec![one(), time.to_vec()], 2),
            TakenOff::Centre => ([vec![one()], circle().to_vec()].concat(), 2),
            TakenOff::CentreAndMean => ([vec![one()], circle().to_vec()].concat(), 3),
        }
    }
}

/// Rounding of rows that lie near each other goes the same way: means of it vary so many times as much as if it did not.
const ALIKE_ROUNDED: f64 = 2.0;

/// Angles that a circle must cover for its centre to be known, rad: a quarter of a turn.
const LEAST_ARC: f64 = 0.5 * std::f64::consts::PI;

/// Recordings off which the same was taken, for everything that may have been.
pub(crate) fn taken_off(sampled: Sampled<'_>, linearised: &Linearised) -> Vec<Suspicion> {
    let Sampled { few_rows: thinned, all_rows: session } = sampled;
    let chain = Chain::of(&session.machine);
    let read: Vec<Option<Read>> = session.tests.iter().map(|test| Read::of(session, &chain, test, None)).collect();
    let within = thinned.tests.iter().zip(&read).map(|(test, read)| (test, read.as_ref().map(|read| read.span_s)));
    let few: Vec<Option<Read>> = within.map(|(test, span_s)| Read::of(thinned, &chain, test, span_s)).collect();
    let mut list: Vec<(TakenOff, Suspicion)> = Vec::new();
    for what in ALL {
        let agreeing = (0..session.tests.len()).filter_map(|test| Some((test, read[test].as_ref()?.agreement(what)?)));
        let found = restored((thinned, &few), linearised, what, &agreeing.collect::<Vec<_>>());
        let is_new =
            |found: &Suspicion| !list.iter().any(|(other, told)| other.includes(what) && told.tests == found.tests);
        if let Some(found) = found.filter(is_new) {
            list.push((what, found));
        }
    }
    list.into_iter().map(|(_, found)| found).collect()
}

/// Log odds from which recordings themselves show that something was taken off: as of a first effect.
const LEAST_LOG_ODDS: f64 = 15.0;

/// Shares of the recordings that may lack it.
const SHARES: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

/// Centres or trends that so many recordings lack, to the last digit, that noise does not leave them so: seen without any fit, for balls and
/// location errors explain a machine without centres as well as any other.
pub(crate) fn lacking(session: &Session) -> Option<DataFault> {
    let chain = Chain::of(&session.machine);
    let read: Vec<Option<Read>> = session.tests.iter().map(|test| Read::of(session, &chain, test, None)).collect();
    let of = |what: TakenOff| {
        let log_of =
            |read: &Option<Read>| read.as_ref().and_then(|read| read.agreement(what)).unwrap_or(f64::NEG_INFINITY);
        let logs: Vec<f64> = read.iter().map(log_of).collect();
        // by noise alone the mean of exp(log) is one, and so is that of each of these products
        let of_share = |share: f64| -> f64 {
            let larger = |log: f64| log.max(0.0);
            let of = |log: &f64| {
                larger(*log) + ((1.0 - share) * (-larger(*log)).exp() + share * (log - larger(*log)).exp()).ln()
            };
            logs.iter().map(of).sum()
        };
        let shown = SHARES.map(of_share).into_iter().fold(f64::NEG_INFINITY, f64::max) - (SHARES.len() as f64).ln();
        (shown, what, logs)
    };
    let all = [TakenOff::CentreAndMean, TakenOff::Centre, TakenOff::TrendAndMean, TakenOff::Trend].map(of);
    let (shown, what, logs) = all.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let struck: Vec<usize> = (0..logs.len()).filter(|&test| logs[test] > 0.0).collect();
    (shown > LEAST_LOG_ODDS).then(|| {
        let names = names(session, &struck);
        let says = format!("{} the readings of {}: export them as they were read", what.words(), listed(&names));
        let mut fault = DataFault::seen(FaultKind::ReadingsProcessed, RECORDER, names, says);
        fault.components = vec!["length".into()];
        fault
    })
}

/// Standard deviations from which something was seen to be taken off.
const LEAST_SIGMAS: f64 = 3.0;

/// The session with what was taken off some tests put back, as it fits best. Tests that lack nothing agree by chance.
fn restored(
    (thinned, few): (&Session, &[Option<Read>]),
    linearised: &Linearised,
    what: TakenOff,
    agreeing: &[(usize, f64)],
) -> Option<Suspicion> {
    let figures_of = |&(test, _): &(usize, f64)| -> Option<Vec<Figure>> {
        let taken = what.taken(few[test].as_ref()?.drivers()).into_iter();
        Some(taken.map(|function| Figure { by_test: vec![(test, function)] }).collect())
    };
    let all: Vec<Figure> = agreeing.iter().map(figures_of).collect::<Option<Vec<_>>>()?.into_iter().flatten().collect();
    let sizes = linearised.fitted(&all)?;
    let lacks = |test: usize| {
        let of = all.iter().zip(&sizes).filter(|(figure, _)| figure.by_test[0].0 == test);
        of.into_iter().any(|(_, size)| size.value.abs() > LEAST_SIGMAS * size.sigma)
    };
    let lacking: Vec<(usize, f64)> = agreeing.iter().copied().filter(|(test, _)| lacks(*test)).collect();
    if lacking.is_empty() {
        return None;
    }
    let figures: Vec<Figure> =
        lacking.iter().map(figures_of).collect::<Option<Vec<_>>>()?.into_iter().flatten().collect();
    let undone = with_figures(thinned, &figures, &linearised.fitted(&figures)?)?;
    let names = names(thinned, &lacking.iter().map(|(test, _)| *test).collect::<Vec<_>>());
    let of = if matches!(what, TakenOff::Start | TakenOff::EndToEnd) { "" } else { " the readings of" };
    let says = format!("{}{of} {}: export them as they were read", what.words(), listed(&names));
    let mut found = Suspicion::new(FaultKind::ReadingsProcessed, RECORDER, names, says, undone);
    (found.components, found.detail) = (vec!["length".into()], Detail::Way(what.words()));
    Some(Suspicion { log_figures: lacking.iter().map(|(_, log)| log).sum(), ..found })
}

/// Deviations of a test with what they may depend on.
struct Read {
    /// First and last time of the recording, s.
    span_s: (f64, f64),
    /// From −1 to 1 over that span.
    time: Vec<f64>,
    /// Of the rotary axis that turns farthest, rad.
    angle: Vec<f64>,
    /// NaN where there is no reading.
    deviation_mm: Vec<f64>,
}

impl Read {
    /// Of a recording, or of a few of its rows where its span is stated.
    fn of(session: &Session, chain: &Chain, test: &Test, span_s: Option<(f64, f64)>) -> Option<Read> {
        let deviation_mm = deviations_mm(test)?;
        let motion = Motion::of(session, chain, test).ok()?;
        let time_s = motion.time_s.as_ref()?;
        let (first, last) = span_s.unwrap_or((*time_s.first()?, *time_s.last()?));
        let time = time_s.iter().map(|time| 2.0 * (time - first) / (last - first) - 1.0).collect();
        let rotary = motion.moving.iter().filter(|&&axis| session.machine.axes[axis].kind == AxisKind::Rotary);
        let travels = rotary.map(|&axis| motion.axis(axis).collect::<Vec<f64>>());
        let angle = travels.max_by(|a, b| travel(a).total_cmp(&travel(b)))?;
        Some(Read { span_s: (first, last), time, angle, deviation_mm })
    }

    fn drivers(&self) -> (&[f64], &[f64]) {
        (&self.time, &self.angle)
    }

    /// How much likelier it is that readings agree so well where something was taken off than where it was not, as a logarithm;
    /// `None` where it is not.
    ///
    /// What is left of a function is normal by the rounding of the file where it was taken off, and by noise at least where it was not.
    fn agreement(&self, what: TakenOff) -> Option<f64> {
        let (noise_mm, step_mm) = (noise_of_rows(&self.deviation_mm), step_mm(&self.deviation_mm)?);
        let rounding_mm = ALIKE_ROUNDED * step_mm / 12f64.sqrt();
        let (first, last) = (*self.deviation_mm.first()?, *self.deviation_mm.last()?);
        let of_one = |left: f64, scale: f64| {
            let (rounded, noisy) = (left / (rounding_mm * scale), left / (noise_mm * scale));
            (noise_mm / rounding_mm).ln() - 0.5 * (rounded.powi(2) - noisy.powi(2))
        };
        let log = match what {
            TakenOff::Start => of_one(first, 1.0),
            TakenOff::EndToEnd => of_one(last - first, std::f64::consts::SQRT_2),
            TakenOff::Centre | TakenOff::CentreAndMean if travel(&self.angle) < LEAST_ARC => return None,
            _ => {
                let (functions, count) = what.functions(self.drivers());
                let left = fitted(&functions, &self.deviation_mm)?;
                let logs = left.iter().rev().take(count).map(|(left, scale)| of_one(*left, *scale));
                logs.fold(0.0, |sum, log| if log > 0.0 { sum + log } else { f64::NEG_INFINITY })
            }
        };
        (noise_mm > rounding_mm && log > 0.0).then_some(log)
    }
}

fn travel(angle: &[f64]) -> f64 {
    let (least, most) = angle.iter().fold((f64::MAX, f64::MIN), |(least, most), &at| (least.min(at), most.max(at)));
    most - least
}

/// Least difference of readings that are not equal, mm: the last digit of the file, or of the gauge. Differences below
/// [`NO_DIGIT_MM`] are rounding.
fn step_mm(deviation_mm: &[f64]) -> Option<f64> {
    let mut sorted: Vec<f64> = deviation_mm.iter().copied().filter(|value| value.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let gaps = sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(|gap| *gap > NO_DIGIT_MM);
    gaps.min_by(f64::total_cmp)
}

/// Sizes of functions in readings by least squares, each with its standard deviation by readings of deviation 1.
fn fitted(functions: &[Vec<f64>], readings: &[f64]) -> Option<Vec<(f64, f64)>> {
    let rows: Vec<usize> = (0..readings.len()).filter(|&row| readings[row].is_finite()).collect();
    let columns = DMatrix::from_fn(rows.len(), functions.len(), |row, k| functions[k][rows[row]]);
    let read = DVector::from_iterator(rows.len(), rows.iter().map(|&row| readings[row]));
    let factor = Cholesky::new(columns.tr_mul(&columns))?;
    let (sizes, variance) = (factor.solve(&columns.tr_mul(&read)), factor.inverse().diagonal());
    Some(sizes.iter().zip(&variance).map(|(size, variance)| (*size, variance.sqrt())).collect())
}
