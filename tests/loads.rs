//! Loads of weight and speed: moments of links and of branches that only hang on the machine, imbalance, form under sensors, a socket left out.

use std::fmt::Write as _;
use std::path::Path;

use fiveaxis::chain::Chain;
use fiveaxis::effects::{self, Context, EffectError};
use fiveaxis::load::{load_session, machine_from_yaml};
use fiveaxis::machine::{Effect, ParameterValue, Place};
use fiveaxis::report::machine_yaml;
use fiveaxis::session::Session;
use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SEED: u64 = 24_241_124;

const TORSO: &str = "name: torso\nchain: [w, b, T1, T2, A1, t]\naxes:\n\
    \x20 T1: {type: rotary, direction: [0, 0, 1]}\n\
    \x20 T2: {type: rotary, direction: [0, 1, 0], origin: [0, 0, 400]}\n\
    \x20 A1: {type: rotary, direction: [1, 0, 0], origin: [0, 200, 900]}\n\
    carried:\n  - name: left arm\n    on: T2\n    joints:\n\
    \x20     - {name: L1, direction: [0, 1, 0]}\n\
    \x20     - {name: L2, direction: [0, 0, 1], reversed: true}\n";

/// A session of poses on the torso; `columns` are those that the recording has, all angles in degrees.
fn torso(folder: &Path, columns: &[&str], rows: &[Vec<f64>]) -> Session {
    std::fs::write(folder.join("machine.yaml"), TORSO).unwrap();
    let mut text = String::from("pose");
    columns.iter().for_each(|name| write!(text, ",{name}_deg").unwrap());
    text += ",x_mm,y_mm,z_mm";
    for (number, row) in rows.iter().enumerate() {
        write!(text, "\n{number}").unwrap();
        row.iter().for_each(|value| write!(text, ",{value}").unwrap());
        write!(text, ",{},0,0", number * number).unwrap();
    }
    std::fs::write(folder.join("rows.csv"), text + "\n").unwrap();
    let file = folder.join("session.yaml");
    let text = "machine: machine.yaml\nreadings: point\ntests:\n  - name: a\n    recording: rows.csv\n    \
                instrument: {link: b, at: [0, 0, 0], quaternion: [1, 0, 0, 0]}\n    target: {link: A1, at: [300, 200, 900]}\n";
    std::fs::write(&file, text).unwrap();
    load_session(&file).unwrap()
}

fn random_rows(columns: usize) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    (0..20).map(|_| (0..columns).map(|_| random.random_range(-80.0..80.0)).collect()).collect()
}

fn moment(session: &Session, place: &str, load: &str) -> Result<Vec<Vec<f64>>, EffectError> {
    let chain = Chain::of(&session.machine);
    let context = Context::of(session, &chain).unwrap();
    let place = Place::Axis(session.machine.axis_index(place).unwrap());
    let effect = Effect::new("gravity-sag", place)
        .with("load", ParameterValue::Word(load.into()))
        .with("moment", ParameterValue::Word("own".into()));
    let profiles = effects::kind("gravity-sag").unwrap().shape(&context, &effect)?;
    Ok(profiles.into_iter().map(|profile| profile[0].clone()).collect())
}

#[test]
fn moments_of_links_add_up_to_the_torque_of_a_hanging_mass() {
    let folder = tempfile::tempdir().unwrap();
    let rows = random_rows(5);
    let session = torso(folder.path(), &["T1", "T2", "A1", "L1", "L2"], &rows);
    // a mass of weight one; levers fixed in T2, L1 and L2, m
    let levers = [Vector3::new(0.05, 0.2, 0.5), Vector3::new(0.0, 0.3, -0.1), Vector3::new(0.25, 0.02, -0.04)];
    let down = Vector3::new(0.0, 0.0, -1.0);
    let turn = |about: [f64; 3], degrees: f64| Rotation3::new(Vector3::from(about) * degrees.to_radians());
    let torque = |row: &[f64]| {
        let first = turn([0.0, 0.0, 1.0], row[0]);
        let torso = first * turn([0.0, 1.0, 0.0], row[1]);
        let upper = torso * turn([0.0, 1.0, 0.0], row[3]);
        let fore = upper * turn([0.0, 0.0, -1.0], row[4]);
        let lever = torso * levers[0] + upper * levers[1] + fore * levers[2];
        (first * Vector3::y()).dot(&lever.cross(&down))
    };
    let parts: Vec<Vec<Vec<f64>>> =
        ["T2", "L1", "L2"].iter().map(|load| moment(&session, "T2", load).unwrap()).collect();
    for (number, row) in rows.iter().enumerate() {
        let sum: f64 = (0..3).map(|link| (0..3).map(|k| levers[link][k] * parts[link][k][number]).sum::<f64>()).sum();
        let due = torque(row) - torque(&[0.0; 5]);
        assert!((sum - due).abs() < 1e-12, "seed {SEED} row {number}: {sum}, due {due}");
    }
}

#[test]
fn branches_that_only_load_are_written_and_refused() {
    let machine = machine_from_yaml(Path::new("torso.yaml"), TORSO.into()).unwrap();
    let again = machine_from_yaml(Path::new("torso.yaml"), machine_yaml(&machine)).unwrap();
    assert_eq!(machine.carried, again.carried);
    let refused = |from: &str, to: &str| {
        machine_from_yaml(Path::new("torso.yaml"), TORSO.replace(from, to)).expect_err("refused").to_string()
    };
    let message = refused("on: T2", "on: T7");
    assert!(message.contains("'left arm' hangs on 'T7'; allowed are b and T1 T2 A1"), "{message}");
    let message = refused("name: L2", "name: A1");
    assert!(message.contains("joint name 'A1' is taken"), "{message}");

    let folder = tempfile::tempdir().unwrap();
    let session = torso(folder.path(), &["T1", "T2", "A1", "L1"], &random_rows(4));
    assert!(moment(&session, "T2", "L1").is_ok());
    let message = moment(&session, "T2", "L2").expect_err("no column").to_string();
    assert!(message.contains("has no column 'L2_deg'"), "{message}");
    let message = moment(&session, "T2", "L3").expect_err("no link").to_string();
    assert!(message.contains("no link is called 'L3'") && message.contains("L1 L2"), "{message}");
}

/// A rotor under three sensors at 0, 120 and 240 degrees, at a steady speed.
fn rotor(folder: &Path, turns_per_s: f64) -> Session {
    let machine = "name: rotor\nchain: [w, C, b, t]\naxes:\n  C: {direction: [0, 0, 1]}\n";
    std::fs::write(folder.join("machine.yaml"), machine).unwrap();
    let mut rows = String::from("time_s,C_deg,displacement_mm");
    (0..200).for_each(|k| write!(rows, "\n{},{},0", 0.01 * k as f64, 3.6 * turns_per_s * k as f64).unwrap());
    std::fs::write(folder.join("rows.csv"), rows + "\n").unwrap();
    let mut text = String::from("machine: machine.yaml\nreadings: displacement\ntests:\n");
    for degrees in [0.0, 120.0, 240.0_f64] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        write!(
            text,
            "  - name: at-{degrees}\n    recording: rows.csv\n    instrument: {{link: b, at: [{}, {}, 0], direction: [{cosine}, {sine}, 0]}}\n    \
             target: {{link: C, at: [0, 0, 0]}}\n",
            100.0 * cosine,
            100.0 * sine
        )
        .unwrap();
    }
    let file = folder.join("session.yaml");
    std::fs::write(&file, text).unwrap();
    load_session(&file).unwrap()
}

#[test]
fn a_displacement_needs_its_direction() {
    let folder = tempfile::tempdir().unwrap();
    rotor(folder.path(), 1.0);
    let file = folder.path().join("session.yaml");
    let text = std::fs::read_to_string(&file).unwrap();
    let (before, after) = text.split_once(", direction: [").unwrap();
    let (_, after) = after.split_once(']').unwrap();
    std::fs::write(&file, format!("{before}{after}")).unwrap();
    let message = load_session(&file).expect_err("no direction").to_string();
    assert!(message.contains("read along a direction, and none is stated"), "{message}");
}

fn shape(session: &Session, effect: &Effect) -> Vec<Vec<Vec<f64>>> {
    let chain = Chain::of(&session.machine);
    let context = Context::of(session, &chain).unwrap();
    effects::kind(&effect.kind).unwrap().shape(&context, effect).unwrap()
}

#[test]
fn imbalance_grows_with_the_square_and_form_passes_the_sensors_in_turn() {
    let folder = tempfile::tempdir().unwrap();
    let axis = Place::Axis(0);
    let largest = |turns_per_s: f64| {
        let profiles = shape(&rotor(folder.path(), turns_per_s), &Effect::new("imbalance", axis));
        profiles[0][0].iter().fold(0.0_f64, |largest, value| largest.max(value.abs()))
    };
    let [slow, fast] = [0.5, 2.0].map(largest);
    assert!((slow - 0.25).abs() < 1e-9 && (fast - 4.0).abs() < 1e-9, "{slow} {fast}");

    let session = rotor(folder.path(), 1.0);
    let form = Effect::new("surface-form", axis).with("orders", ParameterValue::List(vec![4.0]));
    let profiles = shape(&session, &form);
    for (sensor, degrees) in [0.0, 120.0, 240.0_f64].into_iter().enumerate() {
        for (row, found) in profiles[0][sensor].iter().take(60).enumerate() {
            // where on the part the sensor points: its direction less the turn of the part, 3.6 degrees a row
            let due = (4.0 * (degrees - 3.6 * row as f64).to_radians()).cos();
            assert!((found - due).abs() < 1e-9, "sensor {sensor} row {row}");
        }
    }
}

#[test]
fn imbalance_does_not_follow_what_the_angle_jitters() {
    let folder = tempfile::tempdir().unwrap();
    let mut session = rotor(folder.path(), 1.0);
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    for test in &mut session.tests {
        let angles = &mut test.recording.as_mut().unwrap().positions[0];
        angles.iter_mut().for_each(|angle| *angle += random.random_range(-5e-3..5e-3));
    }
    let profiles = shape(&session, &Effect::new("imbalance", Place::Axis(0)));
    let largest = profiles.iter().flat_map(|p| &p[0]).fold(0.0_f64, |largest, value| largest.max(value.abs()));
    // half a turn takes half a second: 5 mrad at either end are 0.02 rad/s of 2 pi, twice that in the square
    assert!((largest - 1.0).abs() < 0.01, "seed {SEED}: {largest}");
}

#[test]
fn a_mount_drifts_from_the_first_pose_to_the_last() {
    let folder = tempfile::tempdir().unwrap();
    let session = socket(folder.path(), false).unwrap();
    let at = session.tests[0].pivot.at;
    let drift = |link: &str, x: f64| {
        let place = ParameterValue::List(vec![x, at.y, at.z]);
        let effect = Effect::new("mount-drift", Place::Pivot).with("at", place);
        shape(&session, &effect.with("link", ParameterValue::Word(link.into())))[0][0][25]
    };
    assert!((drift("w", at.x) - 25.0 / 39.0).abs() < 1e-12);
    assert_eq!((drift("w", at.x + 1.0), drift("C", at.x)), (0.0, 0.0));
}

/// Poses in which the slides keep a ball on a turned head in its socket; `moved`: from row 26 on in another one, 50 mm away.
fn socket(folder: &Path, moved: bool) -> Result<Session, String> {
    let machine = "name: slides\ncode: \"[wbXYZBCt]\"\naxes:\n  B: {origin: [0, 0, 0]}\n  C: {origin: [0, 0, 0]}\n";
    std::fs::write(folder.join("machine.yaml"), machine).unwrap();
    let mut rows = String::from("pose,X_mm,Y_mm,Z_mm,B_deg,C_deg");
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let ball = Vector3::new(30.0, -20.0, -150.0);
    for row in 0..40 {
        let (b, c): (f64, f64) = (random.random_range(-60.0..60.0), random.random_range(-90.0..90.0));
        let turned = Rotation3::new(Vector3::y() * b.to_radians()) * Rotation3::new(Vector3::z() * c.to_radians());
        let at = Vector3::new(if moved && row >= 25 { 150.0 } else { 100.0 }, 40.0, -80.0) - turned * ball;
        write!(rows, "\n{row},{},{},{},{b},{c}", at.x, at.y, at.z).unwrap();
    }
    std::fs::write(folder.join("rows.csv"), rows + "\n").unwrap();
    let file = folder.join("session.yaml");
    let text = "machine: machine.yaml\nreadings: same_point\ntests:\n  - name: front\n    recording: rows.csv\n    \
                socket: {link: w}\n    target: {link: C}\n";
    std::fs::write(&file, text).unwrap();
    load_session(&file).map_err(|why| why.to_string())
}

#[test]
fn a_socket_left_out_is_told() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(socket(folder.path(), false).map(|session| session.tests.len()), Ok(3));
    let message = socket(folder.path(), true).expect_err("refused");
    assert!(
        message.contains("15 of 40 rows, row 26 the first of them") && message.contains("another socket"),
        "{message}"
    );
}
