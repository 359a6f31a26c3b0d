//! Which readings belong to one pose, how far they count as one, and what of a residual they share. It fits no effects.

use crate::statistics::{NOISE_FLOOR_MM, NoiseModel, mean, median, rms};
use std::collections::HashMap;

use nalgebra::{DMatrix, DVector};

use crate::chain::Branch;
use crate::diagnose::model::linear_model::LinearModel;
use crate::machine::{Component, Outlet};
use crate::readings::NOISE_CLASSES;
use crate::session::Test;

/// Readings by the pose in which they were taken, over all tests.
pub struct Poses {
    /// Index of the pose, by test and row, in visiting order.
    pub of_row: Vec<Vec<usize>>,
    pub count: usize,
}

impl Poses {
    /// Rows of different tests with the same number and the same positions were read at one stop.
    pub fn of(model: &LinearModel) -> Poses {
        let mut known: HashMap<Vec<u64>, usize> = HashMap::new();
        let mut of_row = vec![Vec::new(); model.tests()];
        for &test in model.context.order() {
            let motion = model.context.motion(test);
            of_row[test] = (0..motion.rows())
                .map(|row| {
                    let number = model.context.pose_number(test, row);
                    let began = model.context.session().tests[test].started_at_s;
                    let key = [number, began].iter().chain(motion.row(row)).map(|value| value.to_bits()).collect();
                    let next = known.len();
                    *known.entry(key).or_insert(next)
                })
                .collect();
        }
        Poses { of_row, count: known.len() }
    }

    /// Kept rows of every pose as test and row.
    fn rows(&self, model: &LinearModel) -> Vec<Vec<(usize, usize)>> {
        let mut rows = vec![Vec::new(); self.count];
        for (test, poses) in self.of_row.iter().enumerate() {
            for (row, &pose) in poses.iter().enumerate().filter(|(row, _)| model.kept[test][*row]) {
                rows[pose].push((test, row));
            }
        }
        rows
    }
}

/// Number of readings that count as one, at least 1: variance of what a joint sees of the residual, with the readings
/// of a pose together, over what it would be if each had an error of its own; the mean over all joints.
///
/// Kinds of readings with different noise count each in units of its own.
pub fn readings_as_one(model: &LinearModel, poses: &Poses, residual_mm: &[Vec<f64>]) -> f64 {
    let rows = poses.rows(model);
    let scale = scales(model, residual_mm);
    let count = rows.iter().map(Vec::len).sum::<usize>().max(1) as f64;
    let residual = |test: usize, row: usize| residual_mm[test][row] / scale[test];
    let square = rows.iter().flatten().map(|&(test, row)| residual(test, row).powi(2)).sum::<f64>() / count;
    let machine = model.context.machine();
    let ratios: Vec<f64> = (0..machine.axes.len())
        .filter_map(|axis| {
            let outlet = Outlet::own(machine, axis);
            let gains = model.gains(&outlet);
            let gain = |test: usize, row: usize| gains[test].get(row).copied().unwrap_or(0.0) / scale[test];
            let (mut together, mut apart) = (0.0, 0.0);
            for rows in &rows {
                together += rows.iter().map(|&(test, row)| gain(test, row) * residual(test, row)).sum::<f64>().powi(2);
                apart += rows.iter().map(|&(test, row)| gain(test, row).powi(2)).sum::<f64>() * square;
            }
            (apart > 0.0).then_some(together / apart)
        })
        .collect();
    mean(ratios.into_iter()).map_or(1.0, |ratio| ratio.max(1.0))
}

/// Mean squares of the residual by noise class, mm², with the number of readings; zero where a class has none.
pub fn squares_by_class(model: &LinearModel, residual_mm: &[Vec<f64>]) -> [(f64, usize); NOISE_CLASSES] {
    let mut sums = [(0.0, 0usize); NOISE_CLASSES];
    for (test, residual) in residual_mm.iter().enumerate() {
        let own = &mut sums[model.context.session().tests[test].reading.noise_class()];
        for (value, _) in residual.iter().zip(&model.kept[test]).filter(|(_, kept)| **kept) {
            *own = (own.0 + value * value, own.1 + 1);
        }
    }
    sums.map(|(sum, count)| (sum / count.max(1) as f64, count))
}

/// White noise as loud as a residual, by noise class, of which so many readings count as one; noise that was stated stays.
pub(crate) fn white_by_class(model: &LinearModel, residual_mm: &[Vec<f64>], as_one: f64) -> Vec<NoiseModel> {
    let white = squares_by_class(model, residual_mm)
        .map(|(square, _)| NoiseModel::white((square * as_one).sqrt().max(NOISE_FLOOR_MM)));
    let of_test = |test: &Test| match test.reading.stated_noise_mm() {
        Some(noise_mm) => NoiseModel::white(noise_mm),
        None => white[test.reading.noise_class()],
    };
    model.context.session().tests.iter().map(of_test).collect()
}

/// By test, from 0: the group whose noise is one; tests of a class share theirs, and those whose noise was stated, which stays.
pub(crate) fn noise_groups(model: &LinearModel) -> Vec<usize> {
    let mut known: Vec<Option<usize>> = Vec::new();
    let of_test = |test: &Test| {
        let own = test.reading.stated_noise_mm().is_none().then(|| test.reading.noise_class());
        known.iter().position(|other| *other == own).unwrap_or_else(|| {
            known.push(own);
            known.len() - 1
        })
    };
    model.context.session().tests.iter().map(of_test).collect()
}

/// Size of a test's residual beside that of the first class that has readings.
fn scales(model: &LinearModel, residual_mm: &[Vec<f64>]) -> Vec<f64> {
    let squares = squares_by_class(model, residual_mm);
    let first = squares.iter().find(|(_, count)| *count > 0).map_or(1.0, |(square, _)| *square);
    let scale = |test: &Test| match squares[test.reading.noise_class()] {
        (square, count) if count > 0 && square > 0.0 && first > 0.0 => (square / first).sqrt(),
        _ => 1.0,
    };
    model.context.session().tests.iter().map(scale).collect()
}

/// What is left of the residual of static poses, by whether the readings of a pose share it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Left {
    /// Rms of what the readings of a pose share as one displacement of the last link: the arm stands elsewhere, µm.
    pub arm_um: f64,
    /// Rms of what every reading has for itself, noise among it, µm.
    pub readings_um: f64,
}

/// Displacements of the last link: three shifts and three turns.
const FREE_MOTIONS: usize = 6;
/// Poses with more readings than free motions that are needed.
const LEAST_POSES: usize = 10;
/// Singular values below this share of the largest are directions that the bars of a pose do not see.
const LEAST_SINGULAR_SHARE: f64 = 1e-6;
/// Turns count at this lever, rad per mm, so that shifts and turns are of like size.
const PER_LEVER: f64 = 1e-2;

impl Left {
    /// Splits residuals (mm); `None` where too few poses have more readings than their last link has free motions.
    pub fn of(model: &LinearModel, poses: &Poses, residual_mm: &[Vec<f64>]) -> Option<Left> {
        let last = *model.context.chain().branch(Branch::Tool).last()?;
        let outlets = Component::ALL.map(|component| Outlet::Motion { axis: last, component });
        let gains: Vec<_> = outlets.iter().map(|outlet| model.gains(outlet)).collect();
        let rows = poses.rows(model);
        let mut variances: Vec<f64> = Vec::new();
        for rows in rows.iter().filter(|rows| rows.len() > FREE_MOTIONS) {
            let free = DMatrix::from_fn(rows.len(), FREE_MOTIONS, |i, k| {
                let (test, row) = rows[i];
                let scale = if k < 3 { 1.0 } else { PER_LEVER };
                scale * gains[k][test].get(row).copied().unwrap_or(0.0)
            });
            let residual = DVector::from_iterator(rows.len(), rows.iter().map(|&(test, row)| residual_mm[test][row]));
            let svd = free.svd(true, false);
            let Some(seen) = svd.u else { continue };
            let largest = svd.singular_values.max();
            let rank = svd.singular_values.iter().filter(|value| **value > LEAST_SINGULAR_SHARE * largest).count();
            let spare = rows.len().saturating_sub(rank);
            if spare == 0 {
                continue;
            }
            let explained: f64 = (0..rank).map(|k| seen.column(k).dot(&residual).powi(2)).sum();
            let left = (residual.norm_squared() - explained).max(0.0);
            // Wilson and Hilferty: the median of χ² over its degrees of freedom n is (1 − 2/(9n))³
            let median = (1.0 - 2.0 / (9.0 * spare as f64)).powi(3);
            variances.push(left / spare as f64 / median);
        }
        if variances.len() < LEAST_POSES {
            return None;
        }
        // the median is not moved by a wild reading
        let apart = median(variances.into_iter())?;
        let all = rms(rows.iter().flatten().map(|&(test, row)| residual_mm[test][row])).powi(2);
        Some(Left { arm_um: 1e3 * (all - apart).max(0.0).sqrt(), readings_um: 1e3 * apart.sqrt() })
    }
}
