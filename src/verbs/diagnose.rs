//! `fiveaxis diagnose`: which physics the recordings of a session hold beyond location errors.

use std::path::PathBuf;

use clap::Args;
use fiveaxis::diagnose::diagnose;
use fiveaxis::identify::{Options, parse_free};
use fiveaxis::load::load_session;
use fiveaxis::report::diagnosis::{diagnosis_json, diagnosis_text};

use super::Refusal;
use super::progress::Working;

/// Arguments of `diagnose`.
#[derive(Args)]
#[command(after_help = "Example: fiveaxis diagnose examples/gallery/01-rotary-backlash/session.yaml --json")]
pub struct Arguments {
    /// Session file
    session: PathBuf,
    /// Location errors to fit: names (EX0C,EY0C) or groups (rotary, squareness, linear, zero, all)
    #[arg(long)]
    free: Option<String>,
    /// Print JSON instead of the story
    #[arg(long)]
    json: bool,
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    let session = load_session(&arguments.session)?;
    let free = arguments.free.as_ref().map(|text| parse_free(text, &session.machine)).transpose()?;
    let working = Working::on(format!("looking for causes in {}", session.name));
    let diagnosis = diagnose(&session, &Options { free, prior: None })?;
    drop(working);
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&diagnosis_json(&diagnosis))?);
    } else {
        print!("{}", diagnosis_text(&session, &diagnosis));
    }
    Ok(())
}
