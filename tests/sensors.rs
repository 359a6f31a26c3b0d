//! Displacement sensors about a turning part: positions that were read with noise, sensors of different scales, what is found unstated.

use std::fmt::Write as _;
use std::path::Path;

use fiveaxis::chain::Composition;
use fiveaxis::diagnose::{as_found, diagnose};
use fiveaxis::identify::{Options, identify};
use fiveaxis::load::load_session;
use fiveaxis::session::Session;
use fiveaxis::simulate::simulate;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SEED: u64 = 24_301_130;
const ECCENTRIC_MM: [f64; 2] = [0.45, -0.70];

/// What is wrong with the readings of a rotor.
#[derive(Clone, Copy)]
struct Wrong {
    /// Scatter of the angle that is written, degrees rms, and whether the part turned so.
    scatter_deg: f64,
    is_real: bool,
    /// Scale of each sensor.
    gains: [f64; 3],
    /// What each reads of a part in the middle, mm.
    zero_mm: f64,
    /// How the part turns over time, and whether its angle is counted from 0 to 360 degrees.
    turns_deg: fn(f64) -> f64,
    is_folded: bool,
}

const RIGHT: Wrong = Wrong {
    scatter_deg: 0.0,
    is_real: false,
    gains: [1.0; 3],
    zero_mm: 10.0,
    turns_deg: |time_s| 120.0 * time_s,
    is_folded: false,
};

/// One run of an eccentric part under three sensors, 100 readings a second, 2 µm of noise; all in one file.
fn rotor(folder: &Path, wrong: Wrong) -> Session {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let mut normal = move || (0..12).map(|_| random.random_range(-0.5..0.5)).sum::<f64>();
    std::fs::write(
        folder.join("machine.yaml"),
        "name: rotor\nchain: [w, C, b, t]\ndirections: carried\naxes:\n  C: {direction: [0, 0, 1]}\n",
    )
    .unwrap();
    let sensors = [0.0, 120.0, 240.0_f64];
    let mut text = String::from("time_s,C_deg,first_mm,second_mm,third_mm,temperature_degC\n");
    for row in 0..1500 {
        let time_s = 0.01 * row as f64;
        let even = (wrong.turns_deg)(time_s);
        let off = wrong.scatter_deg * normal();
        let turned = (even + if wrong.is_real { off } else { 0.0 }).to_radians();
        let written = if wrong.is_folded { (even + off).rem_euclid(360.0) } else { even + off };
        write!(text, "{time_s:.2},{written:.3}").unwrap();
        for (sensor, gain) in sensors.iter().zip(wrong.gains) {
            let [x, y] = ECCENTRIC_MM;
            let (sine, cosine) = turned.sin_cos();
            let at = [cosine * x - sine * y, sine * x + cosine * y];
            let along = at[0] * sensor.to_radians().cos() + at[1] * sensor.to_radians().sin();
            write!(text, ",{:.5}", wrong.zero_mm + gain * along + 0.002 * normal()).unwrap();
        }
        text += ",20.0\n";
    }
    std::fs::write(folder.join("run.csv"), text).unwrap();
    let mut text = String::from("machine: machine.yaml\nreadings: displacement\ntests:\n");
    for (sensor, name) in sensors.iter().zip(["first", "second", "third"]) {
        let (sine, cosine) = sensor.to_radians().sin_cos();
        writeln!(
            text,
            "  - name: {name}\n    recording: run.csv\n    columns: {{displacement_mm: {name}_mm}}\n    \
             instrument: {{link: b, direction: [{cosine:.6}, {sine:.6}, 0], setup: {name}}}\n    target: {{link: C}}"
        )
        .unwrap();
    }
    let file = folder.join("session.yaml");
    std::fs::write(&file, text).unwrap();
    load_session(&file).unwrap()
}

#[test]
fn zeros_of_sensors_and_the_eccentricity_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let session = rotor(folder.path(), RIGHT);
    for test in &session.tests {
        let off = [test.spindle_ball.at.x - ECCENTRIC_MM[0], test.spindle_ball.at.y - ECCENTRIC_MM[1]];
        assert!(off.iter().all(|off| off.abs() < 1e-3), "{off:?}");
        assert!((test.pivot.at.norm() - 10.0).abs() < 1e-3, "{}", test.pivot.at);
        assert_eq!(test.recording.as_ref().unwrap().scatter, None);
    }
}

#[test]
fn an_angle_that_is_read_with_noise_does_not_flatten_the_eccentricity() {
    let folder = tempfile::tempdir().unwrap();
    let session = rotor(folder.path(), Wrong { scatter_deg: 1.5, ..RIGHT });
    for test in &session.tests {
        let scatter = test.recording.as_ref().unwrap().scatter.expect("scatter").by.to_degrees();
        assert!((scatter - 1.5).abs() < 0.1, "{scatter}");
    }
    let fit = identify(&session, &Options { free: None, prior: None }).unwrap();
    // 2 µm of the sensors, 1.5 degrees over some hundred rows: 0.3 degrees of 0.83 mm
    assert!(fit.rms_mm < 6e-3, "{}", fit.rms_mm);
    let at = session.tests[0].spindle_ball.at;
    assert!((at.norm() - 0.832).abs() < 0.01, "{at}");
}

#[test]
fn an_angle_that_the_part_turned_by_stays_as_it_was_read() {
    let folder = tempfile::tempdir().unwrap();
    let session = rotor(folder.path(), Wrong { scatter_deg: 1.5, is_real: true, ..RIGHT });
    assert!(session.tests.iter().all(|test| test.recording.as_ref().unwrap().scatter.is_none()));
}

#[test]
fn steps_and_ripples_are_no_scatter_however_coarse_the_positions() {
    let folder = tempfile::tempdir().unwrap();
    // half a degree, and rest; a ripple of 3 Hz: positions to 0.001 degrees, which readings do not follow
    let steps = |time_s: f64| 0.5 * (2.0 * time_s).floor() + 0.5 * (10.0 * (2.0 * time_s).fract()).min(1.0);
    let ripple = |time_s: f64| 10.0 * time_s + 0.3 * (18.85 * time_s).sin();
    for turns_deg in [steps as fn(f64) -> f64, ripple as fn(f64) -> f64] {
        let session = rotor(folder.path(), Wrong { turns_deg, ..RIGHT });
        assert!(session.tests.iter().all(|test| test.recording.as_ref().unwrap().scatter.is_none()));
        let fit = identify(&session, &Options { free: None, prior: None }).unwrap();
        assert!(fit.rms_mm < 3e-3, "{}", fit.rms_mm);
    }
}

#[test]
fn an_angle_that_starts_anew_at_a_whole_turn_scatters_no_more() {
    let folder = tempfile::tempdir().unwrap();
    let session = rotor(folder.path(), Wrong { scatter_deg: 1.5, is_folded: true, ..RIGHT });
    let scatter = session.tests[0].recording.as_ref().unwrap().scatter.expect("scatter").by.to_degrees();
    assert!((scatter - 1.5).abs() < 0.1, "{scatter}");
    let fit = identify(&session, &Options { free: None, prior: None }).unwrap();
    assert!(fit.rms_mm < 6e-3, "{}", fit.rms_mm);
}

#[test]
fn readings_that_are_kept_back_do_not_change_what_the_others_say_of_scatter() {
    let folder = tempfile::tempdir().unwrap();
    rotor(folder.path(), Wrong { scatter_deg: 1.5, ..RIGHT });
    let file = folder.path().join("run.csv");
    let text = std::fs::read_to_string(&file).unwrap();
    let kept_back = |(row, line): (usize, &str)| {
        let mut fields: Vec<&str> = line.split(',').collect();
        if row > 0 && (row / 50) % 4 == 0 {
            fields[2..5].fill("");
        }
        fields.join(",") + "\n"
    };
    std::fs::write(&file, text.lines().enumerate().map(kept_back).collect::<String>()).unwrap();
    let session = load_session(&folder.path().join("session.yaml")).unwrap();
    assert!(session.tests.iter().all(|test| test.recording.as_ref().unwrap().scatter.is_some()));
}

#[test]
fn a_sensor_that_reads_too_much_is_named_and_what_is_saved_predicts_its_readings() {
    let folder = tempfile::tempdir().unwrap();
    // sensors are zeroed at a pose, or not
    for (zero_mm, gain) in [(10.0, 1.2), (0.0, 1.2), (0.0, 1.6)] {
        let session = rotor(folder.path(), Wrong { gains: [1.0, gain, 1.0], zero_mm, ..RIGHT });
        let diagnosis = diagnose(&session, &Options { free: None, prior: None }).unwrap();
        let first = &diagnosis.findings.first().expect("a finding").cause;
        assert_eq!(first.effect, "sensor-gain", "{:?}", diagnosis.findings);
        let saved = as_found(&session, &diagnosis).unwrap();
        for (test, trace) in session.tests.iter().zip(simulate(&saved, Composition::Exact).unwrap()) {
            let read = &test.recording.as_ref().unwrap().length_mm;
            let off = read.iter().zip(&trace.length_mm).map(|(read, predicted)| (read - predicted).powi(2));
            let rms_mm = (off.sum::<f64>() / read.len() as f64).sqrt();
            assert!(rms_mm < 3e-3, "zero {zero_mm} gain {gain}: {} is off by {rms_mm}", test.name);
        }
    }
}

#[test]
fn sensors_of_one_file_are_written_into_one_file() {
    let folder = tempfile::tempdir().unwrap();
    rotor(folder.path(), Wrong { scatter_deg: 1.5, ..RIGHT });
    let out = folder.path().join("out");
    let run = std::process::Command::new(env!("CARGO_BIN_EXE_fiveaxis"))
        .arg("simulate")
        .arg(folder.path().join("session.yaml"))
        .arg("--out")
        .arg(&out)
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let written = std::fs::read_to_string(out.join("run.csv")).unwrap();
    let read = std::fs::read_to_string(folder.path().join("run.csv")).unwrap();
    let names = |text: &str| text.lines().next().map(|line| line.split(',').map(str::to_string).collect::<Vec<_>>());
    let (found, due) = (names(&written).unwrap(), names(&read).unwrap());
    assert!(due.iter().all(|name| found.contains(name)), "{found:?}");
    let session = load_session(&folder.path().join("session.yaml")).unwrap();
    let predicted = simulate(&session, Composition::Exact).unwrap();
    for (name, trace) in ["first_mm", "second_mm", "third_mm"].iter().zip(&predicted) {
        let column = found.iter().position(|other| other == name).unwrap();
        let of_row = |line: &str| line.split(',').nth(column).unwrap().parse::<f64>().unwrap();
        let off = written.lines().skip(1).map(of_row).zip(&trace.length_mm).map(|(found, due)| (found - due).abs());
        assert!(off.fold(0.0, f64::max) < 1e-9, "{name}");
    }
}

#[test]
fn sensors_of_one_file_were_read_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let session = rotor(folder.path(), RIGHT);
    assert!(!session.states_no_times());
    let after = session.one_after_the_other();
    assert!(after.tests.iter().all(|test| test.started_at_s == 0.0));
}
