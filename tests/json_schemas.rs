//! The JSON of every verb against its schema, and both against docs/json.md. `identify`, `diagnose` and `plan` have tests of their
//! own over many sessions.

use crate::schema;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

const CHAPTER5: &str = "examples/thesis/chapter5/session.yaml";
const HERMLE: &str = "machines/hermle-c600u.yaml";

fn root(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn contract(verb: &str) -> Value {
    let file = root(&format!("schemas/{verb}.json"));
    let text = std::fs::read_to_string(&file).unwrap_or_else(|why| panic!("{}: {why}", file.display()));
    serde_json::from_str(&text).unwrap()
}

fn run(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_fiveaxis"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(arguments)
        .output()
        .unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// A verb's answer, which its schema holds.
fn held(arguments: &[&str]) -> Value {
    let json: Value = serde_json::from_str(&run(&[arguments, &["--json"]].concat())).unwrap();
    assert_eq!(schema::violations_of(&contract(arguments[0]), &json), Vec::<String>::new(), "{arguments:?}");
    json
}

#[test]
fn machines_and_sessions() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    held(&["check", CHAPTER5]);
    held(&["check", HERMLE, "--at", "A=30,C=-45"]);
    held(&["check", "machines/table-1-1-head-head-ba.yaml"]);
    let code = ["--code", "[wCAXbYZt]", "--travels", "650,520,475", "--nose-to-table", "110..585", "--table", "320"];
    let rest = ["--tilt-above-table", "-60", "--range", "A=-120..30", "--directions", "iso841"];
    held(&[&["init", &at("mill.yaml")], &code[..], &rest[..]].concat());
    let simulated = held(&["simulate", CHAPTER5, "--out", &at("traces"), "--instrument", "default", "--draw-setups"]);
    assert!(!simulated["tests"].as_array().unwrap().is_empty());
    let plan = ["--method", "chapter5", "--out"];
    run(&[&["plan", HERMLE], &plan[..], &[at("plan").as_str()]].concat());
    let clear = held(&["clearance", &format!("{}/session.yaml", at("plan")), "--tolerance", "1"]);
    assert!(!clear["tests"].as_array().unwrap().is_empty());
    let surveyed = held(&["survey", "--code", "[wCAbYXZt]", "--out", &at("survey")]);
    assert_eq!(surveyed["topologies"], 1);
}

#[test]
fn answers_used() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    for aim in [&["--tip", "30,-20,15", "--tool-axis", "0.3,0.2,0.9"][..], &["--tip", "0,0,0", "--tool-axis", "0,0,1"]]
    {
        let inverse = held(&[&["inverse", HERMLE], aim].concat());
        assert!(!inverse["solutions"].as_array().unwrap().is_empty());
    }
    held(&["inverse", HERMLE, "--at", "X=12.5,Y=-30,Z=44,A=-61,C=-100"]);
    let machine = "examples/thesis/chapter5/machine.yaml";
    let part = ["--errors", CHAPTER5, "--part=-100,-100,0,100,100,80", "--poses", "200"];
    let fitted = held(&[&["volume", machine], &part[..]].concat());
    assert!(fitted["sigma"].is_object() && fitted["left_by_the_fit"].is_object());
    assert!(held(&["volume", machine, "--poses", "200"])["sigma"].is_null());
    for control in ["linuxcnc", "heidenhain", "sinumerik", "fanuc"] {
        held(&["control", CHAPTER5, "--control", control, "--directions", "carried"]);
    }
    let erring = std::fs::read_to_string(root("examples/captures/machine.yaml")).unwrap();
    let erring = erring.replace("A: {origin: [0, 0, 0]", "A: {origin: [0, 0, 0], errors: {EY0A: 30 um}");
    std::fs::write(at("erring.yaml"), erring).unwrap();
    let program = "examples/captures/programs/a-100-1.ngc";
    let (errors, offset) = (at("erring.yaml"), ["--initial", "G54", "--offset", "G54:", "--tolerance", "1"]);
    let words = ["compensate", program, "examples/captures/machine.yaml", "--errors", &errors, "--out"];
    let corrected = held(&[&words[..], &[&at("corrected.ngc")], &offset[..]].concat());
    assert!(!corrected["largest_changes"].as_array().unwrap().is_empty());
}

#[test]
fn captures_months_and_methods() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let session = "examples/captures/session.yaml";
    let imported = held(&["import", "examples/captures/a-100-1.csv", "--session", session, "--out", &at("imported")]);
    assert_eq!(imported["captures"].as_array().unwrap().len(), 1);
    for month in ["2026-01-10", "2026-02-10", "2026-03-10"] {
        let to = folder.path().join("months").join(month);
        std::fs::create_dir_all(&to).unwrap();
        for entry in std::fs::read_dir(root("examples/thesis/chapter5")).unwrap() {
            let file = entry.unwrap().path();
            if file.is_file() {
                std::fs::copy(&file, to.join(file.file_name().unwrap())).unwrap();
            }
        }
    }
    assert_eq!(held(&["history", &at("months")])["sessions"].as_array().unwrap().len(), 3);
    let chapters = [4, 5, 6].map(|chapter| format!("examples/thesis/published/chapter{chapter}.yaml"));
    held(&["reconcile", &chapters[0], &chapters[1], &chapters[2]]);
}

/// Verbs that answer in JSON, as their help says.
fn verbs_with_json() -> Vec<String> {
    let help = run(&["--help"]);
    let commands = help.split("Commands:").nth(1).expect("commands").lines().skip(1);
    commands
        .take_while(|line| !line.is_empty())
        .filter_map(|line| line.strip_prefix("  ").filter(|rest| !rest.starts_with(' ')))
        .filter_map(|rest| rest.split_whitespace().next())
        .filter(|verb| *verb != "help" && run(&[verb, "--help"]).contains("--json"))
        .map(String::from)
        .collect()
}

#[test]
fn every_verb_has_a_schema_and_every_key_is_explained() {
    let docs = std::fs::read_to_string(root("docs/json.md")).unwrap();
    let verbs = verbs_with_json();
    assert!(verbs.len() >= 15, "{verbs:?}");
    for verb in verbs {
        let keys = contract(&verb)["properties"].as_object().expect("keys").clone();
        let heading = format!("# `fiveaxis {verb} --json`\n");
        // diagnosis has a page of its own
        let Some(section) = docs.split(&heading).nth(1) else {
            assert_eq!(verb, "diagnose", "docs/json.md has no section on {verb}");
            continue;
        };
        let section = section.split("\n# ").next().unwrap();
        for key in keys.keys().filter(|key| *key != "warnings") {
            assert!(section.contains(&format!("`{key}`")), "docs/json.md does not explain `{key}` of {verb}");
        }
    }
}

#[test]
fn a_wrong_answer_is_seen() {
    let mut json = held(&["inverse", HERMLE, "--tip", "30,-20,15", "--tool-axis", "0.3,0.2,0.9"]);
    json["tip_mm"] = Value::from(3);
    json["complete"] = Value::from("yes");
    json["solutions"][0].as_object_mut().unwrap().remove("outside");
    json["more"] = Value::from(1);
    let found = schema::violations_of(&contract("inverse"), &json);
    assert_eq!(found.len(), 4, "{found:?}");
}
