//! Batch kernels against the single-pose kinematics, which agree with values computed elsewhere: random chains.

use crate::shared_data;
use std::fmt::Write;
use std::path::Path;

use fiveaxis::chain::{Branch, Chain, Column, Composition, Geometry, LinkId, Poses, Sensitivity, sines_and_cosines};
use fiveaxis::load::machine_from_yaml;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SEED: u64 = 20_240_611;

/// Algebraic identity: rounding of lengths of a few hundred mm with levers as long.
const RELATIVE: f64 = 1e-12;

/// A machine with `joints` joints of random kind, direction, origin and sense, the bed at a random place.
fn random_chain(rng: &mut ChaCha8Rng, joints: usize) -> Chain {
    let bed = rng.random_range(0..=joints);
    let mut names: Vec<String> = (0..joints).map(|k| format!("J{k}")).collect();
    let mut yaml = String::from("name: random\n");
    let mut axes = String::from("axes:\n");
    for name in &names {
        let kind = if rng.random_bool(0.6) { "rotary" } else { "linear" };
        let direction = if rng.random_bool(0.5) {
            let mut unit = [0.0; 3];
            unit[rng.random_range(0..3usize)] = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
            Vector3::from(unit)
        } else {
            Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0f64)).normalize()
        };
        let origin = Vector3::from_fn(|_, _| rng.random_range(-200.0..200.0f64));
        let origin = if kind == "rotary" {
            format!(", origin: [{}, {}, {}]", origin.x, origin.y, origin.z)
        } else {
            String::new()
        };
        let reversed = rng.random_bool(0.3);
        writeln!(
            axes,
            "  {name}: {{type: {kind}, direction: [{}, {}, {}]{origin}, reversed: {reversed}, range: [-100000, 100000]}}",
            direction.x, direction.y, direction.z
        )
        .unwrap();
    }
    names.insert(bed, "b".into());
    writeln!(yaml, "chain: [w, {}, t]", names.join(", ")).unwrap();
    yaml.push_str(&axes);
    let machine = machine_from_yaml(Path::new("random.yaml"), yaml).unwrap();
    Chain::of(&machine)
}

fn random_link(rng: &mut ChaCha8Rng, chain: &Chain) -> LinkId {
    let branch = if rng.random_bool(0.5) { Branch::Workpiece } else { Branch::Tool };
    LinkId { branch, depth: rng.random_range(0..=chain.branch(branch).len()) }
}

fn random_errors(rng: &mut ChaCha8Rng, axes: usize) -> Vec<[f64; 6]> {
    let size = [1e-3, 0.1, 1.0][rng.random_range(0..3usize)];
    (0..axes)
        .map(|_| [0, 1, 2, 3, 4, 5].map(|k| size * rng.random_range(-1.0..1.0) * if k < 3 { 1.0 } else { 0.05 }))
        .collect()
}

/// Rows of positions in which each axis stands still with probability one third.
fn random_rows(rng: &mut ChaCha8Rng, axes: usize, rows: usize) -> Vec<f64> {
    let standing: Vec<Option<f64>> =
        (0..axes).map(|_| rng.random_bool(1.0 / 3.0).then(|| rng.random_range(-3.0..3.0))).collect();
    (0..rows * axes).map(|k| standing[k % axes].unwrap_or_else(|| rng.random_range(-6.0..6.0))).collect()
}

fn all_columns(axes: usize) -> Vec<Column> {
    let mut columns: Vec<Column> =
        (0..3).flat_map(|k| [Column::Pivot(k), Column::Spindle(k), Column::SpindleReversed(k)]).collect();
    for axis in 0..axes {
        columns.push(Column::Position { axis });
        for component in 0..6 {
            columns.push(Column::Location { axis, component });
            columns.push(Column::Motion { axis, component });
        }
    }
    columns
}

fn from_sensitivity(s: &Sensitivity, column: Column) -> f64 {
    match column {
        Column::Location { axis, component } => s.location[axis][component],
        Column::Motion { axis, component } => s.motion[axis][component],
        Column::Position { axis } => s.position[axis],
        Column::Pivot(k) => s.pivot[k],
        Column::Spindle(k) => s.spindle[k],
        Column::SpindleReversed(k) => -s.spindle[k],
    }
}

#[test]
fn random_chains_agree_with_the_single_pose_kinematics() {
    println!("seed {SEED}");
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let (mut worst_length, mut worst_column) = (0.0f64, 0.0f64);
    for trial in 0..400 {
        let joints = 1 + trial % 8;
        let chain = random_chain(&mut rng, joints);
        let errors = random_errors(&mut rng, joints);
        let composition = [Composition::Exact, Composition::FirstOrder][trial / 8 % 2];
        let geometry = Geometry::new(&chain, &errors, composition);
        let links = (random_link(&mut rng, &chain), random_link(&mut rng, &chain));
        let mut place = || Vector3::from_fn(|_, _| rng.random_range(-150.0..150.0));
        let (pivot, spindle) = (place(), place());
        // row counts that end inside a register and inside a group
        let rows = rng.random_range(1..45usize);
        let positions = random_rows(&mut rng, joints, rows);
        let mut poses = Poses::from_rows(joints, &positions);
        if rng.random_bool(0.5) {
            poses = poses.with_sines(&chain);
        }
        let bar = geometry.bar((links.0, &pivot), (links.1, &spindle), &poses);
        let columns = all_columns(joints);
        let derivatives = bar.derivatives(&geometry, &columns);
        let start = rng.random_range(0..rows);
        let mut lengths = vec![f64::NAN; rows - start];
        let mut values = vec![f64::NAN; columns.len() * lengths.len()];
        derivatives.evaluate(start..rows, &mut lengths, &mut values);
        let all_lengths = bar.lengths();
        let mut s = Sensitivity::zeros(joints);
        for row in 0..rows {
            let q = &positions[row * joints..(row + 1) * joints];
            geometry.sensitivity((links.0, &pivot), (links.1, &spindle), q, None, &mut s);
            let scale = 300.0 * joints as f64;
            worst_length = worst_length.max((all_lengths[row] - s.length_mm).abs() / scale);
            let Some(here) = row.checked_sub(start) else { continue };
            worst_length = worst_length.max((lengths[here] - s.length_mm).abs() / scale);
            for (k, &column) in columns.iter().enumerate() {
                let found = values[k * lengths.len() + here];
                let wanted = from_sensitivity(&s, column);
                // a short bar amplifies rounding of its direction
                let allowed = scale * (1.0 + scale / s.length_mm);
                let difference = (found - wanted).abs() / allowed;
                assert!(difference < RELATIVE, "trial {trial} row {row} {column:?}: {found} for {wanted}");
                worst_column = worst_column.max(difference);
            }
        }
    }
    println!("worst relative difference: lengths {worst_length:.1e}, derivatives {worst_column:.1e}");
    assert!(worst_length < RELATIVE);
}

#[test]
fn sines_and_cosines_agree_with_the_standard_library() {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut angles: Vec<f64> = (0..200_001).map(|_| rng.random_range(-100.0..100.0)).collect();
    angles.extend((-200..200).map(|k| f64::from(k) * std::f64::consts::FRAC_PI_4));
    angles.extend([0.0, -0.0, 1e-300, 1e-9, std::f64::consts::FRAC_PI_4, f64::NAN, f64::INFINITY]);
    angles.extend((0..10_000).map(|_| rng.random_range(-1e6..1e6)));
    let (sine, cosine) = sines_and_cosines(&angles);
    let (mut worst_small, mut worst_large) = (0.0f64, 0.0f64);
    for ((angle, s), c) in angles.iter().zip(&sine).zip(&cosine) {
        if !angle.is_finite() {
            assert!(s.is_nan() && c.is_nan(), "{angle}: {s} {c}");
            continue;
        }
        let worst = (s - angle.sin()).abs().max((c - angle.cos()).abs());
        let into = if angle.abs() <= 160.0 { &mut worst_small } else { &mut worst_large };
        *into = into.max(worst);
    }
    println!("worst difference {worst_small:.2e} up to 160 rad, {worst_large:.2e} up to 1e6 rad");
    // one unit of the last place of a number just below 1 is 1.1e-16; both sides may round
    assert!(worst_small <= 2.3e-16 && worst_large <= 2.3e-16);
}

#[test]
fn angles_beyond_the_vector_range_are_taken_by_the_standard_library() {
    let yaml = "name: m\nchain: [w, C, b, t]\naxes: {C: {type: rotary, direction: [0, 0, 1], origin: [0, 0, 0]}}\n";
    let machine = machine_from_yaml(Path::new("m.yaml"), yaml.into()).unwrap();
    let chain = Chain::of(&machine);
    let geometry = Geometry::nominal(&chain);
    let (pivot, spindle) = (Vector3::new(100.0, 0.0, 0.0), Vector3::new(0.0, 30.0, 0.0));
    let positions = [0.0, 3.0e7, 5.0e12];
    let poses = Poses::from_rows(1, &positions);
    let links = (chain.link("w").unwrap(), chain.link("t").unwrap());
    let lengths = geometry.bar((links.0, &pivot), (links.1, &spindle), &poses).lengths();
    for (q, length) in positions.iter().zip(lengths) {
        let wanted = geometry.length((links.0, &pivot), (links.1, &spindle), &[*q], None);
        assert!((length - wanted).abs() < 1e-10, "{q}: {length} for {wanted}");
    }
}

#[test]
fn balls_in_one_place_have_zero_length_and_zero_derivatives() {
    let machine = machine_from_yaml(Path::new("m.yaml"), "name: m\ncode: '[wCAbYXZt]'\naxes: {}\n".into()).unwrap();
    let chain = Chain::of(&machine);
    let geometry = Geometry::nominal(&chain);
    let poses = Poses::from_rows(5, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let here = Vector3::new(0.0, 0.0, 0.0);
    let bar = geometry.bar((chain.link("w").unwrap(), &here), (chain.link("t").unwrap(), &here), &poses);
    let columns = all_columns(5);
    let (mut length, mut values) = ([f64::NAN; 1], vec![f64::NAN; columns.len()]);
    bar.derivatives(&geometry, &columns).evaluate(0..1, &mut length, &mut values);
    assert_eq!(length[0], 0.0);
    assert!(values.iter().all(|&value| value == 0.0), "{values:?}");
}

#[test]
fn reference_traces_agree_better_than_a_nanometre() {
    let Some(folder) = shared_data::folder("reference") else { return };
    let machine = machine_from_yaml(Path::new("r.yaml"), "name: r\ncode: '[wCAbYXZt]'\naxes: {}\n".into()).unwrap();
    let chain = Chain::of(&machine);
    let (a, c) = (machine.axis_index("A").unwrap(), machine.axis_index("C").unwrap());
    let text = std::fs::read_to_string(folder.join("reference_traces.csv")).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().filter(|l| !l.starts_with('#')).map(|l| l.split(',').collect()).collect();
    // the cases whose errors are eight known numbers; single errors are in tests/reference.rs
    let cases = [
        ("none", [0.0; 8]),
        ("all", [0.01, 0.01, 10.0, 10.0, 0.01, 0.01, 10.0, 10.0]),
        ("mixed", [0.01, -0.007, 10.0, -8.0, 0.006, -0.009, 5.0, -4.0]),
        ("big", [1.0, -0.7, 1000.0, -800.0, 0.6, -0.9, 500.0, -400.0]),
    ];
    let far = (150.0f64 * 150.0 - 100.0 * 100.0).sqrt();
    let setups = [
        ("A1", a, [0.0, 100.0, 0.0], [0.0, 0.0, 0.0]),
        ("A2", a, [0.0, 100.0, 0.0], [-far, 0.0, 0.0]),
        ("C1", c, [100.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
        ("C2", c, [100.0, 0.0, 0.0], [0.0, 0.0, far]),
    ];
    let (mut worst, mut compared) = (0.0f64, 0);
    for (case, e) in cases {
        let (um, deg) = (1e-3, 1f64.to_radians());
        let mut errors = vec![[0.0; 6]; 5];
        errors[a] = [0.0, e[2] * um, e[3] * um, 0.0, e[0] * deg, e[1] * deg];
        errors[c] = [e[6] * um, e[7] * um, 0.0, e[4] * deg, e[5] * deg, 0.0];
        for (test, axis, pivot, spindle) in setups {
            let of_test: Vec<&Vec<&str>> = rows.iter().filter(|r| r[0] == test && r[1] == case).collect();
            let mut columns = vec![vec![0.0; of_test.len()]; 5];
            columns[axis] = of_test.iter().map(|r| r[2].parse::<f64>().unwrap().to_radians()).collect();
            let poses = Poses::from_columns(columns);
            for (field, composition) in [(4, Composition::Exact), (5, Composition::FirstOrder)] {
                let geometry = Geometry::new(&chain, &errors, composition);
                let (pivot, spindle) = (Vector3::from(pivot), Vector3::from(spindle));
                let ends = (chain.link("w").unwrap(), chain.link("t").unwrap());
                let lengths = geometry.bar((ends.0, &pivot), (ends.1, &spindle), &poses).lengths();
                for (row, length) in of_test.iter().zip(lengths) {
                    worst = worst.max((length - row[field].parse::<f64>().unwrap()).abs());
                    compared += 1;
                }
            }
        }
    }
    println!("{compared} lengths, worst difference {worst:.2e} mm");
    assert_eq!(compared, 2 * 4 * (91 + 91 + 361 + 361));
    assert!(worst < 1e-11, "{worst:e}");
}
