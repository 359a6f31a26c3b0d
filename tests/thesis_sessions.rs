//! The committed thesis sessions are what their generator writes, and the generator's kinematics agree with values computed elsewhere; the library is not used.

#[path = "../examples/thesis_sessions/design.rs"]
mod design;
#[path = "../examples/thesis_sessions/files.rs"]
mod files;
#[path = "../examples/thesis_sessions/kinematics.rs"]
mod kinematics;
#[path = "../examples/thesis_sessions/noise.rs"]
mod noise;
#[path = "../examples/thesis_sessions/session.rs"]
mod session;
mod shared_data;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use kinematics::{AxisLocation, Trunnion};

fn committed() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/thesis")
}

#[test]
fn committed_files_are_what_the_generator_writes() {
    let mut written = BTreeSet::new();
    for (name, text) in files::all(files::COMMITTED_SEED) {
        let path = committed().join(&name);
        let found = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            found == text,
            "{name} differs from the generator's: run `cargo run --release --example thesis_sessions -- --out examples/thesis`"
        );
        written.insert(name);
    }
    for folder in ["", "chapter4", "chapter5", "chapter6"] {
        for entry in std::fs::read_dir(committed().join(folder)).expect("committed folder") {
            let entry = entry.expect("entry");
            if entry.file_type().expect("type").is_file() {
                let name = Path::new(folder).join(entry.file_name());
                let name = name.to_string_lossy().replace('\\', "/");
                assert!(written.contains(&name), "{name} is not the generator's");
            }
        }
    }
}

#[test]
fn another_seed_gives_other_readings() {
    let csv = |seed| {
        let files = files::all(seed);
        let file = files.into_iter().find(|(name, _)| name == "chapter5/c-short-cw-2.csv");
        file.expect("c-short-cw-2").1
    };
    assert_ne!(csv(1), csv(2));
}

#[test]
fn committed_sessions_stay_small() {
    let total: usize = files::all(files::COMMITTED_SEED).iter().map(|(_, text)| text.len()).sum();
    assert!(total < 1_500_000, "{total} bytes");
}

/// Truth of a reference case: EB0A EC0A (deg), EY0A EZ0A (mm), EA0C EB0C (deg), EX0C EY0C (mm).
fn reference_machine(case: &str) -> Option<Trunnion> {
    let names = ["ty0a", "tz0a", "ey0a", "ez0a", "tx0c", "ty0c", "ex0c", "ey0c"];
    let unit = [0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01];
    let e: [f64; 8] = match case {
        "none" => [0.0; 8],
        "all" => unit,
        "mixed" => [0.01, -0.007, 0.01, -0.008, 0.006, -0.009, 0.005, -0.004],
        "big" => [1.0, -0.7, 1.0, -0.8, 0.6, -0.9, 0.5, -0.4],
        one => {
            let index = names.iter().position(|name| *name == one)?;
            std::array::from_fn(|k| if k == index { unit[k] } else { 0.0 })
        }
    };
    Some(Trunnion {
        a: AxisLocation { shift_mm: [0.0, e[2], e[3]], tilt_rad: [0.0, e[0].to_radians(), e[1].to_radians()] },
        c: AxisLocation { shift_mm: [e[6], e[7], 0.0], tilt_rad: [e[4].to_radians(), e[5].to_radians(), 0.0] },
    })
}

#[test]
fn kinematics_agree_with_values_computed_elsewhere() {
    let Some(folder) = shared_data::folder("reference") else { return };
    let text = std::fs::read_to_string(folder.join("reference_traces.csv")).expect("read");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("header").split(',').collect();
    let column = |name: &str| header.iter().position(|h| *h == name).expect("column");
    let (theta, length) = (column("theta_deg"), column("L_exact_mm"));
    let d = design::cone_height_mm();
    let mut worst_mm = 0.0_f64;
    let mut rows = 0;
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let machine = reference_machine(cells[column("case")]).expect("known case");
        let at: f64 = cells[theta].parse().expect("angle");
        let expected: f64 = cells[length].parse().expect("length");
        // the reference's table lies 75 mm below the intersection: its (x, y, 75) is our (x, y, 0)
        let found = match cells[column("test")] {
            "A1" => machine.length_mm(at, 0.0, [0.0, 100.0, 0.0], [0.0; 3]),
            "A2" => machine.length_mm(at, 0.0, [0.0, 100.0, 0.0], [-d, 0.0, 0.0]),
            "C1" => machine.length_mm(0.0, at, [100.0, 0.0, 0.0], [0.0; 3]),
            "C2" => machine.length_mm(0.0, at, [100.0, 0.0, 0.0], [0.0, 0.0, d]),
            other => panic!("unknown test {other}"),
        };
        worst_mm = worst_mm.max((found - expected).abs());
        rows += 1;
    }
    assert_eq!(rows, 10_848);
    assert!(worst_mm < 1e-12 * 150.0 * 4.0, "worst {worst_mm:e} mm");
}

/// Means of length, length·cos φ and length·sin φ over a full turn, φ the pivot's direction in R.
fn harmonics(csv: &str, pivot_at_deg: f64) -> [f64; 3] {
    let rows: Vec<[f64; 2]> = csv
        .lines()
        .skip(1)
        .map(|line| {
            let cells: Vec<f64> = line.split(',').map(|c| c.parse().expect("number")).collect();
            [(cells[1] + pivot_at_deg).to_radians(), cells[2]]
        })
        .collect();
    // least squares of 1, cos, sin: the turn is not covered to the last degree
    let mut normal = nalgebra::Matrix3::<f64>::zeros();
    let mut right = nalgebra::Vector3::<f64>::zeros();
    for [phi, length] in rows {
        let basis = nalgebra::Vector3::new(1.0, phi.cos(), phi.sin());
        normal += basis * basis.transpose();
        right += basis * length;
    }
    let solved = normal.lu().solve(&right).expect("full rank");
    [solved[0], solved[1], solved[2]]
}

#[test]
fn short_c_tests_carry_the_inserted_position_errors() {
    let files: BTreeMap<String, String> = files::all(files::COMMITTED_SEED).into_iter().collect();
    for (folder, test, pivot_at_deg) in
        [("chapter4", "c-short", 0.0), ("chapter5", "c-short", 90.0), ("chapter6", "c-position-1", 0.0)]
    {
        let truth: serde_json::Value = serde_json::from_str(&files[&format!("{folder}/truth.json")]).expect("truth");
        let error = |name: &str| truth["location_errors"][name]["value"].as_f64().expect(name);
        let spindle = |k: usize| truth["spindle_balls"][0]["error_um"][k].as_f64().expect("ball");
        let runs: Vec<[f64; 3]> = files
            .iter()
            .filter(|(name, _)| name.starts_with(&format!("{folder}/{test}-")))
            .map(|(_, csv)| harmonics(csv, pivot_at_deg))
            .collect();
        assert_eq!(runs.len(), 6);
        let mean = |k: usize| runs.iter().map(|run| run[k]).sum::<f64>() / 6.0 * 1e3;
        let expected_x = error("EX0C") - spindle(0);
        let expected_y = error("EY0A") + error("EY0C") - spindle(1);
        // noise and drift average to about 0.1 µm; second-order terms stay below that
        assert!((mean(1) - expected_x).abs() < 0.4, "{folder} x {}", mean(1) - expected_x);
        assert!((mean(2) - expected_y).abs() < 0.4, "{folder} y {}", mean(2) - expected_y);
    }
}

/// Change of length per µm or arcsec of one error, by central differences, µm.
fn slope(error: usize, at: impl Fn(&Trunnion) -> f64) -> f64 {
    let with = |value: f64| {
        let errors = std::array::from_fn(|k| if k == error { value } else { 0.0 });
        at(&session::trunnion(&errors))
    };
    (with(1.0) - with(-1.0)) / 2.0 * 1e3
}

#[test]
fn first_order_statements_of_the_documentation_hold() {
    let arcsec_um = (1.0_f64 / 3600.0).to_radians() * 1e3;
    let (r, d) = (design::RADIUS_MM, design::cone_height_mm());
    let (l, p, h) = (design::EXTENDED_MM, 275.0, 150.0);
    // in the order of ERROR_NAMES, as functions of cosine, sine of the turning angle and [R, D, L, p, h]
    type Statement = (&'static str, [fn(f64, f64, [f64; 5]) -> f64; 8]);
    let none = |_: f64, _: f64, _: [f64; 5]| 0.0;
    let statements: [Statement; 3] = [
        (
            "a at p",
            [
                |c, _, _| c,
                |_, s, _| s,
                |_, s, [_, _, _, p, _]| -p * s,
                |c, _, [_, _, _, p, _]| p * c,
                none,
                |_, _, _| 1.0,
                none,
                none,
            ],
        ),
        (
            "a extended",
            [
                |c, _, [r, _, l, ..]| r / l * c,
                |_, s, [r, _, l, ..]| r / l * s,
                |_, s, [r, d, l, ..]| r * d / l * s,
                |c, _, [r, d, l, ..]| -r * d / l * c,
                |_, _, [_, d, l, ..]| d / l,
                |_, _, [r, _, l, ..]| r / l,
                none,
                none,
            ],
        ),
        (
            "c at h",
            [
                |_, s, _| s,
                none,
                |c, _, [.., h]| h * c,
                none,
                |c, _, _| c,
                |_, s, _| s,
                |_, s, [.., h]| -h * s,
                |c, _, [.., h]| h * c,
            ],
        ),
    ];
    let sizes = [r, d, l, p, h];
    for (name, expected) in statements {
        for at_deg in [-20.0_f64, 0.0, 33.0, 70.0] {
            let (s, c) = at_deg.to_radians().sin_cos();
            for (error, stated) in expected.iter().enumerate() {
                let found = slope(error, |machine| match name {
                    "a at p" => machine.length_mm(at_deg, 0.0, [p, r, 0.0], [p, 0.0, 0.0]),
                    "a extended" => machine.length_mm(at_deg, 0.0, [0.0, r, 0.0], [-d, 0.0, 0.0]),
                    _ => machine.length_mm(0.0, at_deg, [r, 0.0, h], [0.0, 0.0, h]),
                });
                let (error_name, unit) = design::ERROR_NAMES[error];
                let scale = if unit == "um" { 1.0 } else { arcsec_um };
                let stated = stated(c, s, sizes) * scale;
                assert!(
                    (found - stated).abs() < 1e-6,
                    "{name} at {at_deg}: {error_name} moves the length {found} µm, stated {stated}"
                );
            }
        }
    }
}
