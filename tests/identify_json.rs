//! `identify --json` against its schema, and the HTML report: self-contained, complete, never over an input.

use crate::schema as schema_check;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn fiveaxis(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fiveaxis")).args(arguments).output().unwrap()
}

fn root(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn schema() -> Value {
    serde_json::from_str(&std::fs::read_to_string(root("schemas/identify.json")).unwrap()).unwrap()
}

fn check(value: &Value) -> Vec<String> {
    schema_check::violations_of(&schema(), value)
}

#[test]
fn identify_json_holds_what_its_schema_says() {
    for chapter in ["chapter4", "chapter5", "chapter6"] {
        let session = root(&format!("examples/thesis/{chapter}/session.yaml"));
        let output = fiveaxis(&["identify", session.to_str().unwrap(), "--json"]);
        assert!(output.status.success());
        let json: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(check(&json), Vec::<String>::new(), "{chapter}");
        assert_eq!(json["location_errors"].as_object().unwrap().len(), 8);
        // the check itself can fail
        let mut wrong = json.clone();
        wrong["location_errors"]["EX0C"]["unit"] = "mm".into();
        wrong["control"][0]["direction"] = serde_json::json!([0, 1]);
        wrong["further"] = 1.into();
        wrong.as_object_mut().unwrap().remove("rms_um");
        wrong["readings"] = "many".into();
        assert_eq!(check(&wrong).len(), 5, "{:?}", check(&wrong));
    }
}

#[test]
fn every_key_of_the_schema_is_documented() {
    let text = std::fs::read_to_string(root("docs/json.md")).unwrap();
    let schema = schema();
    let mut keys: Vec<&String> = schema["properties"].as_object().unwrap().keys().collect();
    keys.extend(
        schema["properties"]["location_errors"]["additionalProperties"]["properties"].as_object().unwrap().keys(),
    );
    keys.extend(schema["properties"]["control"]["items"]["properties"].as_object().unwrap().keys());
    for key in keys {
        assert!(text.contains(&format!("`{key}`")), "docs/json.md does not name {key}");
    }
}

#[test]
fn the_report_is_one_page_that_needs_nothing_else() {
    let scratch = tempfile::tempdir().unwrap();
    let session = root("examples/thesis/chapter5/session.yaml");
    let output =
        fiveaxis(&["identify", session.to_str().unwrap(), "--report", scratch.path().to_str().unwrap(), "--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    let page = std::fs::read_to_string(scratch.path().join("report.html")).unwrap();
    for outside in ["<script", "<link", "<img", "@import", "url(", "src=", "href="] {
        assert!(!page.contains(outside), "the page holds {outside}");
    }
    // the one address is the name of the SVG namespace
    assert_eq!(page.matches("http").count(), page.matches("http://www.w3.org/2000/svg").count());
    for test in json["tests"].as_array().unwrap() {
        let name = test["name"].as_str().unwrap();
        assert!(page.contains(&format!("<figure id=\"test-{name}\">")), "{name}");
    }
    for name in json["location_errors"].as_object().unwrap().keys() {
        assert!(page.contains(&format!("<th scope=\"row\">{name}</th>")), "{name}");
    }
    assert_eq!(page.matches("<svg ").count(), page.matches("</svg>").count());
    assert!(page.matches("1 division = ").count() == 40 && page.contains("measured") && page.contains("model"));
    let plots = std::fs::read_dir(scratch.path().join("plots")).unwrap().count();
    assert_eq!(plots, 2 * 40);
}

#[test]
fn names_in_the_report_cannot_break_the_page() {
    let scratch = tempfile::tempdir().unwrap();
    let source = root("examples/thesis/chapter5");
    for entry in std::fs::read_dir(&source).unwrap() {
        let file = entry.unwrap().path();
        std::fs::copy(&file, scratch.path().join(file.file_name().unwrap())).unwrap();
    }
    let file = scratch.path().join("session.yaml");
    let text = std::fs::read_to_string(&file).unwrap();
    let text = text
        .replace(
            "name: C600U, chapter 5 (reconstructed by simulation, not measured)",
            "name: \"<script>alert(1)</script> & co\"",
        )
        .replace("name: a-short-ccw-1\n", "name: \"<b>x\\\"y\"\n");
    std::fs::write(&file, text).unwrap();
    let out = scratch.path().join("out");
    let output = fiveaxis(&["identify", file.to_str().unwrap(), "--report", out.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(!page.contains("<script") && !page.contains("<b>") && page.contains("&lt;script&gt;"));
    assert!(out.join("plots/01--b-x-y-polar.svg").is_file());
}
