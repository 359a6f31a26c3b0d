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

use clap::{Parser, Subcommand};

/// Five-axis machine accuracy from double ball bar recordings.
#[derive(Parser)]
#[command(version, about, long_about = None)]
struct CommandLine {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// A test plan that reaches the wanted uncertainty without collisions: fiveaxis plan machine.yaml
    Plan(verbs::plan::Arguments),
    /// Validate a machine or session file and show what it says: fiveaxis check machine.yaml --at "A=30,C=-45"
    Check(verbs::check::Arguments),
    /// Location errors of a machine from recordings: fiveaxis identify session.yaml
    Identify(verbs::identify::Arguments),
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
}

fn main() -> ExitCode {
    let outcome = match CommandLine::parse().verb {
        Verb::Plan(arguments) => verbs::plan::run(&arguments),
        Verb::Check(arguments) => verbs::check::run(&arguments),
        Verb::Identify(arguments) => verbs::identify::run(&arguments),
        Verb::Clearance(arguments) => verbs::clearance::run(&arguments),
        Verb::Diagnose(arguments) => verbs::diagnose::run(&arguments),
        Verb::Reconcile(arguments) => verbs::reconcile::run(&arguments),
        Verb::Simulate(arguments) => verbs::simulate::run(&arguments),
        Verb::Survey(arguments) => verbs::survey::run(&arguments),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(refusal) => {
            eprintln!("fiveaxis: {refusal}");
            ExitCode::from(2)
        }
    }
}
