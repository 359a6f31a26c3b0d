//! Minimum distance, "closer than 5 mm" and certified sweeps on a scene of 12 bodies and 5 bar parts, one thread.

mod peer_scene;

use divan::counter::ItemsCount;
use fiveaxis::chain::Chain;
use fiveaxis::collision::{Scratch, World, certify};
use nalgebra::Vector3;
use peer_scene::{ScenePose, bodies, machine, poses, scene, set_pivot};

fn main() {
    divan::main();
}

const POSES: usize = 10_000;

fn setting() -> (World, Vec<ScenePose>) {
    let machine = machine();
    let mut world = World::new(&Chain::of(&machine), &bodies()).expect("links");
    world.forget_machine_pairs();
    (world, poses(POSES))
}

#[divan::bench(sample_count = 9)]
fn minimum_distance_10000_poses(bencher: divan::Bencher) {
    let (world, poses) = setting();
    let mut scene = scene(&world, Vector3::zeros());
    assert_eq!(scene.pairs().len(), 58);
    let mut scratch = Scratch::default();
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        let mut sum = 0.0;
        for (pivot, q) in &poses {
            set_pivot(&mut scene, pivot);
            sum += scene.least(q, &mut scratch).0;
        }
        sum
    });
}

#[divan::bench(sample_count = 9)]
fn closer_than_5_mm_10000_poses(bencher: divan::Bencher) {
    let (world, poses) = setting();
    let mut scene = scene(&world, Vector3::zeros());
    let mut scratch = Scratch::default();
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        let mut close = 0;
        for (pivot, q) in &poses {
            set_pivot(&mut scene, pivot);
            close += usize::from(scene.closer_than(q, 5.0, &mut scratch));
        }
        close
    });
}

/// Sweeps of A over 40 degrees and of C over 180 that are certified at 5 mm; a counted item is one of the 58 pairs of one sweep.
#[divan::bench(sample_count = 9)]
fn certified_sweep_of_a_pair(bencher: divan::Bencher) {
    let (world, poses) = setting();
    let mut scene = scene(&world, Vector3::zeros());
    let mut scratch = Scratch::default();
    let mut sweeps = Vec::new();
    for (pivot, q) in &poses[..2_000] {
        set_pivot(&mut scene, pivot);
        for (axis, turn_deg) in [(0, 180f64), (1, 40.0)] {
            let mut end = q.clone();
            end[axis] += turn_deg.to_radians();
            let rows = vec![q.clone(), end];
            if certify(&scene, &rows, 5.0, &mut scratch).is_ok() {
                sweeps.push((*pivot, rows));
            }
        }
    }
    assert!(sweeps.len() >= 100);
    bencher.counter(ItemsCount::new(58 * sweeps.len())).bench_local(|| {
        let mut evaluations = 0;
        for (pivot, rows) in &sweeps {
            set_pivot(&mut scene, pivot);
            evaluations += certify(&scene, rows, 5.0, &mut scratch).map_or(0, |clear| clear.evaluations);
        }
        evaluations
    });
}
