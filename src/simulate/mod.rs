//! Traces of a session: what an ideal instrument would read, and the real one in `instrument`. No files.

use nalgebra::Vector3;

use crate::chain::{Chain, Composition, Geometry};
use crate::session::{Motion, MotionError, Session, Test};

/// A simulated recording: lengths over the rows of a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    pub test: String,
    pub motion: Motion,
    /// Readings, mm, one per row.
    pub length_mm: Vec<f64>,
}

/// Trace of every test of a session with the errors of its machine file.
pub fn simulate(session: &Session, composition: Composition) -> Result<Vec<Trace>, MotionError> {
    let chain = Chain::of(&session.machine);
    let errors = session.machine.location_errors();
    let geometry = Geometry::new(&chain, &errors, composition);
    session.tests.iter().map(|test| trace(session, &geometry, test)).collect()
}

/// Trace of one test for a given geometry.
pub fn trace(session: &Session, geometry: &Geometry, test: &Test) -> Result<Trace, MotionError> {
    let chain = geometry.chain();
    let motion = Motion::of(session, chain, test)?;
    let length_mm = lengths(session, geometry, test, &motion, (&test.pivot.at, &test.spindle_ball.at))?;
    Ok(Trace { test: test.name.clone(), motion, length_mm })
}

/// Readings of one test over a motion with balls at the given places, component errors of the machine included, mm.
pub fn lengths(
    session: &Session,
    geometry: &Geometry,
    test: &Test,
    motion: &Motion,
    balls: (&Vector3<f64>, &Vector3<f64>),
) -> Result<Vec<f64>, MotionError> {
    let (pivot, spindle) = test.links(geometry.chain())?;
    let has_component_errors = session.machine.axes.iter().any(|axis| !axis.component_errors.is_empty());
    let mut component = vec![[0.0; 6]; motion.axis_count];
    let readings = (0..motion.rows()).map(|row| {
        let positions = motion.row(row);
        let component = has_component_errors.then(|| {
            component_errors(session, positions, &mut component);
            component.as_slice()
        });
        geometry.length((pivot, balls.0), (spindle, balls.1), positions, component) + test.bar_error_mm
    });
    Ok(readings.collect())
}

/// Component errors of every axis at the given positions, mm and rad.
pub fn component_errors(session: &Session, positions: &[f64], into: &mut [[f64; 6]]) {
    for ((axis, &q), values) in session.machine.axes.iter().zip(positions).zip(into) {
        *values = [0.0; 6];
        for error in &axis.component_errors {
            values[error.component.index()] += error.form.value(q);
        }
    }
}
