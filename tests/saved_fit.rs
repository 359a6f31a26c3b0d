//! `identify --save` writes a folder that stands alone and whose simulation is the fit's prediction.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn fiveaxis(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fiveaxis")).args(arguments).output().unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn lengths(file: &Path) -> Vec<Option<f64>> {
    let text = std::fs::read_to_string(file).unwrap();
    text.lines().skip(1).map(|line| line.rsplit(',').next().unwrap().parse().ok()).collect()
}

fn chapter5() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/thesis/chapter5/session.yaml")
}

/// Root mean square of reading minus prediction over all tests, µm.
fn rms_um(readings: &Path, predictions: &Path) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for entry in std::fs::read_dir(predictions).unwrap() {
        let file = entry.unwrap().path();
        let recorded = lengths(&readings.join(file.file_name().unwrap()));
        for (reading, prediction) in recorded.iter().zip(lengths(&file)) {
            if let (Some(reading), Some(prediction)) = (reading, prediction) {
                sum += ((reading - prediction) * 1e3).powi(2);
                count += 1;
            }
        }
    }
    (sum / f64::from(count)).sqrt()
}

#[test]
fn simulating_a_saved_fit_leaves_the_fit_s_residual() {
    let scratch = tempfile::tempdir().unwrap();
    let (saved, predicted) = (scratch.path().join("saved"), scratch.path().join("predicted"));
    let output = fiveaxis(&["identify", text(&chapter5()), "--json", "--save", text(&saved)]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let output = fiveaxis(&["simulate", text(&saved.join("session.yaml")), "--out", text(&predicted)]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let (rms, fitted) = (rms_um(&saved, &predicted), json["rms_um"].as_f64().unwrap());
    // values are written so that they read back unchanged; positions are those of the same files
    assert!((rms - fitted).abs() < 1e-4, "{rms} for {fitted}");
    // fitting what was fitted changes nothing that matters
    let output = fiveaxis(&["identify", text(&saved.join("session.yaml")), "--json"]);
    let again: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!((again["rms_um"].as_f64().unwrap() - fitted).abs() < 1e-3);
}

#[test]
fn recordings_without_positions_are_saved_with_those_that_were_run() {
    let scratch = tempfile::tempdir().unwrap();
    let plan = scratch.path().join("plan");
    std::fs::create_dir_all(&plan).unwrap();
    std::fs::write(
        plan.join("machine.yaml"),
        "name: mill\ncode: \"[wCAbYXZt]\"\naxes:\n  C: {errors: {EX0C: 20 um, EY0C: -12 um, EA0C: 9 arcsec}}\n  A: {errors: {EZ0A: 15 um}}\n",
    )
    .unwrap();
    let test = |name: &str, path: &str| {
        format!(
            "  - name: {name}\n    bar_length: 100\n    pivot: {{link: C, at: [0, 60, 0]}}\n    spindle_ball: {{link: Z, at: [0, 0, 0]}}\n    positions: {{X: 0, Y: 0, Z: 0, A: 0, C: 0}}\n    recording: {name}.csv\n    {path}\n"
        )
    };
    let paths = [
        ("radial", "sweep: {axis: C, from: 0, to: 360, step: 2, follow: radial}"),
        ("tangential", "sweep: {axis: C, from: 0, to: 360, step: 2, follow: tangential}"),
        ("xy", "circle: {plane: XY, radius: 100, from: 0, to: 360, step: 2}"),
    ];
    // planned first, then recorded as lengths alone along the same paths
    let session = |with_recording: bool| {
        let tests: String = paths.iter().map(|(name, path)| test(name, path)).collect();
        let tests = if with_recording { tests } else { tests.replace("    recording: ", "    # ") };
        format!("machine: machine.yaml\ntests:\n{tests}")
    };
    std::fs::write(plan.join("plan.yaml"), session(false)).unwrap();
    let out = text(&plan);
    let plan_file = plan.join("plan.yaml");
    let simulate = fiveaxis(&["simulate", text(&plan_file), "--out", out, "--draw-setups", "--seed", "3"]);
    assert!(simulate.status.success(), "{}", String::from_utf8_lossy(&simulate.stderr));
    for (name, _) in paths {
        let file = plan.join(format!("{name}.csv"));
        let lengths: Vec<String> = lengths(&file).iter().map(|length| format!("{:.10}", length.unwrap())).collect();
        std::fs::write(&file, format!("length_mm\n{}\n", lengths.join("\n"))).unwrap();
    }
    std::fs::write(plan.join("session.yaml"), session(true)).unwrap();
    let (saved, predicted) = (scratch.path().join("saved"), scratch.path().join("predicted"));
    let output = fiveaxis(&["identify", text(&plan.join("session.yaml")), "--json", "--save", text(&saved)]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(json["rms_um"].as_f64().unwrap() < 0.01, "{}", json["rms_um"]);
    let output = fiveaxis(&["simulate", text(&saved.join("session.yaml")), "--out", text(&predicted)]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    // positions are written to 1e-9 mm
    assert!((rms_um(&saved, &predicted) - json["rms_um"].as_f64().unwrap()).abs() < 1e-4);
}

#[test]
fn a_fit_is_not_saved_over_its_own_input() {
    let scratch = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(chapter5().parent().unwrap()).unwrap() {
        let file = entry.unwrap().path();
        std::fs::copy(&file, scratch.path().join(file.file_name().unwrap())).unwrap();
    }
    let session = scratch.path().join("session.yaml");
    let before = std::fs::read(&session).unwrap();
    let output = fiveaxis(&["identify", text(&session), "--save", text(scratch.path())]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("is an input of this command and is not overwritten"));
    assert_eq!(std::fs::read(&session).unwrap(), before);
}

/// A machine file that holds what was found predicts what changes in the readings: they are believed as before.
#[test]
fn what_was_determined_is_determined_in_the_saved_session_too() {
    let scratch = tempfile::tempdir().unwrap();
    let gallery = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/gallery/07-nothing-wrong/session.yaml");
    for (index, session) in [chapter5(), gallery].iter().enumerate() {
        let saved = scratch.path().join(format!("saved-{index}"));
        let determined = |arguments: &[&str]| -> Vec<(String, bool)> {
            let output = fiveaxis(arguments);
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
            let errors = json["location_errors"].as_object().unwrap();
            errors.iter().map(|(name, error)| (name.clone(), error["determined"].as_bool().unwrap())).collect()
        };
        let before = determined(&["identify", text(session), "--json", "--save", text(&saved)]);
        let after = determined(&["identify", text(&saved.join("session.yaml")), "--json"]);
        assert!(before.iter().filter(|(_, is_so)| *is_so).count() >= 5, "{before:?}");
        assert_eq!(before, after, "{}", session.display());
    }
}
