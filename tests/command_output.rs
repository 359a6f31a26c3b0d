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
fn bodies_that_overlap_at_zero_are_refused_with_both_ways_out() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mill = std::fs::read_to_string(machine("hermle-c600u.yaml")).unwrap();
    // a stop on the bed that stands in the cradle arm with all axes at zero
    let stop = "bodies:\n  - {name: stop, link: Y, box: {at: [195, 0, -65], size: [20, 20, 20]}}\n";
    let planted = mill.replacen("bodies:\n", stop, 1);
    assert_ne!(mill, planted);
    std::fs::write(folder.join("mill.yaml"), planted).unwrap();
    let message = "mill.yaml: bodies overlap with all axes at zero: stop – cradle arm right by 45.0 mm; mend their places and sizes, or, where a bearing or guideway joins them, write 'touching: [[stop, cradle arm right]]'";
    assert!(refused(folder, &["plan", "mill.yaml", "--method", "chapter5"]).contains(message));
    assert!(succeeds(folder, &["check", "mill.yaml"]).contains("OVERLAP with all axes at zero"));
    // listed, the pair is left out, and JSON says so
    let listed = std::fs::read_to_string(folder.join("mill.yaml")).unwrap();
    let listed = listed.replacen("touching:\n", "touching:\n  - [stop, cradle arm right]\n", 1);
    std::fs::write(folder.join("mill.yaml"), listed).unwrap();
    let json = succeeds(folder, &["plan", "mill.yaml", "--method", "chapter5", "--out", "plan", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["touching"][0], serde_json::json!(["stop", "cradle arm right"]));
    // taken out of the plan's own machine file again, clearance refuses as plan does
    let text = std::fs::read_to_string(folder.join("plan/machine.yaml")).unwrap();
    std::fs::write(folder.join("plan/machine.yaml"), text.replacen("  - [stop, cradle arm right]\n", "", 1)).unwrap();
    assert!(refused(folder, &["clearance", "plan/session.yaml"]).contains("overlap with all axes at zero: stop"));
}

const LAMP_OBJ: &str = "v 0 0 0\nv 40 0 0\nv 0 40 0\nv 0 0 40\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n";

/// Writes `mill.yaml`, a C600U with a lamp whose mesh is `parts/lamp.obj`.
fn write_mill_with_lamp(folder: &Path) {
    let mill = std::fs::read_to_string(machine("hermle-c600u.yaml")).unwrap();
    let lamp = "bodies:\n  - {name: lamp, link: b, mesh: {file: parts/lamp.obj, at: [400, 0, 0]}}\n";
    std::fs::create_dir(folder.join("parts")).unwrap();
    std::fs::write(folder.join("parts/lamp.obj"), LAMP_OBJ).unwrap();
    std::fs::write(folder.join("mill.yaml"), mill.replacen("bodies:\n", lamp, 1)).unwrap();
}

#[test]
fn a_plan_takes_the_meshes_of_its_machine_along() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_mill_with_lamp(folder);
    succeeds(folder, &["plan", "mill.yaml", "--method", "chapter5", "--out", "plan"]);
    assert!(succeeds(folder, &["clearance", "plan/session.yaml"]).contains("a-100-1-ccw"));
}

/// Standard error of a command that ends with exit code 2.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = fiveaxis(folder, arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

/// Every file below a folder with its content.
fn content(folder: &Path) -> std::collections::BTreeMap<std::path::PathBuf, Vec<u8>> {
    let mut found = std::collections::BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(content(&path));
        } else {
            found.insert(path.clone(), std::fs::read(&path).unwrap());
        }
    }
    found
}

#[test]
fn plan_leaves_files_alone_that_no_plan_wrote() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["session.yaml", "machine.yaml", "nc/own.nc"] {
        let own = folder.path().join(name.replace(['/', '.'], "-"));
        std::fs::create_dir_all(own.join(name).parent().unwrap()).unwrap();
        std::fs::write(own.join(name), "name: mine\n").unwrap();
        let before = content(&own);
        let mill = machine("hermle-c600u.yaml");
        let said = refused(folder.path(), &["plan", &mill, "--method", "chapter5", "--out", own.to_str().unwrap()]);
        let top = name.split('/').next().unwrap();
        assert!(said.contains(&own.join(top).display().to_string()) && said.contains("another folder"), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
        assert_eq!(content(&own), before);
    }
}

#[test]
fn plan_leaves_sheets_and_meshes_alone_that_no_plan_wrote() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_mill_with_lamp(folder);
    for (name, own) in [("setup-sheet.html", "<!doctype html><p>mine"), ("parts/lamp.obj", "v 1 1 1\n")] {
        let out = folder.join(name.replace(['/', '.'], "-"));
        std::fs::create_dir_all(out.join(name).parent().unwrap()).unwrap();
        std::fs::write(out.join(name), own).unwrap();
        let before = content(&out);
        let said = refused(folder, &["plan", "mill.yaml", "--method", "chapter5", "--out", out.to_str().unwrap()]);
        assert!(said.contains(&out.join(name).display().to_string()) && said.contains("another folder"), "{said}");
        assert_eq!(content(&out), before);
    }
    // its own ones it replaces, also where the mesh has changed since; a copy of the mesh is in nobody's way
    std::fs::create_dir_all(folder.join("plan/parts")).unwrap();
    std::fs::write(folder.join("plan/parts/lamp.obj"), LAMP_OBJ).unwrap();
    succeeds(folder, &["plan", "mill.yaml", "--method", "chapter5", "--out", "plan"]);
    std::fs::write(folder.join("parts/lamp.obj"), LAMP_OBJ.replace("40", "50")).unwrap();
    succeeds(folder, &["plan", "mill.yaml", "--method", "chapter5", "--out", "plan"]);
    assert_eq!(std::fs::read_to_string(folder.join("plan/parts/lamp.obj")).unwrap(), LAMP_OBJ.replace("40", "50"));
    // a plan without tests leaves a sheet alone, which the next one may replace
    let said = refused(folder, &["plan", "mill.yaml", "--margin", "500", "--out", "none"]);
    assert!(said.contains("no test can be planned"), "{said}");
    succeeds(folder, &["plan", "mill.yaml", "--method", "chapter5", "--out", "none"]);
}

#[test]
fn a_new_plan_replaces_the_programs_of_the_former_one() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mill = machine("hermle-c600u.yaml");
    let plan = |method: &str, out: &str| {
        succeeds(folder, &["plan", &mill, "--method", method, "--out", out]);
        let files = content(&folder.join(out));
        let shorter = |(file, text): (std::path::PathBuf, Vec<u8>)| {
            (file.strip_prefix(folder.join(out)).unwrap().to_path_buf(), text)
        };
        files.into_iter().map(shorter).collect::<std::collections::BTreeMap<_, _>>()
    };
    let (first, second) = (plan("chapter5", "plan"), plan("chapter6", "alone"));
    assert!(first.keys().any(|file| !second.contains_key(file)), "the plans share all names");
    assert_eq!(plan("chapter6", "plan"), second);

    // files that the head does not list stay, and so do files that it lists elsewhere
    let hand = folder.join("plan/nc/linuxcnc/by-hand.ngc");
    std::fs::write(&hand, "M2").unwrap();
    std::fs::write(folder.join("elsewhere.nc"), "M2").unwrap();
    let session = folder.join("plan/session.yaml");
    let text = std::fs::read_to_string(&session).unwrap().replacen("\n", "\n# nc/../../elsewhere.nc\n", 1);
    std::fs::write(&session, text).unwrap();
    plan("chapter5", "plan");
    assert!(hand.is_file() && folder.join("elsewhere.nc").is_file());

    // a plan without tests leaves nothing to run
    std::fs::remove_file(&hand).unwrap();
    refused(folder, &["plan", &mill, "--margin", "500", "--out", "plan"]);
    let left: Vec<_> = content(&folder.join("plan")).into_keys().collect();
    // the list of what was written stands beside it
    assert_eq!(left, [folder.join("plan/.fiveaxis-files"), folder.join("plan/setup-sheet.html")]);
    assert!(!folder.join("plan/nc").exists());
    plan("chapter5", "plan");
}

#[test]
fn programs_stop_spindle_and_coolant_before_the_operator_and_say_their_state() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    succeeds(folder, &["plan", &machine("hermle-c600u.yaml"), "--method", "chapter5", "--out", "plan"]);
    let mut seen = 0;
    for (file, text) in content(&folder.join("plan/nc")) {
        // the generic dialect is in capitals
        let text = String::from_utf8(text).unwrap();
        let at = |word: &str| text.lines().position(|line| line.split(' ').any(|found| found == word));
        let stop = at("M0").unwrap();
        assert!(at("M5").is_some_and(|line| line < stop) && at("M9").is_some_and(|line| line < stop), "{text}");
        assert!(text.to_lowercase().contains("positions in "), "{text}");
        match file.extension().and_then(|ending| ending.to_str()) {
            Some("ngc") => assert!(text.contains("\nG64 P0.001 Q0 "), "{text}"),
            Some("mpf") => assert!(text.contains("\nG641 ADIS=0.001\n"), "{text}"),
            // nothing is measured in a dry run
            Some("h") if !file.ends_with("dry-run.h") => assert!(text.contains(" gauge length "), "{text}"),
            _ => {}
        }
        seen += 1;
    }
    assert!(seen >= 8 && seen % 4 == 0, "{seen}");
}

#[test]
fn clearance_tells_where_a_limit_cuts_a_run_in() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mill = machine("hermle-c600u.yaml");
    succeeds(folder, &["plan", &mill, "--method", "chapter5", "--out", "plan"]);
    let said = |text: &str| text.lines().filter(|line| line.contains("the limit of")).map(String::from).collect();
    let cut = |overshoot: &str| -> (Vec<String>, Vec<serde_json::Value>) {
        let session = std::fs::read_to_string(folder.join("plan/session.yaml")).unwrap();
        let longer = session.replace("overshoot: 4", &format!("overshoot: {overshoot}"));
        std::fs::write(folder.join("plan/longer.yaml"), longer).unwrap();
        let text = succeeds(folder, &["clearance", "plan/longer.yaml"]);
        let json = succeeds(folder, &["clearance", "plan/longer.yaml", "--json"]);
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        let tests = json["tests"].as_array().unwrap().iter();
        (said(&text), tests.flat_map(|test| test["run_in_cut"].as_array().unwrap().clone()).collect())
    };
    assert_eq!(cut("4"), (vec![], vec![]));
    // the tilt runs -110...30 deg: 40 deg before and after a sweep of about -70...20 deg are more than it has left
    let (lines, cuts) = cut("40");
    assert_eq!(lines.len(), cuts.len());
    assert!(!cuts.is_empty());
    let tilt = fiveaxis::load::load_machine(&std::path::PathBuf::from(&mill)).unwrap();
    let (low, high) = tilt.axes[tilt.axis_index("A").unwrap()].range.unwrap();
    for (cut, line) in cuts.iter().zip(&lines) {
        assert_eq!(cut["axis"], "A");
        let [wanted, limit] = ["wanted", "limit"].map(|key| cut[key].as_f64().unwrap());
        let nearest = if wanted < 0.0 { low.to_degrees() } else { high.to_degrees() };
        assert!((limit - nearest).abs() < 1e-3 && wanted.abs() > limit.abs(), "{cut}");
        assert!(line.contains(&format!("at A {limit:?}")) && line.contains(&format!("not at {wanted:?}")), "{line}");
    }
}
