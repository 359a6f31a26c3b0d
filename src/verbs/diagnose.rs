//! `fiveaxis diagnose`: which physics the recordings of a session hold beyond location errors.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use fiveaxis::diagnose::{Diagnosis, MOST_ROWS, as_found, diagnose, lean};
use fiveaxis::identify::{Options, parse_free};
use fiveaxis::load::{LoadError, Rows, load_session, load_session_with};
use fiveaxis::methods::circles;
use fiveaxis::report::diagnosis::{DiagnosisJson, diagnosis_json};
use fiveaxis::report::diagnosis_text::diagnosis_text;
use fiveaxis::session::Session;

use super::Refusal;
use super::output::{Foreign, print, remark, remarks, session_inputs, settle, write_all};
use crate::verbs::options::recorded::recorded;
use crate::verbs::options::report::diagnosis_report;
use crate::verbs::options::save::saved;
use crate::verbs::output::ending::Ending;
use crate::verbs::output::progress::Working;

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
    /// End with exit code 1 when there is one (recordings not to be believed end with 3 in any case)
    #[arg(long, value_enum, value_delimiter = ',', value_name = "WHAT")]
    fail_on: Vec<Alarm>,
    /// Print JSON instead of the story
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Alarm {
    /// A finding
    Finding,
    /// A warning
    Warning,
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    settle(&arguments.session)?;
    let session = match load_session(&arguments.session) {
        Ok(session) => recorded(session),
        Err(refusal) => return tell_mistake(arguments, refusal),
    };
    let session = match session.states_no_times() {
        true => {
            remark(format_args!(
                "all {} tests begin at 0, which does not say when they ran: they are taken one after the other as listed, without pauses; state started_at, for what warms up or moves between tests is told by it",
                session.tests.len()
            ));
            session.one_after_the_other()
        }
        false => session,
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
        return Err(Ending::data_fault(format!("nothing is saved, for the model is not to be believed: {says}")));
    }
    let mut sets = Vec::new();
    if let Some(folder) = &arguments.save {
        sets.push((folder.clone(), saved(&arguments.session, &session, as_found(&session, &diagnosis)?)?));
    }
    drop(working);
    let mut json = diagnosis_json(&session.machine, &diagnosis, circles(searched)?);
    json.warnings.extend(remarks());
    if let Some(folder) = &arguments.report {
        sets.push((folder.clone(), diagnosis_report(searched, &diagnosis, &json)?));
    }
    write_all(sets, &session_inputs(&arguments.session, &session), Foreign::with(arguments.force))?;
    tell(arguments, searched, &diagnosis, &json)
}

/// Prints a diagnosis and ends as its verdict asks.
fn tell(arguments: &Arguments, session: &Session, diagnosis: &Diagnosis, json: &DiagnosisJson) -> Result<(), Refusal> {
    match arguments.json {
        true => print(&format!("{}\n", serde_json::to_string_pretty(json)?))?,
        false => print(&diagnosis_text(session, diagnosis, json))?,
    }
    let is_so = |alarm: &Alarm| match alarm {
        Alarm::Finding => !json.findings.is_empty(),
        Alarm::Warning => !json.warnings.is_empty(),
    };
    match arguments.fail_on.iter().any(is_so) {
        _ if !diagnosis.is_sound() => Err(Ending::unbelievable()),
        true => Err(Ending::alarm()),
        false => Ok(()),
    }
}

/// A session that cannot be true may hold a known mistake, which is an answer; any other is refused as everywhere.
fn tell_mistake(arguments: &Arguments, refusal: LoadError) -> Result<(), Refusal> {
    let Ok(session) = load_session_with(&arguments.session, Rows::AsRecorded) else { return Err(refusal.into()) };
    let Some(diagnosis) = Diagnosis::of_implausible(&session) else { return Err(refusal.into()) };
    if arguments.save.is_some() || arguments.report.is_some() {
        return Err(refusal.into());
    }
    tell(arguments, &session, &diagnosis, &diagnosis_json(&session.machine, &diagnosis, Vec::new()))
}
