//! `fiveaxis control`: the parameters of a control from a fit, and what stays of the errors when they are entered.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use fiveaxis::control::{
    Control, Number, Parameter, all_parameters, backlash, counting_against, entered_effects, is_entered, modules_of,
    numbers, parameters, refuse_other_units, remaining, squareness, tables, without_travel,
};
use fiveaxis::diagnose::examine;
use fiveaxis::disturbances::{into_component_errors_within, positions_seen};
use fiveaxis::identify::{Options, axis_lines, fitted_session};
use fiveaxis::load::{load_present_values, load_session};
use fiveaxis::report::control::{
    ControlReport, backlash_file, control_json, control_text, counting_note, parameters_csv, parameters_hal,
    worsening_note,
};
use fiveaxis::report::found::{ends_of_tables, open_causes};
use fiveaxis::units::UM_PER_MM;

use super::Refusal;
use super::output::{Foreign, OutputFolder, print, print_json, session_inputs, settle, write_all};
use crate::verbs::options::directions::{DirectionsName, say};
use crate::verbs::options::recorded::recorded;
use crate::verbs::output::ending::Ending;
use crate::verbs::output::progress::Working;

/// Arguments of `control`.
#[derive(Args)]
#[command(
    after_help = "Example: fiveaxis control examples/thesis/chapter5/session.yaml --control sinumerik --directions carried"
)]
pub struct Arguments {
    /// Session file; it is fitted as 'identify' does
    session: PathBuf,
    /// The control
    #[arg(long, value_enum)]
    control: ControlName,
    /// Present values, one 'name = value' on a line (mm): the list then has the new values too
    #[arg(long, value_name = "FILE")]
    present: Option<PathBuf>,
    /// Largest change that is given without --force, µm
    #[arg(long, value_name = "UM", default_value_t = 500.0)]
    limit: f64,
    /// Sense of the axes where the machine file does not state it
    #[arg(long, value_enum)]
    directions: Option<DirectionsName>,
    /// Write the parameters (CSV; for LinuxCNC a HAL file too) and compensation tables of axes into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Give changes beyond the limit too, and replace files in the way that fiveaxis did not write
    #[arg(long)]
    force: bool,
    /// Print JSON instead of tables
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum ControlName {
    /// Pins of its kinematics modules
    Linuxcnc,
    /// Places and shifts of the kinematics description
    Heidenhain,
    /// CYCLE800 and the five-axis transformation
    Sinumerik,
    /// Tool centre point control, Series 30i
    Fanuc,
}

impl ControlName {
    fn of(self) -> Control {
        match self {
            ControlName::Linuxcnc => Control::LinuxCnc,
            ControlName::Heidenhain => Control::Heidenhain,
            ControlName::Sinumerik => Control::Sinumerik,
            ControlName::Fanuc => Control::Fanuc,
        }
    }
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    if !(arguments.limit > 0.0 && arguments.limit <= 1e6) {
        return Err(format!("--limit {} is not between 0 and 1000000 µm", arguments.limit).into());
    }
    settle(&arguments.session)?;
    let mut session = recorded(load_session(&arguments.session)?);
    let machine_file = session.machine_file.clone();
    say(&mut session.machine, arguments.directions, &machine_file)?;
    session.machine.stated_directions().map_err(|why| format!("{machine_file}: {why}"))?;
    let working = Working::on(format!("fitting {}", session.name));
    let examination = examine(&session, &Options::default())?;
    let Some(fit) = &examination.fit else { return Err(Ending::without_fit(&examination)) };
    if !examination.is_sound() {
        let says = examination.says().unwrap_or_default();
        let rivals = examination.fault.iter().flat_map(|fault| &fault.rivals);
        let or: String = rivals.map(|rival| format!("; or {}", rival.says)).collect();
        return Err(Ending::data_fault(format!(
            "no parameters are given, for the fit is not to be believed: {says}{or}"
        )));
    }
    let control = arguments.control.of();
    let lines = axis_lines(&session, fit);
    let numbers = numbers(&session, fit, &lines);
    let mut fitted = fitted_session(&session, fit).machine;
    let modules = match control {
        Control::LinuxCnc => Some(modules_of(&fitted)?),
        _ => None,
    };
    let both = modules.as_ref().map(|(fitted, nominal)| (fitted, nominal));
    let parameters = parameters(control, &session.machine, &numbers, both);
    let present = match &arguments.present {
        Some(file) => {
            let all = all_parameters(control, &session.machine, &numbers, both);
            let list = load_present_values(file, &all.iter().map(Parameter::names).collect::<Vec<_>>())?;
            refuse_other_units(&list, &session).map_err(|why| format!("{}: {why}", file.display()))?;
            list
        }
        None => Vec::new(),
    };
    refuse_large(&parameters, arguments)?;
    let seen = positions_seen(&session);
    into_component_errors_within(&mut fitted, &seen);
    let mut found = session.machine.clone();
    let taken = into_component_errors_within(&mut found, &seen);
    let module = both.map(|(fitted, _)| fitted);
    let enters = |number: &Number| is_entered(control, &session.machine, &numbers, number, module);
    let remaining = remaining(&session, &fitted, fit, (&numbers, &enters));
    let mut notes = open_causes(&session.machine, &entered_effects(&session.machine, &found));
    notes.extend(ends_of_tables(&session.machine, &taken.ends));
    notes.extend(counting_note(control, &session.machine, &counting_against(&session.machine)));
    if examination.is_doubtful {
        notes.extend(examination.warnings.iter().cloned());
    }
    let worse = remaining.as_ref().and_then(|remaining| remaining.worsening(&fitted)).as_ref().map(worsening_note);
    notes.extend(worse.clone());
    let report = ControlReport {
        machine: &session.machine,
        control,
        module,
        numbers: &numbers,
        parameters: &parameters,
        present: &present,
        volume: remaining.map(|remaining| remaining.figures),
        tables: tables(&found),
        backlash: backlash(control, &found),
        without_travel: without_travel(&found),
        squareness: squareness(&fitted),
        stays: taken.left,
        notes,
    };
    drop(working);
    if let Some(why) = worse.filter(|_| arguments.out.is_some() && !arguments.force) {
        return Err(format!("no files are written, for {why}; --force writes them all the same").into());
    }
    let mut inputs = session_inputs(&arguments.session, &session);
    inputs.extend(arguments.present.clone());
    give(arguments, &report, &inputs)
}

/// Said in place of files without an entry.
const NOTHING_TO_ENTER: &str = "no files are written, for these recordings determine nothing that is entered; 'fiveaxis identify' says which errors they determine";

/// Writes the files and tells.
fn give(arguments: &Arguments, report: &ControlReport, inputs: &[PathBuf]) -> Result<(), Refusal> {
    if let Some(folder) = &arguments.out {
        if report.is_empty() {
            return Err(NOTHING_TO_ENTER.into());
        }
        write_all(vec![(folder.clone(), files(report))], inputs, Foreign::with(arguments.force))?;
    }
    match arguments.json {
        true => {
            report.notes.iter().for_each(|note| eprintln!("fiveaxis: {note}"));
            print_json(&control_json(report))
        }
        false => {
            let written = |folder: &PathBuf| format!("\nwritten to {}: {}\n", folder.display(), files(report).names());
            let written = arguments.out.as_ref().map_or_else(String::new, written);
            print(&(control_text(report) + &written))
        }
    }
}

/// Refuses changes beyond the limit.
fn refuse_large(parameters: &[Parameter], arguments: &Arguments) -> Result<(), Refusal> {
    let beyond = parameters.iter().find(|one| !one.is_angle && one.change.abs() * UM_PER_MM > arguments.limit);
    match beyond.filter(|_| !arguments.force) {
        None => Ok(()),
        Some(one) => Err(format!(
            "{} would change by {:.1} µm, more than the limit of {} µm: check senses, units and places in the session; --limit or --force gives it all the same",
            one.name,
            one.change * UM_PER_MM,
            arguments.limit
        )
        .into()),
    }
}

/// Parameters and tables as files.
fn files(report: &ControlReport) -> OutputFolder {
    let mut output = OutputFolder::default();
    output.add("parameters.csv", parameters_csv(report));
    if let Some(hal) = parameters_hal(report) {
        output.add("kinematics.hal", hal);
    }
    if !report.backlash.is_empty() {
        let (name, text) = backlash_file(report);
        output.add(name, text);
    }
    for table in &report.tables {
        output.add(format!("{}.csv", table.error), table.csv(report.machine));
        if report.control == Control::LinuxCnc
            && let Some(text) = table.linuxcnc(report.machine)
        {
            output.add(format!("{}.comp", report.machine.axes[table.axis].name), text);
        }
    }
    output
}
