//! How well a timing explains averaged readings: twice the negative logarithm of their marginal likelihood. It searches nothing.

use std::f64::consts::{SQRT_2, TAU};

use nalgebra::{Cholesky, DMatrix, DVector};
use statrs::function::erf::erfc;

use super::capture::Averages;
use super::course::{Course, Stretch};
use super::seen_marks::Seen;
use super::timing::Timing;
use super::timing::lag::{LAG, Lag};
use super::wander::{Filter, Wander};
use crate::statistics::{add_products, log_determinant, rms};

/// Standard deviations of what may add to a nominal length beside errors of balls and axes, mm.
const ZERO_MM: f64 = 1.0;
/// Drift over the capture: warming of bar and machine.
const DRIFT_MM: f64 = 3e-3;
/// What the sense of motion adds: backlash, as a constant and once over the run.
const HYSTERESIS_MM: f64 = 3e-3;
/// Form of unknown physics, each harmonic over the run.
const FORM_MM: f64 = 1.5e-3;
const FORM_HARMONICS: usize = 3;

/// How much a machine may do beside errors of balls and axes, as a share of the standard deviations above; the readings say
/// which by their likelihood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Freedom {
    share: f64,
    /// Forms of lost motion are allowed for, at their own standard deviations.
    lost_motion: bool,
}

impl Freedom {
    /// A search on few readings: hysteresis and form left out.
    pub const NONE: Freedom = Freedom::by_share(0.0);
    /// A machine without a fault to one with some µm of it.
    pub const ALL: [Freedom; 3] = [Freedom::by_share(0.03), Freedom::by_share(0.2), Freedom::by_share(1.0)];

    const fn by_share(share: f64) -> Freedom {
        Freedom { share, lost_motion: false }
    }

    /// The same with forms of lost motion.
    pub fn with_lost_motion(self) -> Freedom {
        Freedom { lost_motion: true, ..self }
    }

    /// All shares, with forms of lost motion where this has them.
    pub fn all(self) -> [Freedom; 3] {
        Freedom::ALL.map(|freedom| Freedom { share: freedom.share, ..self })
    }
}

/// Cost of a pace as far again outside of what is thought possible: more than any readings gain.
const WALL: f64 = 1e9;

/// Share of captures in which the control ran its directions at two paces, and the standard deviations of the ratio's logarithm
/// for those that kept one and for the others, by how far a pace may be from the programmed feed.
pub(super) const TWO_PACES: f64 = 0.1;
const ONE_PACE_SIGMA: f64 = 5e-5;

/// Minus twice the logarithm of a mixture of two normal densities about zero: `share` of the wider one.
fn of_mixture(off: f64, sigma: f64, wide: f64, share: f64) -> f64 {
    let density = |sigma: f64| (-0.5 * (off / sigma).powi(2)).exp() / sigma;
    -2.0 * ((1.0 - share) * density(sigma) + share * density(wide)).max(f64::MIN_POSITIVE).ln()
}

/// Ramps of a kind of control.
pub(super) struct RampKind {
    /// Share of all controls.
    pub share: f64,
    /// Middle ramp, s, and standard deviation of its logarithm.
    pub middle_s: f64,
    pub spread: f64,
}

impl RampKind {
    /// Share times the density of the logarithm of a ramp, but for a constant factor.
    pub fn density(&self, ramp_s: f64) -> f64 {
        let RampKind { share, middle_s, spread } = self;
        share / spread * (-0.5 * ((ramp_s / middle_s).ln() / spread).powi(2)).exp()
    }
}

/// Two kinds of control: the accelerations of axes, 0.2 to 2 m/s² at 8 to 25 mm/s, and a time constant or a limited jerk.
const RAMPS: [RampKind; 2] =
    [RampKind { share: 0.5, middle_s: 0.025, spread: 0.9 }, RampKind { share: 0.5, middle_s: 0.15, spread: 0.7 }];

/// Minus twice the logarithm of a ramp's prior density.
fn of_ramp(ramp_s: f64) -> f64 {
    -2.0 * RAMPS.iter().map(|kind| kind.density(ramp_s)).sum::<f64>().max(f64::MIN_POSITIVE).ln()
}

/// Priors of what the control did: paces about the programmed feed, and the ramp.
fn prior(course: &Course, timing: &Timing) -> f64 {
    let pace_sigma = course.feeds.sigma();
    let [slowest, fastest] = course.feeds.range();
    let outside: f64 = timing.paces.map(|pace| (slowest / pace).max(pace / fastest).max(1.0) - 1.0).iter().sum();
    let [there, back] = timing.paces.map(f64::ln);
    let [ends, begins] = timing.meeting_paces(course.run_s).map(f64::ln);
    WALL * outside
        + (0.5 * (there + back) / pace_sigma).powi(2)
        + 2.0 * f64::ln(pace_sigma)
        + of_mixture(ends - begins, ONE_PACE_SIGMA, pace_sigma, TWO_PACES)
        + of_ramp(timing.ramp_s)
}

/// How long the gap between two directions' marks is beside the programmed one: shares of captures and standard deviations, s.
/// Most controls keep a dwell to a cycle or two, and gauges' clocks to a hundredth of it; some count in cycles of a slow clock.
/// Set by reason: waits of real operators were not at hand.
const KEPT: [(f64, f64); 2] = [(0.8, 0.015), (0.15, 0.04)];
/// Share of captures in which the second direction waits longer, by a feed hold, single blocks or a clock that jumps; never
/// shorter. Half of these waits are shorter than the second number, s, and any is possible: `c/(c + x)²`. By reason, as above.
const LONGER: (f64, f64) = (0.05, 0.5);

/// Normal density about zero.
pub(super) fn normal_density(off: f64, sigma: f64) -> f64 {
    (-0.5 * (off / sigma).powi(2)).exp() / (sigma * TAU.sqrt())
}

/// Density, 1/s, of times of which a share occurs: half of these are shorter than `half_s`, and any is possible.
pub(super) fn of_any_time((share, half_s): (f64, f64), seconds: f64) -> f64 {
    share * half_s / (half_s + seconds).powi(2)
}

/// Minus twice the logarithm of the density, 1/s, of a gap that is longer than programmed by `longer_s`.
fn of_gap(longer_s: f64) -> f64 {
    let kept = KEPT.map(|(share, sigma)| share * normal_density(longer_s, sigma));
    let longer = if longer_s > 0.0 { of_any_time(LONGER, longer_s) } else { 0.0 };
    -2.0 * (kept[0] + kept[1] + longer).max(f64::MIN_POSITIVE).ln()
}

/// Share of runs that are slower than the marks: of one axis, whose run is one block, and of several, whose blocks may be too short
/// for the control's look-ahead. None is faster: one feed and one override hold for both. A faster run would only have a longer
/// ramp, and nearly flat readings say little against that.
const SLOWER: [f64; 2] = [1e-3, 0.05];

/// Minus twice the logarithm of the density of a run's pace over the marks' one, `off` in logarithms and seen with `sigma`: the
/// same, or for a share of runs less by half a normal density of `wide`.
fn of_own_pace(off: f64, sigma: f64, wide: f64, share: f64) -> f64 {
    let normal = |sigma: f64| (-0.5 * (off / sigma).powi(2)).exp() / sigma;
    let both = sigma.hypot(wide);
    // the sum of a normal and half a normal variable
    let slower = normal(both) * erfc(off * wide / (both * sigma * SQRT_2));
    -2.0 * ((1.0 - share) * normal(sigma) + share * slower).max(f64::MIN_POSITIVE).ln()
}
/// By how much a control ends its rests at its pleasure, s, with the share of controls that do: a slow part of it has to answer
/// first.
pub(super) const UNEVEN: [(f64, f64); 5] = [(0.0, 0.83), (5e-3, 0.05), (1e-2, 0.05), (UNEVEN_S, 0.05), (5e-2, 0.02)];
/// The largest of these that leaves the times of marks and run comparable.
pub(super) const UNEVEN_S: f64 = 2e-2;

/// Cost of a timing by what the program's marks tell: `Σ(t − t̂)²/σ²` over begins and ends of both runs, and the gap, but for a
/// share of controls whose rests are uneven; pace and lag are those of the marks, but for a share of runs that are slower by
/// themselves.
pub(super) fn of_marks(course: &Course, data: &Averages, timing: &Timing) -> f64 {
    let Some(seen) = &data.marks else { return 0.0 };
    // twice the negative logarithm of all four times' density, by how uneven the rests are
    let kinds = UNEVEN.map(|(uneven_s, share)| -> f64 {
        let of_times: f64 = (0..2)
            .flat_map(|direction| {
                let start = timing.start_s[direction];
                let run = [start, start + timing.moving_s(direction, course.run_s)];
                [0, 1].map(|k| {
                    let sigma = seen.run_sigma_s[direction][k].hypot(uneven_s);
                    ((run[k] - seen.runs_s[direction][k]) / sigma).powi(2) + 2.0 * sigma.ln()
                })
            })
            .sum();
        of_times - 2.0 * share.ln()
    });
    let least = kinds.into_iter().fold(f64::INFINITY, f64::min);
    let times = least - 2.0 * kinds.iter().map(|kind| (0.5 * (least - kind)).exp()).sum::<f64>().ln();
    let off = 0.5 * timing.meeting_paces(course.run_s).map(|pace| (pace / seen.pace).ln()).iter().sum::<f64>();
    let share = SLOWER[usize::from(course.moving().len() > 1)];
    let pace = of_own_pace(off, seen.pace_sigma, course.feeds.sigma(), share);
    let gap = course.marks.map_or(0.0, |marks| of_gap(seen.gap_s - marks.gap_s));
    let lag = ((timing.lag_s - seen.lag_s) / seen.lag_sigma_s).powi(2);
    times + gap + pace + lag
}

/// Cost of a timing: twice the negative log likelihood, but for a constant.
pub(super) fn cost(course: &Course, data: &Averages, timing: &Timing, freedom: Freedom) -> f64 {
    let fit = ridge(model(course, data, timing, freedom), width(course, freedom), data);
    // marks that told the lag counted its prior themselves
    let of_lag = if data.marks.is_some() { 0.0 } else { LAG.cost(Lag(timing.lag_s)) };
    fit.cost + data.wander.cost() + prior(course, timing) + of_marks(course, data, timing) + of_lag
}

/// Reading minus model at a timing, mm, by average.
pub(super) fn residual_mm(course: &Course, data: &Averages, timing: &Timing, freedom: Freedom) -> Vec<f64> {
    let width = width(course, freedom);
    let model = model(course, data, timing, freedom);
    let rows = || model.chunks_exact(width + 1);
    let fit = ridge(model.clone(), width, data);
    let explained = |row: &[f64]| match &fit.solution {
        Some(solution) => row.iter().zip(solution.iter()).map(|(a, b)| a * b).sum::<f64>(),
        None => 0.0,
    };
    rows().map(|row| row[width] - explained(row)).collect()
}

/// What is left of the readings of both runs between marks, mm, root mean square: as they are explained together, and where each is
/// explained by itself. `None` without marks.
pub(super) fn left_of_runs_mm(
    course: &Course,
    data: &Averages,
    timing: &Timing,
    together_mm: &[f64],
) -> Option<[f64; 2]> {
    let seen = data.marks?;
    let (mut together, mut each) = (Vec::new(), Vec::new());
    for [begin_s, end_s] in seen.runs_s {
        let rows: Vec<usize> =
            (0..data.time_s.len()).filter(|&row| (begin_s..=end_s).contains(&data.time_s[row])).collect();
        if rows.is_empty() {
            return None;
        }
        let of_run = |column: &[f64]| rows.iter().map(|&row| column[row]).collect::<Vec<f64>>();
        let (time_s, white_mm) = (of_run(&data.time_s), of_run(&data.white_mm));
        let wander = Wander::default();
        let filter = Filter::of(wander, &time_s, &white_mm);
        let run = Averages { time_s, value_mm: of_run(&data.value_mm), white_mm, wander, filter, marks: data.marks };
        together.extend(of_run(together_mm));
        each.extend(residual_mm(course, &run, timing, Freedom::ALL[1]));
    }
    Some([rms(together.into_iter()), rms(each.into_iter())])
}

/// What may add to a nominal length at a timing, at one standard deviation each, and readings less nominal lengths behind it: row by
/// row.
fn model(course: &Course, data: &Averages, timing: &Timing, freedom: Freedom) -> Vec<f64> {
    let rows = data.time_s.len();
    let (first, last) = (data.time_s[0], data.time_s[rows - 1]);
    let middle = course.middle_mm();
    let drift_mm = if freedom == Freedom::NONE { DRIFT_MM } else { DRIFT_MM * freedom.share };
    let (components, count) = (course.components(), width(course, freedom) + 1);
    let mut model = vec![0.0; rows * count];
    for (row, (&time, &value)) in model.chunks_exact_mut(count).zip(data.time_s.iter().zip(&data.value_mm)) {
        let (place, sense) = timing.place_s(time, course.run_s);
        let [node, sin, cos] = course.node_and_angle(place);
        let (of_errors, others) = row.split_at_mut(components);
        let [length_mm, cut_mm] = course.read_at(node, of_errors);
        let mut off = value - length_mm + middle;
        if timing.lag_s > 0.0 {
            let direction = usize::from(sense < 0.0);
            let square = timing.lagging_square(direction, time - timing.start_s[direction], course.run_s);
            off -= timing.lag_s.powi(2) * square * cut_mm;
        }
        let [zero, drift, of_machine @ .., left] = others else { continue };
        *zero = ZERO_MM;
        *drift = drift_mm * ((time - first) / (last - first) - 0.5);
        *left = off;
        let of_form = if freedom == Freedom::NONE { 0 } else { FORMS };
        let (of_form, of_lost_motion) = of_machine.split_at_mut(of_form);
        write_forms(freedom.share, sense, [sin, cos], of_form);
        if freedom.lost_motion {
            let stretch = stretch(data.marks.as_ref(), time, sense);
            course.lost_motion.forms.write(course.lost_motion.entry(stretch, node), of_lost_motion);
        }
    }
    model
}

/// Number of forms of hysteresis and of unknown physics.
const FORMS: usize = 3 + 2 * FORM_HARMONICS;

/// Hysteresis by the sense of motion, and harmonics over the run, each at its share of one standard deviation.
fn write_forms(share: f64, sense: f64, [sin, cos]: [f64; 2], forms: &mut [f64]) {
    let [constant, of_sin, of_cos, harmonics @ ..] = forms else { return };
    [constant, of_sin, of_cos]
        .into_iter()
        .zip([1.0, sin, cos])
        .for_each(|(to, form)| *to = share * HYSTERESIS_MM * sense * form);
    // each harmonic from the one before
    let (mut sin_k, mut cos_k) = (sin, cos);
    for pair in harmonics.chunks_exact_mut(2) {
        pair.iter_mut().zip([sin_k, cos_k]).for_each(|(to, form)| *to = share * FORM_MM * form);
        (sin_k, cos_k) = (sin_k * cos + cos_k * sin, cos_k * cos - sin_k * sin);
    }
}

/// Part of the program at a time, by its marks or, without them, by the sense of the last motion.
fn stretch(marks: Option<&Seen>, time_s: f64, sense: f64) -> Stretch {
    let Some(seen) = marks else { return Stretch::Run(usize::from(sense < 0.0)) };
    match seen.marks_s.iter().filter(|[begin_s, _]| time_s > *begin_s).count() {
        0 => Stretch::Before,
        1 => Stretch::Run(0),
        2 => Stretch::Between,
        3 => Stretch::Run(1),
        _ => Stretch::After,
    }
}

/// Cost of a bar that only stood: zero and drift.
pub(super) fn cost_at_rest(data: &Averages) -> f64 {
    let (first, last) = (data.time_s[0], data.time_s[data.time_s.len() - 1]);
    let row = |(time, value): (&f64, &f64)| [ZERO_MM, DRIFT_MM * ((time - first) / (last - first) - 0.5), *value];
    let model: Vec<f64> = data.time_s.iter().zip(&data.value_mm).flat_map(row).collect();
    ridge(model, 2, data).cost + data.wander.cost()
}

fn width(course: &Course, freedom: Freedom) -> usize {
    let of_form = if freedom == Freedom::NONE { 0 } else { FORMS };
    let of_lost_motion = if freedom.lost_motion { course.lost_motion.forms.columns() } else { 0 };
    course.components() + 2 + of_form + of_lost_motion
}

struct Ridge {
    cost: f64,
    /// Coefficients; `None` where readings are not finite.
    solution: Option<DVector<f64>>,
}

/// Least squares with unit priors, coefficients integrated out: `yᵀ(C + MMᵀ)⁻¹y + log det(C + MMᵀ)`, C of noise and wander;
/// M row by row with y behind it.
fn ridge(mut model: Vec<f64>, width: usize, data: &Averages) -> Ridge {
    data.filter.apply(&mut model, width + 1);
    let rows = data.time_s.len();
    let count = width + 1;
    let mut columns = vec![0.0; count * rows];
    for (row, values) in model.chunks_exact(count).enumerate() {
        columns.iter_mut().skip(row).step_by(rows).zip(values).for_each(|(to, value)| *to = *value);
    }
    // lower triangle, row by row
    let mut products = vec![0.0; count * count];
    add_products(&columns, rows, count, &mut products);
    let [before @ .., squares] = products.as_slice() else { return Ridge { cost: f64::NAN, solution: None } };
    let right = DVector::from_column_slice(&before[width * count..]);
    let mut normal = DMatrix::from_fn(width, width, |row, column| products[row * count + column]);
    (0..width).for_each(|k| normal[(k, k)] += 1.0);
    // only readings that are not finite can spoil it
    let Some(factor) = Cholesky::new(normal) else { return Ridge { cost: f64::NAN, solution: None } };
    let solution = factor.solve(&right);
    let cost = squares - solution.dot(&right) + log_determinant(&factor) + data.filter.log_determinant;
    Ridge { cost, solution: Some(solution) }
}
