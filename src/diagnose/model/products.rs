//! Products of a block's whitened columns: with each other, with the unknowns of the fit and with the readings. It whitens nothing.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

/// Products of a block's whitened columns: with each other, with the unknowns and with the readings.
#[derive(Debug, Clone)]
pub struct Products {
    pub(super) gram: Gram,
    /// Unknowns × columns.
    pub cross: DMatrix<f64>,
    pub z: DVector<f64>,
}

/// Products with each other over all tests, or by test where every column acts in one test alone.
#[derive(Debug, Clone)]
pub(super) enum Gram {
    Whole(DMatrix<f64>),
    ByTest(Vec<Option<Arc<TestGram>>>),
}

impl Products {
    /// Products with each other over all tests.
    pub fn gram(&self) -> DMatrix<f64> {
        match &self.gram {
            Gram::Whole(gram) => gram.clone(),
            Gram::ByTest(tests) => sum(tests.iter().flatten(), self.z.len()),
        }
    }

    /// Product of a column with itself.
    pub fn square(&self, column: usize) -> f64 {
        match &self.gram {
            Gram::Whole(gram) => gram[(column, column)],
            Gram::ByTest(tests) => tests.iter().flatten().map(|own| own.square(column)).sum(),
        }
    }

    /// The same of some columns that act in one test alone.
    pub fn gram_in(&self, test: usize, columns: &[usize]) -> DMatrix<f64> {
        let count = columns.len();
        match &self.gram {
            Gram::Whole(gram) => DMatrix::from_fn(count, count, |a, b| gram[(columns[a], columns[b])]),
            Gram::ByTest(tests) => {
                let Some(own) = &tests[test] else { return DMatrix::zeros(count, count) };
                let places: Vec<Option<usize>> = columns.iter().map(|j| own.present.binary_search(j).ok()).collect();
                DMatrix::from_fn(count, count, |a, b| match (places[a], places[b]) {
                    (Some(a), Some(b)) => own.product(a, b),
                    _ => 0.0,
                })
            }
        }
    }

    /// Products of some of the columns.
    pub fn of_some(&self, columns: &[usize]) -> Products {
        let count = columns.len();
        let of = |gram: &DMatrix<f64>| DMatrix::from_fn(count, count, |a, b| gram[(columns[a], columns[b])]);
        let gram = match &self.gram {
            Gram::Whole(gram) => of(gram),
            Gram::ByTest(_) => of(&self.gram()),
        };
        Products {
            gram: Gram::Whole(gram),
            cross: self.cross.select_columns(columns),
            z: DVector::from_iterator(count, columns.iter().map(|&j| self.z[j])),
        }
    }

    /// The same where squares of the readings count so many times as much.
    pub(super) fn weighted(mut self, weight: f64) -> Products {
        if weight != 1.0 {
            let times = |own: &Arc<TestGram>| {
                let sums = own.sums.iter().map(|sum| weight * sum).collect();
                Arc::new(TestGram { present: own.present.clone(), sums })
            };
            self.gram = match self.gram {
                Gram::Whole(gram) => Gram::Whole(gram * weight),
                Gram::ByTest(tests) => Gram::ByTest(tests.iter().map(|own| own.as_ref().map(times)).collect()),
            };
            self.cross *= weight;
            self.z *= weight;
        }
        self
    }

    /// Numbers that it holds.
    pub(super) fn values(&self) -> usize {
        let gram = match &self.gram {
            Gram::Whole(gram) => gram.len(),
            Gram::ByTest(tests) => tests.iter().flatten().map(|own| own.sums.len()).sum(),
        };
        gram + self.cross.len() + self.z.len()
    }
}

/// Sum over tests of the products of `count` columns.
pub(super) fn sum<'t>(tests: impl Iterator<Item = &'t Arc<TestGram>>, count: usize) -> DMatrix<f64> {
    let mut gram = DMatrix::zeros(count, count);
    for own in tests {
        for (a, &j) in own.present.iter().enumerate() {
            own.present.iter().enumerate().for_each(|(b, &k)| gram[(j, k)] += own.product(a, b));
        }
    }
    gram
}

/// Products with each other of the columns that act in a test.
#[derive(Debug)]
pub(super) struct TestGram {
    pub(super) present: Vec<usize>,
    /// Row by row, lower triangle.
    pub(super) sums: Vec<f64>,
}

impl TestGram {
    /// Product of a column with itself; nothing where it does not act.
    fn square(&self, column: usize) -> f64 {
        self.present.binary_search(&column).map_or(0.0, |a| self.product(a, a))
    }

    /// Product of two of the present columns.
    fn product(&self, a: usize, b: usize) -> f64 {
        self.sums[a.max(b) * self.present.len() + a.min(b)]
    }
}
