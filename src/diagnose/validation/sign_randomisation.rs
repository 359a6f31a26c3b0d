//! What a finding driven by motion would gain if the sense of motion were drawn at random: hardly anything, or it is chance.

use crate::statistics::{NoiseModel, mean};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::diagnose::findings::finding::Finding;
use crate::diagnose::model::linear_model::{Column, LinearModel};
use crate::diagnose::model::regression::{Accepted, Regression};
use crate::diagnose::noise::pose_noise::Poses;
use crate::effects::Driver;

/// Gain of a finding with the true sense of motion and with random ones, as falls of the weighted sum of squares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignRandomisation {
    pub gain: f64,
    /// Mean and largest over the draws.
    pub mean: f64,
    pub largest: f64,
    /// Runs in one direction, or poses, whose signs were drawn.
    pub runs: usize,
    pub draws: usize,
}

/// Draws of all signs.
const DRAWS: u64 = 20;
/// Runs below which random signs come too near to the true ones, or to all of them turned.
const LEAST_RUNS: usize = 8;
/// The same draws every time.
const SEED: u64 = 0x0091_ACEB;
/// Steps below this are rounding of the file, mm or rad.
const STANDSTILL: f64 = 1e-7;

/// Placebos by finding; `None` where motion does not drive it or too few runs show it.
///
/// With everything else in the fit, the columns of a finding are judged as they are and with the sign of every run of
/// a sweep, or of every pose of an arm, drawn anew. An effect that follows the direction or speed of motion keeps
/// about one over the number of runs of its gain.
pub fn placebos(
    model: &LinearModel,
    findings: &[Finding],
    columns: &[Accepted],
    noise: &[NoiseModel],
) -> Vec<Option<SignRandomisation>> {
    findings.iter().map(|finding| placebo(model, finding, columns, noise)).collect()
}

fn placebo(
    model: &LinearModel,
    finding: &Finding,
    columns: &[Accepted],
    noise: &[NoiseModel],
) -> Option<SignRandomisation> {
    if !matches!(finding.cause.driver, Driver::Direction | Driver::Speed) {
        return None;
    }
    let (own, others): (Vec<usize>, Vec<usize>) = (0..columns.len()).partition(|index| finding.columns.contains(index));
    let own: Vec<&Column> = own.iter().map(|&index| &columns[index].column).collect();
    let others: Vec<Accepted> = others.iter().map(|&index| columns[index].clone()).collect();
    let run_of_row = if model.has_sweeps() { runs(model, driving_axis(model, finding)) } else { poses(model) };
    let runs = shown_runs(model, &own, &run_of_row);
    if runs < LEAST_RUNS {
        return None;
    }
    let regression = Regression::new(model, noise, &others, &model.kept);
    let gain = |signs: Option<&[f64]>| {
        let columns: Vec<Column> = own.iter().map(|column| with_signs(column, &run_of_row, signs)).collect();
        regression.judge(&columns, f64::INFINITY).chi2
    };
    let count = run_of_row.iter().flatten().max().map_or(0, |last| last + 1);
    let drawn: Vec<f64> = (0..DRAWS)
        .into_par_iter()
        .map(|draw| {
            let mut random = ChaCha8Rng::seed_from_u64(SEED + draw);
            let signs: Vec<f64> = (0..count).map(|_| if random.random_bool(0.5) { 1.0 } else { -1.0 }).collect();
            gain(Some(&signs))
        })
        .collect();
    Some(SignRandomisation {
        gain: gain(None),
        mean: mean(drawn.iter().copied()).unwrap_or(f64::NAN),
        largest: drawn.iter().copied().fold(0.0, f64::max),
        runs,
        draws: drawn.len(),
    })
}

/// The axis whose motion drives a finding: the one that its effect names, else the one where it sits.
fn driving_axis(model: &LinearModel, finding: &Finding) -> Option<usize> {
    use crate::machine::ParameterValue;
    let effect = finding.effects.first()?;
    match effect.parameter("of") {
        Some(ParameterValue::Word(name)) => model.context.machine().axis_index(name),
        _ => effect.place.axis(),
    }
}

/// The pose of every row: its readings were taken after the same move.
fn poses(model: &LinearModel) -> Vec<Vec<usize>> {
    Poses::of(model).of_row
}

/// The run of every row, numbered through all tests by time: a new one with every test and every reversal of the axis.
fn runs(model: &LinearModel, axis: Option<usize>) -> Vec<Vec<usize>> {
    let mut next = 0;
    let mut run_of_row = vec![Vec::new(); model.tests()];
    for &test in model.context.order() {
        let positions: Vec<f64> = axis.map_or(Vec::new(), |axis| model.context.motion(test).axis(axis).collect());
        let mut sense = 0.0;
        let mut last = None;
        let of_row = |row: usize| {
            if let (Some(&here), Some(before)) = (positions.get(row), last) {
                let step: f64 = here - before;
                if step.abs() > STANDSTILL {
                    next += usize::from(sense * step < 0.0);
                    sense = step.signum();
                }
            }
            last = positions.get(row).copied();
            next
        };
        run_of_row[test] = (0..model.residual_mm[test].len()).map(of_row).collect();
        next = run_of_row[test].last().map_or(next, |last| last + 1);
    }
    run_of_row
}

/// Number of runs in which any of the columns is not zero.
fn shown_runs(model: &LinearModel, columns: &[&Column], run_of_row: &[Vec<usize>]) -> usize {
    let mut shown = std::collections::BTreeSet::new();
    for column in columns {
        for (test, values) in column.by_test.iter().enumerate() {
            let rows = values.iter().enumerate().filter(|(row, value)| **value != 0.0 && model.kept[test][*row]);
            shown.extend(rows.map(|(row, _)| run_of_row[test][row]));
        }
    }
    shown.len()
}

/// A column with the sign of every run replaced.
fn with_signs(column: &Column, run_of_row: &[Vec<usize>], signs: Option<&[f64]>) -> Column {
    let Some(signs) = signs else { return column.clone() };
    let by_test = column.by_test.iter().zip(run_of_row);
    let signed = |(values, runs): (&Vec<f64>, &Vec<usize>)| -> Vec<f64> {
        values.iter().zip(runs).map(|(value, &run)| value * signs[run]).collect()
    };
    Column::new(by_test.map(signed).collect())
}
