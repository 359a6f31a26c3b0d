//! Points, poses, sockets and displacements: derivatives against differences, recovery and coverage, saved fits, refusals.

use crate::shipped;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use fiveaxis::chain::{Chain, Composition};
use fiveaxis::identify::{Options, Problem, Quantity, fitted_session, identify};
use fiveaxis::load::load_session;
use fiveaxis::machine::Component;
use fiveaxis::session::{Session, Setups};
use fiveaxis::simulate::simulate;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

const SEED: u64 = 24_240_024;

/// A machine with a link for the target, one for the instrument, and its axes with their ranges.
struct Case {
    name: &'static str,
    machine: &'static str,
    axes: &'static [(&'static str, &'static str, f64)],
    target: &'static str,
    instrument: &'static str,
}

const CASES: [Case; 3] = [
    Case {
        name: "arm",
        machine: "name: arm\nchain: [w, b, J1, J2, J3, J4, J5, J6, t]\naxes:\n\
            \x20 J1: {type: rotary, direction: [0, 0, 1], origin: [0, 0, 0]}\n\
            \x20 J2: {type: rotary, direction: [0, 1, 0], origin: [40, 0, 400]}\n\
            \x20 J3: {type: rotary, direction: [0, 1, 0], origin: [40, 0, 860]}\n\
            \x20 J4: {type: rotary, direction: [1, 0, 0], origin: [40, 0, 900]}\n\
            \x20 J5: {type: rotary, direction: [0, 1, 0], origin: [500, 0, 900]}\n\
            \x20 J6: {type: rotary, direction: [1, 0, 0], origin: [590, 0, 900]}\n",
        axes: &[
            ("J1", "deg", 130.0),
            ("J2", "deg", 75.0),
            ("J3", "deg", 60.0),
            ("J4", "deg", 140.0),
            ("J5", "deg", 100.0),
            ("J6", "deg", 150.0),
        ],
        target: "J6",
        instrument: "b",
    },
    Case {
        name: "table-table",
        machine: "name: trunnion\ncode: \"[wCAbYXZt]\"\naxes:\n  A: {origin: [0, 20, -30]}\n  C: {origin: [10, 0, 0]}\n",
        axes: &[("X", "mm", 200.0), ("Y", "mm", 150.0), ("Z", "mm", 100.0), ("A", "deg", 80.0), ("C", "deg", 170.0)],
        target: "C",
        instrument: "Z",
    },
    Case {
        name: "head-head",
        machine: "name: portal\ncode: \"[wXbYZCBt]\"\naxes:\n  C: {origin: [0, 0, 200]}\n  B: {origin: [0, 0, 150]}\n",
        axes: &[("X", "mm", 300.0), ("Y", "mm", 250.0), ("Z", "mm", 200.0), ("C", "deg", 170.0), ("B", "deg", 90.0)],
        target: "B",
        instrument: "w",
    },
];

/// Writes a session of random poses; recordings hold zeros for a simulation to fill.
fn session(folder: &Path, case: &Case, kind: &str, rows: usize, seed: u64) -> Session {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    std::fs::write(folder.join("machine.yaml"), case.machine).unwrap();
    let mut text = String::from("pose");
    case.axes.iter().for_each(|(axis, unit, _)| write!(text, ",{axis}_{unit}").unwrap());
    let (columns, zeros) = match kind {
        "point" => (",x_mm,y_mm,z_mm", ",0,0,0"),
        "pose" => (",x_mm,y_mm,z_mm,qw,qx,qy,qz", ",0,0,0,1,0,0,0"),
        "displacement" => (",displacement_mm", ",0"),
        _ => ("", ""),
    };
    text += columns;
    for row in 0..rows {
        write!(text, "\n{row}").unwrap();
        for (_, _, range) in case.axes {
            write!(text, ",{:.4}", random.random_range(-range..*range)).unwrap();
        }
        text += zeros;
    }
    std::fs::write(folder.join("rows.csv"), text + "\n").unwrap();
    let place = match kind {
        "same_point" => "socket: {link: w, at: [300, -200, 100]}".to_string(),
        "displacement" => {
            format!("instrument: {{link: {}, at: [300, -200, 100], direction: [1, 2, 2]}}", case.instrument)
        }
        _ => format!(
            "instrument: {{link: {}, at: [-800, 300, 200], quaternion: [0.5, 0.5, -0.5, 0.5]}}",
            case.instrument
        ),
    };
    let file = folder.join("session.yaml");
    let text = format!(
        "machine: machine.yaml\nreadings: {kind}\ntests:\n  - name: a\n    recording: rows.csv\n    {place}\n    target: {{link: {}, at: [650, 40, 880], quaternion: [0.6, 0, 0.8, 0]}}\n",
        case.target
    );
    std::fs::write(&file, text).unwrap();
    load_session(&file).unwrap()
}

/// The session as its machine would be read: traces in place of the recordings, with noise of 20 µm and 20 arcsec.
fn read(mut session: Session, seed: u64) -> Session {
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x5eed);
    let noise = Normal::new(0.0, 0.02).unwrap();
    let traces = simulate(&session, Composition::Exact).unwrap();
    for (test, trace) in session.tests.iter_mut().zip(traces) {
        let is_turn = test.reading.is_turn();
        let recording = test.recording.as_mut().unwrap();
        recording.length_mm = trace.length_mm.iter().map(|value| value + noise.sample(&mut random)).collect();
        assert!(!is_turn || recording.length_mm.iter().all(|value| value.is_finite()));
    }
    session
}

#[test]
fn derivatives_are_those_of_differences() {
    for case in &CASES {
        for kind in ["point", "pose", "same_point", "displacement"] {
            let folder = tempfile::tempdir().unwrap();
            let session = session(folder.path(), case, kind, 12, SEED);
            let chain = Chain::of(&session.machine);
            let setups = Setups::of(&session);
            let problem =
                Problem::new(&session, &chain, &setups, Options::default().unknowns(&session, &setups)).unwrap();
            let mut random = ChaCha8Rng::seed_from_u64(SEED);
            let values: Vec<f64> = problem
                .unknowns
                .iter()
                .map(|unknown| {
                    let size = if unknown.measure == fiveaxis::units::Measure::Angle { 0.02 } else { 2.0 };
                    random.random_range(-size..size)
                })
                .collect();
            let residual =
                |values: &[f64], test: usize| problem.predict(test, &problem.geometry(values), values).residual_mm;
            for test in 0..problem.tests.len() {
                let prediction = problem.predict(test, &problem.geometry(&values), &values);
                for (column, &unknown) in problem.tests[test].columns.iter().enumerate() {
                    let is_angle = problem.unknowns[unknown].measure == fiveaxis::units::Measure::Angle;
                    // error of the difference: third derivatives of at most 1e3 mm times step², and rounding over step
                    let (step, tolerance) = if is_angle { (1e-4, 2e-4) } else { (1e-2, 1e-8) };
                    // rotations stem from differences of points: 1e-13 of a metre at the lever, more near half a turn
                    let tolerance =
                        if session.tests[test].reading.is_turn() { f64::max(tolerance, 1e-6) } else { tolerance };
                    let mut ends = [values.clone(), values.clone()];
                    ends[0][unknown] += step;
                    ends[1][unknown] -= step;
                    let [up, down] = [residual(&ends[0], test), residual(&ends[1], test)];
                    for row in 0..up.len() {
                        let difference = -(up[row] - down[row]) / (2.0 * step);
                        let found = prediction.jacobian[(row, column)];
                        assert!(
                            (found - difference).abs() < tolerance,
                            "{} {kind}: {} in row {row} of {}: {found} by formula, {difference} by difference",
                            case.name,
                            problem.unknowns[unknown].label,
                            session.tests[test].name
                        );
                    }
                }
            }
        }
    }
}

/// Known errors of every rotary axis, and an instrument that stands elsewhere than stated.
fn with_errors(mut session: Session, seed: u64) -> Session {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for name in fiveaxis::identify::default_free(&session.machine) {
        let axis = session.machine.axis_index(&name.axis).unwrap();
        let size = if name.component.is_angle() { 5e-4 } else { 0.3 };
        session.machine.axes[axis].location_errors[name.component.index()] = random.random_range(-size..size);
    }
    session
}

#[test]
fn what_was_put_in_is_found_within_its_sigma() {
    let seeds = if shipped::is_thorough() { 300 } else { 24 };
    for case in &CASES {
        for kind in ["point", "pose"] {
            let (mut inside, mut all) = (0usize, 0usize);
            for seed in 0..seeds {
                let folder = tempfile::tempdir().unwrap();
                let stated = session(folder.path(), case, kind, 60, SEED + seed);
                let real = with_errors(stated.clone(), SEED + 1000 + seed);
                let mut recorded = read(real.clone(), seed);
                recorded.machine = stated.machine.clone();
                let fit = identify(&recorded, &Options::default()).unwrap();
                for (unknown, estimate) in fit.unknowns.iter().zip(&fit.estimates) {
                    let Quantity::Location { axis, component } = unknown.quantity else { continue };
                    // what stays open between axes and instrument follows the priors, which nothing was drawn from
                    if estimate.prior_share > 0.01 {
                        continue;
                    }
                    let truth = real.machine.axes[axis].location_errors[Component::index(component)];
                    all += 1;
                    inside += usize::from((estimate.value - truth).abs() < 2.0 * estimate.sigma);
                    assert!(
                        (estimate.value - truth).abs() < 6.0 * estimate.sigma,
                        "{} {kind} seed {seed}: {}",
                        case.name,
                        unknown.label
                    );
                }
            }
            let share = inside as f64 / all as f64;
            assert!(all > 3 * seeds as usize, "{} {kind}: only {all} errors were determined", case.name);
            // 95.4 % of a normal distribution; estimates of one session go together
            let slack = if seeds >= 300 { 0.02 } else { 0.045 };
            assert!(
                (share - 0.954).abs() < slack,
                "{} {kind}: {:.1} % of {all} within 2 sigma",
                case.name,
                100.0 * share
            );
        }
    }
}

fn fiveaxis(arguments: &[&str]) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_fiveaxis")).args(arguments).output().unwrap()
}

/// Writes the readings of a session's machine as its recordings.
fn simulated(case: &Case, kind: &str, rows: usize) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    session(folder.path(), case, kind, rows, SEED);
    let out = folder.path().join("out");
    let text = |path: &Path| path.to_str().unwrap().to_string();
    let done = fiveaxis(&["simulate", &text(&folder.path().join("session.yaml")), "--out", &text(&out)]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    std::fs::copy(out.join("rows.csv"), folder.path().join("rows.csv")).unwrap();
    folder
}

#[test]
fn a_saved_fit_predicts_what_it_read_and_an_instrument_is_found() {
    for case in &CASES {
        for kind in ["point", "pose", "same_point", "displacement"] {
            if kind == "same_point" {
                continue; // random poses do not keep a ball in its socket
            }
            let folder = simulated(case, kind, 40);
            let file = folder.path().join("session.yaml");
            if kind != "displacement" {
                // nothing is said of where instrument and target stand
                let text = std::fs::read_to_string(&file).unwrap();
                let open: Vec<String> = text
                    .lines()
                    .map(|line| match line.trim_start().split(':').next() {
                        Some("instrument") => format!("    instrument: {{link: {}}}", case.instrument),
                        Some("target") => format!("    target: {{link: {}}}", case.target),
                        _ => line.to_string(),
                    })
                    .collect();
                std::fs::write(&file, open.join("\n")).unwrap();
            }
            let session = load_session(&file).unwrap();
            let fit = identify(&session, &Options::default()).unwrap();
            assert!(fit.rms_mm < 1e-6, "{} {kind}: {} mm are left", case.name, fit.rms_mm);
            let fitted = fitted_session(&session, &fit);
            let left = simulate(&fitted, Composition::Exact).unwrap();
            for ((test, trace), of_fit) in session.tests.iter().zip(&left).zip(&fit.tests) {
                for (row, read) in test.recording.as_ref().unwrap().length_mm.iter().enumerate() {
                    let off = read - trace.length_mm[row] - of_fit.residual_mm[row];
                    assert!(off.abs() < 1e-8, "{} {kind}: {off} mm between fit and prediction", case.name);
                }
            }
        }
    }
}

#[test]
fn simulating_sockets_counts_the_files_and_moves_both_ends_of_a_distance() {
    let session = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/real/sockets-panda/panda-1/session.yaml");
    let out = tempfile::tempdir().expect("folder");
    let folder = out.path().join("out");
    let folder = folder.to_string_lossy();
    let output = fiveaxis(&["simulate", session, "--out", &folder, "--draw-setups", "--json"]);
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let tests = value["tests"].as_array().expect("tests");
    let files: std::collections::BTreeSet<&str> = tests.iter().filter_map(|test| test["recording"].as_str()).collect();
    let written = std::fs::read_dir(&*folder).expect("written").filter_map(Result::ok);
    assert_eq!(files.len(), written.filter(|file| file.path().extension().is_some_and(|one| one == "csv")).count());
    assert!(files.iter().all(|file| Path::new(&*folder).join(file).is_file()), "{files:?}");
    let text = fiveaxis(&["simulate", session, "--out", &folder, "--force"]).stdout;
    let text = String::from_utf8(text).expect("text");
    assert!(text.contains(&format!("{} recordings written", files.len())), "{text}");
    assert!(text.contains("nothing is simulated in them"), "{text}");
}

#[test]
fn wrong_rotations_are_refused_with_their_line() {
    let case = &CASES[0];
    let folder = tempfile::tempdir().unwrap();
    session(folder.path(), case, "pose", 4, SEED);
    let file = folder.path().join("session.yaml");
    let rows = std::fs::read_to_string(folder.path().join("rows.csv")).unwrap();
    let refused = |rows: &str| {
        std::fs::write(folder.path().join("rows.csv"), rows).unwrap();
        load_session(&file).expect_err("refused").to_string()
    };
    let message = refused(&rows.replacen(",1,0,0,0\n", ",1,0.5,0,0\n", 1));
    assert!(message.contains("rows.csv:2: the quaternion (1, 0.5, 0, 0) has length 1.1180, due is 1"), "{message}");
    let matrix = |last: &str| {
        rows.replace(",qw,qx,qy,qz", ",r00,r01,r02,r10,r11,r12,r20,r21,r22")
            .replace(",1,0,0,0\n", &format!(",1,0,0,0,1,0,0,0,{last}\n"))
    };
    let message = refused(&matrix("-1"));
    assert!(message.contains("rows.csv:2: the rotation matrix is mirrored"), "{message}");
    let message = refused(&matrix("0.9"));
    assert!(message.contains("r00 to r22 are no rotation"), "{message}");
    let message = refused(&rows.replace("x_mm", "X"));
    assert!(message.contains("a pose has the columns x_mm y_mm z_mm qw qx qy qz, or"), "{message}");
    let message = refused(&rows.replace(",0,0,0,1,0,0,0\n", ",,,,,,,\n"));
    assert!(message.contains("has no reading"), "{message}");
}

#[test]
fn wrong_keys_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    session(folder.path(), &CASES[0], "point", 4, SEED);
    let file = folder.path().join("session.yaml");
    let text = std::fs::read_to_string(&file).unwrap();
    let refused = |text: String| {
        std::fs::write(&file, text).unwrap();
        load_session(&file).expect_err("refused").to_string()
    };
    let message = refused(text.replace("readings: point", "readings: points"));
    assert!(message.contains("unknown readings 'points'; did you mean 'point'?"), "{message}");
    let message = refused(text.replace("    instrument:", "    pivot: {link: b, at: [0, 0, 0]}\n    instrument:"));
    assert!(message.contains("which have no pivot"), "{message}");
    let message = refused(text.replace("quaternion: [0.5, 0.5, -0.5, 0.5]", "quaternion: [0.5, 0.5, -0.5, 0.9]"));
    assert!(message.contains("the quaternion has length"), "{message}");
    let message = refused(text.replace("readings: point", "readings: same_point"));
    assert!(message.contains("no instrument"), "{message}");
}

/// What `identify` says of a session whose rows were changed.
fn said_of(change: impl Fn(usize, &mut Vec<String>)) -> String {
    said_with_target("J6", change)
}

/// The same with the target stated on some link.
fn said_with_target(link: &str, change: impl Fn(usize, &mut Vec<String>)) -> String {
    let folder = simulated(&CASES[0], "pose", 160);
    let file = folder.path().join("rows.csv");
    let text = std::fs::read_to_string(&file).unwrap();
    let changed = text.lines().enumerate().map(|(row, line)| {
        let mut fields: Vec<String> = line.split(',').map(String::from).collect();
        change(row, &mut fields);
        fields.join(",")
    });
    let changed: Vec<String> = changed.collect();
    std::fs::write(&file, changed.join("\n") + "\n").unwrap();
    let session = folder.path().join("session.yaml");
    let text = std::fs::read_to_string(&session).unwrap();
    let open: Vec<String> = text
        .lines()
        .map(|line| match line.trim_start().split(':').next() {
            Some("instrument") => "    instrument: {link: b}".to_string(),
            Some("target") => format!("    target: {{link: {link}}}"),
            _ => line.to_string(),
        })
        .collect();
    std::fs::write(&session, open.join("\n")).unwrap();
    let done = fiveaxis(&["identify", session.to_str().unwrap(), "--json"]);
    String::from_utf8_lossy(&done.stdout).into_owned() + &String::from_utf8_lossy(&done.stderr)
}

#[test]
fn rotations_in_another_form_are_named() {
    let says = |change: &dyn Fn(&mut [String]), due: &str| {
        let said = said_of(|row, fields| {
            if row > 0 {
                change(&mut fields[10..14])
            }
        });
        assert!(said.contains(due), "due is '{due}', said was {}", &said[..said.len().min(3000)]);
    };
    says(&|quaternion| quaternion.rotate_left(1), "quaternions have their real part last");
    says(
        &|quaternion| scaled(&mut quaternion[1..], -1.0),
        "rotations are those of the instrument in the target's axes",
    );
}

#[test]
fn a_gauge_with_the_other_sign_or_unit_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let machine =
        "name: trunnion\ncode: \"[wCAbYXZt]\"\naxes:\n  A: {origin: [0, 20, -30]}\n  C: {origin: [10, 0, 0]ERRORS}\n";
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("machine.yaml", &machine.replace("ERRORS", ""));
    write("truth.yaml", &machine.replace("ERRORS", ", errors: {EX0C: 20 um, EY0C: -30 um}"));
    let session = "machine: truth.yaml\ntests:\n  - name: dial\n    readings: displacement\n    recording: rows.csv\n    \
                   instrument: {link: Z, at: [160, 0, 0], direction: [0, 1, 0]}\n    target: {link: C, at: [150, 0, 0]}\n    \
                   positions: {X: 0, Y: 0, Z: 0, A: 0}\n";
    write("truth-session.yaml", session);
    write("session.yaml", &session.replace("truth.yaml", "machine.yaml"));
    // C turns by 0.6 deg: the ball moves by 1.5 mm along y
    let rows: String = (0..60).map(|k| format!("{k},{:.3},0\n", -0.3 + 0.01 * f64::from(k))).collect();
    write("rows.csv", &format!("pose,C_deg,displacement_mm\n{rows}"));
    let truth = load_session(&folder.path().join("truth-session.yaml")).unwrap();
    let read: Vec<f64> = simulate(&truth, Composition::Exact).unwrap()[0].length_mm.clone();
    let said = |factor: f64| {
        let noise = |k: usize| 5e-4 * ((k * 7) % 5) as f64;
        let row = |k: usize| format!("{k},{:.3},{:.7}\n", -0.3 + 0.01 * k as f64, factor * (read[k] + noise(k)));
        write("rows.csv", &format!("pose,C_deg,displacement_mm\n{}", (0..60).map(row).collect::<String>()));
        let file = folder.path().join("session.yaml");
        let done = fiveaxis(&["identify", file.to_str().unwrap(), "--json"]);
        String::from_utf8_lossy(&done.stdout).into_owned()
    };
    assert!(!said(1.0).contains("data fault"));
    assert!(said(-1.0).contains("the displacement of dial has the other sign"));
    assert!(said(1e-3).contains("the displacement of dial is in metres"));
    assert!(said(1e3).contains("the displacement of dial is in µm"));
    // what no chain predicts is as large in every unit
    let rows: String = (0..60)
        .map(|k| format!("{k},0.001,{:.7}\n", 0.3 * (0.7 * f64::from(k)).sin() + 1e-4 * f64::from(k % 3)))
        .collect();
    write("rows.csv", &format!("pose,C_deg,displacement_mm\n{rows}"));
    let done = fiveaxis(&["diagnose", folder.path().join("session.yaml").to_str().unwrap(), "--json"]);
    let text = String::from_utf8_lossy(&done.stdout);
    assert!(!text.contains("convert the column"), "{text}");
}

/// Shift of a point along the x of a target that is turned by a quaternion, w first.
fn along_x([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)]
}

#[test]
fn a_target_that_moved_in_its_nest_is_named_and_found_once_it_has_a_setup_of_its_own() {
    let folder = simulated(&CASES[0], "pose", 160);
    let path = |name: &str| folder.path().join(name);
    let text = std::fs::read_to_string(path("rows.csv")).unwrap();
    let (header, body) = text.split_once('\n').unwrap();
    let moved = |(row, line): (usize, &str)| {
        let mut fields: Vec<String> = line.split(',').map(String::from).collect();
        let shift = along_x(std::array::from_fn(|k| fields[10 + k].parse().unwrap()));
        for k in 0..3 {
            let by = if row < 90 { 0.0 } else { 0.5 * shift[k] };
            // the instrument's noise
            let noise = 0.01 * ((37 * row + 11 * k) % 7) as f64 / 7.0;
            fields[7 + k] = (fields[7 + k].parse::<f64>().unwrap() + by + noise).to_string();
        }
        fields.join(",")
    };
    let lines: Vec<String> = body.lines().enumerate().map(moved).collect();
    let write = |name: &str, lines: &[String]| {
        std::fs::write(path(name), format!("{header}\n{}\n", lines.join("\n"))).unwrap();
    };
    write("rows.csv", &lines);
    let session = |tests: &str| {
        std::fs::write(path("session.yaml"), format!("machine: machine.yaml\nreadings: pose\ntests:\n{tests}"))
            .unwrap();
        let done = fiveaxis(&["identify", path("session.yaml").to_str().unwrap(), "--json"]);
        (done.status.code(), String::from_utf8_lossy(&done.stdout).into_owned())
    };
    let first = "  - {name: a, recording: rows.csv, instrument: {link: b}, target: {link: J6}}\n";
    let (code, said) = session(first);
    assert_eq!(code, Some(3), "{said}");
    assert!(said.contains("the target of test 'a' stands elsewhere from row 91 on"), "{said}");
    assert!(said.contains("mounted-anew"), "{said}");
    write("rows.csv", &lines[..90]);
    write("later.csv", &lines[90..]);
    let second = "  - {name: later, recording: later.csv, instrument: {link: b}, target: {link: J6, setup: second}}\n";
    let (code, said) = session(&format!("{first}{second}"));
    assert!(code == Some(0) && said.contains("\"verdict\": \"fits\""), "{said}");
}

#[test]
fn a_distance_of_sockets_that_the_readings_contradict_is_named_and_one_stated_twice_refused() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/real/sockets-panda/panda-3");
    let folder = tempfile::tempdir().unwrap();
    for file in std::fs::read_dir(&shipped).unwrap() {
        let file = file.unwrap().path();
        std::fs::copy(&file, folder.path().join(file.file_name().unwrap())).unwrap();
    }
    let text = std::fs::read_to_string(shipped.join("session.yaml")).unwrap();
    let said = |text: &str| {
        std::fs::write(folder.path().join("session.yaml"), text).unwrap();
        let done = fiveaxis(&["identify", folder.path().join("session.yaml").to_str().unwrap(), "--json"]);
        (done.status.code(), String::from_utf8_lossy(&done.stdout).into_owned())
    };
    let of_left = |by: &str| {
        let (before, after) = text.split_once("[left-0, left-1], distance: 50").expect("a distance of 50 mm");
        format!("{before}[left-0, left-1], distance: {by}{after}")
    };
    let (code, wrong) = said(&of_left("52"));
    assert!(code == Some(3) && wrong.contains("leaves the distance left-0 to left-1"), "{wrong}");
    assert!(!wrong.contains("\"determined\": true"), "{wrong}");
    let (code, twice) = said(&of_left("50}\n  - {between: [left-1, left-0], distance: 51"));
    assert!(code == Some(2) && twice.contains("is stated twice, 50 mm before"), "{twice}");
    let (code, itself) = said(&of_left("50}\n  - {between: [left-1, left-1], distance: 51"));
    assert!(code == Some(2) && itself.contains("names one socket twice"), "{itself}");
}

#[test]
fn other_links_one_axis_in_radians_and_readings_beside_other_poses_are_named() {
    let said = said_with_target("J5", |_, _| {});
    assert!(said.contains("the target on J5 stands on J6"), "{}", &said[..said.len().min(3000)]);
    let said = said_of(|row, fields| {
        if row > 0 {
            scaled(&mut fields[2..3], std::f64::consts::PI / 180.0)
        }
    });
    assert!(said.contains("J2 is in radians"), "{}", &said[..said.len().min(3000)]);
    let before = std::cell::RefCell::new(Vec::new());
    let said = said_of(|row, fields| {
        if row > 0 {
            let own = fields[1..7].to_vec();
            let last = before.replace(own.clone());
            fields.splice(1..7, if last.is_empty() { own } else { last });
        }
    });
    assert!(said.contains("readings stand one row earlier"), "{}", &said[..said.len().min(3000)]);
}

/// Fields of a row times a factor.
fn scaled(fields: &mut [String], factor: f64) {
    fields.iter_mut().for_each(|field| *field = (field.parse::<f64>().unwrap() * factor).to_string());
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn mistakes_in_columns_and_a_moved_instrument_are_named() {
    let says = |change: &dyn Fn(usize, &mut Vec<String>), due: &str| {
        let said = said_of(change);
        assert!(said.contains(due), "due is '{due}', said was {}", &said[..said.len().min(3000)]);
    };
    says(
        &|row, fields| {
            if row > 0 {
                scaled(&mut fields[7..10], 1e-3)
            }
        },
        "coordinates are in metres",
    );
    says(
        &|row, fields| {
            if row > 0 {
                scaled(&mut fields[1..7], std::f64::consts::PI / 180.0)
            }
        },
        "in radians",
    );
    says(
        &|row, fields| {
            if row > 0 {
                scaled(&mut fields[3..4], -1.0)
            }
        },
        "J3 counts the other way",
    );
    says(
        &|row, fields| {
            if row == 0 {
                fields.swap(2, 3)
            }
        },
        "the columns of J2 and J3 are exchanged",
    );
    says(
        &|row, fields| {
            if row == 0 {
                fields.swap(7, 8)
            }
        },
        "two of the columns x, y and z of the readings are exchanged",
    );
    let shifted = |row: usize, fields: &mut Vec<String>| {
        if row > 90 {
            fields[7] = (fields[7].parse::<f64>().unwrap() + 6.0).to_string();
        }
    };
    says(&shifted, "stands elsewhere from row");
    // what grows, evenly or ever slower, was not moved
    for grown in [|share: f64| share, |share: f64| 1.0 - (-4.0 * share).exp()] {
        let drifting = |row: usize, fields: &mut Vec<String>| {
            if row > 0 {
                fields[7] = (fields[7].parse::<f64>().unwrap() + 0.2 * grown(row as f64 / 160.0)).to_string();
            }
        };
        let said = said_of(drifting);
        assert!(!said.contains("stands elsewhere"), "said was {}", &said[..said.len().min(3000)]);
    }
}

#[test]
fn an_instrument_that_moved_between_tests_is_named_and_doubled_rows_are() {
    let folder = simulated(&CASES[1], "point", 60);
    let (rows, text) = (folder.path().join("rows.csv"), folder.path().join("session.yaml"));
    let (recorded, session) = (std::fs::read_to_string(&rows).unwrap(), std::fs::read_to_string(&text).unwrap());
    let (head, test) = session.split_once("tests:\n").unwrap();
    let (header, body) = recorded.split_once('\n').unwrap();
    let lines: Vec<&str> = body.lines().collect();
    let later: Vec<String> = lines[30..]
        .iter()
        .map(|line| {
            let mut fields: Vec<String> = line.split(',').map(String::from).collect();
            let x = header.split(',').position(|name| name == "x_mm").unwrap();
            fields[x] = (fields[x].parse::<f64>().unwrap() + 0.5).to_string();
            fields.join(",")
        })
        .collect();
    std::fs::write(&rows, format!("{header}\n{}\n", lines[..30].join("\n"))).unwrap();
    std::fs::write(folder.path().join("later.csv"), format!("{header}\n{}\n", later.join("\n"))).unwrap();
    let name = test.split("name: ").nth(1).unwrap().split([',', '\n']).next().unwrap().to_string();
    let second = test.replace(&format!("name: {name}"), "name: later").replace("rows.csv", "later.csv");
    std::fs::write(&text, format!("{head}tests:\n{test}\n{second}")).unwrap();
    let said = |verb: &str| {
        let done = fiveaxis(&[verb, text.to_str().unwrap(), "--json"]);
        (done.status.code(), String::from_utf8_lossy(&done.stdout).into_owned())
    };
    let (code, moved) = said("identify");
    assert_eq!(code, Some(3), "{moved}");
    assert!(moved.contains("the instrument of test 'later' stands elsewhere than before"), "{moved}");
    std::fs::write(&text, &session).unwrap();
    let twice: Vec<String> = lines.iter().flat_map(|line| [line.to_string(), line.to_string()]).collect();
    std::fs::write(&rows, format!("{header}\n{}\n", twice.join("\n"))).unwrap();
    let (_, doubled) = said("identify");
    assert!(doubled.contains("every row stands there twice") || doubled.contains("pose"), "{doubled}");
}

const POSITIONER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/real/positioner");

#[test]
fn coordinates_in_metres_are_told_by_rotations_and_a_sense_that_nothing_fixes_is_open() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["machine.yaml", "session.yaml"] {
        std::fs::copy(Path::new(POSITIONER).join(name), folder.path().join(name)).unwrap();
    }
    let rows = std::fs::read_to_string(Path::new(POSITIONER).join("points.csv")).unwrap();
    let columns: Vec<&str> = rows.lines().next().unwrap().split(',').collect();
    let is_coordinate = |k: usize| ["x_mm", "y_mm", "z_mm"].contains(&columns[k]);
    let in_metres = |line: &str| -> String {
        let fields = line.split(',').enumerate().map(|(k, field)| match field.parse::<f64>() {
            Ok(value) if is_coordinate(k) => format!("{}", 1e-3 * value),
            _ => field.to_string(),
        });
        fields.collect::<Vec<_>>().join(",")
    };
    let identified = |text: &str| {
        std::fs::write(folder.path().join("points.csv"), text).unwrap();
        let done = fiveaxis(&["identify", folder.path().join("session.yaml").to_str().unwrap(), "--json"]);
        serde_json::from_slice::<serde_json::Value>(&done.stdout).unwrap()
    };
    let sound = identified(&rows);
    assert_eq!(sound["verdict"], "fits");
    // tilting the other way, the target and instrument elsewhere, all readings are the same
    let senses = sound["senses"].as_array().unwrap();
    let tilt = senses.iter().find(|sense| sense["axis"] == "J1").unwrap();
    assert_eq!(tilt["told"], false, "{tilt}");
    let metres: Vec<String> = rows.lines().map(in_metres).collect();
    let said = identified(&metres.join("\n"));
    assert_eq!(said["mistake"]["effect"], "unit", "{said}");
    assert!(said["mistake"]["says"].as_str().unwrap().contains("in metres"));
}

/// Machine of the R-test, with location errors or without.
fn trunnion(errors: [&str; 2]) -> String {
    format!(
        "name: trunnion\ncode: \"[wCAbYXZt]\"\ndirections: carried\naxes:\n  A: {{origin: [0, 20, -30]{}}}\n  C: {{origin: [10, 0, 0]{}}}\n",
        errors[0], errors[1]
    )
}

/// An R-test: three coordinates of a ball on the table, seen from the spindle that follows it, with noise of 1 µm. Says what `identify` says
/// of the session with its rows changed.
fn said_of_an_r_test(files: usize, change: impl Fn(usize, [f64; 3]) -> [f64; 3]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let errors = [
        ", errors: {EY0A: 25 um, EZ0A: -18 um, EB0A: 12 arcsec, EC0A: -9 arcsec}",
        ", errors: {EX0C: 14 um, EY0C: -22 um, EA0C: 8 arcsec, EB0C: -15 arcsec}",
    ];
    std::fs::write(path("machine.yaml"), trunnion(errors)).unwrap();
    let (tilts, turns) =
        ((0..13).map(|k| (-90.0 + 10.0 * f64::from(k), 0.0)), (0..24).map(|k| (0.0, 15.0 * f64::from(k))));
    let both = [-60.0, -30.0, 20.0].into_iter().flat_map(|tilt| (0..12).map(move |k| (tilt, 30.0 * f64::from(k))));
    // where the nominal machine carries the ball, by plane trigonometry
    let followed = |(tilt, turn): (f64, f64)| {
        let (c, a) = (turn.to_radians(), tilt.to_radians());
        let (x, y) = (140.0 * c.cos() - 40.0 * c.sin() + 10.0, 140.0 * c.sin() + 40.0 * c.cos() - 20.0);
        let (y, z) = (y * a.cos() - 90.0 * a.sin() + 20.0, y * a.sin() + 90.0 * a.cos() - 30.0);
        format!("{tilt},{turn},{:.4},{:.4},{:.4},0,0,0", x - 150.0, y - 40.0, z - 60.0)
    };
    let rows: Vec<String> = tilts.chain(turns).chain(both).map(followed).collect();
    let mut session = "machine: machine.yaml\nreadings: point\ntests:\n".to_string();
    for file in 0..files {
        let numbered = rows.iter().enumerate().map(|(row, text)| format!("{row},{text}\n"));
        let text = format!("pose,A_deg,C_deg,X_mm,Y_mm,Z_mm,x_mm,y_mm,z_mm\n{}", numbered.collect::<String>());
        std::fs::write(path(&format!("{file}.csv")), text).unwrap();
        write!(
            session,
            "  - name: r{file}\n    recording: {file}.csv\n    instrument: {{link: Z, at: [150, 40, 60], quaternion: [1, 0, 0, 0], spread: 1 mm, turn_spread: 0.02 rad}}\n    target: {{link: C, at: [150, 40, 60], spread: 1 mm}}\n"
        )
        .unwrap();
    }
    std::fs::write(path("session.yaml"), &session).unwrap();
    let text = |name: &str| path(name).to_str().unwrap().to_string();
    let done = fiveaxis(&["simulate", &text("session.yaml"), "--out", &text("out")]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    std::fs::write(path("machine.yaml"), trunnion(["", ""])).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let noise = Normal::new(0.0, 1e-3).unwrap();
    for file in 0..files {
        let read = std::fs::read_to_string(path("out").join(format!("{file}.csv"))).unwrap();
        let changed = read.lines().enumerate().map(|(row, line)| {
            let mut fields: Vec<String> = line.split(',').map(String::from).collect();
            if row > 0 {
                let read = [6, 7, 8].map(|k| fields[k].parse::<f64>().unwrap() + noise.sample(&mut random));
                change(file, read).iter().zip(6..).for_each(|(value, k)| fields[k] = format!("{value:.9}"));
            }
            fields.join(",") + "\n"
        });
        std::fs::write(path(&format!("{file}.csv")), changed.collect::<String>()).unwrap();
    }
    String::from_utf8_lossy(&fiveaxis(&["identify", &text("session.yaml"), "--json"]).stdout).into_owned()
}

#[test]
fn an_r_test_tells_how_its_coordinates_are_held() {
    let sound = said_of_an_r_test(1, |_, read| read);
    assert!(sound.contains("\"fits\"") && sound.contains("do not tell their own sense"), "{sound}");
    let per = |factor: f64| move |_: usize, read: [f64; 3]| read.map(|value| value * factor);
    type Change<'c> = &'c dyn Fn(usize, [f64; 3]) -> [f64; 3];
    let mistakes: [(Change, &str); 7] = [
        (&|_, [x, y, z]| [y, x, z], "the columns x and y of the readings are exchanged"),
        (&|_, [x, y, z]| [x, y, -z], "z of the readings counts the other way"),
        (
            &|_, [x, y, z]| [y, -x, z],
            "turned by 90° about its z against the session: state quaternion: [0.7071, 0.0000, 0.0000, 0.7071]",
        ),
        (
            &|_, [x, y, z]| [x, z, -y],
            "turned by 90° about its x against the session: state quaternion: [0.7071, 0.7071, 0.0000, 0.0000]",
        ),
        (&per(1e-3), "coordinates are in metres"),
        (&per(1e3), "coordinates are in µm"),
        (&per(1.0 / 25.4), "are they in metres or inches?"),
    ];
    for (change, due) in mistakes {
        let said = said_of_an_r_test(1, change);
        assert!(said.contains(due), "due is '{due}', said was {}", &said[..said.len().min(3000)]);
    }
}

#[test]
fn one_file_of_several_that_is_held_otherwise_is_named() {
    type Change<'c> = &'c dyn Fn([f64; 3]) -> [f64; 3];
    let mistakes: [(Change, &str); 3] = [
        (&|read| read.map(|value| -value), "in r1 all coordinates have the other sign"),
        (&|[x, y, z]| [y, x, z], "in r1 the columns x and y of the readings are exchanged"),
        (&|[x, y, z]| [-y, x, z], "in r1 the instrument is turned by -90° about its z"),
    ];
    for (change, due) in mistakes {
        let said = said_of_an_r_test(3, |file, read| if file == 1 { change(read) } else { read });
        assert!(said.contains(due), "due is '{due}', said was {}", &said[..said.len().min(3000)]);
    }
    for (factor, due) in [
        (1e-3, "coordinates of r1 are in metres"),
        (1.0 / 25.4, "coordinates of r1 are in inches"),
        (1e3, "coordinates of r1 are in µm"),
    ] {
        let said = said_of_an_r_test(3, |file, read| if file == 1 { read.map(|value| factor * value) } else { read });
        assert!(said.contains(due), "due is '{due}', said was {}", &said[..said.len().min(3000)]);
    }
}

#[test]
fn a_target_that_was_turned_in_its_nest_is_named() {
    let (sine, cosine) = 0.0026_f64.sin_cos();
    let said = said_of(|row, fields| {
        if row > 0 {
            // the instrument's noise, 10 µm
            let noise = |k: usize| 0.01 * ((37 * row + 11 * k) % 7) as f64 / 7.0;
            (7..10).for_each(|k| fields[k] = (fields[k].parse::<f64>().unwrap() + noise(k)).to_string());
        }
        if row > 90 {
            // by 0.3° about its own x
            let [w, x, y, z]: [f64; 4] = std::array::from_fn(|k| fields[10 + k].parse().unwrap());
            let turned = [w * cosine - x * sine, x * cosine + w * sine, y * cosine + z * sine, z * cosine - y * sine];
            turned.iter().zip(10..).for_each(|(value, k)| fields[k] = value.to_string());
        }
    });
    assert!(said.contains("the target of test 'a' stands elsewhere from row 91 on"), "{said}");
}
