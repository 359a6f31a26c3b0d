//! Could these recordings tell that an axis goes the other way? Its sense is turned in the model and all is fitted again.
//!
//! With the noise and the kept rows of the fit, `Δχ² = χ²(sense turned) − χ²(as stated)`, each at its minimum over all
//! unknowns with their priors. A design that is its own mirror image has a Δχ² of nothing: the turned sense fits as well,
//! with errors of other signs. A short test that tells is looked for among the session's own balls and bars: the axis a
//! little aside and one linear axis moved until the bar has its length again; with the other sense it would not fit on.
//! Where captures show the marks of programs, these are such tests: see `mark_senses`.

use crate::statistics::NoiseModel;
use nalgebra::{Cholesky, DMatrix, DVector, Vector3};

use super::estimate::Fit;
use super::mark_senses::worse_by_marks;
use super::solve::{Weighting, normal_equations};
use crate::chain::{Chain, Composition, Geometry, sense_in_words};
use crate::identify::model::error::FitError;
use crate::identify::model::problem::Problem;
use crate::identify::model::unknowns::Quantity;
use crate::machine::{AxisKind, Machine};
use crate::session::{Session, Setups, located_anew};

/// Δχ² from which a sense is told: five standard deviations, one chance in a million of being misled.
const LEAST_CHI2_OF_A_SENSE: f64 = 25.0;
/// Δχ² from which no further step can make the turned sense fit: lengths are linear in errors but for 1 part in 100.
const MOST_CHI2_WORTH_A_STEP: f64 = 1e9;
/// Most Gauss–Newton steps; errors of a machine are small against its levers, so that two are the rule.
const MOST_STEPS: usize = 8;
/// A step that changes χ² by less than this is the last.
const LEAST_CHI2_CHANGE: f64 = 0.1;
/// Change of an estimate in its standard deviations from which it is told.
const LEAST_CHANGE_SIGMAS: f64 = 2.0;
/// How far aside the axis stands in a short test, deg and mm, either way: seen by eye, and within most ranges.
const ASIDE: [f64; 2] = [20.0, 50.0];
/// Least difference of the two lengths in a short test, mm: the stroke of a ball bar, so that it does not go on at all.
const CLEAR_MM: f64 = 1.0;

/// An error that would be another one with a sense turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovedError {
    /// Index of the unknown.
    pub unknown: usize,
    /// Its value with the sense as stated and turned, mm or rad.
    pub stated: f64,
    pub turned: f64,
}

/// What the recordings say of the sense of one axis, or of several together.
#[derive(Debug, Clone, PartialEq)]
pub struct TurnedSense {
    /// Axis indices: one, or those whose senses turn where the machine is mirrored.
    pub axes: Vec<usize>,
    /// χ² with the sense turned minus χ² as stated.
    pub worse_by: f64,
    /// Part of it that the marks of programs make, as captures show them.
    pub by_marks: f64,
    /// Determined errors that would be other ones.
    pub moved: Vec<MovedError>,
    /// A short test that tells, where the recordings do not.
    pub test: Option<SenseTest>,
}

impl TurnedSense {
    /// The recordings tell the sense.
    pub fn is_told(&self) -> bool {
        self.worse_by.abs() >= LEAST_CHI2_OF_A_SENSE
    }

    /// The marks alone would tell the sense.
    pub fn is_shown_by_marks(&self) -> bool {
        self.by_marks.abs() >= LEAST_CHI2_OF_A_SENSE
    }

    /// The recordings speak for the other sense.
    pub fn looks_wrong(&self) -> bool {
        self.worse_by <= -LEAST_CHI2_OF_A_SENSE
    }

    /// The axes by name: `A`, `Y and C`.
    pub fn named(&self, machine: &Machine) -> String {
        let names: Vec<&str> = self.axes.iter().map(|&axis| machine.axes[axis].name.as_str()).collect();
        match names.split_last() {
            Some((last, others)) if !others.is_empty() => format!("{} and {last}", others.join(", ")),
            _ => names.concat(),
        }
    }

    /// The short test that tells the sense: a look at the axis, and a place where the bar would not go on.
    pub fn how_to_tell(&self, session: &Session) -> String {
        let machine = &session.machine;
        let zero = vec![0.0; machine.axes.len()];
        let goes: Vec<String> = self.axes.iter().map(|&axis| sense_in_words(machine, axis, &zero)).collect();
        let each = if self.axes.len() > 1 { "each of " } else { "" };
        let look = format!("move {each}{} a little in + and see: {}", self.named(machine), goes.join("; "));
        match &self.test {
            None => look,
            Some(test) => format!(
                "{look}; or, if nothing is in the way, stand at {} with balls and bar of {}, bar off on the way: the balls are {:.2} mm apart, the other way {:.2} mm",
                places(machine, &test.positions),
                session.tests[test.test].name,
                test.stated_mm,
                test.turned_mm
            ),
        }
    }
}

/// `A 20, Z 68.404, the others at 0`.
fn places(machine: &Machine, positions: &[f64]) -> String {
    let shown = machine.axes.iter().zip(positions).filter_map(|(axis, &q)| {
        let q = (axis.kind.to_file_unit(q) * 1e3).round() / 1e3 + 0.0;
        (q != 0.0).then(|| format!("{} {q}", axis.name))
    });
    let listed: Vec<String> = shown.collect();
    let rest = if listed.len() < machine.axes.len() { ", the others at 0" } else { "" };
    format!("{}{rest}", listed.join(", "))
}

/// One place to stand at with balls and bar of a test.
#[derive(Debug, Clone, PartialEq)]
pub struct SenseTest {
    /// Whose balls and bar.
    pub test: usize,
    /// Commands of all axes, mm or rad.
    pub positions: Vec<f64>,
    /// Distance of the balls with the sense as stated, and with it turned, mm.
    pub stated_mm: f64,
    pub turned_mm: f64,
}

impl SenseTest {
    /// By how much the two lengths differ, mm.
    fn apart_mm(&self) -> f64 {
        (self.turned_mm - self.stated_mm).abs()
    }
}

/// A fitted model: its χ² and the values of the unknowns.
struct Fitted {
    cost: f64,
    values: Vec<f64>,
}

/// Every axis that moves in the recordings or stands off zero there, and those together that turn in a mirror, where the recordings do not tell
/// them: a design that is its own mirror image tells each sense alone, but not all of them.
pub fn turned_senses(session: &Session, fit: &Fit) -> Result<Vec<TurnedSense>, FitError> {
    let chain = Chain::of(&session.machine);
    let setups = Setups::of(session);
    let budget = &session.machine.linear_axes;
    let stated = Problem::new(session, &chain, &setups, fit.unknowns.clone())?.with_linear_axes(budget);
    let kept = fit.kept_rows();
    let prior_means =
        |problem: &Problem| problem.unknowns.iter().map(|unknown| unknown.prior_mean).collect::<Vec<f64>>();
    let mut start = prior_means(&stated);
    start[..fit.unknowns.len()].copy_from_slice(&fit.values());
    let Some(as_stated) = refit(&stated, &start, (&fit.noise, &kept), f64::INFINITY) else {
        return Ok(Vec::new());
    };
    let is_used = |axis: usize| {
        let tests = stated.tests.iter().zip(&session.tests).filter(|(_, test)| test.recording.is_some());
        tests.into_iter().any(|(test, _)| test.motion.leaves_zero(axis))
    };
    let used: Vec<usize> = (0..session.machine.axes.len()).filter(|&axis| is_used(axis)).collect();
    let alone = used.iter().map(|&axis| vec![axis]);
    let together = (0..3).map(|plane| mirrored(&session.machine, &used, plane)).filter(|axes| axes.len() > 1);
    let mut list = Vec::new();
    for axes in alone.chain(together) {
        let mut other = session.clone();
        axes.iter().for_each(|&axis| other.machine.axes[axis].reversed ^= true);
        let other_chain = Chain::of(&other.machine);
        // instruments and targets that the readings placed would stand elsewhere
        if session.has_parts() {
            other = located_anew(other.clone(), &other_chain).unwrap_or(other);
        }
        let other_setups = Setups::of(&other);
        let problem = Problem::new(&other, &other_chain, &other_setups, fit.unknowns.clone())?.with_linear_axes(budget);
        let turned =
            refit(&problem, &prior_means(&problem), (&fit.noise, &kept), as_stated.cost + MOST_CHI2_WORTH_A_STEP);
        let by_readings = turned.as_ref().map_or(MOST_CHI2_WORTH_A_STEP, |turned| turned.cost - as_stated.cost);
        let by_marks = worse_by_marks([&stated, &problem]);
        let worse_by = (by_readings + by_marks).min(MOST_CHI2_WORTH_A_STEP);
        let mut sense = TurnedSense { axes, worse_by, by_marks, moved: Vec::new(), test: None };
        // of several together only what the recordings leave open is news
        if sense.axes.len() > 1 && worse_by >= LEAST_CHI2_OF_A_SENSE {
            continue;
        }
        if let Some(turned) = turned.filter(|_| worse_by < LEAST_CHI2_OF_A_SENSE) {
            sense.moved = moved(fit, &turned.values);
            let values = [&as_stated.values[..], &turned.values];
            let tests = sense.axes.iter().filter_map(|&axis| short_test(&stated, &problem, axis, values));
            sense.test = tests.max_by(|one, other| one.apart_mm().total_cmp(&other.apart_mm()));
        }
        list.push(sense);
    }
    Ok(list)
}

/// Axes whose senses turn where the machine is seen in a mirror across a coordinate: slides along it, and axes that turn about the others.
fn mirrored(machine: &Machine, used: &[usize], across: usize) -> Vec<usize> {
    let turns = |&axis: &usize| {
        let is_along = machine.axes[axis].direction[across].abs() > LEAST_SHARE_ALONG;
        is_along == (machine.axes[axis].kind == AxisKind::Linear)
    };
    used.iter().copied().filter(turns).collect()
}

/// Part of a direction along a coordinate from which it is that coordinate's.
const LEAST_SHARE_ALONG: f64 = 0.9;

/// Gauss–Newton from a start; `None` where χ² cannot come below the limit.
fn refit(problem: &Problem, start: &[f64], (noise, kept): (&[NoiseModel], &[Vec<bool>]), limit: f64) -> Option<Fitted> {
    let mut values = start.to_vec();
    for step in 0..MOST_STEPS {
        let (normal, _) = normal_equations(problem, &values, &Weighting::Whitened { noise, kept });
        let count = values.len();
        let off = DVector::from_iterator(
            count,
            problem.unknowns.iter().zip(&values).map(|(of, value)| (value - of.prior_mean) / of.prior_sigma),
        );
        let cost = normal.cost + off.norm_squared();
        let right = normal.gradient - off;
        let scaled = Cholesky::new(normal.information + DMatrix::identity(count, count))?.solve(&right);
        // what the linear model expects of the step
        let gain = right.dot(&scaled);
        if !(cost - gain).is_finite() || cost - gain > limit {
            return None;
        }
        if gain < LEAST_CHI2_CHANGE || step + 1 == MOST_STEPS {
            return Some(Fitted { cost, values });
        }
        values.iter_mut().zip(problem.unknowns.iter().zip(scaled.iter())).for_each(|(value, (of, step))| {
            *value += step * of.prior_sigma;
        });
    }
    None
}

/// Determined location errors that the turned sense would give otherwise, the farthest in its standard deviations first.
fn moved(fit: &Fit, turned: &[f64]) -> Vec<MovedError> {
    let far = |k: usize| (turned[k] - fit.estimates[k].value).abs() / fit.estimates[k].sigma;
    let is_told = |k: &usize| {
        let is_error = matches!(fit.unknowns[*k].quantity, Quantity::Location { .. });
        is_error && fit.estimates[*k].determined && far(*k) > LEAST_CHANGE_SIGMAS
    };
    let mut list: Vec<usize> = (0..fit.unknowns.len()).filter(is_told).collect();
    list.sort_by(|&a, &b| far(b).total_cmp(&far(a)));
    list.into_iter().map(|k| MovedError { unknown: k, stated: fit.estimates[k].value, turned: turned[k] }).collect()
}

/// The place at which the two senses differ most; places and bars are those of the session's tests.
fn short_test(stated: &Problem, turned: &Problem, axis: usize, values: [&[f64]; 2]) -> Option<SenseTest> {
    let models = [(stated, values[0]), (turned, values[1])];
    let errors = models.map(|(problem, values)| problem.location_errors(values));
    let geometries = [0, 1].map(|model| Geometry::new(models[model].0.chain, &errors[model], Composition::Exact));
    let machine = &stated.session.machine;
    let inside = |axis: usize, q: f64| machine.axes[axis].range.is_none_or(|(low, high)| q >= low && q <= high);
    let mut best: Option<SenseTest> = None;
    for (index, prepared) in stated.tests.iter().enumerate() {
        let Some(bar_mm) = stated.session.tests[index].bar_length_mm.filter(|_| prepared.motion.rows() > 0) else {
            continue;
        };
        let between = |model: usize, q: &[f64]| -> Vector3<f64> {
            let (pivot, spindle, _) = models[model].0.setup_of(index, models[model].1);
            geometries[model].point(prepared.links.0, &pivot, q, None)
                - geometries[model].point(prepared.links.1, &spindle, q, None)
        };
        for aside in [1.0, -1.0] {
            let mut at = prepared.motion.row(0).to_vec();
            at[axis] = aside * ASIDE[usize::from(machine.axes[axis].kind == AxisKind::Linear)];
            at[axis] = machine.axes[axis].kind.from_file_unit(at[axis]);
            if !inside(axis, at[axis]) {
                continue;
            }
            let others = (0..at.len()).filter(|&k| k != axis && machine.axes[k].kind == AxisKind::Linear);
            for slide in others {
                for moved in on_the_bar(&at, slide, bar_mm, |q| between(0, q)) {
                    let [stated_mm, turned_mm] = [0, 1].map(|model| between(model, &moved).norm());
                    let apart = (turned_mm - stated_mm).abs();
                    let is_better = best.as_ref().is_none_or(|best| apart > best.apart_mm() + 1e-6);
                    if inside(slide, moved[slide]) && apart > CLEAR_MM && is_better {
                        best = Some(SenseTest { test: index, positions: moved, stated_mm, turned_mm });
                    }
                }
            }
        }
    }
    best
}

/// Positions that differ in one slide alone and keep the balls at a distance: the gap is linear in the slide, so its
/// square is a parabola with two roots or none.
fn on_the_bar(at: &[f64], slide: usize, bar_mm: f64, gap: impl Fn(&[f64]) -> Vector3<f64>) -> Vec<Vec<f64>> {
    let moved = |by_mm: f64| {
        let mut q = at.to_vec();
        q[slide] += by_mm;
        q
    };
    let here = gap(at);
    let way = gap(&moved(1.0)) - here;
    let (square, half, rest) = (way.norm_squared(), here.dot(&way), here.norm_squared() - bar_mm * bar_mm);
    let inner = half * half - square * rest;
    // a slide that carries both balls or none changes nothing
    if square < 0.5 || inner < 0.0 {
        return Vec::new();
    }
    [1.0, -1.0].map(|sign| moved((sign * inner.sqrt() - half) / square)).to_vec()
}
