//! Axes that do not come back, concealed in recordings: `diagnose` names them, their place and their size.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// The session of a worm gear, without its physics: C alone, and followed by slides.
const SESSION: &str = "examples/gallery/01-worm-gear";

fn fiveaxis(arguments: &[&str]) -> Vec<u8> {
    let output = Command::new(env!("CARGO_BIN_EXE_fiveaxis")).args(arguments).output().expect("run");
    String::from_utf8_lossy(&output.stderr).lines().for_each(|line| println!("{line}"));
    output.stdout
}

/// Diagnosis of what the default gauge records of the session on a machine with some effects.
fn diagnosed(effects: &str) -> Value {
    let scratch = tempfile::tempdir().expect("folder");
    let own = scratch.path();
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join(SESSION);
    for entry in fs::read_dir(&from).expect("example") {
        let file = entry.expect("entry").path();
        fs::copy(&file, own.join(file.file_name().expect("name"))).expect("copied");
    }
    let machine = own.join("machine.yaml");
    let without = fs::read_to_string(&machine).expect("machine");
    fs::write(&machine, format!("{without}{effects}")).expect("written");
    let text = |name: &str| own.join(name).to_str().expect("path").to_string();
    fiveaxis(&["simulate", &text("session.yaml"), "--out", &text("run"), "--instrument", "default"]);
    for entry in fs::read_dir(own.join("run")).expect("run") {
        let file = entry.expect("entry").path();
        if file.extension().is_some_and(|kind| kind == "csv") {
            fs::copy(&file, own.join(file.file_name().expect("name"))).expect("copied");
        }
    }
    fs::write(&machine, without).expect("written");
    serde_json::from_slice(&fiveaxis(&["diagnose", "--json", &text("session.yaml")])).expect("JSON")
}

/// Names of the session's tests.
fn tests() -> Vec<String> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(SESSION).join("session.yaml");
    let text = fs::read_to_string(file).expect("session");
    text.lines().filter_map(|line| line.trim().strip_prefix("- name: ").map(String::from)).collect()
}

/// The first finding is this, of this size.
fn is_found(json: &Value, (effect, place): (&str, &str), size: f64) {
    let first = &json["findings"][0];
    println!("{first:#}");
    assert_eq!((first["effect"].as_str(), first["place"].as_str()), (Some(effect), Some(place)));
    let (value, sigma) = (first["size"]["value"].as_f64().expect("size"), first["size"]["sigma"].as_f64().expect("σ"));
    assert!((value - size).abs() < 3.0 * sigma, "{value} ± {sigma} for {size}");
    assert!(sigma < value, "{value} ± {sigma}");
}

#[test]
fn a_cage_that_turns_at_its_own_order_is_found() {
    let amplitude = 2.0f64;
    let of = |(k, name): (usize, String)| {
        let (sine, cosine) = (1.7 * k as f64).sin_cos();
        let (a, b) = (amplitude * cosine, amplitude * sine);
        format!(
            "  - {{effect: asynchronous-error-motion, place: C, order: 2.43, tests: [{name}], \
             sizes: {{EXC: {{cos: {a} um, sin: {b} um}}, EYC: {{cos: {b} um, sin: {} um}}}}}}\n",
            -a
        )
    };
    let lines: String = tests().into_iter().enumerate().map(of).collect();
    is_found(&diagnosed(&format!("effects:\n{lines}")), ("asynchronous-error-motion", "C"), amplitude);
}

#[test]
fn a_table_that_stands_elsewhere_from_test_to_test_is_found() {
    let places = [3.0, -5.0, 1.0, 6.0, -2.0, -4.0, 2.0, 5.0, -6.0, 1.5];
    let names = tests();
    let own: Vec<f64> = (0..names.len()).map(|k| places[k % places.len()]).collect();
    let rms = (own.iter().map(|value| value * value).sum::<f64>() / own.len() as f64).sqrt();
    let of = |(name, place): (&String, &f64)| {
        format!("  - {{effect: repeatability, place: C, tests: [{name}], sizes: {{EXC: {place} um}}}}\n")
    };
    let lines: String = names.iter().zip(&own).map(of).collect();
    let json = diagnosed(&format!("effects:\n{lines}"));
    let causes = |finding: &Value| {
        let own = (finding["effect"].to_string(), finding["place"].to_string());
        let rivals = finding["cannot_tell_from"].as_array().expect("rivals").clone();
        let rivals = rivals.iter().map(|one| (one["effect"].to_string(), one["place"].to_string())).collect::<Vec<_>>();
        [vec![own], rivals].concat()
    };
    // a bar that never turns sees the same of another axis
    let named = causes(&json["findings"][0]);
    println!("{named:?}, {rms:.2} µm");
    assert!(named.contains(&("\"repeatability\"".into(), "\"C\"".into())), "{named:?}");
}

#[test]
fn a_bar_that_is_longer_from_a_test_on_is_found() {
    let json = diagnosed("effects:\n  - {effect: bar-change, place: bar, time: 715, sizes: {length: 6 um}}\n");
    is_found(&json, ("bar-change", "bar"), 6.0);
}

#[test]
fn a_slide_that_stands_elsewhere_from_a_moment_on_is_found() {
    let line = "effects:\n  - {effect: axis-shift, place: X, time: 520, return_share: 0.9, return_time: 200, sizes: {EXX: 8 um}}\n";
    let json = diagnosed(line);
    is_found(&json, ("axis-shift", "X"), 8.0);
    // a ball that slips and creeps does nearly the same
    assert_eq!(json["findings"][0]["cannot_tell_from"][0]["effect"], "ball-slip");
}
