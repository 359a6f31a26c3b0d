//! The ten codes of the thesis's Table 1.1 through check, plan, clearance, simulate, identify, diagnose and survey, as a user runs them.
//!
//! One of the ten by default, all with `FIVEAXIS_TESTS=all`.

use crate::shipped;
use std::path::Path;
use std::process::Command;

use serde_json::Value;
use shipped::TABLE_1_1;

/// Standard output of a run that must end with 0.
fn run(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_fiveaxis")).args(arguments).output().expect("runs");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {message}");
    String::from_utf8(output.stdout).expect("UTF-8")
}

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&run(&[arguments, &["--json"]].concat())).expect("JSON")
}

fn goes_through_all(file: &Path, code: &str) {
    let machine = file.to_str().expect("UTF-8");
    let folder = tempfile::tempdir().expect("folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_string();
    let text = run(&["check", machine]);
    assert!(text.contains(code), "{text}");

    let plan = json(&["plan", machine, "--out", &path("setups")]);
    let errors = plan["location_errors"].as_object().expect("errors");
    assert_eq!(errors.len(), 8, "{code}: {:?}", errors.keys());
    for (name, error) in errors {
        let has_reason = error["reason"].as_str().is_some_and(|reason| !reason.is_empty());
        assert!(error["determined"] == true || has_reason, "{code} {name}: {error}");
    }

    let session = path("setups/session.yaml");
    let clearance = json(&["clearance", &session]);
    // null: nothing near
    let least = clearance["tests"].as_array().expect("tests").iter().filter_map(|test| test["clearance_mm"].as_f64());
    assert!(least.fold(f64::INFINITY, f64::min) > 4.9, "{code}: {clearance}");

    run(&["simulate", &session, "--out", &path("setups"), "--instrument", "default", "--draw-setups", "--seed", "11"]);
    let fit = json(&["identify", &session]);
    for (name, error) in errors {
        let fitted = &fit["location_errors"][name];
        assert_eq!(fitted["determined"], error["determined"], "{code} {name}");
        // the machine has none
        let off = fitted["value"].as_f64().unwrap() / fitted["sigma"].as_f64().unwrap();
        assert!(off.abs() < 4.0, "{code} {name}: {off:.1} sigma");
    }
    let diagnosis = json(&["diagnose", &session]);
    assert_eq!(diagnosis["findings"].as_array().map(Vec::len), Some(0), "{code}: {}", diagnosis["findings"]);

    let survey = json(&["survey", "--code", code, "--out", &path("survey")]);
    assert!(survey.to_string().contains(code), "{code}: {survey}");
}

#[test]
fn every_code_goes_through_all_verbs() {
    // a head and a table in one
    let sample = if shipped::is_thorough() { &TABLE_1_1[..] } else { &TABLE_1_1[9..] };
    for code in sample {
        let file = shipped::machine_of(code);
        goes_through_all(&file, code);
        println!("{code} {}", file.display());
    }
}
