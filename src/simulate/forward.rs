//! Traces that an ideal instrument reads of a session: errors and effects of its machine file. The real one is in `instrument`.

use nalgebra::Vector3;

use super::component_errors::component_errors;
use super::setup_errors::SetupErrors;
use super::trace::Trace;
use crate::chain::{Chain, Composition, Geometry, MotionErrors, Sensitivity};
use crate::disturbances::{Disturbance, Disturbances};
use crate::effects::{Context, EffectError};
use crate::readings::{At, Mount};
use crate::session::{Motion, MotionError, Session, Test};

/// Why a session cannot be simulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimulateError {
    #[error(transparent)]
    Motion(#[from] MotionError),
    #[error(transparent)]
    Effect(#[from] EffectError),
}

/// Trace of every test of a session with the errors and effects of its machine file, balls where the session says.
pub fn simulate(session: &Session, composition: Composition) -> Result<Vec<Trace>, SimulateError> {
    simulate_with(session, composition, &SetupErrors::none(session))
}

/// The same with balls displaced; the commanded positions of planned paths stay those of the stated places.
pub fn simulate_with(
    session: &Session,
    composition: Composition,
    setup: &SetupErrors,
) -> Result<Vec<Trace>, SimulateError> {
    let chain = Chain::of(&session.machine);
    let context = Context::of(session, &chain)?;
    let disturbances = Disturbances::of(&context, &session.machine.effects)?;
    let mut errors = session.machine.location_errors();
    for (error, added) in errors.iter_mut().zip(&disturbances.location) {
        error.iter_mut().zip(added).for_each(|(error, added)| *error += added);
    }
    let geometry = Geometry::new(&chain, &errors, composition);
    session
        .tests
        .iter()
        .enumerate()
        .map(|(index, test)| {
            let motion = context.motion(index);
            let balls = (&(test.pivot.at + setup.pivot_mm[index]), &(test.spindle_ball.at + setup.spindle_mm[index]));
            let mut length_mm = lengths(session, &geometry, test, motion, balls, &disturbances.by_test[index])?;
            length_mm.iter_mut().for_each(|length| *length += setup.bar_mm[index]);
            Ok(Trace { test: test.name.clone(), motion: motion.clone(), length_mm })
        })
        .collect()
}

/// Trace of one test for a given geometry, without effects: those depend on what the session did before.
pub fn trace(session: &Session, geometry: &Geometry, test: &Test) -> Result<Trace, MotionError> {
    let motion = Motion::of(session, geometry.chain(), test)?;
    let length_mm = lengths(session, geometry, test, &motion, (&test.pivot.at, &test.spindle_ball.at), &[])?;
    Ok(Trace { test: test.name.clone(), motion, length_mm })
}

/// Readings of one test over a motion with balls at the given places, component errors of the machine included, mm.
///
/// `disturbances` are those of the test by row; an empty slice stands for none.
pub fn lengths(
    session: &Session,
    geometry: &Geometry,
    test: &Test,
    motion: &Motion,
    balls: (&Vector3<f64>, &Vector3<f64>),
    disturbances: &[Disturbance],
) -> Result<Vec<f64>, MotionError> {
    let (pivot, spindle) = test.links(geometry.chain())?;
    let mut read = Read::of(geometry, test);
    let has_component_errors = session.machine.axes.iter().any(|axis| !axis.component_errors.is_empty());
    let mut component = vec![[0.0; 6]; motion.axis_count];
    let mut actual = vec![0.0; motion.axis_count];
    let readings = (0..motion.rows()).map(|row| {
        let commanded = motion.row(row);
        let moves = (has_component_errors || !disturbances.is_empty()).then(|| {
            component_errors(session, commanded, &mut component);
            component.as_mut_slice()
        });
        let Some(disturbance) = disturbances.get(row) else {
            return read.at(row, ((pivot, balls.0), (spindle, balls.1)), commanded, moves.as_deref())
                + test.bar_error_mm;
        };
        for (sum, added) in moves.into_iter().flatten().zip(&disturbance.motion) {
            sum.iter_mut().zip(added).for_each(|(sum, added)| *sum += added);
        }
        for ((actual, commanded), off) in actual.iter_mut().zip(commanded).zip(&disturbance.position) {
            *actual = commanded + off;
        }
        let pivot_at = balls.0 + disturbance.pivot_mm;
        let spindle_at = balls.1 + disturbance.spindle_mm;
        read.at(row, ((pivot, &pivot_at), (spindle, &spindle_at)), &actual, Some(component.as_slice()))
            + disturbance.reading_mm
            + test.bar_error_mm
    });
    Ok(readings.collect())
}

/// Reads the rows of one test.
struct Read<'a> {
    geometry: &'a Geometry<'a>,
    part: Option<(Mount<'a>, Sensitivity)>,
}

impl<'a> Read<'a> {
    fn of(geometry: &'a Geometry<'a>, test: &'a Test) -> Read<'a> {
        let room = || Sensitivity::zeros(geometry.chain().axis_count());
        let part = test.reading.part();
        Read { geometry, part: part.map(|part| (Mount::of(Some(part), Default::default()), room())) }
    }

    /// The reading at a row, mm.
    fn at(&mut self, row: usize, balls: (At, At), positions: &[f64], motion: Option<&MotionErrors>) -> f64 {
        match &mut self.part {
            None => self.geometry.length(balls.0, balls.1, positions, motion),
            Some((mount, out)) => {
                mount.evaluate(self.geometry, balls, row, (positions, motion), out);
                out.length_mm
            }
        }
    }
}
