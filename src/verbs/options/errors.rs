//! `--errors`: the errors of a machine from a fit in place of those of its file.

use std::path::{Path, PathBuf};

use fiveaxis::diagnose::examine;
use fiveaxis::identify::{Fit, Options, fitted_session};
use fiveaxis::load::{load_machine, load_session, names_tests};
use fiveaxis::machine::Machine;
use fiveaxis::session::Session;

use super::directions::{DirectionsName, say};
use super::recorded::recorded;
use crate::verbs::Refusal;
use crate::verbs::output::ending::Ending;
use crate::verbs::output::progress::Working;
use crate::verbs::output::{session_inputs, settle};

/// A machine with the errors that it is taken to have.
pub struct ErringMachine {
    pub machine: Machine,
    /// The fit that its errors come from, with its session.
    pub fit: Option<(Session, Fit)>,
    /// Files that were read.
    pub inputs: Vec<PathBuf>,
}

/// Reads a machine file, and errors from `errors`: a session, which is fitted, or another machine file such as that of
/// `identify --save`.
pub fn erring_machine(
    file: &Path,
    errors: Option<&Path>,
    directions: Option<DirectionsName>,
) -> Result<ErringMachine, Refusal> {
    settle(file)?;
    if names_tests(file)? {
        return Err(format!(
            "{} is a session, where a machine file is due: name its machine file, and the session with --errors",
            file.display()
        )
        .into());
    }
    let mut machine = load_machine(file)?;
    say(&mut machine, directions, &file.display().to_string())?;
    let mut erring = ErringMachine { machine, fit: None, inputs: vec![file.to_path_buf()] };
    let Some(errors) = errors else { return Ok(erring) };
    settle(errors)?;
    erring.inputs.push(errors.to_path_buf());
    let mut with_errors = if names_tests(errors)? {
        let session = recorded(load_session(errors)?);
        erring.inputs.extend(session_inputs(errors, &session));
        let working = Working::on(format!("fitting {}", session.name));
        let examination = examine(&session, &Options::default())?;
        drop(working);
        let Some(fit) = &examination.fit else { return Err(Ending::without_fit(&examination)) };
        if !examination.is_sound() {
            let says = examination.says().unwrap_or_default();
            return Err(Ending::data_fault(format!("{}: the fit is not to be believed: {says}", errors.display())));
        }
        let fitted = fitted_session(&session, fit).machine;
        erring.fit = Some((session, fit.clone()));
        fitted
    } else {
        load_machine(errors)?
    };
    // a sense that no file states is said for both
    if with_errors.directions.is_none() {
        say(&mut with_errors, directions, &errors.display().to_string())?;
    }
    take_errors(&mut erring.machine, with_errors, file, errors)?;
    Ok(erring)
}

/// Takes the errors over axis by axis; machines that are not alike are refused.
fn take_errors(machine: &mut Machine, other: Machine, file: &Path, errors: &Path) -> Result<(), Refusal> {
    let differs = |what: &str| -> Refusal {
        format!(
            "{} and {} are two machines: {what} differ; name the machine that the errors are of",
            file.display(),
            errors.display()
        )
        .into()
    };
    if machine.code != other.code {
        return Err(differs("their codes"));
    }
    let signs = |machine: &Machine| (0..machine.axes.len()).map(|axis| machine.motion_sign(axis)).collect::<Vec<f64>>();
    if signs(machine) != signs(&other) {
        return Err(differs("the senses of their axes (directions, reversed)"));
    }
    for (axis, with_errors) in machine.axes.iter_mut().zip(other.axes) {
        let is_same_line =
            (axis.direction - with_errors.direction).norm() < 1e-9 && (axis.origin - with_errors.origin).norm() < 1e-6;
        if axis.kind != with_errors.kind || !is_same_line {
            return Err(differs(&format!("the lines of {}", axis.name)));
        }
        axis.location_errors = with_errors.location_errors;
        axis.component_errors = with_errors.component_errors;
    }
    machine.effects = other.effects;
    Ok(())
}
