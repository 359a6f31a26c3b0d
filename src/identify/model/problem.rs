//! Predicted readings and their derivatives for all tests of a session at given values of the unknowns. It does not solve.

use nalgebra::{DMatrix, Vector3};

use super::error::FitError;
use super::slides::Slides;
use super::unknowns::{Quantity, Unknown, moves_spindle_ball};
use crate::chain::{Chain, Column, Composition, Geometry, LinkId, Poses, Sensitivity};
use crate::disturbances::Disturbances;
use crate::effects::Context;
use crate::machine::{AxisKind, LinearAxes};
use crate::readings::Mount;
use crate::session::{Motion, Session, Setups};
use crate::simulate::component_errors;

/// A session prepared for fitting: motions and links are worked out once.
pub struct Problem<'a> {
    pub session: &'a Session,
    pub chain: &'a Chain,
    pub setups: &'a Setups,
    /// What a fit is asked for, then what the linear axes may do within their budget.
    pub unknowns: Vec<Unknown>,
    /// Number of unknowns that a fit is asked for; the ones after them belong to the linear axes' budget.
    pub asked: usize,
    /// Shapes of the linear axes' displacements.
    pub slides: Slides,
    pub tests: Vec<PreparedTest>,
    pub composition: Composition,
    /// What the effects of the machine file do: known, so the same in every step of a fit.
    pub disturbances: Disturbances,
}

/// One test: its motion, links, readings, and which unknowns reach it.
pub struct PreparedTest {
    pub motion: Motion,
    /// The same positions axis by axis, with their sines.
    pub poses: Poses,
    pub links: (LinkId, LinkId),
    /// Readings, mm; NaN where there is none.
    pub reading_mm: Vec<f64>,
    /// Indices of the unknowns on which this test's readings depend.
    pub columns: Vec<usize>,
    /// Of the columns that are displacements of a linear axis: which one, and its shape at every row.
    slide_shapes: Vec<(usize, Vec<f64>)>,
}

/// Prediction of one test.
pub struct Prediction {
    /// Reading minus prediction, mm; NaN where there is no reading.
    pub residual_mm: Vec<f64>,
    /// Derivatives of the prediction, rows × `PreparedTest::columns`, mm per mm or per rad.
    pub jacobian: DMatrix<f64>,
}

impl<'a> Problem<'a> {
    /// Prepares the tests that have a recording; tests without one are left out of the fit.
    pub fn new(
        session: &'a Session,
        chain: &'a Chain,
        setups: &'a Setups,
        unknowns: Vec<Unknown>,
    ) -> Result<Problem<'a>, FitError> {
        let context = Context::of(session, chain)?;
        let disturbances = Disturbances::of(&context, &session.machine.effects)?;
        let tests = session.tests.iter().enumerate().map(|(index, test)| {
            let motion = context.motion(index).clone();
            let links = test.links(chain)?;
            let reading_mm = match &test.recording {
                Some(recording) => recording.length_mm.clone(),
                None => vec![f64::NAN; motion.rows()],
            };
            let poses = Poses::from_rows(motion.axis_count, &motion.positions).with_sines(chain);
            Ok(PreparedTest { motion, poses, links, reading_mm, columns: Vec::new(), slide_shapes: Vec::new() })
        });
        let tests = tests.collect::<Result<Vec<_>, FitError>>()?;
        let composition = Composition::Exact;
        let (asked, slides) = (unknowns.len(), Slides::default());
        let mut problem = Problem { session, chain, setups, unknowns, asked, slides, tests, composition, disturbances };
        problem.find_columns();
        Ok(problem)
    }

    /// The same with linear axes that are not exact: their squareness and displacements as unknowns with priors.
    pub fn with_linear_axes(mut self, budget: &LinearAxes) -> Problem<'a> {
        let machine = &self.session.machine;
        let recorded = self.tests.iter().filter(|test| test.reading_mm.iter().any(|reading| reading.is_finite()));
        let motions: Vec<&Motion> = recorded.map(|test| &test.motion).collect();
        self.slides = Slides::of(machine, budget, &motions);
        let more = self.slides.unknowns(machine, budget, &self.unknowns);
        self.unknowns.extend(more);
        self.find_columns();
        self
    }

    fn find_columns(&mut self) {
        for test in 0..self.tests.len() {
            self.tests[test].columns = self.reaching(test);
            self.tests[test].slide_shapes = self.slide_shapes(test);
        }
    }

    /// Of a test's columns that are displacements of a linear axis: which one, and its shape at every row.
    fn slide_shapes(&self, test: usize) -> Vec<(usize, Vec<f64>)> {
        let prepared = &self.tests[test];
        let shape_of = |(column, &index): (usize, &usize)| {
            let Quantity::Slide { axis, shape, .. } = self.unknowns[index].quantity else { return None };
            let (mut last, mut there) = (f64::NAN, 0.0);
            let at = |q: f64| {
                if q != last {
                    (last, there) = (q, self.slides.at(axis, shape, q));
                }
                there
            };
            Some((column, prepared.motion.axis(axis).map(at).collect()))
        };
        prepared.columns.iter().enumerate().filter_map(shape_of).collect()
    }

    /// Unknowns on which a test's readings depend, by topology, setup and, for the way of a linear axis, its motion.
    fn reaching(&self, test: usize) -> Vec<usize> {
        let links = self.tests[test].links;
        let between = |axis: usize| self.chain.carries(axis, links.0) != self.chain.carries(axis, links.1);
        let goes = |axis: usize| self.tests[test].motion.leaves_zero(axis);
        let is_linear = |axis: usize| self.session.machine.axes[axis].kind == AxisKind::Linear;
        // a rotation does not depend on where instrument and target stand
        let sees_places = !self.session.tests[test].reading.is_turn();
        let reaches = |unknown: &Unknown| match unknown.quantity {
            Quantity::Location { axis, component } if is_linear(axis) && component.is_angle() => {
                between(axis) && goes(axis)
            }
            Quantity::Location { axis, .. } => between(axis),
            Quantity::Slide { axis, .. } => between(axis) && goes(axis),
            Quantity::Pivot { setup, .. } => {
                (self.setups.pivot_of[test] == setup || self.setups.second_pivot_of[test] == Some(setup)) && sees_places
            }
            Quantity::SpindleBall { setup, coordinate } => {
                let own = self.setups.spindle_ball_of[test];
                moves_spindle_ball(self.session, (setup, coordinate), test, own) && sees_places
            }
            // coordinates do not depend on how the target is turned
            Quantity::InstrumentTurn { setup, .. } => self.setups.pivot_of[test] == setup,
            Quantity::TargetTurn { setup, .. } => {
                self.setups.spindle_ball_of[test] == setup && self.session.tests[test].reading.is_turn()
            }
            Quantity::Bar { setup } => self.setups.bar_of[test] == Some(setup),
        };
        (0..self.unknowns.len()).filter(|&index| reaches(&self.unknowns[index])).collect()
    }

    /// Location errors of all axes with the unknown ones at `values`.
    pub fn location_errors(&self, values: &[f64]) -> Vec<[f64; 6]> {
        let mut errors = self.session.machine.location_errors();
        for (unknown, value) in self.unknowns.iter().zip(values) {
            if let Quantity::Location { axis, component } = unknown.quantity {
                errors[axis][component.index()] = *value;
            }
        }
        errors
    }

    /// Places of pivot and spindle ball and the reading's offset of a test, mm.
    pub fn setup_of(&self, test: usize, values: &[f64]) -> (Vector3<f64>, Vector3<f64>, f64) {
        let stated = &self.session.tests[test];
        let (mut pivot, mut spindle, mut bar) = (stated.pivot.at, stated.spindle_ball.at, stated.bar_error_mm);
        for &index in &self.tests[test].columns {
            match self.unknowns[index].quantity {
                Quantity::Pivot { setup, coordinate } => match self.setups.second_pivot_of[test] == Some(setup) {
                    true => spindle[coordinate] += values[index],
                    false => pivot[coordinate] += values[index],
                },
                Quantity::SpindleBall { coordinate, .. } => {
                    spindle[coordinate] += stated.spindle_ball.sign(coordinate) * values[index];
                }
                Quantity::Bar { .. } => bar += values[index],
                Quantity::InstrumentTurn { .. } | Quantity::TargetTurn { .. } => {}
                Quantity::Location { .. } | Quantity::Slide { .. } => {}
            }
        }
        (pivot, spindle, bar)
    }

    /// Turns of instrument and target of a test as rotation vectors, rad.
    pub fn turns_of(&self, test: usize, values: &[f64]) -> [Vector3<f64>; 2] {
        let mut turns = [Vector3::zeros(); 2];
        for &index in &self.tests[test].columns {
            match self.unknowns[index].quantity {
                Quantity::InstrumentTurn { coordinate, .. } => turns[0][coordinate] += values[index],
                Quantity::TargetTurn { coordinate, .. } => turns[1][coordinate] += values[index],
                _ => {}
            }
        }
        turns
    }

    /// Derivative of a test's reading by an unknown that it sees, of displacements without their shape.
    #[inline]
    pub fn derivative(&self, test: usize, unknown: usize, s: &Sensitivity) -> f64 {
        match self.unknowns[unknown].quantity {
            Quantity::Location { axis, component } => s.location[axis][component.index()],
            Quantity::Slide { axis, direction, .. } => s.location[axis][direction],
            Quantity::Pivot { setup, coordinate } => match self.setups.second_pivot_of[test] == Some(setup) {
                true => s.spindle[coordinate],
                false => s.pivot[coordinate],
            },
            Quantity::SpindleBall { coordinate, .. } => {
                self.session.tests[test].spindle_ball.sign(coordinate) * s.spindle[coordinate]
            }
            Quantity::InstrumentTurn { coordinate, .. } => s.pivot_turn[coordinate],
            Quantity::TargetTurn { coordinate, .. } => s.spindle_turn[coordinate],
            Quantity::Bar { .. } => 1.0,
        }
    }

    /// Geometry with the unknown location errors at `values`, and what effects add to them.
    pub fn geometry(&self, values: &[f64]) -> Geometry<'a> {
        let mut errors = self.location_errors(values);
        for (error, added) in errors.iter_mut().zip(&self.disturbances.location) {
            error.iter_mut().zip(added).for_each(|(error, added)| *error += added);
        }
        Geometry::new(self.chain, &errors, self.composition)
    }

    /// True when nothing but constant errors acts on the lengths of a test: no component errors, no effects.
    fn is_constant(&self, test: usize) -> bool {
        self.disturbances.by_test[test].is_empty()
            && self.session.machine.axes.iter().all(|axis| axis.component_errors.is_empty())
            && self.session.tests[test].reading.part().is_none()
    }

    /// What the batch kernels differentiate with respect to for an unknown of a test; `None` for the reading of a bar.
    fn column(&self, test: usize, unknown: usize) -> Option<Column> {
        match self.unknowns[unknown].quantity {
            Quantity::Location { axis, component } => Some(Column::Location { axis, component: component.index() }),
            // of the carriage's displacement, which the shape multiplies
            Quantity::Slide { axis, direction, .. } => Some(Column::Location { axis, component: direction }),
            Quantity::Pivot { coordinate, .. } => Some(Column::Pivot(coordinate)),
            Quantity::SpindleBall { coordinate, .. } => match self.session.tests[test].spindle_ball.sign(coordinate) {
                sign if sign < 0.0 => Some(Column::SpindleReversed(coordinate)),
                _ => Some(Column::Spindle(coordinate)),
            },
            // batches are of lengths
            Quantity::InstrumentTurn { .. } | Quantity::TargetTurn { .. } => None,
            Quantity::Bar { .. } => None,
        }
    }

    /// Residuals and derivatives of one test.
    pub fn predict(&self, test: usize, geometry: &Geometry, values: &[f64]) -> Prediction {
        if self.is_constant(test) {
            self.predict_constant(test, geometry, values)
        } else {
            self.predict_by_row(test, geometry, values)
        }
    }

    /// Many rows at a time.
    fn predict_constant(&self, test: usize, geometry: &Geometry, values: &[f64]) -> Prediction {
        let prepared = &self.tests[test];
        let (pivot, spindle, bar_error_mm) = self.setup_of(test, values);
        let rows = prepared.motion.rows();
        // the bar's column, which is 1 everywhere, is differentiated as a place and overwritten
        let columns: Vec<Option<Column>> = prepared.columns.iter().map(|&index| self.column(test, index)).collect();
        let known: Vec<Column> = columns.iter().map(|column| column.unwrap_or(Column::Pivot(0))).collect();
        let mut jacobian = DMatrix::zeros(rows, columns.len());
        let mut lengths = vec![0.0; rows];
        let bar = geometry.bar((prepared.links.0, &pivot), (prepared.links.1, &spindle), &prepared.poses);
        bar.derivatives(geometry, &known).evaluate(0..rows, &mut lengths, jacobian.as_mut_slice());
        for (k, _) in columns.iter().enumerate().filter(|(_, column)| column.is_none()) {
            jacobian.column_mut(k).fill(1.0);
        }
        let residuals =
            prepared.reading_mm.iter().zip(lengths).map(|(reading, length)| reading - length - bar_error_mm);
        let mut prediction = Prediction { residual_mm: residuals.collect(), jacobian };
        self.add_slides(test, values, &mut prediction);
        prediction
    }

    /// Residuals of one test, mm.
    pub fn residual_mm(&self, test: usize, geometry: &Geometry, values: &[f64]) -> Vec<f64> {
        if !self.is_constant(test) {
            return self.predict_by_row(test, geometry, values).residual_mm;
        }
        let prepared = &self.tests[test];
        let (pivot, spindle, bar_error_mm) = self.setup_of(test, values);
        let rows = prepared.motion.rows();
        let bar = geometry.bar((prepared.links.0, &pivot), (prepared.links.1, &spindle), &prepared.poses);
        let value_of = |column: usize| values[prepared.columns[column]];
        let displaced = prepared.slide_shapes.iter().filter(|(column, _)| value_of(*column) != 0.0);
        let (columns, factors): (Vec<Column>, Vec<(&[f64], f64)>) = displaced
            .filter_map(|(column, shape)| {
                let derivative = self.column(test, prepared.columns[*column])?;
                Some((derivative, (shape.as_slice(), value_of(*column))))
            })
            .unzip();
        let mut lengths = vec![0.0; rows];
        let mut derivatives = vec![0.0; rows * columns.len()];
        match columns.is_empty() {
            true => bar.lengths_into(&mut lengths),
            false => bar.derivatives(geometry, &columns).evaluate(0..rows, &mut lengths, &mut derivatives),
        }
        let readings = prepared.reading_mm.iter().zip(lengths);
        let mut residual_mm: Vec<f64> = readings.map(|(reading, length)| reading - length - bar_error_mm).collect();
        for (derivatives, (shape, value)) in derivatives.chunks_exact(rows.max(1)).zip(factors) {
            for ((residual, derivative), factor) in residual_mm.iter_mut().zip(derivatives).zip(shape) {
                *residual -= derivative * factor * value;
            }
        }
        residual_mm
    }

    /// Multiplies the columns of displacements by their shapes and takes what they do from the residuals: they are so small
    /// that the length is linear in them.
    fn add_slides(&self, test: usize, values: &[f64], prediction: &mut Prediction) {
        let prepared = &self.tests[test];
        for (column, shape) in &prepared.slide_shapes {
            let value = values[prepared.columns[*column]];
            let derivatives = prediction.jacobian.column_mut(*column);
            for ((derivative, residual), factor) in derivatives.into_iter().zip(&mut prediction.residual_mm).zip(shape)
            {
                *derivative *= factor;
                *residual -= *derivative * value;
            }
        }
    }

    fn predict_by_row(&self, test: usize, geometry: &Geometry, values: &[f64]) -> Prediction {
        let prepared = &self.tests[test];
        let rows = prepared.motion.rows();
        let mut residual_mm = Vec::with_capacity(rows);
        let mut jacobian = DMatrix::zeros(rows, prepared.columns.len());
        self.visit(test, geometry, values, |row, s, bar| {
            residual_mm.push(prepared.reading_mm[row] - s.length_mm - bar);
            for (column, &index) in prepared.columns.iter().enumerate() {
                jacobian[(row, column)] = self.derivative(test, index, s);
            }
        });
        let mut prediction = Prediction { residual_mm, jacobian };
        self.add_slides(test, values, &mut prediction);
        prediction
    }

    /// Calls `see(row, sensitivity, bar error)` for every row of a test.
    pub fn visit(
        &self,
        test: usize,
        geometry: &Geometry,
        values: &[f64],
        mut see: impl FnMut(usize, &Sensitivity, f64),
    ) {
        let prepared = &self.tests[test];
        let (pivot, spindle, bar) = self.setup_of(test, values);
        let mount = Mount::of(self.session.tests[test].reading.part(), self.turns_of(test, values));
        let axis_count = self.chain.axis_count();
        let mut s = Sensitivity::zeros(axis_count);
        let disturbances = &self.disturbances.by_test[test];
        let moves =
            !disturbances.is_empty() || self.session.machine.axes.iter().any(|axis| !axis.component_errors.is_empty());
        let mut motion = vec![[0.0; 6]; axis_count];
        let mut actual = vec![0.0; axis_count];
        for row in 0..prepared.motion.rows() {
            let commanded = prepared.motion.row(row);
            let component = moves.then(|| {
                component_errors(self.session, commanded, &mut motion);
                motion.as_mut_slice()
            });
            let Some(disturbance) = disturbances.get(row) else {
                let balls = ((prepared.links.0, &pivot), (prepared.links.1, &spindle));
                mount.evaluate(geometry, balls, row, (commanded, component.as_deref()), &mut s);
                see(row, &s, bar);
                continue;
            };
            for (sum, added) in component.into_iter().flatten().zip(&disturbance.motion) {
                sum.iter_mut().zip(added).for_each(|(sum, added)| *sum += added);
            }
            for ((actual, commanded), off) in actual.iter_mut().zip(commanded).zip(&disturbance.position) {
                *actual = commanded + off;
            }
            let balls = (pivot + disturbance.pivot_mm, spindle + disturbance.spindle_mm);
            let balls = ((prepared.links.0, &balls.0), (prepared.links.1, &balls.1));
            mount.evaluate(geometry, balls, row, (&actual, Some(motion.as_slice())), &mut s);
            see(row, &s, bar + disturbance.reading_mm);
        }
    }
}
