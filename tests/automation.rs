//! What scripts rely on: errors as JSON, exit codes, alarms, silence, standard input, completions and manual pages.

use crate::schema;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

const CHAPTER5: &str = "examples/thesis/chapter5/session.yaml";

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fiveaxis")).args(arguments).output().unwrap()
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|why| {
        panic!("{why}: {}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
    })
}

/// The error of a refusal, which its schema holds.
fn refusal(arguments: &[&str]) -> Value {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("schemas/error.json")).unwrap();
    let (contract, refusal) = (serde_json::from_str(&text).unwrap(), json(&run(arguments)));
    assert_eq!(schema::violations_of(&contract, &refusal), Vec::<String>::new(), "{arguments:?}");
    refusal["error"].clone()
}

#[test]
fn wrong_input_is_an_object_under_json() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("machine.yaml");
    std::fs::write(&file, "name: mill\ncode: \"[wCAbYXZt]\"\naxes:\n  X: {rang: [-300, 300]}\n").unwrap();
    let name = file.to_str().unwrap();
    let output = run(&["check", name, "--json"]);
    assert_eq!(output.status.code(), Some(2));
    let error = refusal(&["check", name, "--json"]);
    assert_eq!((&error["kind"], &error["exit_code"]), (&Value::from("wrong input"), &Value::from(2)));
    assert_eq!((&error["file"], &error["line"]), (&Value::from(name), &Value::from(4)));
    assert!(error["found"].as_str().unwrap().contains("unknown key 'rang'"), "{error}");
    assert!(error["cure"].as_str().unwrap().contains("did you mean 'range'?"), "{error}");
    assert!(error["allowed"].as_str().unwrap().contains("range"), "{error}");
    // the message for people stands on standard error as ever
    assert!(String::from_utf8_lossy(&output.stderr).starts_with("fiveaxis: "));
    let usage = refusal(&["plan", "--margn", "3", "--json"]);
    assert_eq!(usage["exit_code"], 2, "{usage}");
    assert!(usage["message"].as_str().unwrap().contains("--margn"), "{usage}");
}

#[test]
fn a_refusal_names_its_file_and_what_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    // a bar that only stood is of no program of the session
    let rows: String = (0..3000).map(|k| format!("{:.2},{:.1}\n", 0.02 * f64::from(k), f64::from(k % 3))).collect();
    std::fs::write(at("flat.csv"), format!("time_s,deviation_um\n{rows}")).unwrap();
    let axes = "X: {range: [-300, 300]}, Y: {range: [-200, 200]}, Z: {range: [0, 400]}, A: {range: [-90, 20]}, C: {range: [-360, 360]}";
    std::fs::write(at("bare.yaml"), format!("name: bare\ncode: \"[wCAbYXZt]\"\naxes: {{{axes}}}\n")).unwrap();
    let session = "examples/captures/session.yaml";
    let flat = refusal(&["import", &at("flat.csv"), "--session", session, "--out", &at("out"), "--json"]);
    assert_eq!((&flat["file"], &flat["exit_code"]), (&Value::from(at("flat.csv")), &Value::from(3)), "{flat}");
    let bare = refusal(&["plan", &at("bare.yaml"), "--directions", "iso841", "--json"]);
    assert_eq!((&bare["file"], &bare["exit_code"]), (&Value::from(at("bare.yaml")), &Value::from(2)), "{bare}");
    assert!(bare["found"].as_str().unwrap().starts_with("has no 'bodies'"), "{bare}");
    let unknown = refusal(&["diagnose", session, "--fail-on", "foo", "--json"]);
    assert_eq!(unknown["allowed"], "finding, warning", "{unknown}");
}

#[test]
fn exit_codes_tell_alarms() {
    let code = |arguments: &[&str]| run(arguments).status.code();
    assert_eq!(code(&["identify", CHAPTER5, "--fail-on", "warning"]), Some(0));
    // no test of this session tells squareness and table apart from the spindle ball
    assert_eq!(code(&["identify", CHAPTER5, "--free", "all", "--fail-on", "undetermined,warning"]), Some(1));
    let finding = ["diagnose", "examples/gallery/03-lost-motion/session.yaml", "--fail-on", "finding"];
    assert_eq!(code(&finding), Some(1));
}

#[test]
fn every_result_has_a_list_of_warnings() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let out = out.to_str().unwrap();
    let runs: [&[&str]; 4] = [
        &["check", CHAPTER5, "--json"],
        &["identify", CHAPTER5, "--json"],
        &["identify", CHAPTER5, "--method", "chapter5", "--json"],
        &["simulate", CHAPTER5, "--out", out, "--json"],
    ];
    for arguments in runs {
        let output = run(arguments);
        assert!(json(&output)["warnings"].is_array(), "{arguments:?}");
    }
}

#[test]
fn a_session_may_come_from_standard_input() {
    let folder = Path::new(CHAPTER5).parent().unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_fiveaxis"))
        .args(["check", "-", "--json"])
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(&std::fs::read(CHAPTER5).unwrap()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    assert_eq!(json(&output)["session"], json(&run(&["check", CHAPTER5, "--json"]))["session"]);
}

#[test]
fn quiet_keeps_remarks_off_and_errors_on() {
    let loud = run(&["check", "machines/no-such.yaml"]);
    let quiet = run(&["-q", "check", "machines/no-such.yaml"]);
    assert_eq!((loud.stderr, loud.status.code()), (quiet.stderr, quiet.status.code()));
}

#[test]
fn shells_and_manuals_know_every_verb() {
    let text = |arguments: &[&str]| {
        let output = run(arguments);
        assert!(output.status.success(), "{arguments:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    for shell in ["bash", "zsh", "fish"] {
        let script = text(&["completions", shell]);
        assert!(["identify", "diagnose", "fail-on"].iter().all(|word| script.contains(word)), "{shell}");
    }
    let bash = text(&["completions", "bash"]);
    if let Ok(mut child) = Command::new("bash").args(["-n"]).stdin(Stdio::piped()).spawn() {
        child.stdin.take().unwrap().write_all(bash.as_bytes()).unwrap();
        assert!(child.wait().unwrap().success());
    }
    assert!(text(&["man", "identify"]).contains(".TH"));
    let folder = tempfile::tempdir().unwrap();
    text(&["man", "--out", folder.path().join("man1").to_str().unwrap()]);
    assert!(folder.path().join("man1/fiveaxis-identify.1").is_file());
    let output = run(&["man", "identfy"]);
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn the_python_example_reads_the_json() {
    let script = |sessions: &[&str]| {
        Command::new("python3")
            .args(["examples/automation/judge.py", "--program", env!("CARGO_BIN_EXE_fiveaxis"), "--limit", "20"])
            .args(sessions)
            .output()
    };
    let Ok(output) = script(&[CHAPTER5]) else {
        println!("SKIPPED the_python_example_reads_the_json: no python3");
        return;
    };
    let says = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(1), "{says}{}", String::from_utf8_lossy(&output.stderr));
    assert!(says.contains("beyond 20 um: ") && says.contains("EY0C -52."), "{says}");
    let output = script(&["no-such.yaml"]).unwrap();
    let says = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.code() == Some(2) && says.contains("is not there"), "{says}");
}
