//! Recordings in which less changes than balls placed to their spreads let expect: as if the axis stood, or the centre of the circle had been taken off.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::contradictions::is_read;
use super::data_fault::listed;
use super::places::exchanged::repeats;
use crate::chain::Chain;
use crate::diagnose::model::decimate::few_rows;
use crate::identify::{Options, Problem, Quantity, residual_mm};
use crate::session::{Session, Setups};

/// Chance of such a quiet set-up in a session, below which it is told: one sound session in five hundred is doubted.
const CHANCE: f64 = 0.002;

/// What balls move along the less visible of two directions, mm, below which a recording tells nothing of them.
const LEAST_MOVED_MM: f64 = 5e-4;

/// Tests of a set-up, with the chance that so little changes in them, by what, and by what it was to be expected, µm.
struct Quiet {
    tests: Vec<usize>,
    chance: f64,
    changes_um: f64,
    expected_um: f64,
}

/// Set-ups in whose readings nearly nothing changes with the position, in words.
///
/// The place of two balls is uncertain by their spreads, so the readings of a circle or arc change as `a cos q + b sin q` with `a`, `b` of
/// known variance. Both of them near to nothing is rare: in two dimensions the chance is `(a² + b²) / 2σ_a σ_b`.
pub(crate) fn quiet_setups(session: &Session) -> Option<String> {
    if session.has_parts() {
        return None;
    }
    let few = few_rows(session);
    let chain = Chain::of(&few.machine);
    let setups = Setups::of(&few);
    let problem = Problem::new(&few, &chain, &setups, Options::default().unknowns(&few, &setups)).ok()?;
    let means: Vec<f64> = problem.unknowns.iter().map(|unknown| unknown.prior_mean).collect();
    let nominal = residual_mm(&problem, &means);
    let is_place = |quantity| matches!(quantity, Quantity::Pivot { .. } | Quantity::SpindleBall { .. });
    let moved: Vec<Vec<Vec<f64>>> = problem
        .unknowns
        .iter()
        .enumerate()
        .filter(|(_, unknown)| is_place(unknown.quantity))
        .map(|(k, unknown)| {
            let mut values = means.clone();
            values[k] += unknown.prior_sigma;
            residual_mm(&problem, &values)
        })
        .collect();
    let quiet: Vec<Quiet> = (0..session.tests.len())
        .map(|test| (test, repeats(session, test)))
        .filter(|(test, tests)| tests.first() == Some(test))
        .filter_map(|(_, tests)| {
            let of_tests = tests.iter().map(|&test| {
                let columns = moved.iter().map(|moved| difference(&moved[test], &nominal[test])).collect::<Vec<_>>();
                quietness(&nominal[test], &columns)
            });
            // the loudest of them: all were recorded with the same balls
            let loudest = of_tests.collect::<Option<Vec<_>>>()?.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
            let (chance, changes_um, expected_um) = loudest;
            Some(Quiet { tests, chance, changes_um, expected_um })
        })
        .collect();
    let told: Vec<&Quiet> = quiet.iter().filter(|one| quiet.len() as f64 * one.chance < CHANCE).collect();
    let quietest = told.iter().min_by(|a, b| a.chance.total_cmp(&b.chance))?;
    let names: Vec<String> =
        told.iter().flat_map(|one| &one.tests).map(|&test| session.tests[test].name.clone()).collect();
    Some(format!(
        "readings of {} hardly change with the position, by {:.2} µm where the spreads of the balls let expect {:.0} µm: look whether the axis \
         moved (clamped, or tool centre point control on) and whether the centre of the circle was taken off",
        listed(&names),
        quietest.changes_um,
        quietest.expected_um
    ))
}

fn difference(one: &[f64], other: &[f64]) -> Vec<f64> {
    one.iter().zip(other).map(|(one, other)| one - other).collect()
}

/// Chance that so little changes in a recording, by what it changes along the two directions that balls move most, and by what they
/// move it, µm rms; `None` where they hardly do or nothing was read.
fn quietness(readings_mm: &[f64], columns: &[Vec<f64>]) -> Option<(f64, f64, f64)> {
    let rows: Vec<usize> = (0..readings_mm.len()).filter(|&row| readings_mm[row].is_finite()).collect();
    let count = rows.len() as f64;
    let centred = |values: &[f64]| {
        let some = DVector::from_iterator(rows.len(), rows.iter().map(|&row| values[row]));
        let mean = some.mean();
        some.add_scalar(-mean)
    };
    let readings = centred(readings_mm);
    if !is_read(readings.as_slice()) {
        return None;
    }
    let moved = DMatrix::from_columns(&columns.iter().map(|column| centred(column)).collect::<Vec<_>>());
    let eigen = SymmetricEigen::new(moved.tr_mul(&moved) / count);
    let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let [first, second] = order.get(..2)? else { return None };
    let variances = [*first, *second].map(|k| eigen.eigenvalues[k].max(0.0));
    if variances[1].sqrt() < LEAST_MOVED_MM {
        return None;
    }
    let square = |k: usize| {
        let along = (&moved * eigen.eigenvectors.column(k)).normalize();
        along.dot(&readings).powi(2) / count
    };
    let changes = square(*first) + square(*second);
    let chance = changes / (2.0 * (variances[0] * variances[1]).sqrt());
    Some((chance, 1e3 * changes.sqrt(), 1e3 * (variances[0] + variances[1]).sqrt()))
}
