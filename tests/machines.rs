//! Every file in `machines/` loads, prints, reads back and has right derivatives: a new machine is tested by existing.

use crate::finite_differences;
use std::path::{Path, PathBuf};
use std::process::Command;

use finite_differences::Arguments;
use fiveaxis::chain::{Chain, Composition, Geometry, Pose};
use fiveaxis::load::{load_machine, machine_from_yaml};
use fiveaxis::machine::{AxisKind, Machine, StructuralCode};
use fiveaxis::report::machine_yaml;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SEED: u64 = 1_048_583;

fn machines() -> Vec<(PathBuf, Machine)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= 26, "{} files", files.len());
    let load = |file: PathBuf| {
        let machine = load_machine(&file).unwrap_or_else(|why| panic!("{why}"));
        (file, machine)
    };
    files.into_iter().map(load).collect()
}

#[test]
fn codes_print_and_read_back() {
    for (file, machine) in machines() {
        let printed = machine.code.to_string();
        assert_eq!(StructuralCode::parse(&printed).as_ref(), Ok(&machine.code), "{}", file.display());
        assert_eq!(machine.axis_names(), machine.code.axis_names().map(String::as_str).collect::<Vec<_>>());
    }
}

#[test]
fn files_read_back_as_written() {
    for (file, machine) in machines() {
        let read = machine_from_yaml(Path::new("written.yaml"), machine_yaml(&machine)).unwrap();
        assert_eq!(read, machine, "{}", file.display());
    }
}

#[test]
fn every_link_frame_is_the_reference_frame_at_zero() {
    for (file, machine) in machines() {
        let chain = Chain::of(&machine);
        let geometry = Geometry::nominal(&chain);
        for (name, link) in chain.links() {
            let pose = geometry.pose(link, &vec![0.0; machine.axes.len()], None);
            let rounding = 1e-12 * 1000.0;
            let off = (pose.rotation - Pose::identity().rotation).norm() + pose.translation_mm.norm();
            assert!(off < rounding, "{} {name}: {off:e}", file.display());
        }
    }
}

#[test]
fn zero_lies_inside_every_range() {
    for (file, machine) in machines() {
        for axis in &machine.axes {
            let Some((from, to)) = axis.range else { continue };
            assert!(from <= 0.0 && 0.0 <= to, "{}: zero lies outside {}'s range", file.display(), axis.name);
        }
    }
}

#[test]
fn derivatives_agree_with_differences() {
    println!("seed {SEED}");
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    for (file, machine) in machines() {
        let chain = Chain::of(&machine);
        let links = (chain.link("w").unwrap(), chain.link("t").unwrap());
        let mut poses = 0;
        while poses < 6 {
            let mut error =
                |k: usize| if k < 3 { random.random_range(-0.5..0.5) } else { random.random_range(-0.01..0.01) };
            let mut errors = || machine.axes.iter().map(|_| std::array::from_fn(&mut error)).collect();
            let (location, motion) = (errors(), errors());
            let positions = machine.axes.iter().map(|axis| {
                let unlimited = match axis.kind {
                    AxisKind::Linear => 100.0,
                    AxisKind::Rotary => std::f64::consts::PI,
                };
                let (from, to) = axis.range.unwrap_or((-unlimited, unlimited));
                // portals of four metres would leave the steps' accuracy
                random.random_range(from.max(-500.0)..to.min(500.0))
            });
            let positions = positions.collect();
            let mut ball = || Vector3::from_fn(|_, _| random.random_range(-200.0..200.0));
            let at = Arguments { errors: location, motion, positions, pivot: ball(), spindle: ball() };
            if at.length(&chain, links, Composition::Exact) < 60.0 {
                continue;
            }
            poses += 1;
            for composition in [Composition::Exact, Composition::FirstOrder] {
                finite_differences::check(&file.display().to_string(), &chain, links, &at, composition);
            }
        }
    }
}

#[test]
fn check_shows_every_machine() {
    for (file, machine) in machines() {
        let run = |arguments: &[&str]| {
            let output = Command::new(env!("CARGO_BIN_EXE_fiveaxis")).arg("check").arg(&file).args(arguments).output();
            let output = output.unwrap();
            assert!(output.status.success() && output.stderr.is_empty(), "{}: {output:?}", file.display());
            String::from_utf8(output.stdout).unwrap()
        };
        let text = run(&[]);
        assert!(text.contains(&machine.code.to_string()), "{text}");
        for slot in machine.slots() {
            assert!(text.contains(&slot.to_string()), "{}: {slot}", file.display());
        }
        let first = &machine.axes[0];
        let json: serde_json::Value =
            serde_json::from_str(&run(&["--json", "--at", &format!("{}=-4.5", first.name)])).unwrap();
        assert_eq!(json["code"], machine.code.to_string());
        assert_eq!(json["axes"].as_array().unwrap().len(), machine.axes.len());
        assert_eq!(json["placements"][1]["positions"][0][1], -4.5);
        check_transforms(&machine, &json);
    }
}

/// The printed transforms place a point where the chain places it.
fn check_transforms(machine: &Machine, json: &serde_json::Value) {
    let chain = Chain::of(machine);
    let mut positions = vec![0.0; machine.axes.len()];
    positions[0] = machine.axes[0].kind.from_file_unit(-4.5);
    let at = Vector3::new(12.0, -34.0, 56.0);
    for link in json["placements"][1]["links"].as_array().unwrap() {
        let id = chain.link(link["name"].as_str().unwrap()).unwrap();
        let due = Geometry::nominal(&chain).point(id, &at, &positions, None);
        for k in 0..3 {
            let row: Vec<f64> = link["nominal"][k].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
            let found = row[0] * at.x + row[1] * at.y + row[2] * at.z + row[3];
            assert!((found - due[k]).abs() < 1e-12 * 4000.0, "{} {k}: {found} {}", link["name"], due[k]);
        }
    }
}
