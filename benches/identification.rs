//! Time of white-noise fits of the thesis's four tests with 2000 samples each, one thread:
//! `cargo bench --bench identification`. Poses, sines and the basis of the compression are prepared beforehand, as the
//! positions of a test plan are known before its readings; `from_raw_rows` prepares them too.

#[path = "../tests/four_tests/mod.rs"]
mod four_tests;

use divan::{Bencher, black_box};
use fiveaxis::identify::{Evidence, Problem, SweepBasis, Unknown, fit_white};
use four_tests::*;

const SAMPLES: usize = 2000;

fn main() {
    divan::main();
}

struct Workload {
    prepared: Prepared,
    unknowns: Vec<Unknown>,
}

fn workload(unknowns: fn(&fiveaxis::session::Session) -> Vec<Unknown>) -> Workload {
    let prepared = Prepared::of(&thesis_sweeps(), SAMPLES);
    let unknowns = unknowns(&prepared.session);
    Workload { prepared, unknowns }
}

fn by_sample(bencher: Bencher, unknowns: fn(&fiveaxis::session::Session) -> Vec<Unknown>) {
    let workload = workload(unknowns);
    let problem = workload.prepared.problem(workload.unknowns.clone());
    let evidence = samples(&problem, &noisy_readings(&problem, 3));
    bencher.bench_local(|| fit_white(&problem, black_box(&evidence), &[NOISE_MM; 4]).expect("a fit"));
}

/// Compression of new readings and the fit, on bases made beforehand.
fn by_sweep(bencher: Bencher, unknowns: fn(&fiveaxis::session::Session) -> Vec<Unknown>) {
    let workload = workload(unknowns);
    let problem = workload.prepared.problem(workload.unknowns.clone());
    let readings = noisy_readings(&problem, 3);
    let mut evidence = compressed(&problem, &samples(&problem, &readings));
    bencher.bench_local(|| {
        for (evidence, readings) in evidence.iter_mut().zip(&readings) {
            if let Evidence::Sweep { basis, statistics } = evidence {
                *statistics = basis.compress(black_box(readings));
            }
        }
        fit_white(&problem, &evidence, &[NOISE_MM; 4]).expect("a fit")
    });
}

#[divan::bench(sample_count = 500)]
fn unknowns_12_sample_by_sample(bencher: Bencher) {
    by_sample(bencher, unknowns_without_priors);
}

#[divan::bench(sample_count = 500)]
fn unknowns_32_with_priors_sample_by_sample(bencher: Bencher) {
    by_sample(bencher, unknowns_with_priors);
}

#[divan::bench(sample_count = 2000)]
fn unknowns_12_compressed(bencher: Bencher) {
    by_sweep(bencher, unknowns_without_priors);
}

#[divan::bench(sample_count = 2000)]
fn unknowns_32_with_priors_compressed(bencher: Bencher) {
    by_sweep(bencher, unknowns_with_priors);
}

/// Sines, bases, compression and fit from rows of positions and readings.
#[divan::bench(sample_count = 500)]
fn unknowns_12_compressed_from_raw_rows(bencher: Bencher) {
    let workload = workload(unknowns_without_priors);
    let problem = workload.prepared.problem(workload.unknowns.clone());
    let start = vec![0.0; problem.unknowns.len()];
    bencher.bench_local(|| {
        let prepare = |test| Evidence::samples(black_box(&problem), test, &[]).compressed(&problem, test, &start);
        let evidence: Vec<Evidence> = (0..4).map(prepare).collect();
        fit_white(&problem, &evidence, &[NOISE_MM; 4]).expect("a fit")
    });
}

/// Compression alone: 4 × 2000 readings to 4 × 2·K + 1 numbers.
#[divan::bench(sample_count = 2000)]
fn compression_alone(bencher: Bencher) {
    let workload = workload(unknowns_without_priors);
    let problem: Problem = workload.prepared.problem(workload.unknowns.clone());
    let readings = noisy_readings(&problem, 3);
    let evidence = compressed(&problem, &samples(&problem, &readings));
    let bases: Vec<&SweepBasis> = evidence
        .iter()
        .filter_map(|evidence| match evidence {
            Evidence::Sweep { basis, .. } => Some(basis),
            Evidence::Samples { .. } => None,
        })
        .collect();
    bencher.bench_local(|| {
        for (basis, readings) in bases.iter().zip(&readings) {
            black_box(basis.compress(black_box(readings)));
        }
    });
}
