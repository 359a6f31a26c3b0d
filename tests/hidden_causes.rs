//! Causes that a session cannot show move its location errors by what `diagnose` says, and its σ holds them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// The four-step design: only A and C turn.
const SESSION: &str = "examples/gallery/08-out-of-sight";

/// Causes that leave no trace in it, as the machine file states them: effect, place, component, size, unit.
const CAUSES: [(&str, &str, &str, f64, &str); 3] = [
    ("rotary-backlash", "A", "EAA", 30.0, "arcsec"),
    ("squareness", "X", "EC0X", 6.0, "arcsec"),
    ("squareness", "X", "EB0X", 6.0, "arcsec"),
];

fn fiveaxis(arguments: &[&str]) -> Vec<u8> {
    let output = Command::new(env!("CARGO_BIN_EXE_fiveaxis")).args(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// Diagnosis of what the default gauge records of the design on its machine, with further lines in the machine file.
fn diagnosed(scratch: &Path, name: &str, effects: &str) -> Value {
    let own = scratch.join(name);
    fs::create_dir(&own).unwrap();
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join(SESSION);
    for entry in fs::read_dir(&from).unwrap() {
        let file = entry.unwrap().path();
        fs::copy(&file, own.join(file.file_name().unwrap())).unwrap();
    }
    let machine = own.join("machine.yaml");
    let without = fs::read_to_string(&machine).unwrap();
    fs::write(&machine, format!("{without}{effects}")).unwrap();
    let run = own.join("run");
    let text = |path: &PathBuf| path.to_str().unwrap().to_string();
    let (session, out) = (text(&own.join("session.yaml")), text(&run));
    fiveaxis(&["simulate", &session, "--out", &out, "--instrument", "default", "--draw-setups"]);
    // whoever reads the recordings does not know of the effect
    for entry in fs::read_dir(&run).unwrap() {
        let file = entry.unwrap().path();
        if file.extension().is_some_and(|kind| kind == "csv") {
            fs::copy(&file, own.join(file.file_name().unwrap())).unwrap();
        }
    }
    fs::write(&machine, without).unwrap();
    serde_json::from_slice(&fiveaxis(&["diagnose", "--json", &text(&own.join("session.yaml"))])).unwrap()
}

/// Shifts of location errors by one unit of a cause, as a diagnosis states them.
fn stated(json: &Value, (effect, place, component, ..): (&str, &str, &str, f64, &str)) -> Vec<(String, f64)> {
    let is_it = |index: &Value| {
        let blind = &json["blind_to"][index.as_u64().unwrap() as usize];
        blind["effect"] == effect && blind["place"] == place && blind["components"][0] == component
    };
    let errors = json["location_errors"].as_object().unwrap().iter();
    let of = |(name, error): (&String, &Value)| {
        let hangs_on = error["hangs_on"].as_array().unwrap();
        let own = hangs_on.iter().find(|one| is_it(&one["blind_to"]))?;
        Some((name.clone(), own["per_unit"].as_f64().unwrap()))
    };
    errors.filter_map(of).collect()
}

#[test]
fn hidden_causes_move_location_errors_by_what_is_stated() {
    let scratch = tempfile::tempdir().unwrap();
    let clean = diagnosed(scratch.path(), "clean", "");
    let value = |json: &Value, name: &str, of: &str| json["location_errors"][name][of].as_f64().unwrap();
    for cause in CAUSES {
        let (effect, place, component, size, unit) = cause;
        let lines =
            format!("effects:\n  - {{effect: {effect}, place: {place}, sizes: {{{component}: {size} {unit}}}}}\n");
        let hidden = diagnosed(scratch.path(), &format!("{effect}-{component}"), &lines);
        assert_eq!(hidden["verdict"], "clean", "{effect} at {place}");
        let shifts = stated(&clean, cause);
        assert!(!shifts.is_empty(), "{effect} at {place} moves nothing");
        for (name, per_unit) in shifts {
            let moved = value(&hidden, &name, "before") - value(&clean, &name, "before");
            // which flank an axis stands on is not known: the sign is open
            let predicted = per_unit * size;
            assert!(
                (moved.abs() - predicted.abs()).abs() < 0.03 * predicted.abs(),
                "{effect} at {place}: {name} by {moved} for {predicted}"
            );
            let sigmas = moved.abs() / value(&hidden, &name, "sigma");
            let before = moved.abs() / value(&hidden, &name, "seen_sigma");
            assert!(sigmas < 6.0, "{effect} at {place}: {name} {moved}, {sigmas} σ ({before} σ without unseen causes)");
        }
    }
}
