//! Traces with the found errors taken out, and what the circles leave (thesis Figs 4.6–4.8). Values only, no plot.

use super::error::MethodError;
use super::runs::Runs;
use super::thesis_value::ThesisValue;
use crate::chain::{Chain, Composition, Geometry};
use crate::session::{Motion, Session};

/// One test before and after compensation, at its rows with a reading.
#[derive(Debug, Clone, PartialEq)]
pub struct CompensatedTrace {
    pub test: String,
    /// Angle of the carried ball in the turning plane, rad.
    pub angle_rad: Vec<f64>,
    /// Reading minus the length of the nominal geometry, mm.
    pub measured_mm: Vec<f64>,
    /// What is left of it when the effect of the found errors is taken out, mm. The pivot's own placement stays in:
    /// a constant along the bar, as the thesis's start position leaves it.
    pub compensated_mm: Vec<f64>,
    /// Reading minus the test's own circle, mm: what no location error explains.
    pub residual_mm: Vec<f64>,
}

/// Compensates every run with the found errors, composed exactly on the nominal balls.
pub fn compensated(
    session: &Session,
    chain: &Chain,
    values: &[ThesisValue],
    used: &[Runs],
) -> Result<Vec<CompensatedTrace>, MethodError> {
    let machine = &session.machine;
    let mut errors = vec![[0.0; 6]; machine.axes.len()];
    for value in values {
        if let Some(axis) = machine.axis_index(&value.name.axis) {
            errors[axis][value.name.component.index()] = value.value;
        }
    }
    let nominal = Geometry::nominal(chain);
    let found = Geometry::new(chain, &errors, Composition::Exact);
    let mut traces = Vec::new();
    for circle in used.iter().flat_map(|runs| &runs.circles) {
        let test = &session.tests[circle.test];
        let motion = Motion::of(session, chain, test)?;
        let (pivot, spindle) = test.links(chain)?;
        let length = |geometry: &Geometry, row: usize| {
            geometry.length((pivot, &test.pivot.at), (spindle, &test.spindle_ball.at), motion.row(row), None)
        };
        let mut trace = CompensatedTrace {
            test: test.name.clone(),
            angle_rad: circle.angle_rad.clone(),
            measured_mm: Vec::with_capacity(circle.rows.len()),
            compensated_mm: Vec::with_capacity(circle.rows.len()),
            residual_mm: Vec::with_capacity(circle.rows.len()),
        };
        for ((&row, &reading), &angle) in circle.rows.iter().zip(&circle.length_mm).zip(&circle.angle_rad) {
            let nominal_mm = length(&nominal, row);
            trace.measured_mm.push(reading - nominal_mm);
            trace.compensated_mm.push(reading - length(&found, row));
            trace.residual_mm.push(reading - circle.length_at(angle));
        }
        traces.push(trace);
    }
    Ok(traces)
}
