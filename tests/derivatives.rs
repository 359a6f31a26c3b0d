//! Closed-form derivatives against differences, and algebraic laws, on random chains of one to eight joints.

use crate::finite_differences;
use finite_differences::Arguments;
use fiveaxis::chain::{Branch, Chain, Composition, Geometry, LinkId};
use fiveaxis::machine::{Axis, AxisKind, Directions, Machine, StructuralCode};
use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SEED: u64 = 7_340_033;

fn vector(random: &mut ChaCha8Rng, largest: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| random.random_range(-largest..largest))
}

/// A machine of `joints` joints on both sides of the bed, a third of its axes along coordinates, the others inclined.
fn random_machine(joints: usize, random: &mut ChaCha8Rng) -> Machine {
    let names: Vec<String> = (1..=joints).map(|k| format!("J{k}")).collect();
    let on_workpiece_side = random.random_range(0..=joints);
    let axes = names
        .iter()
        .map(|name| Axis {
            name: name.clone(),
            kind: if random.random_bool(0.6) { AxisKind::Rotary } else { AxisKind::Linear },
            direction: if random.random_bool(0.33) {
                Vector3::ith(random.random_range(0..3), if random.random_bool(0.5) { 1.0 } else { -1.0 })
            } else {
                vector(random, 1.0).normalize()
            },
            origin: vector(random, 300.0),
            range: None,
            reversed: random.random_bool(0.4),
            location_errors: [0.0; 6],
            component_errors: Vec::new(),
        })
        .collect();
    let (workpiece_side, tool_side) = names.split_at(on_workpiece_side);
    Machine {
        name: "random".into(),
        code: StructuralCode { workpiece_side: workpiece_side.to_vec(), tool_side: tool_side.to_vec() },
        directions: [None, Some(Directions::Carried), Some(Directions::Iso841)][random.random_range(0..3)],
        axes,
        gravity: -Vector3::z(),
        machine_zero: vec![None; joints],
        gauge_length_mm: None,
        spindle: None,
        link_names: Vec::new(),
        carried: Vec::new(),
        effects: Vec::new(),
        linear_axes: Default::default(),
        caveats: Vec::new(),
    }
}

/// Errors far above real ones, so that a wrong order or sign shows.
fn random_errors(joints: usize, random: &mut ChaCha8Rng) -> Vec<[f64; 6]> {
    let mut error = |k: usize| if k < 3 { random.random_range(-2.0..2.0) } else { random.random_range(-0.05..0.05) };
    (0..joints).map(|_| std::array::from_fn(&mut error)).collect()
}

fn random_positions(machine: &Machine, random: &mut ChaCha8Rng) -> Vec<f64> {
    let position = |axis: &Axis| match axis.kind {
        AxisKind::Linear => random.random_range(-200.0..200.0),
        AxisKind::Rotary => random.random_range(-3.0..3.0),
    };
    machine.axes.iter().map(position).collect()
}

/// Balls at least this far apart: nearer ones bend the length too much for the steps.
const LEAST_LENGTH_MM: f64 = 60.0;

fn random_arguments(machine: &Machine, chain: &Chain, links: (LinkId, LinkId), random: &mut ChaCha8Rng) -> Arguments {
    loop {
        let at = Arguments {
            errors: random_errors(machine.axes.len(), random),
            motion: random_errors(machine.axes.len(), random),
            positions: random_positions(machine, random),
            pivot: vector(random, 300.0),
            spindle: vector(random, 300.0),
        };
        if at.length(chain, links, Composition::Exact) > LEAST_LENGTH_MM {
            return at;
        }
    }
}

fn ends(chain: &Chain) -> (LinkId, LinkId) {
    (chain.end(Branch::Workpiece), chain.end(Branch::Tool))
}

#[test]
fn every_derivative_agrees_with_differences() {
    println!("seed {SEED}");
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let mut worst = 0.0f64;
    for joints in 1..=8 {
        for round in 0..12 {
            let machine = random_machine(joints, &mut random);
            let chain = Chain::of(&machine);
            // balls on inner links too, and both on one branch
            let links = match round % 3 {
                0 => ends(&chain),
                1 => (chain.carried_by(random.random_range(0..joints)), ends(&chain).1),
                _ => (chain.carried_by(random.random_range(0..joints)), LinkId::BED),
            };
            let at = random_arguments(&machine, &chain, links, &mut random);
            for composition in [Composition::Exact, Composition::FirstOrder] {
                let what = format!("{joints} joints, round {round}, {}", machine.code);
                worst = worst.max(finite_differences::check(&what, &chain, links, &at, composition));
            }
        }
    }
    println!("largest difference: {worst:.2} of its tolerance");
}

#[test]
fn exact_transforms_are_rigid() {
    println!("seed {SEED}");
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    for _ in 0..40 {
        let joints = random.random_range(1..=8);
        let machine = random_machine(joints, &mut random);
        let chain = Chain::of(&machine);
        let (errors, motion) = (random_errors(joints, &mut random), random_errors(joints, &mut random));
        let geometry = Geometry::new(&chain, &errors, Composition::Exact);
        let q = random_positions(&machine, &mut random);
        for (name, link) in chain.links() {
            let rotation = geometry.pose(link, &q, Some(&motion)).rotation;
            // the columns are differences of coordinates of some metres
            let scale = 4000.0;
            assert!((rotation.transpose() * rotation - Matrix3::identity()).norm() < 1e-12 * scale, "{name}");
            assert!((rotation.determinant() - 1.0).abs() < 1e-12 * scale, "{name}");
        }
    }
}

#[test]
fn squared_length_of_one_turning_axis_is_a_constant_a_cosine_and_a_sine() {
    println!("seed {SEED}");
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let mut turned = 0;
    for _ in 0..60 {
        let machine = random_machine(6, &mut random);
        let chain = Chain::of(&machine);
        let Some(axis) = machine.axes.iter().position(|axis| axis.kind == AxisKind::Rotary) else { continue };
        let mut at = random_arguments(&machine, &chain, ends(&chain), &mut random);
        const SAMPLES: usize = 12;
        let squared: Vec<f64> = (0..SAMPLES)
            .map(|k| {
                at.positions[axis] = std::f64::consts::TAU * k as f64 / SAMPLES as f64;
                at.length(&chain, ends(&chain), Composition::Exact).powi(2)
            })
            .collect();
        let scale = squared.iter().cloned().fold(0.0, f64::max);
        for harmonic in 2..=SAMPLES / 2 {
            let term = |wave: fn(f64) -> f64| -> f64 {
                let angle = |k: usize| std::f64::consts::TAU * (harmonic * k) as f64 / SAMPLES as f64;
                squared.iter().enumerate().map(|(k, value)| value * wave(angle(k))).sum::<f64>() / SAMPLES as f64
            };
            let amplitude = term(f64::cos).hypot(term(f64::sin));
            assert!(amplitude < 1e-12 * scale, "harmonic {harmonic}: {amplitude:e} of {scale:e}");
        }
        turned += 1;
    }
    assert!(turned > 50, "{turned} chains with a rotary axis");
}

#[test]
fn a_reversed_axis_is_the_same_axis_run_backwards() {
    println!("seed {SEED}");
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    for _ in 0..30 {
        let machine = random_machine(5, &mut random);
        let chain = Chain::of(&machine);
        let at = random_arguments(&machine, &chain, ends(&chain), &mut random);
        let mut reversed = machine.clone();
        reversed.axes[2].reversed = !reversed.axes[2].reversed;
        let mut backwards = at.clone();
        backwards.positions[2] = -backwards.positions[2];
        let other = Chain::of(&reversed);
        for composition in [Composition::Exact, Composition::FirstOrder] {
            let length = at.length(&chain, ends(&chain), composition);
            assert_eq!(backwards.length(&other, ends(&other), composition), length);
        }
    }
}

#[test]
fn iso841_is_the_carried_sense_with_the_workpiece_axes_run_backwards() {
    println!("seed {SEED}");
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    for _ in 0..60 {
        let mut carried = random_machine(5, &mut random);
        carried.directions = Some(Directions::Carried);
        let mut iso = carried.clone();
        iso.directions = Some(Directions::Iso841);
        let mut unstated = carried.clone();
        unstated.directions = None;
        let [chain, other, silent] = [&carried, &iso, &unstated].map(Chain::of);
        assert_eq!(silent, chain, "a file that states no sense reads as carried");
        let at = random_arguments(&carried, &chain, ends(&chain), &mut random);
        let mut turned = at.clone();
        turned.positions[..carried.code.workpiece_side.len()].iter_mut().for_each(|q| *q = -*q);
        for composition in [Composition::Exact, Composition::FirstOrder] {
            let length = at.length(&chain, ends(&chain), composition);
            assert_eq!(turned.length(&other, ends(&other), composition), length, "{}", carried.code);
        }
    }
}

/// Reflection in the y–z plane: points and displacements change the sign of x, turning vectors that of y and z.
#[test]
fn the_mirrored_machine_has_the_mirrored_lengths() {
    println!("seed {SEED}");
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let point = |v: &Vector3<f64>| Vector3::new(-v.x, v.y, v.z);
    let turning = |v: &Vector3<f64>| Vector3::new(v.x, -v.y, -v.z);
    let error = |e: &[f64; 6]| [-e[0], e[1], e[2], e[3], -e[4], -e[5]];
    for _ in 0..30 {
        let machine = random_machine(6, &mut random);
        let chain = Chain::of(&machine);
        let at = random_arguments(&machine, &chain, ends(&chain), &mut random);
        let mut mirrored = machine.clone();
        for axis in &mut mirrored.axes {
            axis.origin = point(&axis.origin);
            axis.direction = match axis.kind {
                AxisKind::Linear => point(&axis.direction),
                AxisKind::Rotary => turning(&axis.direction),
            };
        }
        let image = Arguments {
            errors: at.errors.iter().map(error).collect(),
            motion: at.motion.iter().map(error).collect(),
            positions: at.positions.clone(),
            pivot: point(&at.pivot),
            spindle: point(&at.spindle),
        };
        let other = Chain::of(&mirrored);
        for composition in [Composition::Exact, Composition::FirstOrder] {
            let (one, two) =
                (at.length(&chain, ends(&chain), composition), image.length(&other, ends(&other), composition));
            assert!((one - two).abs() < 1e-12 * 4000.0, "{one} against {two}");
        }
    }
}

#[test]
fn compositions_differ_by_the_square_of_the_errors() {
    println!("seed {SEED}");
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    for _ in 0..20 {
        let machine = random_machine(5, &mut random);
        let chain = Chain::of(&machine);
        let at = random_arguments(&machine, &chain, ends(&chain), &mut random);
        let gap = |share: f64| {
            let scaled = |list: &[[f64; 6]]| list.iter().map(|e| e.map(|part| part * share)).collect();
            let small = Arguments { errors: scaled(&at.errors), motion: scaled(&at.motion), ..at.clone() };
            let length = |composition| small.length(&chain, ends(&chain), composition);
            (length(Composition::Exact) - length(Composition::FirstOrder)).abs()
        };
        let (large, tenth) = (gap(1e-1), gap(1e-2));
        // a hundredth, and a tenth of it to spare for third-order terms and rounding
        assert!(tenth < 0.02 * large + 1e-10, "{large:e} shrinks to {tenth:e}");
    }
}
