//! `fiveaxis control` end to end: signs of parameters, the limit, present values, heads component by component.

use crate::recorded;
use std::path::Path;

use assert_cmd::Command;
use fiveaxis::chain::Composition;
use fiveaxis::control::{What, numbers};
use fiveaxis::identify::{Options, axis_lines, identify};
use fiveaxis::load::load_session;
use serde_json::Value;

fn run(arguments: &[&str]) -> (Option<i32>, Value) {
    let output = Command::cargo_bin("fiveaxis")
        .expect("built")
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(arguments)
        .arg("--json")
        .output()
        .expect("run");
    let text = String::from_utf8(output.stdout).expect("text");
    (output.status.code(), serde_json::from_str(&text).expect("JSON"))
}

const SESSION: &str = "examples/thesis/chapter5/session.yaml";

#[test]
fn parameters_have_the_signs_of_the_page_on_controls() {
    // the fit: C's own shift y −52.9 µm, A's y 36.2 µm and z −34.0 µm
    for (control, name, expected) in [
        ("sinumerik", "$TC_CARR16", -52.9),
        ("sinumerik", "$TC_CARR19", 52.9),
        ("sinumerik", "$TC_CARR5", 36.2),
        ("fanuc", "No. 19701", 36.2),
        ("fanuc", "No. 19704", -52.9),
        ("linuxcnc", "xyzac-trt-kins.y-offset", 52.9),
        ("linuxcnc", "xyzac-trt-kins.z-rot-point", -34.0),
        ("linuxcnc", "xyzac-trt-kins.y-rot-point", 36.2 - 52.9),
    ] {
        let (code, value) = run(&["control", SESSION, "--control", control, "--directions", "carried"]);
        assert_eq!(code, Some(0), "{value}");
        let list = value["parameters"].as_array().expect("parameters");
        let found = list.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{name} in {list:?}"));
        assert!((found["add_um"].as_f64().expect("change") - expected).abs() < 0.3, "{name}: {found}");
    }
}

#[test]
fn large_changes_are_refused_and_present_values_added() {
    let said = ["control", SESSION, "--control", "fanuc", "--directions", "carried"];
    let (code, value) = run(&[&said[..], &["--limit", "20"]].concat());
    assert_eq!(code, Some(2));
    assert!(value["error"].to_string().contains("more than the limit of 20"), "{value}");
    let (code, _) = run(&[&said[..], &["--limit", "20", "--force"]].concat());
    assert_eq!(code, Some(0));
    let scratch = tempfile::tempdir().expect("folder");
    let file = scratch.path().join("present.txt");
    std::fs::write(&file, "# now\nNo. 19701 = 0.5\n").expect("written");
    let (code, value) = run(&[&said[..], &["--present", file.to_str().expect("text")]].concat());
    assert_eq!(code, Some(0));
    let list = value["parameters"].as_array().expect("parameters");
    let found = list.iter().find(|one| one["name"] == "No. 19701").expect("19701");
    assert!((found["new_mm"].as_f64().expect("value") - 0.5362).abs() < 3e-4, "{found}");
    std::fs::write(&file, "No. 19701 is 0.5\n").expect("written");
    let (code, value) = run(&[&said[..], &["--present", file.to_str().expect("text")]].concat());
    assert_eq!(code, Some(2));
    assert!(value["error"].to_string().contains("name = value"), "{value}");
}

#[test]
fn a_head_tells_its_pivot_length_and_each_component_that_is_determined() {
    let scratch = tempfile::tempdir().expect("folder");
    let machine = "name: head\ncode: \"[wXYbZCAt]\"\ndirections: iso841\naxes:\n  A: {origin: [0, 0, 200]}\n  C: {origin: [0, 0, 0]}\n";
    std::fs::write(scratch.path().join("machine.yaml"), machine).expect("written");
    let mut session = String::from("machine: machine.yaml\nspread: {spindle_ball: 200 um}\ntests:\n");
    for (name, axis, from, to, pivot) in [
        ("a-side", "A", -60, 60, "[0, 100, 0]"),
        ("a-below", "A", -60, 60, "[0, 0, -100]"),
        ("c-side", "C", -170, 170, "[100, 0, 0]"),
    ] {
        let positions = if axis == "A" { "{X: 0, Y: 0, Z: 0, C: 0}" } else { "{X: 0, Y: 0, Z: 0, A: 30}" };
        session += &format!(
            "  - {{name: {name}, bar_length: 100, pivot: {{link: X, at: {pivot}}}, spindle_ball: {{link: t, at: [0, 0, 0]}}, positions: {positions}, feed: 500, sweep: {{axis: {axis}, from: {from}, to: {to}, step: 1}}}}\n"
        );
    }
    let file = scratch.path().join("session.yaml");
    std::fs::write(&file, session).expect("written");
    let planned = load_session(Path::new(&file)).expect("session");
    // the spindle ball hangs 60 µm lower than stated: a longer pivot
    let mut real = planned.clone();
    real.tests.iter_mut().for_each(|test| test.spindle_ball.at.z -= 0.06);
    let mut traces = fiveaxis::simulate::simulate(&real, Composition::Exact).expect("traces");
    for (trace, own) in
        traces.iter_mut().zip(fiveaxis::simulate::simulate(&planned, Composition::Exact).expect("traces"))
    {
        trace.motion = own.motion;
    }
    let recorded = recorded::recorded(&planned, &traces);
    let fit = identify(&recorded, &Options::default()).expect("fit");
    let lines = axis_lines(&recorded, &fit);
    let list = numbers(&recorded, &fit, &lines);
    let pivot: Vec<_> = list.iter().filter(|number| number.what == What::Pivot).collect();
    let z = pivot.iter().find(|number| number.component == 2).expect("pivot z");
    println!("pivot z {:.2} ± {:.2} µm, determined {}", 1e3 * z.change, 1e3 * z.sigma, z.determined);
    assert!(z.determined && (z.change + 0.06).abs() < 4.0 * z.sigma.max(1e-4), "{z:?}");
    assert!(list.iter().any(|number| matches!(number.what, What::Vector { .. })));
}
