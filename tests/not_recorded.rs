//! Tests that are planned and not recorded yet, and recordings of few readings: fits say nothing that they do not know.

use std::path::Path;
use std::process::Command;

const CHAPTER5: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/thesis/chapter5");

fn identified(folder: &Path) -> serde_json::Value {
    let file = folder.join("session.yaml");
    let arguments = ["identify", file.to_str().unwrap(), "--json"];
    let done = Command::new(env!("CARGO_BIN_EXE_fiveaxis")).args(arguments).output().unwrap();
    serde_json::from_slice(&done.stdout).unwrap()
}

fn copied() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(CHAPTER5).unwrap() {
        let file = entry.unwrap().path();
        std::fs::copy(&file, folder.path().join(file.file_name().unwrap())).unwrap();
    }
    folder
}

#[test]
fn a_planned_test_changes_no_error_of_a_machine_with_backlash() {
    let folder = copied();
    let machine = folder.path().join("machine.yaml");
    let text = std::fs::read_to_string(&machine).unwrap();
    let backlash = "effects:\n  - {effect: rotary-backlash, place: A, sizes: {EAA: 10 arcsec}}\n";
    std::fs::write(&machine, text + backlash).unwrap();
    let recorded = identified(folder.path());
    let session = folder.path().join("session.yaml");
    let text = std::fs::read_to_string(&session).unwrap();
    let planned = "\n  - name: to-come\n    bar_length: 100\n    pivot: {link: C, at: [0, 100, 0]}\n    spindle_ball: {link: Z, at: [0, 0, 0]}\n    \
                   feed: 500\n    started_at: 865\n    sweep: {axis: A, from: 20, to: -10}\n    positions: {X: 0, Y: 0, Z: 0, C: 0}\n";
    std::fs::write(&session, text.trim_end().to_string() + planned).unwrap();
    let with_planned = identified(folder.path());
    assert!(with_planned["warnings"].to_string().contains("'to-come' has no recording"), "{with_planned}");
    for (name, error) in recorded["location_errors"].as_object().unwrap() {
        assert_eq!(error["value"], with_planned["location_errors"][name]["value"], "{name}");
    }
}

#[test]
fn a_dozen_readings_determine_nothing() {
    let folder = copied();
    let session = std::fs::read_to_string(folder.path().join("session.yaml")).unwrap();
    // three readings of each of four tests
    let (head, tests) = session.split_once("\ntests:\n").unwrap();
    let each: Vec<&str> = tests.split("\n  - ").collect();
    let few = [0, each.len() / 4, each.len() / 2, 3 * each.len() / 4].map(|k| each[k].trim_start_matches("  - "));
    std::fs::write(folder.path().join("session.yaml"), format!("{head}\ntests:\n  - {}\n", few.join("\n  - ")))
        .unwrap();
    for entry in std::fs::read_dir(folder.path()).unwrap() {
        let file = entry.unwrap().path();
        if file.extension().is_some_and(|extension| extension == "csv") {
            let text = std::fs::read_to_string(&file).unwrap();
            let lines: Vec<&str> = text.lines().collect();
            let rows = [1, lines.len() / 2, lines.len() - 1].map(|k| lines[k]);
            std::fs::write(&file, format!("{}\n{}\n", lines[0], rows.join("\n"))).unwrap();
        }
    }
    let few = identified(folder.path());
    let errors = few["location_errors"].as_object().unwrap_or_else(|| panic!("{few}"));
    assert!(errors.values().all(|error| error["determined"] == false), "{few}");
    assert!(few["warnings"].to_string().contains("more than unknowns"), "{few}");
}
