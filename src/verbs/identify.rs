//! `fiveaxis identify`: location errors of a machine from the recordings of a session.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use fiveaxis::diagnose::examine;
use fiveaxis::identify::{Options, axis_lines, fitted_session, parse_free, turned_senses};
use fiveaxis::load::load_session;
use fiveaxis::methods::{ThesisEstimate, chapter4, chapter5, chapter6, circles};
use fiveaxis::report::circles::circles_text;
use fiveaxis::report::fit::fit_json;
use fiveaxis::report::fit_text::fit_text;
use fiveaxis::report::thesis::{thesis_json, thesis_text};
use fiveaxis::session::Session;

use super::Refusal;
use super::output::{Foreign, print, print_json, remarks, session_inputs, settle, write_all};
use crate::verbs::options::directions::{DirectionsName, say};
use crate::verbs::options::recorded::recorded;
use crate::verbs::options::report::fit_report;
use crate::verbs::options::save::saved;
use crate::verbs::output::ending::Ending;
use crate::verbs::output::progress::Working;

/// Arguments of `identify`.
#[derive(Args)]
#[command(after_help = "Example: fiveaxis identify examples/thesis/chapter5/session.yaml --free rotary --json")]
pub struct Arguments {
    /// Session file
    session: PathBuf,
    /// Location errors to fit: names (EX0C,EY0C) or groups (rotary, squareness, linear, zero, all)
    #[arg(long)]
    free: Option<String>,
    /// The thesis's own estimators in place of the fit
    #[arg(long, value_enum, conflicts_with = "free")]
    method: Option<Method>,
    /// Sense of the axes where the machine file does not state it
    #[arg(long, value_enum)]
    directions: Option<DirectionsName>,
    /// Write machine.yaml and session.yaml as fitted, with the recordings, into this folder
    #[arg(long, value_name = "DIR", conflicts_with = "method")]
    save: Option<PathBuf>,
    /// Write report.html (one page, opens offline) and its plots as SVG files into this folder
    #[arg(long, value_name = "DIR", conflicts_with = "method")]
    report: Option<PathBuf>,
    /// Replace files in the way that fiveaxis did not write; never the session's own
    #[arg(long)]
    force: bool,
    /// End with exit code 1 when this is so (recordings not to be believed end with 3 in any case)
    #[arg(long, value_enum, value_delimiter = ',', value_name = "WHAT")]
    fail_on: Vec<Alarm>,
    /// Print JSON instead of tables
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Alarm {
    /// An error that was asked for is not determined
    Undetermined,
    /// There is a warning
    Warning,
}

#[derive(Clone, Copy, ValueEnum)]
enum Method {
    /// Circles with the short and the extended bar, the pivot mounted once for each axis
    Chapter4,
    /// The same four tests from one pivot mounting
    Chapter5,
    /// Circles with the short bar at two positions along each axis
    Chapter6,
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    settle(&arguments.session)?;
    let mut session = recorded(load_session(&arguments.session)?);
    let machine_file = session.machine_file.clone();
    say(&mut session.machine, arguments.directions, &machine_file)?;
    if let Some(method) = arguments.method {
        let examination = examine(&session, &Options::default())?;
        if let Some(says) = examination.says() {
            return Err(Ending::data_fault(format!("the recordings are not to be believed: {says}")));
        }
        return run_method(&session, method, arguments.json);
    }
    let free = arguments.free.as_ref().map(|text| parse_free(text, &session.machine)).transpose()?;
    let working = Working::on(format!("fitting {}", session.name));
    let examination = examine(&session, &Options { free, prior: None })?;
    drop(working);
    let says = examination.says().unwrap_or_default();
    let Some(fit) = &examination.fit else { return Err(Ending::without_fit(&examination)) };
    if arguments.save.is_some() && !examination.is_sound() {
        return Err(Ending::data_fault(format!("nothing is saved, for the fit is not to be believed: {says}")));
    }
    let mut sets = Vec::new();
    if let Some(folder) = &arguments.save {
        sets.push((folder.clone(), saved(&arguments.session, &session, fitted_session(&session, fit))?));
    }
    let senses = turned_senses(&session, fit)?;
    let lines = axis_lines(&session, fit);
    let mut json = fit_json(&session, fit, &lines, &senses, circles(&session)?).examined(&examination);
    json.warnings.extend(remarks());
    if let Some(folder) = &arguments.report {
        sets.push((folder.clone(), fit_report(&session, fit, &json)?));
    }
    write_all(sets, &session_inputs(&arguments.session, &session), Foreign::with(arguments.force))?;
    match arguments.json {
        true => print(&format!("{}\n", serde_json::to_string_pretty(&json)?))?,
        false => print(&format!("{}{}", fit_text(&json, fit), circles_text(&json.circles)))?,
    }
    let undetermined = json.location_errors.values().any(|error| !error.determined);
    let is_so = |alarm: &Alarm| match alarm {
        Alarm::Warning => !json.warnings.is_empty(),
        Alarm::Undetermined => undetermined,
    };
    match arguments.fail_on.iter().any(is_so) {
        _ if !examination.is_sound() => Err(Ending::unbelievable()),
        true => Err(Ending::alarm()),
        false => Ok(()),
    }
}

fn run_method(session: &Session, method: Method, json: bool) -> Result<(), Refusal> {
    let estimate: ThesisEstimate = match method {
        Method::Chapter4 => chapter4(session)?,
        Method::Chapter5 => chapter5(session)?,
        Method::Chapter6 => chapter6(session)?,
    };
    if json { print_json(&thesis_json(&estimate, session)) } else { print(&thesis_text(&estimate, session)) }
}
