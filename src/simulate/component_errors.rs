//! Component errors of all axes of a machine at given positions.

use crate::machine::Machine;
use crate::session::Session;

/// Component errors of every axis at the given positions, mm and rad.
pub fn component_errors(session: &Session, positions: &[f64], into: &mut [[f64; 6]]) {
    machine_component_errors(&session.machine, positions, into);
}

/// Component errors of every axis of a machine at the given positions, mm and rad.
pub fn component_errors_of(machine: &Machine, positions: &[f64]) -> Vec<[f64; 6]> {
    let mut values = vec![[0.0; 6]; machine.axes.len()];
    machine_component_errors(machine, positions, &mut values);
    values
}

fn machine_component_errors(machine: &Machine, positions: &[f64], into: &mut [[f64; 6]]) {
    for ((axis, &q), values) in machine.axes.iter().zip(positions).zip(into) {
        *values = [0.0; 6];
        for error in &axis.component_errors {
            values[error.component.index()] += error.form.value(q);
        }
    }
}
