//! `fiveaxis diagnose`: which physics the recordings of a session hold beyond location errors.

use std::path::PathBuf;

use clap::Args;
use fiveaxis::diagnose::{Diagnosis, MOST_ROWS, as_found, diagnose, lean};
use fiveaxis::identify::{Options, parse_free};
use fiveaxis::load::{LoadError, Rows, load_session, load_session_with};
use fiveaxis::report::diagnosis::diagnosis_json;
use fiveaxis::report::diagnosis_text::diagnosis_text;

use super::Refusal;
use super::output::{Foreign, print, session_inputs, settle, write_all};
use super::progress::Working;
use super::report::diagnosis_report;
use super::save::saved;

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
    /// Replace files in the way that fiveaxis did not write; never the session's own
    #[arg(long)]
    force: bool,
    /// Print JSON instead of the story
    #[arg(long)]
    json: bool,
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    settle(&arguments.session)?;
    let session = match load_session(&arguments.session) {
        Ok(session) => session,
        Err(refusal) => return tell_mistake(arguments, refusal),
    };
    let leaner = lean(&session);
    for long in leaner.iter().flat_map(|(_, averaged)| averaged) {
        eprintln!(
            "test '{}': its {} rows are averaged in groups of {}; {MOST_ROWS} rows of a session are searched",
            long.test, long.rows, long.group
        );
    }
    let searched = leaner.as_ref().map_or(&session, |(searched, _)| searched);
    let free = arguments.free.as_ref().map(|text| parse_free(text, &session.machine)).transpose()?;
    let working = Working::on(format!("looking for causes in {}", session.name));
    let diagnosis = diagnose(searched, &Options { free, prior: None })?;
    if arguments.save.is_some() && !diagnosis.is_sound() {
        let fault = diagnosis.data_fault.as_ref().map(|fault| fault.says.as_str());
        let says = fault.or(diagnosis.unjudged.as_deref()).unwrap_or_default();
        return Err(format!("nothing is saved, for the model is not to be believed: {says}").into());
    }
    let mut sets = Vec::new();
    if let Some(folder) = &arguments.save {
        sets.push((folder.clone(), saved(&arguments.session, &session, as_found(&session, &diagnosis)?)?));
    }
    drop(working);
    let json = diagnosis_json(&diagnosis);
    if let Some(folder) = &arguments.report {
        sets.push((folder.clone(), diagnosis_report(searched, &diagnosis, &json)?));
    }
    write_all(sets, &session_inputs(&arguments.session, &session), Foreign::with(arguments.force))?;
    if arguments.json {
        print(&format!("{}\n", serde_json::to_string_pretty(&json)?))
    } else {
        print(&diagnosis_text(searched, &diagnosis, &json))
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
