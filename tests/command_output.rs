//! What verbs say to a terminal and to a pipe: nobody listening is no failure, what is left unchecked is told.

use std::path::Path;
use std::process::{Command, Stdio};

fn machine(name: &str) -> String {
    format!("{}/machines/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn fiveaxis(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fiveaxis"));
    command.current_dir(folder).args(arguments);
    command
}

fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = fiveaxis(folder, arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn every_verb_ends_quietly_when_nobody_reads() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mill = machine("hermle-c600u.yaml");
    succeeds(folder, &["plan", &mill, "--method", "chapter5", "--out", "plan"]);
    succeeds(folder, &["simulate", "plan/session.yaml", "--out", "plan"]);
    let runs: Vec<Vec<&str>> = vec![
        vec!["plan", &mill],
        vec!["plan", &mill, "--json"],
        vec!["plan", &mill, "--out", "again"],
        vec!["clearance", "plan/session.yaml"],
        vec!["clearance", "plan/session.yaml", "--json"],
        vec!["check", &mill],
        vec!["check", "plan/session.yaml", "--json"],
        vec!["identify", "plan/session.yaml"],
        vec!["identify", "plan/session.yaml", "--json"],
        vec!["diagnose", "plan/session.yaml"],
        vec!["simulate", "plan/session.yaml", "--out", "other"],
        vec!["survey", "--code", "[wCAbYXZt]", "--out", "survey"],
        vec!["survey", "--code", "[wCAbYXZt]", "--out", "survey", "--json"],
        vec!["--help"],
        vec!["plan", "--help"],
    ];
    for arguments in runs {
        // the reading end is gone before the program starts: its first line meets a broken pipe
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = fiveaxis(folder, &arguments).stdout(Stdio::from(writer)).output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), error.as_ref()), (Some(0), ""), "{arguments:?}");
    }
    // what was asked for on disk is there nevertheless
    for file in ["again/session.yaml", "other/c-100-1-ccw.csv", "survey/survey.csv"] {
        assert!(folder.join(file).is_file(), "{file}");
    }
}

#[test]
fn a_refusal_that_nobody_reads_keeps_its_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let status = fiveaxis(folder.path(), &["plan", "none.yaml"]).stderr(Stdio::from(writer)).status().unwrap();
    assert_eq!(status.code(), Some(2));
}

#[test]
fn bodies_that_touch_at_zero_are_told_by_plan_and_clearance() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mill = std::fs::read_to_string(machine("hermle-c600u.yaml")).unwrap();
    // a stop on the bed that stands in the cradle arm with all axes at zero
    let stop = "bodies:\n  - {name: stop, link: Y, box: {at: [195, 0, -65], size: [20, 20, 20]}}\n";
    let planted = mill.replacen("bodies:\n", stop, 1);
    assert_ne!(mill, planted);
    std::fs::write(folder.join("mill.yaml"), planted).unwrap();
    let told = |text: &str| {
        let note = text.lines().find(|line| line.starts_with("note: not checked against each other"));
        note.is_some_and(|note| note.contains("stop – cradle arm right"))
    };
    let plan = succeeds(folder, &["plan", "mill.yaml", "--method", "chapter5", "--out", "plan"]);
    assert!(told(&plan), "{plan}");
    assert!(told(&succeeds(folder, &["clearance", "plan/session.yaml"])));
    let plain = succeeds(folder, &["plan", &machine("hermle-c600u.yaml"), "--method", "chapter5"]);
    assert!(!told(&plain));
}

#[test]
fn a_plan_takes_the_meshes_of_its_machine_along() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mill = std::fs::read_to_string(machine("hermle-c600u.yaml")).unwrap();
    let lamp = "bodies:\n  - {name: lamp, link: b, mesh: {file: parts/lamp.obj, at: [400, 0, 0]}}\n";
    std::fs::create_dir(folder.join("parts")).unwrap();
    let obj = "v 0 0 0\nv 40 0 0\nv 0 40 0\nv 0 0 40\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n";
    std::fs::write(folder.join("parts/lamp.obj"), obj).unwrap();
    std::fs::write(folder.join("mill.yaml"), mill.replacen("bodies:\n", lamp, 1)).unwrap();
    succeeds(folder, &["plan", "mill.yaml", "--method", "chapter5", "--out", "plan"]);
    assert!(succeeds(folder, &["clearance", "plan/session.yaml"]).contains("a-100-1-ccw"));
}
