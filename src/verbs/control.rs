//! `fiveaxis control`: the parameters of a control from a fit, and what stays of the errors when they are entered.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use fiveaxis::bodies::Bodies;
use fiveaxis::control::{
    Control, Number, Parameter, What, backlash, counting_against, held, held_where, is_entered, left_over, module_of,
    numbers, parameters, tables, what_stays,
};
use fiveaxis::diagnose::examine;
use fiveaxis::disturbances::{into_component_errors_within, positions_seen};
use fiveaxis::effects::{Signature, is_a};
use fiveaxis::identify::{Fit, Options, axis_lines, fitted_session};
use fiveaxis::inverse::Tool;
use fiveaxis::load::{LoadError, load_machine_and_bodies, load_session, read_limited};
use fiveaxis::machine::{AxisKind, Effect, Machine};
use fiveaxis::report::control::{
    ControlReport, backlash_file, control_json, control_text, parameters_csv, parameters_hal,
};
use fiveaxis::report::found::{ends_of_tables, open_causes};
use fiveaxis::session::Session;
use fiveaxis::units::UM_PER_MM;
use fiveaxis::volume::{Figures, poses, spread};
use nalgebra::Vector3;

use super::Refusal;
use super::inverse::tool_of;
use super::output::{Foreign, OutputFolder, print, print_json, session_inputs, settle, write_all};
use crate::verbs::options::directions::{DirectionsName, say};
use crate::verbs::output::ending::Ending;
use crate::verbs::output::progress::Working;

/// Poses over which it is told what stays.
const POSES: usize = 3000;

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
    let mut session = load_session(&arguments.session)?;
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
    let known = held(&fitted);
    let modules = match control {
        Control::LinuxCnc => Some((module_of(&known)?, module_of(&held(&fitted.as_drawn()))?)),
        _ => None,
    };
    let parameters =
        parameters(control, &session.machine, &numbers, modules.as_ref().map(|(fitted, nominal)| (fitted, nominal)));
    let present = match &arguments.present {
        Some(file) => {
            let all: Vec<Number> = numbers.iter().map(|number| Number { determined: true, ..number.clone() }).collect();
            let modules = modules.as_ref().map(|(fitted, nominal)| (fitted, nominal));
            let list = present(file, &fiveaxis::control::parameters(control, &session.machine, &all, modules))?;
            refuse_other_units(file, &list, &session)?;
            list
        }
        None => Vec::new(),
    };
    refuse_large(&parameters, arguments)?;
    let seen = positions_seen(&session);
    into_component_errors_within(&mut fitted, &seen);
    let mut found = session.machine.clone();
    let taken = into_component_errors_within(&mut found, &seen);
    let module = modules.as_ref().map(|(fitted, _)| fitted);
    let enters = |number: &Number| is_entered(control, &session.machine, &numbers, number, module);
    let volume = volume(&arguments.session, &session, &fitted, fit, (&numbers, &enters));
    let stays = |effect: &Effect| found.effects.contains(effect) && !is_a(&effect.kind, Signature::Reversal);
    let entered: Vec<Effect> = session.machine.effects.iter().filter(|one| !stays(one)).cloned().collect();
    let mut notes = open_causes(&session.machine, &entered);
    notes.extend(ends_of_tables(&session.machine, &taken.ends));
    notes.extend(as_read(control, &session.machine));
    if examination.is_doubtful {
        notes.extend(examination.warnings.iter().cloned());
    }
    let worse = volume.as_ref().and_then(|volume| volume.worse(&fitted));
    notes.extend(worse.clone());
    let report = ControlReport {
        machine: &session.machine,
        control,
        module,
        numbers: &numbers,
        parameters: &parameters,
        present: &present,
        volume: volume.map(|volume| volume.figures),
        tables: tables(&found),
        backlash: backlash(control, &found),
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

/// Writes the files and tells.
fn give(arguments: &Arguments, report: &ControlReport, inputs: &[PathBuf]) -> Result<(), Refusal> {
    if let Some(folder) = &arguments.out {
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

/// Whether the control takes a number.
type Enters<'e> = dyn Fn(&Number) -> bool + 'e;

/// Figures of the volume as the machine is, as it is left with what the control takes, and how far its drawn likes stand from it; `None` where
/// travels or the spindle are not stated.
fn volume(
    file: &Path,
    session: &Session,
    fitted: &Machine,
    fit: &Fit,
    (numbers, enters): (&[Number], &Enters),
) -> Option<Volume> {
    let machine_file = file.parent().map(PathBuf::from).unwrap_or_default().join(&session.machine_file);
    let bodies = load_machine_and_bodies(&machine_file).map_or_else(|_| Bodies::default(), |(_, bodies)| bodies);
    let mut tool = tool_of(fitted, &bodies, None).ok()?;
    // the tip is where the spindle ball is
    if let Some(ball) =
        session.tests.first().map(|test| &test.spindle_ball).filter(|_| session.machine.carried.is_empty())
    {
        tool.tip_mm = ball.at;
    }
    let poses = poses(fitted, tool, None, POSES).ok()?;
    let pivot = |is_told: &dyn Fn(&Number) -> bool| {
        let told = numbers.iter().filter(|number| number.what == What::Pivot && is_told(number));
        told.fold(tool.tip_mm, |tip, number| tip + Vector3::ith(number.component, number.change))
    };
    let real = Tool { tip_mm: pivot(&|_| true), ..tool };
    let entered = Tool { tip_mm: pivot(enters), ..tool };
    // a zero shift is taken with the workpiece's zero
    let is_left_out = |number: &Number, axis: usize, component: usize| {
        let is_vector = matches!(number.what, What::TableCentre | What::Vector { .. });
        is_vector && (number.axis, number.component) == (axis, component) && !enters(number)
    };
    let kept = held_where(fitted, &|axis, component| !numbers.iter().any(|one| is_left_out(one, axis, component)));
    let nominal = fitted.as_drawn();
    let unsure = spread(fitted, fit, tool, &poses).left;
    let tools = (real, entered);
    let figures = [left_over(fitted, &nominal, (real, tool), &poses), left_over(fitted, &kept, tools, &poses), unsure];
    Some(Volume { figures, kept, tools, poses })
}

/// What stays over the travel, and where it was looked at.
struct Volume {
    figures: [Figures; 3],
    /// The machine and the tool as the control has them with its parameters, the tool as it is first.
    kept: Machine,
    tools: (Tool, Tool),
    poses: Vec<Vec<f64>>,
}

/// Figures of drawn poses that differ by less are the same: parameters then make the volume no worse.
const SAME_FIGURE: f64 = 0.01;

impl Volume {
    /// What to tell when the parameters make the volume worse: by how much, what stays, what to do.
    fn worse(&self, fitted: &Machine) -> Option<String> {
        let [now, after] = [0, 1].map(|k| self.figures[k].position_mm.p95 * UM_PER_MM);
        (after > (1.0 + SAME_FIGURE) * now).then(|| {
            let stays = what_stays(fitted, &self.kept, self.tools, &self.poses);
            format!(
                "these parameters make the volume worse: {now:.1} µm of the tool tip now, {after:.1} µm with them (95 % of poses). {stays} stays, which the present values partly cancel by chance. Take that out first, by its table or with 'compensate', or record the tests that show its cause; enter these parameters with it, not alone"
            )
        })
    }
}

/// What to know of parameters along slides that count against the tool's way.
fn as_read(control: Control, machine: &Machine) -> Option<String> {
    let against: Vec<&str> = counting_against(machine).iter().map(|&axis| machine.axes[axis].name.as_str()).collect();
    let is_said = !against.is_empty() && control != Control::LinuxCnc;
    is_said.then(|| {
        format!(
            "by the machine file a positive command of {} moves the tool in the negative sense over the workpiece: parameters along it are \
             given as the control reads it, with the opposite sign of what 'identify' says. Most controls count it the other way (ISO 841): look \
             which way it goes before anything is entered",
            against.join(" and ")
        )
    })
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

/// A pivot length is wrong by a unit from so many times its nominal length on: metres and µm are a thousand times off, inches 25 times.
const OTHER_UNIT: f64 = 20.0;

/// Refuses a present pivot length in another unit than mm: how far the ball is from the head's last axis is known.
fn refuse_other_units(file: &Path, present: &[(String, f64)], session: &Session) -> Result<(), Refusal> {
    let Some((name, value)) = present.iter().find(|(name, _)| name.ends_with("pivot-length")) else { return Ok(()) };
    let machine = &session.machine;
    let turns_the_tool =
        |&axis: &usize| !machine.carries_workpiece(axis) && machine.axes[axis].kind == AxisKind::Rotary;
    let last = (0..machine.axes.len()).rev().find(turns_the_tool);
    let Some((axis, test)) = last.zip(session.tests.first()) else { return Ok(()) };
    let nominal_mm = (machine.axes[axis].origin.z - test.spindle_ball.at.z).abs();
    let ratio = value.abs() / nominal_mm;
    match (1.0 / OTHER_UNIT..OTHER_UNIT).contains(&ratio) || nominal_mm < 1.0 {
        true => Ok(()),
        false => Err(format!(
            "{}: {name} = {value} is far from the {nominal_mm} mm between axis {} and the spindle ball; values are in mm, convert it",
            file.display(),
            machine.axes[axis].name
        )
        .into()),
    }
}

/// `name = value`, mm; of parameters that the control has for this machine, each once.
fn present(file: &Path, all: &[Parameter]) -> Result<Vec<(String, f64)>, Refusal> {
    let text = read_limited(file, fiveaxis::load::limits::YAML_BYTES)?;
    let mut list: Vec<(String, f64)> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        let refused = |why: String| LoadError::line(file, index + 1, why);
        let parsed = line.rsplit_once('=').and_then(|(name, value)| {
            Some((name.trim().to_string(), value.trim().parse::<f64>().ok().filter(|value| value.abs() <= 1e6)?))
        });
        let (name, value) = parsed.ok_or_else(|| {
            refused(format!("'{line}' is not 'name = value' in mm; write for example $TC_CARR15 = -0.0123"))
        })?;
        let Some(parameter) = all.iter().find(|one| one.is_called(&name)) else {
            let names: Vec<&str> = all.iter().map(Parameter::short_name).collect();
            return Err(refused(format!(
                "'{name}' is none of this control's parameters here; there are {}",
                names.join(", ")
            ))
            .into());
        };
        if list.iter().any(|(other, _)| parameter.is_called(other)) {
            return Err(refused(format!("'{name}' stands twice; keep one line")).into());
        }
        list.push((name, value));
    }
    Ok(list)
}
