//! A fit made linear about its values: what readings changed by a figure or by their order would leave, without another fit.

use crate::chain::Chain;
use crate::diagnose::preflight::quick_fit::Refit;
use crate::identify::{Problem, Unknown};
use crate::session::{Session, Setups};
use crate::statistics::{Fitted, median, noise_of_rows};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Noise from row to row that is assumed at least, mm: what a gauge resolves.
const LEAST_NOISE_MM: f64 = 1e-4;

/// Changes of readings by one figure of a mistake: mm per unit of the figure, row by row, of the tests that it concerns.
pub(crate) struct Figure {
    pub(crate) by_test: Vec<(usize, Vec<f64>)>,
}

/// Residuals of a fit with their derivatives, in units of the noise, and what the priors allow.
pub(crate) struct Linearised {
    unknowns: Vec<Unknown>,
    values: Vec<f64>,
    tests: Vec<TestRows>,
    information: Cholesky<f64, Dyn>,
    gradient: DVector<f64>,
    /// What a step of the unknowns would still take off the squares.
    to_gain: f64,
    noise_mm: f64,
}

struct TestRows {
    columns: Vec<usize>,
    /// By unknowns in their prior sigmas; rows without a reading are zero.
    jacobian: DMatrix<f64>,
    residual: DVector<f64>,
    /// What the fit predicts, mm.
    predicted_mm: Vec<f64>,
}

impl Linearised {
    /// Of a refit; `None` where it has no problem to be made linear.
    pub(crate) fn of(session: &Session, refit: &Refit) -> Option<Linearised> {
        let chain = Chain::of(&session.machine);
        let setups = Setups::of(session);
        let problem = Problem::new(session, &chain, &setups, refit.unknowns.clone()).ok()?;
        let noise_mm = median(refit.residual_mm.iter().map(|residual| noise_of_rows(residual)))?.max(LEAST_NOISE_MM);
        let geometry = problem.geometry(&refit.values);
        let tests: Vec<TestRows> = (0..problem.tests.len())
            .map(|test| {
                let prepared = &problem.tests[test];
                let prediction = problem.predict(test, &geometry, &refit.values);
                let mut jacobian = prediction.jacobian;
                for (mut column, &index) in jacobian.column_iter_mut().zip(&prepared.columns) {
                    column *= problem.unknowns[index].prior_sigma / noise_mm;
                }
                let mut residual = DVector::from_vec(prediction.residual_mm);
                let read = prepared.reading_mm.iter().zip(&residual);
                let predicted_mm = read.map(|(reading, residual)| reading - residual).collect();
                residual /= noise_mm;
                for row in (0..residual.len()).filter(|&row| !prepared.reading_mm[row].is_finite()) {
                    residual[row] = 0.0;
                    jacobian.row_mut(row).fill(0.0);
                }
                TestRows { columns: prepared.columns.clone(), jacobian, residual, predicted_mm }
            })
            .collect();
        let count = problem.unknowns.len();
        let off = problem.unknowns.iter().zip(&refit.values);
        let off = off.map(|(unknown, value)| (value - unknown.prior_mean) / unknown.prior_sigma);
        let mut gradient = -DVector::from_iterator(count, off);
        let mut information = DMatrix::identity(count, count);
        for test in &tests {
            let products = test.jacobian.tr_mul(&test.jacobian);
            for (a, &column) in test.columns.iter().enumerate() {
                for (b, &other) in test.columns.iter().enumerate() {
                    information[(column, other)] += products[(a, b)];
                }
            }
            test.add_to(&mut gradient, &test.residual);
        }
        let (unknowns, values) = (problem.unknowns.clone(), refit.values.clone());
        let information = Cholesky::new(information)?;
        let to_gain = gradient.dot(&information.solve(&gradient));
        Some(Linearised { unknowns, values, tests, information, gradient, to_gain, noise_mm })
    }

    /// What the fit predicts of a test, mm, row by row.
    pub(crate) fn predicted_mm(&self, test: usize) -> &[f64] {
        &self.tests[test].predicted_mm
    }

    /// What readings of some tests lack where their positions are those of another session: per unit of a figure, of which the other
    /// session has `by` more.
    pub(crate) fn figure_of(&self, other: &Session, tests: &[usize], by: f64) -> Option<Figure> {
        let chain = Chain::of(&other.machine);
        let setups = Setups::of(other);
        let problem = Problem::new(other, &chain, &setups, self.unknowns.clone()).ok()?;
        let geometry = problem.geometry(&self.values);
        let of = |&test: &usize| {
            let residual = problem.predict(test, &geometry, &self.values).residual_mm;
            let read = problem.tests[test].reading_mm.iter().zip(residual);
            let moved = read.zip(&self.tests[test].predicted_mm).map(|((read, left), was)| (was - (read - left)) / by);
            (test, moved.collect())
        };
        Some(Figure { by_test: tests.iter().map(of).collect() })
    }

    /// Figures that readings lack or have too much, found together with all that the fit explains: with these multiples of
    /// `figures` added the readings fit best. Each with its standard deviation by the noise.
    pub(crate) fn fitted(&self, figures: &[Figure]) -> Option<Vec<Fitted>> {
        let Sums { normal, right } = self.sums(figures);
        let factor = Cholesky::new(normal)?;
        let (fitted, variance) = (factor.solve(&right), factor.inverse().diagonal());
        Some(
            fitted
                .iter()
                .zip(&variance)
                .map(|(figure, variance)| Fitted { value: *figure, sigma: variance.sqrt() })
                .collect(),
        )
    }

    /// What tells of readings with figures of any size added, once all that the fit explains has followed them.
    pub(crate) fn sums(&self, figures: &[Figure]) -> Sums {
        let (count, unknowns) = (figures.len(), self.gradient.len());
        let mut into_unknowns = DMatrix::zeros(unknowns, count);
        let mut normal = DMatrix::zeros(count, count);
        let mut right = DVector::zeros(count);
        let scaled: Vec<Vec<(usize, DVector<f64>)>> = figures.iter().map(|figure| self.scaled(figure)).collect();
        for (k, by_test) in scaled.iter().enumerate() {
            let mut column = DVector::zeros(unknowns);
            for (test, changes) in by_test {
                self.tests[*test].add_to(&mut column, changes);
                right[k] -= changes.dot(&self.tests[*test].residual);
                for (other, others) in scaled.iter().enumerate() {
                    let same = others.iter().filter(|(of, _)| of == test);
                    normal[(k, other)] += same.map(|(_, other)| changes.dot(other)).sum::<f64>();
                }
            }
            into_unknowns.set_column(k, &column);
        }
        let taken_up = self.information.solve(&into_unknowns);
        normal -= into_unknowns.tr_mul(&taken_up);
        right += taken_up.tr_mul(&self.gradient);
        Sums { normal, right }
    }

    /// Sum of squares that the fit leaves, in units of the noise, by what it leaves in the middle: a gross reading counts as one of many.
    pub(crate) fn squares(&self, left_um: f64) -> f64 {
        let readings: usize = self.tests.iter().map(|test| test.residual.len()).sum();
        readings as f64 * (1e-3 * left_um / self.noise_mm).powi(2)
    }

    fn scaled(&self, figure: &Figure) -> Vec<(usize, DVector<f64>)> {
        let of = |(test, changes): &(usize, Vec<f64>)| {
            let read = changes.iter().map(|change| if change.is_finite() { change / self.noise_mm } else { 0.0 });
            (*test, DVector::from_iterator(changes.len(), read))
        };
        figure.by_test.iter().map(of).collect()
    }

    /// What all readings leave, as a sum of squares in units of the noise less what they leave now, where the residuals of one
    /// test are these, mm.
    pub(crate) fn left_with(&self, test: usize, residual_mm: &[f64]) -> f64 {
        let rows = &self.tests[test];
        let read = residual_mm.iter().map(|residual| if residual.is_finite() { residual / self.noise_mm } else { 0.0 });
        let changed = DVector::from_iterator(residual_mm.len(), read);
        let mut gradient = self.gradient.clone();
        rows.add_to(&mut gradient, &(&changed - &rows.residual));
        changed.norm_squared() - rows.residual.norm_squared() - gradient.dot(&self.information.solve(&gradient))
            + self.to_gain
    }
}

/// What tells of readings with figures of sizes v added: they leave `vᵀNv − 2vᵀr` more squares, in units of the noise, than without.
pub(crate) struct Sums {
    /// N and r.
    pub(crate) normal: DMatrix<f64>,
    pub(crate) right: DVector<f64>,
}

impl TestRows {
    /// Adds what changes of this test's readings pull at the unknowns.
    fn add_to(&self, gradient: &mut DVector<f64>, changes: &DVector<f64>) {
        let pulled = self.jacobian.tr_mul(changes);
        for (pull, &column) in pulled.iter().zip(&self.columns) {
            gradient[column] += pull;
        }
    }
}

/// The session with figures of these sizes added to its readings.
pub(crate) fn with_figures(session: &Session, figures: &[Figure], sizes: &[Fitted]) -> Option<Session> {
    let mut with = session.clone();
    for (figure, size) in figures.iter().zip(sizes) {
        for (test, changes) in &figure.by_test {
            let recording = with.tests[*test].recording.as_mut()?;
            recording.length_mm.iter_mut().zip(changes).for_each(|(length, change)| *length += size.value * change);
        }
    }
    Some(with)
}
