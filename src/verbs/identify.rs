//! `fiveaxis identify`: location errors of a machine from the recordings of a session.

use std::path::PathBuf;

use clap::Args;
use fiveaxis::identify::{Options, identify, parse_free};
use fiveaxis::load::load_session;
use fiveaxis::report::fit::{fit_json, fit_text};

use super::Refusal;

/// Arguments of `identify`.
#[derive(Args)]
#[command(
    after_help = "Example: fiveaxis identify examples/thesis/chapter5/session.yaml --free rotary,squareness --json"
)]
pub struct Arguments {
    /// Session file
    session: PathBuf,
    /// Location errors to fit: names (EX0C,EY0C) or groups (rotary, squareness, linear, zero, all)
    #[arg(long)]
    free: Option<String>,
    /// Print JSON instead of tables
    #[arg(long)]
    json: bool,
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    let session = load_session(&arguments.session)?;
    let free = arguments.free.as_ref().map(|text| parse_free(text, &session.machine)).transpose()?;
    let fit = identify(&session, &Options { free, prior: None })?;
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&fit_json(&session, &fit))?);
    } else {
        print!("{}", fit_text(&session, &fit));
    }
    Ok(())
}
