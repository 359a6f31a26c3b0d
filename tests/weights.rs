//! Deflection under the weight of the joints beyond: the moments by hand, of an arm, of a branch that hangs on it and of a slide;
//! refused input; and sizes of a simulated arm found again, saved and simulated.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use fiveaxis::chain::Chain;
use fiveaxis::effects::{self, Context};
use fiveaxis::load::{load_machine, load_session, machine_from_yaml};
use fiveaxis::machine::{Effect, ParameterValue, Place};
use fiveaxis::report::machine_yaml;
use fiveaxis::session::Session;
use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SEED: u64 = 26_031_124;
const GRAVITY: f64 = 9.80665;

/// A column, an arm of two links on it and a second arm on its first joint.
const COLUMN: &str = "name: column\nchain: [w, b, Z, J1, J2, J3, J4, t]\naxes:\n\
    \x20 Z: {type: linear, direction: [0, 0, 1], origin: [100, 0, 0]}\n\
    \x20 J1: {type: rotary, direction: [0, 0, 1], origin: [300, 0, 200]}\n\
    \x20 J2: {type: rotary, direction: [0, 1, 0], origin: [300, 0, 500]}\n\
    \x20 J3: {type: rotary, direction: [0, 1, 0], origin: [700, 0, 500]}\n\
    \x20 J4: {type: rotary, direction: [1, 0, 0], origin: [1000, 0, 500]}\n";

const BRANCH: &str = "carried:\n  - name: left arm\n    on: J1\n    joints:\n\
    \x20     - {name: L1, direction: [0, 1, 0], origin: [300, 250, 500]}\n\
    \x20     - {name: L2, direction: [0, 0, 1], origin: [650, 250, 500], reversed: true}\n\
    \x20     - {name: L3, direction: [1, 0, 0], origin: [900, 300, 500]}\n";

/// A session of poses; `columns` are those that the recording has, with their units.
fn poses(folder: &Path, machine: &str, columns: &[&str], rows: &[Vec<f64>]) -> Session {
    std::fs::write(folder.join("machine.yaml"), machine).unwrap();
    let mut text = String::from("pose");
    columns.iter().for_each(|name| write!(text, ",{name}").unwrap());
    text += ",x_mm,y_mm,z_mm";
    for (number, row) in rows.iter().enumerate() {
        write!(text, "\n{number}").unwrap();
        row.iter().for_each(|value| write!(text, ",{value}").unwrap());
        text += ",0,0,0";
    }
    std::fs::write(folder.join("rows.csv"), text + "\n").unwrap();
    let file = folder.join("session.yaml");
    let text = "machine: machine.yaml\nreadings: point\ntests:\n  - name: a\n    recording: rows.csv\n    \
                instrument: {link: b, at: [0, 0, 0], quaternion: [1, 0, 0, 0]}\n    target: {link: J4, at: [1200, 40, 560]}\n";
    std::fs::write(&file, text).unwrap();
    load_session(&file).unwrap()
}

const COLUMNS: [&str; 8] = ["Z_mm", "J1_deg", "J2_deg", "J3_deg", "J4_deg", "L1_deg", "L2_deg", "L3_deg"];

fn random_rows(count: usize, columns: usize) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let mut row = || -> Vec<f64> {
        let mut value =
            |k: usize| if k == 0 { random.random_range(0.0..1500.0) } else { random.random_range(-80.0..80.0) };
        (0..columns).map(|k| f64::round(1e3 * value(k)) / 1e3).collect()
    };
    (0..count).map(|_| row()).collect()
}

fn weight(session: &Session, place: &str) -> Effect {
    Effect::new(effects::WEIGHT_COMPLIANCE.name, Place::Axis(session.machine.axis_index(place).unwrap()))
}

/// Functions of an effect by name.
fn shape(session: &Session, effect: &Effect, function: &str) -> Vec<f64> {
    let chain = Chain::of(&session.machine);
    let context = Context::of(session, &chain).unwrap();
    let kind = effects::kind(&effect.kind).unwrap();
    let index = (kind.functions)(effect).iter().position(|name| name == function).unwrap();
    kind.shape(&context, effect).unwrap()[index][0].clone()
}

#[test]
fn moments_of_an_arm_are_those_of_weights_at_its_joints() {
    let folder = tempfile::tempdir().unwrap();
    let rows = random_rows(20, 5);
    let session = poses(folder.path(), COLUMN, &COLUMNS[..5], &rows);
    // level arm of 0.4 and 0.3 m, a weight at the elbow and one at the wrist
    let shoulder = |row: &[f64]| {
        let (upper, fore) = (row[2].to_radians(), (row[2] + row[3]).to_radians());
        GRAVITY * (2.0 * 0.4 * upper.cos() + 0.3 * fore.cos())
    };
    let elbow = |row: &[f64]| GRAVITY * 0.3 * (row[2] + row[3]).to_radians().cos();
    let under = weight(&session, "J2").with("under", ParameterValue::Word("J3".into()));
    let heavy = weight(&session, "J2").with("masses", ParameterValue::List(vec![2.0, 5.0]));
    let [own, led, heavy] = [weight(&session, "J2"), under, heavy].map(|effect| shape(&session, &effect, "own"));
    let zero = [0.0; 5];
    for (number, row) in rows.iter().enumerate() {
        let near =
            |found: f64, due: f64| assert!((found - due).abs() < 1e-9, "seed {SEED} row {number}: {found}, due {due}");
        near(own[number], shoulder(row) - shoulder(&zero));
        near(led[number], elbow(row) - elbow(&zero));
        let of_masses = |row: &[f64]| 5.0 * elbow(row) + 7.0 * GRAVITY * 0.4 * row[2].to_radians().cos();
        near(heavy[number], of_masses(row) - of_masses(&zero));
    }
}

#[test]
fn a_slide_and_a_joint_bear_all_that_hangs_beyond() {
    let folder = tempfile::tempdir().unwrap();
    let rows = random_rows(20, 8);
    let session = poses(folder.path(), &format!("{COLUMN}{BRANCH}"), &COLUMNS, &rows);
    let turn = |about: [f64; 3], degrees: f64| Rotation3::new(Vector3::from(about) * degrees.to_radians());
    let (y, z) = ([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    // levers in metres, of the two arms from the line of J1
    let levers = |row: &[f64]| {
        let shoulder = Vector3::new(0.0, 0.0, 0.3);
        let elbow = shoulder + turn(y, row[2]) * Vector3::new(0.4, 0.0, 0.0);
        let wrist = elbow + turn(y, row[2] + row[3]) * Vector3::new(0.3, 0.0, 0.0);
        let first = Vector3::new(0.0, 0.25, 0.3);
        let second = first + turn(y, row[5]) * Vector3::new(0.35, 0.0, 0.0);
        let third = second + turn(y, row[5]) * turn(z, -row[6]) * Vector3::new(0.25, 0.05, 0.0);
        [shoulder, elbow, wrist, first, second, third].map(|lever| turn(z, row[1]) * lever)
    };
    let down = Vector3::new(0.0, 0.0, -GRAVITY);
    let of_joint = |row: &[f64]| levers(row).map(|lever| lever.cross(&down)).into_iter().sum::<Vector3<f64>>();
    // the slide is 0.2 m before J1 and bears that one too
    let of_slide = |row: &[f64]| of_joint(row) + 7.0 * Vector3::new(0.2, 0.0, 0.2).cross(&down);
    let tilt = ["x", "y"].map(|about| shape(&session, &weight(&session, "J1"), about));
    let slide = weight(&session, "Z").with("middle", ParameterValue::Number(400.0));
    let column = ["x", "yh", "yhh"].map(|function| shape(&session, &slide, function));
    let zero = [0.0; 8];
    for (number, row) in rows.iter().enumerate() {
        let near =
            |found: f64, due: f64| assert!((found - due).abs() < 1e-9, "seed {SEED} row {number}: {found}, due {due}");
        near(tilt[0][number], (of_joint(row) - of_joint(&zero)).x);
        near(tilt[1][number], (of_joint(row) - of_joint(&zero)).y);
        near(column[0][number], (of_slide(row) - of_slide(&zero)).x);
        for (function, power) in [(1, 1), (2, 2)] {
            let of = |row: &[f64]| of_slide(row).y * ((row[0] - 400.0) / 1e3).powi(power);
            near(column[function][number], of(row) - of(&zero));
        }
    }
}

#[test]
fn weights_without_a_lever_or_of_another_number_are_refused() {
    let file = Path::new("column.yaml");
    let with =
        |branch: &str, effect: &str| format!("{COLUMN}{branch}effects:\n  - {{effect: weight-compliance, {effect}}}\n");
    let own = "place: J2, sizes: {EBJ2: {own: 2 arcsec/Nm}}";
    let machine = machine_from_yaml(file, with(BRANCH, own)).unwrap();
    let again = machine_from_yaml(file, machine_yaml(&machine)).unwrap();
    assert_eq!((machine.carried, machine.effects), (again.carried, again.effects));
    let refused = |text: String| machine_from_yaml(file, text).expect_err("refused").to_string();
    let bare = BRANCH.replace(", origin: [650, 250, 500]", "");
    let tilt = "place: J1, sizes: {EAJ1: {x: 2 arcsec/Nm}}";
    for (text, due) in [
        (with(&bare, tilt), "joint 'L2' of 'left arm' under 'carried' hangs beyond J1 and has no origin"),
        (with("", &own.replace("place: J2", "place: J2, under: J7")), "under: no rotary axis is called 'J7'"),
        (
            with("", &own.replace("place: J2", "place: J2, masses: [1, 2, 3]")),
            "masses: 3 are stated, 2 rotary joints are beyond J2",
        ),
        (with("", "place: J2, middle: 0, sizes: {EBJ2: {y: 2 arcsec/Nm}}"), "middle: only a slide has it"),
        (with("", "place: Z, sizes: {EBZ: {y: 2 arcsec/Nm}}"), "a slide needs the key 'middle'"),
        (with("", "place: Z, middle: 0, under: J2, sizes: {EBZ: {y: 2 arcsec/Nm}}"), "leave it out at a slide"),
        (with("", "place: J4, sizes: {own: 2 arcsec/Nm}"), "weight-compliance cannot sit at 'J4'"),
        (with(&BRANCH.replace("[650, 250, 500]", "[650, .nan, 500]"), tilt), "'NaN' is not a finite number"),
    ] {
        let message = refused(text);
        assert!(message.contains(due), "{message}\ndue: {due}");
    }
    // where nothing needs the lever the branch may stand without
    machine_from_yaml(file, with(&bare, own)).unwrap();
}

fn run(arguments: &[&str]) {
    let output = Command::new(env!("CARGO_BIN_EXE_fiveaxis")).args(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Points of a recording, mm.
fn points(file: &Path) -> Vec<[f64; 3]> {
    let text = std::fs::read_to_string(file).unwrap();
    let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let columns = ["x_mm", "y_mm", "z_mm"].map(|name| header.iter().position(|other| *other == name).unwrap());
    let of_row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        columns.map(|column| cells[column].parse().unwrap())
    };
    text.lines().skip(1).map(of_row).collect()
}

#[test]
fn joints_that_yield_to_weight_are_found_again_and_predict() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let rows = random_rows(160, 5);
    // a tendon leads the moment of the elbow to the shoulder, and the column bends
    let sizes = "effects:\n\
        \x20 - {effect: weight-compliance, place: J3, sizes: {EBJ3: {own: 60 arcsec/Nm}}}\n\
        \x20 - {effect: weight-compliance, place: J2, under: J3, sizes: {EBJ2: {own: -50 arcsec/Nm}}}\n\
        \x20 - {effect: weight-compliance, place: Z, middle: 750, sizes: {EXZ: {y: 30 um/Nm, yh: 20 um/Nm}, EYZ: {x: -30 um/Nm, xh: -20 um/Nm}}}\n";
    poses(folder.path(), &format!("{COLUMN}{sizes}"), &COLUMNS[..5], &rows);
    run(&["simulate", &path("session.yaml"), "--out", &path("sim")]);
    let truth = points(&folder.path().join("sim/rows.csv"));
    let mut random = ChaCha8Rng::seed_from_u64(SEED + 1);
    let mut text = String::from("pose,") + &COLUMNS[..5].join(",") + ",x_mm,y_mm,z_mm";
    for (number, (row, point)) in rows.iter().zip(&truth).enumerate() {
        write!(text, "\n{number}").unwrap();
        row.iter().for_each(|value| write!(text, ",{value}").unwrap());
        for value in point {
            // a fourth of the rows is kept back
            let noise: f64 = (0..12).map(|_| random.random_range(-0.5..0.5)).sum();
            let reading = if number % 4 == 3 { String::new() } else { format!("{:.5}", value + 0.03 * noise) };
            write!(text, ",{reading}").unwrap();
        }
    }
    std::fs::write(folder.path().join("rows.csv"), text + "\n").unwrap();
    std::fs::write(folder.path().join("machine.yaml"), COLUMN).unwrap();
    run(&["diagnose", &path("session.yaml"), "--save", &path("saved")]);
    let saved = load_machine(&folder.path().join("saved/machine.yaml")).unwrap();
    let found = |place: &str, under: Option<&str>| {
        let place = Place::Axis(saved.axis_index(place).unwrap());
        let under = under.map(|name| ParameterValue::Word(name.into()));
        let is_it = |effect: &&Effect| {
            effect.kind == effects::WEIGHT_COMPLIANCE.name
                && effect.place == place
                && effect.parameter("under") == under.as_ref()
        };
        let of = |effect: &Effect| effect.sizes.iter().find(|size| size.function == "own").map(|size| size.value);
        saved.effects.iter().filter(is_it).find_map(of).unwrap_or_default().to_degrees() * 3600.0
    };
    for (due, is) in [(60.0, found("J3", None)), (-50.0, found("J2", Some("J3")))] {
        assert!((is - due).abs() < 10.0, "{is} arcsec/Nm for {due}\n{}", machine_yaml(&saved));
    }
    run(&["simulate", &path("saved/session.yaml"), "--out", &path("again")]);
    let again = points(&folder.path().join("again/rows.csv"));
    let off = |k: usize| (0..3).map(|c| (again[k][c] - truth[k][c]).powi(2)).sum::<f64>();
    let hidden: Vec<f64> = (0..rows.len()).filter(|k| k % 4 == 3).map(off).collect();
    let rms = (hidden.iter().sum::<f64>() / hidden.len() as f64).sqrt();
    // noise of a reading is 0.03 mm in each direction
    assert!(rms < 0.05, "rows kept back are off by {rms} mm\n{}", machine_yaml(&saved));
}
