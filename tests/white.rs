//! White-noise fits: against the general fit, recovery without noise, and compressed sweeps against their samples.

use crate::four_tests;
use fiveaxis::chain::Composition;
use fiveaxis::identify::{Evidence, FitError, Problem, Weighting, WhiteFit, fit_white, minimise};
use fiveaxis::statistics::NoiseModel;
use four_tests::*;

/// Largest difference of two fits in sigmas of the first.
fn difference_in_sigmas(one: &WhiteFit, values: &[f64]) -> f64 {
    let covariance = one.covariance().unwrap();
    (0..values.len()).map(|k| (one.values[k] - values[k]).abs() / covariance[(k, k)].sqrt()).fold(0.0, f64::max)
}

fn is_compressed(evidence: &[Evidence]) -> bool {
    evidence.iter().all(|evidence| matches!(evidence, Evidence::Sweep { .. }))
}

/// Tests whose lengths vary by tens of mm, and sweeps of linear axes.
fn uneven_sweeps() -> Vec<Sweep> {
    let mut sweeps = thesis_sweeps();
    sweeps.push(Sweep { axis: "C", from: 0.3, to: 4.0, pivot: [80.0, 20.0, 10.0], spindle: [-30.0, 25.0, 90.0] });
    sweeps.push(Sweep { axis: "A", from: -0.5, to: 1.0, pivot: [40.0, 90.0, -20.0], spindle: [-60.0, 30.0, 40.0] });
    sweeps.push(Sweep { axis: "X", from: -40.0, to: 30.0, pivot: [0.0, 90.0, 0.0], spindle: [5.0, 0.0, 100.0] });
    sweeps.push(Sweep { axis: "Y", from: -20.0, to: 45.0, pivot: [60.0, 90.0, 0.0], spindle: [5.0, 0.0, 80.0] });
    sweeps
}

#[test]
fn without_noise_the_inserted_errors_come_back() {
    let prepared = Prepared::of(&thesis_sweeps(), 500);
    let problem = prepared.problem(unknowns_without_priors(&prepared.session));
    let readings: Vec<Vec<f64>> = problem.tests.iter().map(|test| test.reading_mm.clone()).collect();
    let samples = samples(&problem, &readings);
    for evidence in [compressed(&problem, &samples), samples] {
        let fit = fit_white(&problem, &evidence, &[NOISE_MM; 4]).unwrap();
        for (value, (axis, component, truth)) in fit.values.iter().zip(LOCATION_ERRORS) {
            // 1e-9 mm at a lever of 100 mm
            let allowed = if component.index() < 3 { 1e-9 } else { 1e-11 };
            assert!((value - truth).abs() < allowed, "{component:?}0{axis}: {value} for {truth}");
        }
        for (test, bar) in fit.values[8..].iter().enumerate() {
            assert!((bar - true_bar(&prepared.session, test)).abs() < 1e-9, "{bar}");
        }
    }
}

#[test]
fn the_general_fit_with_white_noise_gives_the_same() {
    let prepared = Prepared::of(&uneven_sweeps(), 150);
    let mut problem = prepared.problem(unknowns_with_priors(&prepared.session));
    // the general fit wants every prior finite
    problem.unknowns.iter_mut().for_each(|unknown| unknown.prior_sigma = unknown.prior_sigma.min(1.0));
    let readings = noisy_readings(&problem, 11);
    for (test, reading) in problem.tests.iter_mut().zip(&readings) {
        test.reading_mm = reading.clone();
    }
    let tests = readings.len();
    let white = fit_white(&problem, &samples(&problem, &readings), &vec![NOISE_MM; tests]).unwrap();
    let start = vec![0.0; problem.unknowns.len()];
    let kept = vec![vec![true; 150]; tests];
    let weighting = Weighting::Whitened { noise: &vec![NoiseModel::white(NOISE_MM); tests], kept: &kept };
    let general = minimise(&problem, &start, &weighting);
    let difference = difference_in_sigmas(&white, &general.values);
    println!("largest difference {difference:.1e} sigma after {} evaluations", white.evaluations);
    // the general fit stops at a thousandth of a sigma
    assert!(general.converged && difference < 1e-3, "{difference}");
}

/// Compressed and sample-by-sample fits of several seeds: values, covariance and cost.
fn compressed_agrees(problem: &Problem, seeds: std::ops::Range<u64>) -> f64 {
    let noise = vec![NOISE_MM; problem.tests.len()];
    let mut worst = 0.0f64;
    for seed in seeds {
        let samples = samples(problem, &noisy_readings(problem, seed));
        let compressed = compressed(problem, &samples);
        assert!(is_compressed(&compressed));
        let by_sample = fit_white(problem, &samples, &noise).unwrap();
        let by_sweep = fit_white(problem, &compressed, &noise).unwrap();
        worst = worst.max(difference_in_sigmas(&by_sample, &by_sweep.values));
        let information = (&by_sample.information - &by_sweep.information).norm() / by_sample.information.norm();
        assert!(information < 1e-9, "information differs by {information:e}");
        let cost = (by_sample.cost - by_sweep.cost).abs() / by_sample.cost;
        assert!(cost < 1e-6, "{} and {}", by_sample.cost, by_sweep.cost);
    }
    worst
}

#[test]
fn compressed_sweeps_lose_nothing() {
    let thesis = Prepared::of(&thesis_sweeps(), 400);
    let uneven = Prepared::of(&uneven_sweeps(), 300);
    for (prepared, name) in [(&thesis, "thesis"), (&uneven, "uneven")] {
        for unknowns in [unknowns_without_priors(&prepared.session), unknowns_with_priors(&prepared.session)] {
            for composition in [Composition::Exact, Composition::FirstOrder] {
                let mut problem = prepared.problem(unknowns.clone());
                problem.composition = composition;
                let worst = compressed_agrees(&problem, 0..5);
                println!("{name}, {} unknowns, {composition:?}: {worst:.1e} sigma", unknowns.len());
                // a hundredth of a sigma would already be harmless; both fits stop at 1e-5
                assert!(worst < 1e-4, "{name} {worst:e}");
            }
        }
    }
}

#[test]
fn what_nothing_determines_is_named() {
    let prepared = Prepared::of(&thesis_sweeps()[..2], 100);
    let problem = prepared.problem(unknowns_without_priors(&prepared.session));
    let readings = noisy_readings(&problem, 1);
    match fit_white(&problem, &samples(&problem, &readings), &[NOISE_MM; 2]) {
        Err(FitError::Undetermined { unknown }) => println!("{unknown}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn missing_readings_are_left_out() {
    let prepared = Prepared::of(&thesis_sweeps(), 200);
    let mut problem = prepared.problem(unknowns_without_priors(&prepared.session));
    for test in &mut problem.tests {
        test.reading_mm[7] = f64::NAN;
        test.reading_mm[120] = 1e3;
    }
    let kept: Vec<bool> = (0..200).map(|row| row != 120).collect();
    let evidence: Vec<Evidence> = (0..4).map(|test| Evidence::samples(&problem, test, &kept)).collect();
    for evidence in [compressed(&problem, &evidence), evidence] {
        let fit = fit_white(&problem, &evidence, &[NOISE_MM; 4]).unwrap();
        assert!((fit.values[2] - LOCATION_ERRORS[2].2).abs() < 1e-9, "{}", fit.values[2]);
    }
}
