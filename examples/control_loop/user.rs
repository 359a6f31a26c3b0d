//! The commands of a user, and nothing else: plan, import, diagnose, compensate.

use std::path::{Path, PathBuf};
use std::process::Command;

use fiveaxis::machine::Machine;
use serde_json::Value;

use crate::gauge::{BEGAN_H, DAY};

/// What `diagnose` says.
pub struct Answer {
    json: Value,
    pub noise_um: f64,
}

/// The binary of the same build, or the one that `FIVEAXIS_BIN` names.
fn fiveaxis() -> Command {
    let own = || {
        std::env::current_exe().expect("own place").parent().and_then(Path::parent).expect("target").join("fiveaxis")
    };
    Command::new(std::env::var_os("FIVEAXIS_BIN").map_or_else(own, PathBuf::from))
}

pub fn run(command: &mut Command) -> String {
    let output = command.output().expect("it starts");
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Plans a machine of `machines/`, once.
pub fn planned(machine: &str, folder: &Path) -> PathBuf {
    if !folder.join("session.yaml").is_file() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("machines/{machine}.yaml"));
        run(fiveaxis()
            .arg("plan")
            .arg(file)
            .args(["--feed", "1500", "--circles", "--sigma", "3um,3arcsec", "--out"])
            .arg(folder));
    }
    folder.to_path_buf()
}

/// Imports captures whose programs are known, one by one, and puts the sessions together.
pub fn imported(plan: &Path, captures: &[(String, PathBuf)], folder: &Path) -> PathBuf {
    let mut head = String::new();
    let mut tests = String::new();
    for (program, capture) in captures {
        let part = folder.join(program);
        let test = format!("{program}-ccw");
        let output = fiveaxis()
            .arg("import")
            .arg(capture)
            .args(["--test", &test, "--began", &format!("{DAY} {BEGAN_H:02}:00"), "--force", "--session"])
            .arg(plan.join("session.yaml"))
            .arg("--out")
            .arg(&part)
            .output()
            .expect("it starts");
        if !output.status.success() {
            println!("not placed: {program}: {}", String::from_utf8_lossy(&output.stderr).trim());
            continue;
        }
        let text = std::fs::read_to_string(part.join("session.yaml")).expect("session");
        let (before, list) = text.split_once("tests:\n").expect("a list of tests");
        head = before.replace("machine: ", &format!("machine: {program}/"));
        tests += &list.replace("recording: ", &format!("recording: {program}/"));
    }
    let session = folder.join("session.yaml");
    std::fs::write(&session, format!("{head}tests:\n{tests}")).expect("written");
    session
}

/// Diagnoses a session; the machine as found goes into a folder.
pub fn diagnosed(session: &Path, folder: &Path) -> Answer {
    let text = run(fiveaxis().arg("diagnose").arg(session).args(["--json", "--force", "--save"]).arg(folder));
    let json: Value = serde_json::from_str(&text).expect("JSON");
    let noise_um = json["fit"]["noise_um"].as_f64().unwrap_or(f64::NAN);
    Answer { json, noise_um }
}

/// Identifies location errors from a session.
pub fn identified(session: &Path) -> Answer {
    let text = run(fiveaxis().arg("identify").arg(session).arg("--json"));
    Answer { json: serde_json::from_str(&text).expect("JSON"), noise_um: f64::NAN }
}

/// The planned program with N words, which stay in the corrected one.
pub fn numbered(program: &Path, folder: &Path) -> PathBuf {
    std::fs::create_dir_all(folder).expect("folder");
    let out = folder.join(program.file_name().expect("name"));
    let text = std::fs::read_to_string(program).expect("program");
    let lines = text.lines().enumerate().map(|(k, line)| match line.starts_with('G') {
        true => format!("N{} {line}\n", k + 1),
        false => format!("{line}\n"),
    });
    std::fs::write(&out, lines.collect::<String>()).expect("written");
    out
}

/// A program corrected for the machine as found, with the length that its head tells the operator.
pub fn corrected(program: &Path, plan: &Path, found: &Path, folder: &Path) -> PathBuf {
    std::fs::create_dir_all(folder).expect("folder");
    let out = folder.join(program.file_name().expect("name"));
    let text = std::fs::read_to_string(program).expect("program");
    let told = text.lines().find_map(|line| line.strip_prefix("(gauge length ")?.split(' ').next());
    let said = run(fiveaxis()
        .arg("compensate")
        .arg(program)
        .arg(plan.join("machine.yaml"))
        .arg("--errors")
        .arg(found)
        .args([
            "--initial",
            "G54",
            "--offset",
            "G54:",
            "--tool-length",
            told.expect("a gauge length"),
            "--force",
            "--out",
        ])
        .arg(&out));
    std::fs::write(out.with_extension("txt"), said).expect("written");
    out
}

impl Answer {
    fn findings(&self) -> &[Value] {
        self.json["findings"].as_array().map_or(&[], Vec::as_slice)
    }

    /// Cause and place of the first finding.
    pub fn first(&self) -> String {
        let word = |finding: &Value, key: &str| finding[key].as_str().unwrap_or("?").to_owned();
        self.findings().first().map_or("–".into(), |one| format!("{} ({})", word(one, "effect"), word(one, "place")))
    }

    /// At which rank a cause stands, with the number of findings.
    pub fn rank(&self, name: &str) -> String {
        let count = self.findings().len();
        match self.findings().iter().position(|finding| finding["effect"] == name) {
            Some(rank) => format!("{} of {count}", rank + 1),
            None if name == "none" && count == 0 => "nothing, rightly".into(),
            None => format!("no, {count} told"),
        }
    }

    /// Location errors within two of their standard deviations of the truth, of those that are told.
    pub fn within(&self, truth: &Machine, sigma: &str) -> (usize, usize) {
        let (mut good, mut count) = (0, 0);
        for slot in truth.slots() {
            let told = &self.json["location_errors"][slot.to_string()];
            let value = told["after"].as_f64().or(told["value"].as_f64());
            let (Some(value), Some(sigma)) = (value, told[sigma].as_f64()) else { continue };
            let axis = truth.axis_index(&slot.axis).expect("axis");
            let real = slot.component.measure().to_output(truth.axes[axis].location_errors[slot.component.index()]);
            count += 1;
            good += usize::from((value - real).abs() <= 2.0 * sigma);
        }
        (good, count)
    }
}
