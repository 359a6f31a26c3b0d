//! `fiveaxis diagnose`: which physics the recordings of a session hold beyond location errors.

use std::path::PathBuf;

use clap::Args;
use fiveaxis::diagnose::{Diagnosis, as_found, diagnose};
use fiveaxis::identify::{Options, parse_free};
use fiveaxis::load::{LoadError, Rows, load_session, load_session_with};
use fiveaxis::report::diagnosis::diagnosis_json;
use fiveaxis::report::diagnosis_text::diagnosis_text;

use super::Refusal;
use super::output::print;
use super::progress::Working;
use super::report::write_diagnosis;
use super::save::save;

/// Arguments of `diagnose`.
#[derive(Args)]
#[command(after_help = "Example: fiveaxis diagnose examples/gallery/03-lost-motion/session.yaml --report out")]
pub struct Arguments {
    /// Session file
    session: PathBuf,
    /// Location errors to fit: names (EX0C,EY0C) or groups (rotary, squareness, linear, zero, all)
    #[arg(long)]
    free: Option<String>,
    /// Write machine.yaml and session.yaml as found, effects included, with the recordings, into this folder
    #[arg(long, value_name = "DIR")]
    save: Option<PathBuf>,
    /// Write report.html (one page, opens offline) and its plots as SVG files into this folder
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Print JSON instead of the story
    #[arg(long)]
    json: bool,
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    let session = match load_session(&arguments.session) {
        Ok(session) => session,
        Err(refusal) => return tell_mistake(arguments, refusal),
    };
    let free = arguments.free.as_ref().map(|text| parse_free(text, &session.machine)).transpose()?;
    let working = Working::on(format!("looking for causes in {}", session.name));
    let diagnosis = diagnose(&session, &Options { free, prior: None })?;
    let saved = arguments
        .save
        .as_ref()
        .map(|folder| Ok::<_, Refusal>((folder, as_found(&session, &diagnosis)?)))
        .transpose()?;
    drop(working);
    if let Some((folder, found)) = saved {
        save(&arguments.session, &session, found, folder)?;
    }
    let json = diagnosis_json(&diagnosis);
    if let Some(folder) = &arguments.report {
        write_diagnosis(&arguments.session, &session, &diagnosis, &json, folder)?;
    }
    if arguments.json {
        print(&format!("{}\n", serde_json::to_string_pretty(&json)?))
    } else {
        print(&diagnosis_text(&session, &diagnosis, &json))
    }
}

/// A session that cannot be true may hold a known mistake, which is an answer; any other is refused as everywhere.
fn tell_mistake(arguments: &Arguments, refusal: LoadError) -> Result<(), Refusal> {
    let Ok(session) = load_session_with(&arguments.session, Rows::AsRecorded) else { return Err(refusal.into()) };
    let Some(diagnosis) = Diagnosis::of_implausible(&session) else { return Err(refusal.into()) };
    if arguments.save.is_some() || arguments.report.is_some() {
        return Err(refusal.into());
    }
    let json = diagnosis_json(&diagnosis);
    if arguments.json {
        print(&format!("{}\n", serde_json::to_string_pretty(&json)?))
    } else {
        print(&diagnosis_text(&session, &diagnosis, &json))
    }
}
