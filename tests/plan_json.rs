//! The JSON of `plan` against its schema, on every shipped machine and for every kind of plan.

use crate::schema;
use crate::shipped;
use std::path::{Path, PathBuf};
use std::process::Command;

use rayon::prelude::*;
use serde_json::Value;
use shipped::some_machines;

fn root(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn contract() -> Value {
    serde_json::from_str(&std::fs::read_to_string(root("schemas/plan.json")).unwrap()).unwrap()
}

fn planned(machine: &Path, further: &[&str]) -> Value {
    let run =
        Command::new(env!("CARGO_BIN_EXE_fiveaxis")).arg("plan").arg(machine).arg("--json").args(further).output();
    let run = run.unwrap();
    let json: Value = serde_json::from_slice(&run.stdout).unwrap();
    // where tests are wanted and there is none, there is no plan
    let has_tests = !json["tests"].as_array().unwrap().is_empty();
    let code = if has_tests || json["goal_reached"] == true { 0 } else { 2 };
    assert_eq!(run.status.code(), Some(code), "{}", String::from_utf8_lossy(&run.stderr));
    json
}

#[test]
fn plans_of_shipped_machines_hold_what_the_schema_says() {
    let schema = contract();
    some_machines(2, 8).par_iter().for_each(|file| {
        let json = planned(file, &[]);
        assert_eq!(schema::violations_of(&schema, &json), Vec::<String>::new(), "{}", file.display());
        assert!(!json["tests"].as_array().unwrap().is_empty());
        // the sum and its parts: runs of both directions cannot take longer than the plan
        let runs: f64 = json["tests"].as_array().unwrap().iter().map(|test| test["minutes"].as_f64().unwrap()).sum();
        assert!(runs > 0.0 && runs < json["minutes"].as_f64().unwrap());
    });
}

#[test]
fn circles_index_methods_and_empty_plans_hold_it_too() {
    let schema = contract();
    let machine = root("machines/hermle-c600u.yaml");
    for further in [
        &["--circles", "--index-spindle"][..],
        &["--method", "chapter5"],
        &["--minutes", "5"],
        &["--sigma", "4um,1arcsec"],
        &["--follow", "none", "--pivots", "1"],
    ] {
        let json = planned(&machine, further);
        assert_eq!(schema::violations_of(&schema, &json), Vec::<String>::new(), "{further:?}");
        for test in json["tests"].as_array().unwrap() {
            assert!(test["sweep"].is_object() != test["circle"].is_object(), "{test}");
        }
    }
}

#[test]
fn a_plan_with_an_indexed_spindle_keeps_its_time() {
    let json = planned(&root("machines/hermle-c600u.yaml"), &["--minutes", "20", "--index-spindle"]);
    assert!(!json["tests"].as_array().unwrap().is_empty());
    assert!(json["minutes"].as_f64().unwrap() <= 20.0, "{}", json["minutes"]);
}

#[test]
fn the_schema_refuses_what_is_not_in_the_contract() {
    let mut wrong = planned(&root("machines/hermle-c600u.yaml"), &["--method", "chapter5"]);
    wrong["minutes"] = "thirty".into();
    wrong["tests"][0]["sweep"]["follow"] = "sideways".into();
    wrong["tests"][0]["pivot"]["at"] = vec![1.0, 2.0].into();
    wrong["tests"][1].as_object_mut().unwrap().remove("clearance_mm");
    wrong["location_errors"]["EX0C"]["unit"] = "mm".into();
    wrong["further"] = 1.into();
    let found = schema::violations_of(&contract(), &wrong);
    assert_eq!(found.len(), 6, "{found:?}");
}
