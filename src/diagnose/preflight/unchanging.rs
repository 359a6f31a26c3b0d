//! Tests in which hardly anything changes where balls and a machine in order let expect micrometres: an axis that did not turn, a bar out of its
//! cup, a centre that software took off. No fit shows it, for a machine without errors explains such readings best of all.
//! Machine and session may state what an earlier fit found, and then predict what changes: where the readings themselves change as they may,
//! nothing is doubted.
//!
//! With `D` the derivatives of a test's lengths by ball places and location errors, each times what it usually is and without its mean, and
//! `D = U S Wᵀ`, deviations `v` have `uⱼ·v` of standard deviation `Sⱼ`. The two largest tell how little would change by chance.

use nalgebra::{DMatrix, DVector};
use statrs::function::erf::erf;

use super::contradictions::is_read;
use super::data_fault::listed;
use crate::chain::Chain;
use crate::diagnose::model::decimate::few_rows;
use crate::identify::{Options, Problem, Quantity};
use crate::machine::AxisKind;
use crate::session::{Session, Setups};
use crate::statistics::median;
use crate::units::ARCSEC_PER_RAD;

/// Location errors of a machine in order, mm and rad: 10 µm and 10 arcsec.
const IN_ORDER_MM: f64 = 0.01;
const IN_ORDER_RAD: f64 = 10.0 / ARCSEC_PER_RAD;

/// Chance with which so little changes in any test of a sound session, from which the readings are doubted.
const BY_CHANCE: f64 = 1e-3;

/// The tests in which too little changes, in words with what to look for; `None` where every test shows what it may.
pub(crate) fn unchanging(session: &Session) -> Option<String> {
    let thinned = few_rows(session);
    let chain = Chain::of(&thinned.machine);
    let setups = Setups::of(&thinned);
    let unknowns = Options::default().unknowns(&thinned, &setups);
    let problem = Problem::new(&thinned, &chain, &setups, unknowns).ok()?;
    let usual = problem.unknowns.iter().map(|unknown| match unknown.quantity {
        Quantity::Location { component, .. } if component.is_angle() => unknown.prior_sigma.min(IN_ORDER_RAD),
        Quantity::Location { .. } => unknown.prior_sigma.min(IN_ORDER_MM),
        _ => unknown.prior_sigma,
    });
    let usual: Vec<f64> = usual.collect();
    let judged: Vec<(usize, f64, f64)> = (0..thinned.tests.len())
        .filter(|&test| is_turning(&problem, test))
        .filter_map(|test| {
            let (chance, due_mm) = chance_of_so_little(&problem, test, &usual)?;
            Some((test, chance, due_mm))
        })
        .collect();
    // all runs of a set-up show what changes in it: the middle one counts
    let is_of_one = |one: usize, other: usize| thinned.tests[one].is_repeat_of(&thinned.tests[other]);
    let of_set_up = |test: usize| {
        let runs = judged.iter().filter(move |(other, ..)| is_of_one(*other, test));
        median(runs.map(|(_, chance, _)| *chance)).unwrap_or(1.0)
    };
    let set_ups = (0..judged.len()).filter(|&k| !judged[..k].iter().any(|(other, ..)| is_of_one(*other, judged[k].0)));
    let set_ups = set_ups.count() as f64;
    let struck: Vec<&(usize, f64, f64)> =
        judged.iter().filter(|(test, ..)| of_set_up(*test) * set_ups < BY_CHANCE).collect();
    let due_um = 1e3 * struck.iter().map(|(.., due_mm)| *due_mm).reduce(f64::min)?;
    let names: Vec<String> = struck.iter().map(|(test, ..)| session.tests[*test].name.clone()).collect();
    Some(format!(
        "nothing but noise changes in {}, where balls placed as the session says and a machine in order let expect {due_um:.0} µm or more: look whether \
         the axis turned, whether the bar sat in both cups, and whether software took the centre off; until then no error is called determined",
        listed(&names)
    ))
}

/// Whether a rotary axis turns while a bar is read.
fn is_turning(problem: &Problem, test: usize) -> bool {
    let machine = &problem.session.machine;
    let moving = &problem.tests[test].motion.moving;
    problem.session.tests[test].bar_length_mm.is_some()
        && moving.iter().any(|&axis| machine.axes[axis].kind == AxisKind::Rotary)
}

/// Chance that no more changes in a test, and what is due, mm: the amplitude of what changes most.
fn chance_of_so_little(problem: &Problem, test: usize, usual: &[f64]) -> Option<(f64, f64)> {
    let prepared = &problem.tests[test];
    let means: Vec<f64> = problem.unknowns.iter().map(|unknown| unknown.prior_mean).collect();
    let prediction = problem.predict(test, &problem.geometry(&means), &means);
    let rows: Vec<usize> =
        (0..prediction.residual_mm.len()).filter(|&row| prediction.residual_mm[row].is_finite()).collect();
    let mut due = DMatrix::from_fn(rows.len(), prepared.columns.len(), |row, k| {
        prediction.jacobian[(rows[row], k)] * usual[prepared.columns[k]]
    });
    due.column_iter_mut().for_each(|mut column| {
        let mean = column.mean();
        column.add_scalar_mut(-mean);
    });
    let recorded = &problem.session.tests[test].recording.as_ref()?.length_mm;
    let left = DVector::from_iterator(rows.len(), rows.iter().map(|&row| prediction.residual_mm[row]));
    let read = DVector::from_iterator(rows.len(), rows.iter().map(|&row| recorded[row]));
    // computed lengths may be those of a machine without errors
    if !is_read(left.as_slice()) {
        return None;
    }
    let directions = due.tr_mul(&due).symmetric_eigen();
    let mut ways: Vec<(f64, DVector<f64>)> = directions
        .eigenvalues
        .iter()
        .zip(directions.eigenvectors.column_iter())
        .filter(|(square, _)| **square > 0.0)
        .map(|(square, direction)| (square.sqrt(), &due * direction / square.sqrt()))
        .collect();
    ways.sort_by(|a, b| b.0.total_cmp(&a.0));
    let [first, second] = ways.get(..2)? else { return None };
    let chance = |changed: &DVector<f64>| {
        let share = |(due, way): &(f64, DVector<f64>)| {
            erf(way.dot(changed).abs() / (due * std::f64::consts::SQRT_2)).max(f64::MIN_POSITIVE)
        };
        let both = share(first) * share(second);
        // the product of two numbers that lie evenly between 0 and 1
        both * (1.0 - both.ln())
    };
    Some((chance(&left).max(chance(&read)), first.0 * (2.0 / rows.len() as f64).sqrt()))
}
