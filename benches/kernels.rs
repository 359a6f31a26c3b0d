//! Time of lengths and derivatives over many poses, one thread: `cargo bench --bench kernels`. Divide by the poses.

use std::path::Path;

use divan::{Bencher, black_box, counter::ItemsCount};
use fiveaxis::chain::{Chain, Column, Composition, Geometry, Poses, Sensitivity, sines_and_cosines};
use fiveaxis::load::machine_from_yaml;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const POSES: usize = 100_000;
const SWEEP: usize = 2_000;
const PIVOT: Vector3<f64> = Vector3::new(80.0, 60.0, 0.0);
const SPINDLE: Vector3<f64> = Vector3::new(3.0, -2.0, 120.0);

fn main() {
    divan::main();
}

fn chain() -> Chain {
    let yaml = "name: bench\ncode: '[wCAYbXZt]'\naxes: {}\n";
    let machine = machine_from_yaml(Path::new("bench.yaml"), yaml.into()).expect("the benchmark's own machine file");
    Chain::of(&machine)
}

/// All six location errors of all five axes, some 10 µm and 0.01° each.
fn errors() -> Vec<[f64; 6]> {
    (0..5)
        .map(|axis| {
            let sign = if axis % 2 == 0 { 1.0 } else { -1.0 };
            [0.010, -0.008, 0.005, 1.7e-4, -1.2e-4, 1.0e-4].map(|size| sign * size)
        })
        .collect()
}

/// Axis columns in the order C A Y X Z: random poses of the whole working space.
fn random_columns() -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut column = |from: f64, to: f64| (0..POSES).map(|_| rng.random_range(from..to)).collect::<Vec<f64>>();
    vec![
        column(0.0, std::f64::consts::TAU),
        column(-20f64.to_radians(), 70f64.to_radians()),
        column(-100.0, 100.0),
        column(-100.0, 100.0),
        column(-100.0, 100.0),
    ]
}

/// Location errors of both rotary axes that the thesis identifies, and the places of both balls.
fn fourteen_columns(chain: &Chain) -> Vec<Column> {
    let axis = |name: &str| (0..5).find(|&k| chain.link(name) == Some(chain.carried_by(k))).expect("an axis");
    let (a, c) = (axis("A"), axis("C"));
    let mut columns: Vec<Column> = [4, 5, 1, 2].map(|component| Column::Location { axis: a, component }).into();
    columns.extend([3, 4, 0, 1].map(|component| Column::Location { axis: c, component }));
    columns.extend((0..3).map(Column::Pivot));
    columns.extend((0..3).map(Column::Spindle));
    columns
}

#[divan::bench(sample_count = 200)]
fn lengths_of_100000_random_poses(bencher: Bencher) {
    let (chain, errors) = (chain(), errors());
    let poses = Poses::from_columns(random_columns());
    let ends = (chain.link("w").expect("w"), chain.link("t").expect("t"));
    let mut out = vec![0.0; POSES];
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        let geometry = Geometry::new(&chain, black_box(&errors), Composition::Exact);
        geometry.bar((ends.0, &PIVOT), (ends.1, &SPINDLE), &poses).lengths_into(black_box(&mut out));
    });
}

#[divan::bench(sample_count = 200)]
fn lengths_of_100000_random_poses_first_order(bencher: Bencher) {
    let (chain, errors) = (chain(), errors());
    let poses = Poses::from_columns(random_columns());
    let ends = (chain.link("w").expect("w"), chain.link("t").expect("t"));
    let mut out = vec![0.0; POSES];
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        let geometry = Geometry::new(&chain, black_box(&errors), Composition::FirstOrder);
        geometry.bar((ends.0, &PIVOT), (ends.1, &SPINDLE), &poses).lengths_into(black_box(&mut out));
    });
}

#[divan::bench(sample_count = 200)]
fn lengths_and_14_derivatives_of_100000_random_poses(bencher: Bencher) {
    let (chain, errors) = (chain(), errors());
    let poses = Poses::from_columns(random_columns());
    let ends = (chain.link("w").expect("w"), chain.link("t").expect("t"));
    let columns = fourteen_columns(&chain);
    let mut lengths = vec![0.0; POSES];
    let mut values = vec![0.0; POSES * columns.len()];
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        let geometry = Geometry::new(&chain, black_box(&errors), Composition::Exact);
        let bar = geometry.bar((ends.0, &PIVOT), (ends.1, &SPINDLE), &poses);
        bar.derivatives(&geometry, &columns).evaluate(0..POSES, black_box(&mut lengths), black_box(&mut values));
    });
}

/// The same, with the derivatives used block by block and never written to memory, as a fit uses them.
#[divan::bench(sample_count = 200)]
fn lengths_and_14_derivatives_in_blocks_of_256(bencher: Bencher) {
    let (chain, errors) = (chain(), errors());
    let poses = Poses::from_columns(random_columns());
    let ends = (chain.link("w").expect("w"), chain.link("t").expect("t"));
    let columns = fourteen_columns(&chain);
    let (mut lengths, mut values) = (vec![0.0; 256], vec![0.0; 256 * columns.len()]);
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        let geometry = Geometry::new(&chain, black_box(&errors), Composition::Exact);
        let bar = geometry.bar((ends.0, &PIVOT), (ends.1, &SPINDLE), &poses);
        let derivatives = bar.derivatives(&geometry, &columns);
        for start in (0..POSES).step_by(256) {
            let rows = start..(start + 256).min(POSES);
            derivatives.evaluate(rows, black_box(&mut lengths), black_box(&mut values));
        }
    });
}

#[divan::bench(sample_count = 1000)]
fn one_axis_sweep_of_2000_samples(bencher: Bencher) {
    let (chain, errors) = (chain(), errors());
    let mut columns = vec![vec![0.0; SWEEP]; 5];
    columns[0] = (0..SWEEP).map(|k| std::f64::consts::TAU * k as f64 / SWEEP as f64).collect();
    let poses = Poses::from_columns(columns);
    let ends = (chain.link("w").expect("w"), chain.link("t").expect("t"));
    let mut out = vec![0.0; SWEEP];
    bencher.counter(ItemsCount::new(SWEEP)).bench_local(|| {
        let geometry = Geometry::new(&chain, black_box(&errors), Composition::Exact);
        geometry.bar((ends.0, &PIVOT), (ends.1, &SPINDLE), &poses).lengths_into(black_box(&mut out));
    });
}

#[divan::bench(sample_count = 1000)]
fn sines_and_cosines_of_2000_angles(bencher: Bencher) {
    let angles: Vec<f64> = (0..SWEEP).map(|k| std::f64::consts::TAU * k as f64 / SWEEP as f64).collect();
    bencher.counter(ItemsCount::new(SWEEP)).bench_local(|| sines_and_cosines(black_box(&angles)));
}

/// The pose-by-pose functions, for comparison.
#[divan::bench(sample_count = 50)]
fn length_pose_by_pose_10000(bencher: Bencher) {
    let (chain, errors) = (chain(), errors());
    let geometry = Geometry::new(&chain, &errors, Composition::Exact);
    let columns = random_columns();
    let ends = (chain.link("w").expect("w"), chain.link("t").expect("t"));
    bencher.counter(ItemsCount::new(10_000usize)).bench_local(|| {
        (0..10_000)
            .map(|row| {
                let q: [f64; 5] = std::array::from_fn(|axis| columns[axis][row]);
                geometry.length((ends.0, &PIVOT), (ends.1, &SPINDLE), &q, None)
            })
            .sum::<f64>()
    });
}

#[divan::bench(sample_count = 50)]
fn all_derivatives_pose_by_pose_10000(bencher: Bencher) {
    let (chain, errors) = (chain(), errors());
    let geometry = Geometry::new(&chain, &errors, Composition::Exact);
    let columns = random_columns();
    let ends = (chain.link("w").expect("w"), chain.link("t").expect("t"));
    let mut s = Sensitivity::zeros(5);
    bencher.counter(ItemsCount::new(10_000usize)).bench_local(|| {
        // five columns are read together, so the row cannot be an iterator over one of them
        let row_of = |row: usize| -> [f64; 5] { std::array::from_fn(|axis| columns[axis][row]) };
        for q in (0..10_000).map(row_of) {
            geometry.sensitivity((ends.0, &PIVOT), (ends.1, &SPINDLE), &q, None, &mut s);
            black_box(&s);
        }
    });
}
