//! Axis positions for tool poses: round trips over every shipped machine, errors included, and what has no answer.
//!
//! Poses are made by the kernel's points of links, which the reference traces check; the inverse composes poses of its own.

use crate::shipped;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use fiveaxis::chain::{Branch, Chain, Composition, Geometry};
use fiveaxis::inverse::{InverseError, Kinematics, Target, Tool};
use fiveaxis::load::{LinkChoice, load_machine, load_machine_and_bodies_with_links};
use fiveaxis::machine::{AxisKind, Component, ComponentError, ComponentForm, Harmonic, Machine};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Round trips close to this, mm and rad.
const CLOSED: f64 = 1e-9;

fn machines() -> Vec<PathBuf> {
    shipped::machine_files()
}

/// Gives a machine errors of all kinds: a tenth of a millimetre and a minute of arc, and forms over position.
fn err(machine: &mut Machine, random: &mut ChaCha8Rng) {
    for axis in &mut machine.axes {
        for k in 0..6 {
            let size = if k < 3 { 0.1 } else { 3e-4 };
            axis.location_errors[k] = size * random.random_range(-1.0..1.0);
        }
        for component in Component::ALL {
            let size = if component.is_angle() { 1e-4 } else { 0.03 };
            let value = size * random.random_range(-1.0..1.0);
            let form = match (axis.kind, component.index() % 2) {
                (AxisKind::Rotary, _) => {
                    ComponentForm::Fourier(vec![Harmonic { frequency: 2.0, cosine: value, sine: 0.5 * value }])
                }
                (AxisKind::Linear, 0) => ComponentForm::Polynomial(vec![value / 300.0, value / 90_000.0]),
                (AxisKind::Linear, _) => {
                    ComponentForm::Table { position: vec![-200.0, 0.0, 250.0], value: vec![value, 0.0, -value] }
                }
            };
            axis.component_errors.push(ComponentError { component, form });
        }
    }
}

fn random_positions(machine: &Machine, random: &mut ChaCha8Rng) -> Vec<f64> {
    let one = |axis: &fiveaxis::machine::Axis| {
        let (from, to) = axis.range.expect("travel");
        random.random_range(from..to)
    };
    machine.axes.iter().map(one).collect()
}

/// Tip and axis of a tool in the workpiece by the points of links.
fn forward(machine: &Machine, tool: &Tool, q: &[f64], errs: bool) -> (Vector3<f64>, Vector3<f64>) {
    let chain = Chain::of(machine);
    let errors = if errs { machine.location_errors() } else { Vec::new() };
    let geometry = Geometry::new(&chain, &errors, Composition::Exact);
    let motion = fiveaxis::simulate::component_errors_of(machine, q);
    let motion = errs.then_some(motion.as_slice());
    let tip = geometry.point(chain.end(Branch::Tool), &tool.tip_mm, q, motion);
    let above = geometry.point(chain.end(Branch::Tool), &(tool.tip_mm + tool.axis), q, motion);
    let w = geometry.pose(chain.end(Branch::Workpiece), q, motion);
    let back = w.rotation.transpose();
    (back * (tip - w.translation_mm), (back * (above - tip)).normalize())
}

#[test]
fn every_machine_comes_back_to_its_pose_with_all_its_errors() {
    let mut random = ChaCha8Rng::seed_from_u64(25);
    for file in machines() {
        let mut machine = load_machine(&file).expect("machine");
        let tool = Tool::of(&machine, Some(120.0)).expect("tool");
        for errs in [false, true] {
            if errs {
                err(&mut machine, &mut random);
            }
            let chain = Chain::of(&machine);
            let kinematics = match errs {
                true => Kinematics::actual(&machine, &chain, tool),
                false => Kinematics::nominal(&machine, &chain, tool),
            };
            let mut worst = [0.0f64; 2];
            for _ in 0..200 {
                let q = random_positions(&machine, &mut random);
                let (tip_mm, axis) = forward(&machine, &tool, &q, errs);
                let target = Target { tip_mm, axis, across: None };
                let near = random_positions(&machine, &mut random);
                let inverse = kinematics.inverse(&target, &near).unwrap_or_else(|why| panic!("{file:?} {q:?}: {why}"));
                assert!(inverse.is_complete);
                let reach = inverse.reach.expect("five axes");
                let mut found = f64::INFINITY;
                for solution in &inverse.solutions {
                    let (tip, way) = forward(&machine, &tool, &solution.positions, errs);
                    worst[0] = worst[0].max((tip - tip_mm).norm());
                    worst[1] = worst[1].max(way.cross(&axis).norm());
                    let off = solution.positions.iter().zip(&q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                    found = found.min(off);
                }
                // a degree from singular directions and from the edge of the reach positions follow from the pose to 1e-8
                let edge = reach.angles_rad.map(|edge| {
                    let from = reach.about.angle(&axis);
                    (from - edge).abs()
                });
                if reach.from_pole_rad > 0.02 && edge.iter().all(|edge| *edge > 0.02) {
                    assert!(found < 1e-8, "{file:?}: the positions {q:?} are not among the solutions, nearest {found}");
                }
            }
            assert!(worst[0] < CLOSED && worst[1] < CLOSED, "{file:?}: {worst:?}");
        }
    }
}

#[test]
fn an_arm_of_six_joints_comes_back_to_its_pose() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/irb120.urdf");
    let (machine, _) = load_machine_and_bodies_with_links(&file, &LinkChoice::default()).expect("arm");
    let chain = Chain::of(&machine);
    let tool = Tool::new(Vector3::new(400.0, 0.0, 630.0), -Vector3::x());
    let kinematics = Kinematics::actual(&machine, &chain, tool);
    let mut random = ChaCha8Rng::seed_from_u64(120);
    for _ in 0..10 {
        let q = random_positions(&machine, &mut random);
        let pose = kinematics.pose(&q);
        let target = Target { tip_mm: pose.tip_mm, axis: pose.axis, across: Some(pose.across) };
        let inverse = kinematics.inverse(&target, &vec![0.0; q.len()]).expect("solutions");
        assert!(!inverse.is_complete);
        let off = |positions: &[f64]| positions.iter().zip(&q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let nearest = inverse.solutions.iter().map(|solution| off(&solution.positions)).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-7, "{q:?} is not among {} solutions", inverse.solutions.len());
        for solution in &inverse.solutions {
            let back = kinematics.pose(&solution.positions);
            assert!((back.tip_mm - pose.tip_mm).norm() < CLOSED && (back.across - pose.across).norm() < CLOSED);
        }
    }
}

#[test]
fn singular_directions_and_those_out_of_reach_are_told() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/table-table-ca-portal.yaml");
    let machine = load_machine(&file).expect("machine");
    let chain = Chain::of(&machine);
    let tool = Tool::of(&machine, None).expect("tool");
    let kinematics = Kinematics::nominal(&machine, &chain, tool);
    let mut near = vec![0.0; machine.axes.len()];
    let c = machine.axis_index("C").expect("C");
    near[c] = 0.7;
    let upright = Target { tip_mm: Vector3::new(10.0, 20.0, 30.0), axis: Vector3::z(), across: None };
    let inverse = kinematics.inverse(&upright, &near).expect("upright");
    let reach = inverse.reach.expect("five axes");
    assert!(reach.has_pole[0] && reach.from_pole_rad < 1e-12);
    assert_eq!(inverse.solutions[0].free, Some(c));
    assert_eq!(inverse.solutions[0].positions[c], 0.7);
    let nutating = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/nutating-head-45.yaml");
    let machine = load_machine(&nutating).expect("machine");
    let chain = Chain::of(&machine);
    let tool = Tool::of(&machine, None).expect("tool");
    let kinematics = Kinematics::nominal(&machine, &chain, tool);
    // a 45 deg axis points the tool from upright to level and no further
    let below = Target { tip_mm: Vector3::zeros(), axis: Vector3::new(0.0, 1.0, -0.1).normalize(), across: None };
    let refused = kinematics.inverse(&below, &vec![0.0; machine.axes.len()]).expect_err("below level");
    let InverseError::Direction { by_deg, .. } = refused else { panic!("{refused}") };
    assert!((by_deg - 0.1f64.atan().to_degrees()).abs() < 1e-9, "{by_deg}");
}

fn machine_of(text: &str) -> Machine {
    fiveaxis::load::machine_from_yaml(Path::new("machine.yaml"), text.to_string()).expect("machine")
}

#[test]
fn of_a_hundred_turns_the_nearest_are_told() {
    let machine = machine_of(
        "name: m\ncode: \"[wCAbYXZt]\"\ndirections: iso841\naxes:\n  X: {range: [-300, 300]}\n  Y: {range: [-225, 225]}\n  \
         Z: {range: [-320, 330]}\n  A: {range: [-110, 110]}\n  C: {range: [-36000, 36000]}\n",
    );
    let chain = Chain::of(&machine);
    let kinematics = Kinematics::actual(&machine, &chain, Tool::of(&machine, Some(100.0)).expect("tool"));
    let c = machine.axis_index("C").expect("C");
    for turns in [0.0, 5.0, -99.0, 99.0f64] {
        let mut positions = vec![0.0; 5];
        positions[machine.axis_index("A").expect("A")] = 0.4;
        positions[c] = 0.7 + turns * std::f64::consts::TAU;
        let pose = kinematics.pose(&positions);
        let target = Target { tip_mm: pose.tip_mm, axis: pose.axis, across: None };
        let found = kinematics.inverse(&target, &positions).expect("solutions");
        assert!((found.solutions[0].positions[c] - positions[c]).abs() < 1e-9, "{turns}: {:?}", found.solutions[0]);
        assert!(!found.is_complete);
    }
}

#[test]
fn of_more_axes_than_a_pose_asks_for_a_solution_within_the_travel_is_told() {
    let machine = machine_of(
        "name: m\nchain: [w, C, A, b, Y, X, Z, W, t]\naxes:\n  X: {range: [-300, 300]}\n  Y: {range: [-225, 225]}\n  \
         Z: {range: [-100, 400]}\n  W: {type: linear, direction: [0, 0, 1], range: [-100, 100]}\n  A: {range: [-90, 90]}\n  \
         C: {range: [-360, 360]}\n",
    );
    let chain = Chain::of(&machine);
    let kinematics = Kinematics::nominal(&machine, &chain, Tool::of(&machine, Some(0.0)).expect("tool"));
    let mut positions = vec![0.0; 6];
    positions[machine.axis_index("Z").expect("Z")] = 300.0;
    let pose = kinematics.pose(&positions);
    let target = Target { tip_mm: pose.tip_mm, axis: pose.axis, across: None };
    let found = kinematics.inverse(&target, &[0.0; 6]).expect("solutions");
    assert!(found.solutions[0].outside.is_empty(), "{:?}", found.solutions);
}

#[test]
fn the_command_finds_the_positions_of_a_pose_it_told() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let run = |arguments: &[&str]| {
        let output =
            Command::cargo_bin("fiveaxis").expect("built").current_dir(root).args(arguments).output().expect("run");
        let text = String::from_utf8(output.stdout).expect("text");
        (output.status.code(), serde_json::from_str::<serde_json::Value>(&text).ok(), text)
    };
    let machine = "machines/nutating-table-45.yaml";
    let (code, pose, _) = run(&["inverse", machine, "--at", "X=12.5,Y=-30,Z=44,B=61,C=-100", "--json"]);
    assert_eq!(code, Some(0));
    let pose = pose.expect("JSON");
    let list = |key: &str| {
        let numbers = pose[key].as_array().expect(key).iter().map(|value| value.to_string());
        numbers.collect::<Vec<String>>().join(",")
    };
    let (tip, axis) = (list("tip_mm"), list("tool_axis"));
    let (code, found, _) =
        run(&["inverse", machine, "--tip", &tip, "--tool-axis", &axis, "--near", "B=60,C=-90", "--json"]);
    assert_eq!(code, Some(0));
    let found = found.expect("JSON");
    let first = &found["solutions"][0]["positions"];
    for (name, wanted) in [("X", 12.5), ("Y", -30.0), ("Z", 44.0), ("B", 61.0), ("C", -100.0)] {
        assert!((first[name].as_f64().expect(name) - wanted).abs() < 1e-9, "{name}: {first}");
    }
    for wrong in [["--tip", "1,2", "--tool-axis", "0,0,1"], ["--tip", "1,2,3", "--tool-axis", "0,0,0"]] {
        let (code, refused, _) = run(&[&["inverse", machine, "--json"], wrong.as_slice()].concat());
        assert_eq!(code, Some(2));
        assert!(refused.expect("JSON")["error"].to_string().contains("write for example"));
    }
}
