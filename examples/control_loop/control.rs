//! Programs on LinuxCNC: traces of what its planner commanded.

use std::path::{Path, PathBuf};
use std::process::Command;

use fiveaxis::machine::{AxisKind, Machine};

use crate::exact;

/// A trace takes longer than this only if the control stands, s of its clock: now and then it misses that it was resumed.
const MOST_SECONDS: f64 = 400.0;
/// A plan's programs dwell at least so long, s.
const SHORTEST_DWELL_S: f64 = 0.5;
/// Dwells of a trace may be off by this, s.
const LATE_S: f64 = 0.05;
/// Tries of a program before the run ends.
const TRIES: usize = 8;

/// What drives the axes, and the folder of its traces.
pub struct Control {
    /// The reference data's script; `None` drives programs exactly.
    script: Option<PathBuf>,
    traces: PathBuf,
}

impl Control {
    /// If LinuxCNC and the script are there.
    pub fn found(traces: &Path) -> Option<Control> {
        let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
        let script = std::env::var_os("FIVEAXIS_SHARED").map_or_else(beside, PathBuf::from).join("control-loop/run");
        let path = std::env::var_os("PATH")?;
        let is_there = std::env::split_paths(&path).any(|folder| folder.join("linuxcnc").is_file());
        (is_there && script.is_file()).then(|| Control { script: Some(script), traces: traces.to_path_buf() })
    }

    /// Without LinuxCNC: axes go exactly where the program says.
    pub fn exact(traces: &Path) -> Control {
        Control { script: None, traces: traces.to_path_buf() }
    }

    /// Runs a program, once for each folder of traces.
    pub fn trace(&self, folder: &str, machine: &Machine, program: &Path) -> PathBuf {
        let folder = self.traces.join(folder);
        std::fs::create_dir_all(&folder).expect("folder");
        let trace = folder.join(format!("{}.csv", name_of(program)));
        // of the same program, not of another correction
        let beside = trace.with_extension("ngc");
        let text = std::fs::read(program).expect("program");
        if trace.is_file() && std::fs::read(&beside).is_ok_and(|other| other == text) {
            return trace;
        }
        let Some(script) = &self.script else {
            exact::trace(machine, program, &trace);
            std::fs::write(&beside, &text).expect("written");
            return trace;
        };
        let rotary: String =
            machine.axes.iter().filter(|axis| axis.kind == AxisKind::Rotary).map(|axis| axis.name.as_str()).collect();
        // the script wants the letters in their order
        let rotary: String = ["AB", "AC", "BC"]
            .into_iter()
            .find(|pair| pair.chars().all(|letter| rotary.contains(letter)))
            .expect("two rotary axes")
            .into();
        for _ in 0..TRIES {
            let ended = run(script, program, &trace, &rotary).is_some_and(|seconds| seconds < MOST_SECONDS);
            if ended && kept_dwells(program, &trace) {
                std::fs::write(&beside, &text).expect("written");
                return trace;
            }
            // none is written by a control that did not start
            let _ = std::fs::remove_file(&trace);
        }
        panic!("{}: the control stood in {TRIES} runs", program.display());
    }
}

/// Runs a program; the time of its trace, s, if there is one.
fn run(script: &Path, program: &Path, trace: &Path, rotary: &str) -> Option<f64> {
    let speed = std::env::var("FIVEAXIS_CONTROL_SPEED").unwrap_or_else(|_| "1".into());
    let mut command = match speed.as_str() {
        "1" => Command::new(script),
        _ => {
            let faster = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/control_loop/faster");
            let mut command = Command::new(faster);
            command.arg(speed).arg(script);
            command
        }
    };
    command.arg(program).arg(trace).env("ROTARY", rotary).env("MOST_SECONDS", MOST_SECONDS.to_string());
    if !command.output().expect("it starts").status.success() {
        return None;
    }
    let text = std::fs::read_to_string(trace).ok()?;
    text.lines().last()?.split(',').next()?.parse().ok()
}

/// Whether the axes stood as long as the program says: on a busy machine a faster clock does not keep dwells.
fn kept_dwells(program: &Path, trace: &Path) -> bool {
    let text = std::fs::read_to_string(program).expect("program");
    let dwell = |line: &str| line.split_once("G4 P")?.1.trim().parse::<f64>().ok();
    let wanted: Vec<f64> = text.lines().filter_map(dwell).collect();
    let text = std::fs::read_to_string(trace).expect("trace");
    let rows = text.lines().skip(1).filter_map(|row| {
        let (seconds, rest) = row.split_once(',')?;
        Some((seconds.parse::<f64>().ok()?, rest.rsplit_once(',')?.0))
    });
    let mut rests: Vec<f64> = Vec::new();
    let mut stands: Option<(f64, &str)> = None;
    for (seconds, positions) in rows {
        match stands {
            Some((since, at)) if at != positions => {
                rests.push(seconds - since);
                stands = Some((seconds, positions));
            }
            None => stands = Some((seconds, positions)),
            _ => {}
        }
    }
    // the first is the start; stops of the program are short
    let seen: Vec<f64> = rests.into_iter().skip(1).filter(|rest| *rest > 0.7 * SHORTEST_DWELL_S).collect();
    seen.len() == wanted.len() && seen.iter().zip(&wanted).all(|(seen, wanted)| (seen - wanted).abs() < LATE_S)
}

/// The programs of a plan.
pub fn programs(folder: &Path) -> Vec<PathBuf> {
    let mut list: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("programs")
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|file| file.extension().is_some_and(|extension| extension == "ngc") && !file.ends_with("dry-run.ngc"))
        .collect();
    list.sort();
    list
}

/// A program's name, which is that of its setup.
pub fn name_of(program: &Path) -> String {
    program.file_stem().expect("name").to_string_lossy().into_owned()
}
