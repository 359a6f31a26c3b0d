//! The command line: one verb per file in `verbs`.

#![forbid(unsafe_code)]

// std's panic when the reader of a pipe has gone; these stand in for them in all verbs

/// Prints a line; a reader that stops reading ends the program quietly.
macro_rules! println {
    ($($text:tt)*) => { $crate::verbs::output::line(format_args!($($text)*)) };
}

/// Prints a line on standard error, if it is read.
macro_rules! eprintln {
    ($($text:tt)*) => { $crate::verbs::output::remark(format_args!($($text)*)) };
}

mod verbs;

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};
use verbs::ending::{code_of, is_told, refusal_json, usage_json};
use verbs::output::{print, quieten, remarks};

#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Five-axis machine accuracy from double ball bar recordings.
#[derive(Parser)]
#[command(
    version,
    about,
    long_about = None,
    after_help = "A file called - is standard input.\nExit codes: 0 done, 1 what --fail-on names is so, 2 wrong input, 3 recordings not to be believed, 4 no convergence."
)]
struct CommandLine {
    #[command(subcommand)]
    verb: Verb,
    /// No remarks and no sign of life on standard error; errors are told
    #[arg(short, long, global = true)]
    quiet: bool,
}

#[derive(Subcommand)]
enum Verb {
    /// A test plan that reaches the wanted uncertainty without collisions: fiveaxis plan machine.yaml
    Plan(verbs::plan::Arguments),
    /// Validate a machine or session file and show what it says: fiveaxis check machine.yaml --at "A=30,C=-45"
    Check(verbs::check::Arguments),
    /// Location errors of a machine from recordings: fiveaxis identify session.yaml
    Identify(verbs::identify::Arguments),
    /// Recordings from captures in one piece, as a gauge writes them: fiveaxis import FILE --session session.yaml --out DIR
    Import(verbs::import::Arguments),
    /// A machine file from a data sheet: fiveaxis init mill.yaml --kind table-table --travels 650,520,475 ...
    Init(verbs::init::Arguments),
    /// Least clearance over every sweep: fiveaxis clearance session.yaml
    Clearance(verbs::clearance::Arguments),
    /// The physics that location errors leave unexplained: fiveaxis diagnose session.yaml
    Diagnose(verbs::diagnose::Arguments),
    /// Results of several methods on one machine against each other: fiveaxis reconcile a.yaml b.yaml
    Reconcile(verbs::reconcile::Arguments),
    /// Write the recordings that a session would give: fiveaxis simulate session.yaml --out DIR
    Simulate(verbs::simulate::Arguments),
    /// What a ball bar determines on all 2,160 serial five-axis topologies: fiveaxis survey --out DIR
    Survey(verbs::survey::Arguments),
    /// Parameters of a control from a fit, and what it cannot hold: fiveaxis control session.yaml --control linuxcnc
    Control(verbs::control::Arguments),
    /// A program corrected for the errors of a machine: fiveaxis compensate part.ngc machine.yaml --out corrected.ngc
    Compensate(verbs::compensate::Arguments),
    /// Errors of one machine over its sessions, drifts and steps: fiveaxis history FOLDER
    History(verbs::history::Arguments),
    /// Axis positions for a tool pose in the workpiece: fiveaxis inverse machine.yaml --tip 30,-20,15 --tool-axis 0.3,0.2,0.9
    Inverse(verbs::inverse::Arguments),
    /// What the errors do to the tool tip over the work volume: fiveaxis volume machine.yaml --errors session.yaml
    Volume(verbs::volume::Arguments),
    /// A script that completes commands in a shell: fiveaxis completions bash
    Completions(verbs::shell::CompletionsArguments),
    /// Manual pages: fiveaxis man identify
    Man(verbs::shell::ManArguments),
}

fn main() -> ExitCode {
    // known before the command line is understood: a wrong one is told as JSON too
    let wants_json = std::env::args_os().any(|argument| argument == "--json");
    let line = match CommandLine::try_parse() {
        Ok(line) => line,
        Err(why) => {
            if wants_json && why.use_stderr() {
                tell_json(&usage_json(&why.to_string()));
            }
            why.exit()
        }
    };
    if line.quiet {
        quieten();
    }
    let outcome = match line.verb {
        Verb::Plan(arguments) => verbs::plan::run(&arguments),
        Verb::Check(arguments) => verbs::check::run(&arguments),
        Verb::Identify(arguments) => verbs::identify::run(&arguments),
        Verb::Init(arguments) => verbs::init::run(&arguments),
        Verb::Import(arguments) => verbs::import::run(&arguments),
        Verb::Clearance(arguments) => verbs::clearance::run(&arguments),
        Verb::Diagnose(arguments) => verbs::diagnose::run(&arguments),
        Verb::Reconcile(arguments) => verbs::reconcile::run(&arguments),
        Verb::Simulate(arguments) => verbs::simulate::run(&arguments),
        Verb::Survey(arguments) => verbs::survey::run(&arguments),
        Verb::Control(arguments) => verbs::control::run(&arguments),
        Verb::Compensate(arguments) => verbs::compensate::run(&arguments),
        Verb::History(arguments) => verbs::history::run(&arguments),
        Verb::Inverse(arguments) => verbs::inverse::run(&arguments),
        Verb::Volume(arguments) => verbs::volume::run(&arguments),
        Verb::Completions(arguments) => verbs::shell::completions(&arguments, CommandLine::command()),
        Verb::Man(arguments) => verbs::shell::man(&arguments, CommandLine::command()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(refusal) => {
            if !is_told(&refusal) {
                if wants_json {
                    tell_json(&refusal_json(&refusal, remarks()));
                }
                verbs::output::complain(&refusal);
            }
            ExitCode::from(code_of(&refusal))
        }
    }
}

/// Prints an object; when that fails too there is no one to tell.
fn tell_json(value: &serde_json::Value) {
    let _ = print(&format!("{value:#}\n"));
}
