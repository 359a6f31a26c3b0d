//! `fiveaxis simulate`: the recordings that a session would give, one CSV per test.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use fiveaxis::chain::Composition;
use fiveaxis::load::load_session;
use fiveaxis::machine::Machine;
use fiveaxis::session::Test;
use fiveaxis::simulate::{Trace, simulate};

use super::Refusal;
use super::output::OutputFolder;

/// Arguments of `simulate`.
#[derive(Args)]
pub struct Arguments {
    /// Session file
    session: PathBuf,
    /// Folder for the recordings
    #[arg(long)]
    out: PathBuf,
    /// How error rotations are composed
    #[arg(long, value_enum, default_value_t = CompositionName::Exact)]
    composition: CompositionName,
}

#[derive(Clone, Copy, ValueEnum)]
enum CompositionName {
    /// Exact rotation matrices
    Exact,
    /// The thesis's product of small-angle matrices
    FirstOrder,
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    let session = load_session(&arguments.session)?;
    let composition = match arguments.composition {
        CompositionName::Exact => Composition::Exact,
        CompositionName::FirstOrder => Composition::FirstOrder,
    };
    let traces = simulate(&session, composition)?;
    let mut output = OutputFolder::default();
    for (test, trace) in session.tests.iter().zip(&traces) {
        let name = test.recording_file.clone().unwrap_or_else(|| format!("{}.csv", test.name));
        output.add(name, csv(&session.machine, test, trace));
    }
    let mut inputs = vec![arguments.session.clone()];
    let folder = arguments.session.parent().map(PathBuf::from).unwrap_or_default();
    inputs.extend(session.tests.iter().filter_map(|test| test.recording_file.as_ref()).map(|file| folder.join(file)));
    output.write(&arguments.out, &inputs)
}

/// A recording as CSV: rows, order and position columns of the test's own recording where it has one.
fn csv(machine: &Machine, test: &Test, trace: &Trace) -> String {
    let mut text = String::new();
    match &test.recording {
        Some(recording) if !recording.leading_header.is_empty() => {
            let _ = writeln!(text, "{},length_mm", recording.leading_header);
            for (leading, length) in recording.leading_texts.iter().zip(&trace.length_mm) {
                let _ = writeln!(text, "{leading},{length:.10}");
            }
        }
        Some(_) => {
            text.push_str("length_mm\n");
            for length in &trace.length_mm {
                let _ = writeln!(text, "{length:.10}");
            }
        }
        None => planned_csv(machine, trace, &mut text),
    }
    text
}

fn planned_csv(machine: &Machine, trace: &Trace, text: &mut String) {
    let motion = &trace.motion;
    let headers: Vec<String> = motion
        .moving
        .iter()
        .map(|&axis| format!("{}_{}", machine.axes[axis].name, machine.axes[axis].kind.position_unit()))
        .collect();
    let _ = writeln!(text, "time_s,{},length_mm", headers.join(","));
    for (row, length) in trace.length_mm.iter().enumerate() {
        let time = motion.time_s.as_ref().map_or(row as f64, |time| time[row]);
        let _ = write!(text, "{time:.4}");
        for &axis in &motion.moving {
            let position = machine.axes[axis].kind.to_file_unit(motion.row(row)[axis]);
            let _ = write!(text, ",{position:.6}");
        }
        let _ = writeln!(text, ",{length:.10}");
    }
}
