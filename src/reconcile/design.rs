//! The design behind a claim as a map from readings to its errors: what any change of machine, balls or readings does to them.

use nalgebra::{DMatrix, DVector, Vector3};

use super::error::ReconcileError;
use crate::chain::{Chain, Composition};
use crate::machine::ErrorName;
use crate::methods::{Runs, chapter4, chapter5, chapter6};
use crate::session::{Claim, Clock, LengthColumn, Motion, Recording, Reduction, Session, Setups};
use crate::simulate::simulate;
use crate::units::UM_PER_MM;

/// Rows kept of each test: a circle has three unknowns, and what is looked for varies with the first orders of the angle.
const ROWS: usize = 25;
/// Scatter of a reading by which the fit weighs readings against spreads, mm: the noise of a ball bar.
const READING_MM: f64 = 0.5e-3;

/// A circle of the design: repeats of one test.
#[derive(Debug, Clone)]
pub struct Group {
    /// Index of the axis that turns.
    pub axis: usize,
    /// Place of the standing ball along the axis, mm.
    pub at_mm: f64,
    /// From the standing to the carried ball along the axis, mm.
    pub reach_mm: f64,
    /// Coordinates of R that span the turning plane.
    pub plane: [usize; 2],
    /// Tests and, by row, the angle of the carried ball, rad.
    pub tests: Vec<(usize, Vec<f64>)>,
    /// Session time of its first test, s.
    pub begins_s: f64,
}

/// A claim's design with its tests thinned, the machine nominal.
pub struct Design {
    pub names: Vec<ErrorName>,
    pub session: Session,
    pub chain: Chain,
    pub groups: Vec<Group>,
    reduction: Reduction,
    /// Gain of the fit from lengths (mm) to errors (mm, rad).
    gain: Option<DMatrix<f64>>,
    nominal_mm: Vec<f64>,
    base: DVector<f64>,
}

impl Design {
    /// Prepares the design of a claim; errors come in the order of the claim.
    pub fn of(claim: &Claim) -> Result<Design, ReconcileError> {
        let session = thinned(&claim.session)?;
        let names: Vec<ErrorName> = claim.values.iter().map(|value| value.name.clone()).collect();
        let chain = Chain::of(&session.machine);
        let refuse = |reason: String| ReconcileError::Design { claim: claim.name.clone(), reason };
        let groups = groups(&session, &chain).map_err(|error| refuse(error.to_string()))?;
        if groups.is_empty() {
            return Err(refuse("no test turns a rotary axis with one ball on it and the other on its line".into()));
        }
        let nominal_mm = readings(&session)?;
        let mut design = Design {
            base: DVector::zeros(names.len()),
            names,
            chain,
            groups,
            reduction: claim.reduction,
            gain: None,
            nominal_mm,
            session,
        };
        if claim.reduction == Reduction::Fit {
            design.gain = Some(gain(&design, &claim.name)?);
        }
        design.base = design.reduce(&design.session, &design.nominal_mm)?;
        Ok(design)
    }

    /// Errors (µm, arcsec) that readings give when reduced with a session's description.
    fn reduce(&self, declared: &Session, lengths_mm: &[f64]) -> Result<DVector<f64>, ReconcileError> {
        let output = |name: &ErrorName, value: f64| name.component.measure().to_output(value);
        if let Some(gain) = &self.gain {
            let change =
                DVector::from_iterator(lengths_mm.len(), lengths_mm.iter().zip(&self.nominal_mm).map(|(l, n)| l - n));
            let errors = gain * change;
            return Ok(DVector::from_iterator(
                self.names.len(),
                self.names.iter().zip(errors.iter()).map(|(n, e)| output(n, *e)),
            ));
        }
        let mut read = declared.clone();
        let mut rest = lengths_mm;
        for test in &mut read.tests {
            let Some(recording) = &mut test.recording else { continue };
            let (own, others) = rest.split_at(recording.length_mm.len());
            recording.length_mm.copy_from_slice(own);
            rest = others;
        }
        let estimate = match self.reduction {
            Reduction::Chapter4 => chapter4(&read),
            Reduction::Chapter5 => chapter5(&read),
            Reduction::Chapter6 | Reduction::Fit => chapter6(&read),
        }?;
        let value = |name: &ErrorName| {
            let found = estimate.values.iter().find(|value| value.name == *name);
            found.map(|found| output(name, found.value)).ok_or_else(|| ReconcileError::NotOfTheMethod {
                error: name.to_string(),
                method: estimate.method.to_string(),
            })
        };
        Ok(DVector::from_vec(self.names.iter().map(value).collect::<Result<_, _>>()?))
    }

    /// What the claim's errors become, µm and arcsec, when the session was in truth `actual`.
    pub fn response(&self, actual: &Session) -> Result<DVector<f64>, ReconcileError> {
        self.response_as(actual, &self.session)
    }

    /// The same when the readings were reduced with another description.
    pub fn response_as(&self, actual: &Session, declared: &Session) -> Result<DVector<f64>, ReconcileError> {
        Ok(self.reduce(declared, &readings(actual)?)? - &self.base)
    }

    /// What readings wrong by `size_um · cos` or `sin` of the angle in one circle do.
    pub fn response_of_circle(
        &self,
        group: usize,
        coordinate: usize,
        size_um: f64,
    ) -> Result<DVector<f64>, ReconcileError> {
        let mut lengths = self.nominal_mm.clone();
        for (test, angles) in &self.groups[group].tests {
            let first: usize = self.session.tests[..*test].iter().map(|test| test.rows()).sum();
            for (row, angle) in angles.iter().enumerate() {
                let wave = if coordinate == 0 { angle.cos() } else { angle.sin() };
                lengths[first + row] += size_um / UM_PER_MM * wave;
            }
        }
        Ok(self.reduce(&self.session, &lengths)? - &self.base)
    }

    /// The session with location errors (µm, arcsec in the order of the names).
    pub fn with_errors(&self, session: &Session, errors: &DVector<f64>) -> Session {
        let mut wrong = session.clone();
        for (name, error) in self.names.iter().zip(errors.iter()) {
            let Some(axis) = wrong.machine.axis_index(&name.axis) else { continue };
            wrong.machine.axes[axis].location_errors[name.component.index()] +=
                error / name.component.measure().to_output(1.0);
        }
        wrong
    }

    /// The session with both balls of the tests of some groups moved along the turning axis, by group, mm: standing, carried.
    pub fn with_balls_along(&self, session: &Session, moved: impl Fn(&Group) -> [f64; 2]) -> Session {
        let mut other = session.clone();
        for group in &self.groups {
            let along = session.machine.axes[group.axis].direction;
            let [standing_mm, carried_mm] = moved(group);
            for (test, _) in &group.tests {
                let (pivot_mm, spindle_mm) = match self.pivot_is_carried(group, *test) {
                    true => (carried_mm, standing_mm),
                    false => (standing_mm, carried_mm),
                };
                other.tests[*test].pivot.at += along * pivot_mm;
                other.tests[*test].spindle_ball.at += along * spindle_mm;
            }
        }
        other
    }

    /// The session with the carried ball on the other side of the axis in the tests of one axis.
    pub fn with_pivot_opposite(&self, axis: usize) -> Session {
        let mut other = self.session.clone();
        let (along, origin) = (self.session.machine.axes[axis].direction, self.session.machine.axes[axis].origin);
        for group in self.groups.iter().filter(|group| group.axis == axis) {
            for (test, _) in &group.tests {
                let is_pivot = self.pivot_is_carried(group, *test);
                let test = &mut other.tests[*test];
                let ball = if is_pivot { &mut test.pivot.at } else { &mut test.spindle_ball.at };
                let arm: Vector3<f64> = *ball - origin;
                let across = arm - along * along.dot(&arm);
                *ball -= across * 2.0;
            }
        }
        other
    }

    /// True where the turning axis carries the pivot, false where it carries the spindle ball.
    pub fn pivot_is_carried(&self, group: &Group, test: usize) -> bool {
        let link = self.chain.link(&self.session.tests[test].pivot.link);
        link.is_some_and(|link| self.chain.carries(group.axis, link))
    }
}

/// Readings of all tests in one row, mm.
fn readings(session: &Session) -> Result<Vec<f64>, ReconcileError> {
    Ok(simulate(session, Composition::Exact)?.into_iter().flat_map(|trace| trace.length_mm).collect())
}

/// The session on a nominal machine, each test with a few rows of its motion and lengths to fill in.
fn thinned(session: &Session) -> Result<Session, ReconcileError> {
    let mut thin = Session { machine: session.machine.as_drawn(), ..session.clone() };
    let chain = Chain::of(&thin.machine);
    for (index, test) in session.tests.iter().enumerate() {
        let motion = Motion::of(&thin, &chain, test)?;
        let last = motion.rows().saturating_sub(1);
        let kept: Vec<usize> = match last {
            0 => vec![0],
            _ if last < ROWS => (0..=last).collect(),
            _ => (0..ROWS).map(|k| k * last / (ROWS - 1)).collect(),
        };
        let column = |axis: &usize| kept.iter().map(|&row| motion.row(row)[*axis]).collect();
        let clock = match &motion.time_s {
            Some(time) => Clock::TimeS(kept.iter().map(|&row| time[row]).collect()),
            None => Clock::Pose((0..kept.len()).map(|k| k as f64).collect()),
        };
        thin.tests[index].path = None;
        thin.tests[index].bar_error_mm = 0.0;
        thin.tests[index].recording = Some(Recording {
            clock,
            axes: motion.moving.clone(),
            positions: motion.moving.iter().map(column).collect(),
            length_mm: vec![0.0; kept.len()],
            channels: Vec::new(),
            leading_texts: std::sync::Arc::default(),
            leading_header: String::new(),
            column: LengthColumn::default(),
            scatter: None,
        });
    }
    let lengths = readings(&thin)?;
    let mut rest = lengths.as_slice();
    for test in &mut thin.tests {
        let Some(recording) = &mut test.recording else { continue };
        let (own, others) = rest.split_at(recording.length_mm.len());
        recording.length_mm.copy_from_slice(own);
        rest = others;
    }
    Ok(thin)
}

fn groups(session: &Session, chain: &Chain) -> Result<Vec<Group>, ReconcileError> {
    let mut groups: Vec<Group> = Vec::new();
    for runs in Runs::of(session, chain)? {
        let Some(first) = runs.circles.first() else { continue };
        let begins = |test: usize| session.tests[test].started_at_s;
        groups.push(Group {
            axis: runs.axis,
            at_mm: runs.at_mm,
            reach_mm: first.reach_mm,
            plane: [first.plane[0].iamax(), first.plane[1].iamax()],
            tests: runs.circles.iter().map(|circle| (circle.test, circle.angle_rad.clone())).collect(),
            begins_s: runs.circles.iter().map(|circle| begins(circle.test)).fold(f64::INFINITY, f64::min),
        });
    }
    groups.sort_by(|a, b| a.begins_s.total_cmp(&b.begins_s));
    Ok(groups)
}

/// `(JᵀJ/σ² + P)⁻¹ Jᵀ/σ²` for the errors, J the change of the lengths by errors, pivots and bars, P their spreads.
fn gain(design: &Design, name: &str) -> Result<DMatrix<f64>, ReconcileError> {
    const STEP: f64 = 1e-4;
    let (session, errors) = (&design.session, design.names.len());
    let setups = Setups::of(session);
    let mut columns: Vec<(Vec<f64>, f64)> = Vec::new();
    let change = |actual: &Session| -> Result<Vec<f64>, ReconcileError> {
        Ok(readings(actual)?
            .iter()
            .zip(&design.nominal_mm)
            .map(|(length, nominal)| (length - nominal) / STEP)
            .collect())
    };
    for name in &design.names {
        let mut wrong = session.clone();
        let Some(axis) = wrong.machine.axis_index(&name.axis) else { continue };
        wrong.machine.axes[axis].location_errors[name.component.index()] = STEP;
        columns.push((change(&wrong)?, 0.0));
    }
    for (pivot, setup) in setups.pivots.iter().enumerate() {
        for coordinate in 0..3 {
            let mut moved = session.clone();
            let its_own = |test: &usize| setups.pivot_of[*test] == pivot;
            (0..session.tests.len()).filter(its_own).for_each(|test| moved.tests[test].pivot.at[coordinate] += STEP);
            columns.push((change(&moved)?, setup.spread_mm.powi(-2)));
        }
    }
    for (bar, setup) in setups.bars.iter().enumerate() {
        let mut longer = session.clone();
        let its_own = |test: &usize| setups.bar_of[*test] == Some(bar);
        (0..session.tests.len()).filter(its_own).for_each(|test| longer.tests[test].bar_error_mm += STEP);
        columns.push((change(&longer)?, setup.spread_mm.powi(-2)));
    }
    let rows = design.nominal_mm.len();
    let jacobian = DMatrix::from_fn(rows, columns.len(), |row, column| columns[column].0[row]) / READING_MM;
    let prior = DMatrix::from_diagonal(&DVector::from_iterator(columns.len(), columns.iter().map(|column| column.1)));
    let normal = jacobian.transpose() * &jacobian + prior;
    let undetermined = || ReconcileError::Design {
        claim: name.to_string(),
        reason: "its tests do not determine the errors stated; state fewer errors or more tests".into(),
    };
    let inverse = normal.cholesky().ok_or_else(undetermined)?.inverse();
    if (0..errors).any(|k| !inverse[(k, k)].is_finite() || inverse[(k, k)] > 1.0) {
        return Err(undetermined());
    }
    Ok((inverse * jacobian.transpose() / READING_MM).rows(0, errors).into_owned())
}
