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
        self.gram.whole(self.z.len())
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

    /// Numbers that it holds.
    fn values(&self) -> usize {
        let gram = match &self.gram {
            Gram::Whole(gram) => gram.len(),
            Gram::ByTest(tests) => tests.iter().flatten().map(|own| own.sums.len()).sum(),
        };
        gram + self.cross.len() + self.z.len()
    }
}

/// Products by group of tests, for readings of one group count as many times as they were whitened for.
#[derive(Debug, Clone)]
pub(super) struct ByGroup(pub Vec<Products>);

impl ByGroup {
    /// Products over all tests where squares of the readings of each group count so many times.
    pub fn weighted(self, weights: &[f64]) -> Products {
        debug_assert!(weights.len() >= self.0.len(), "a group without a weight");
        let mut all = self.0.into_iter().zip(weights).map(|(own, weight)| own.times(*weight));
        let first = all.next().unwrap_or_else(Products::none);
        all.fold(first, Products::with)
    }

    /// Products of some of the columns.
    pub fn of_some(&self, columns: &[usize]) -> ByGroup {
        ByGroup(self.0.iter().map(|own| own.of_some(columns)).collect())
    }

    /// Numbers that it holds.
    pub fn values(&self) -> usize {
        self.0.iter().map(Products::values).sum()
    }
}

impl Products {
    /// Products of no columns.
    fn none() -> Products {
        Products { gram: Gram::ByTest(Vec::new()), cross: DMatrix::zeros(0, 0), z: DVector::zeros(0) }
    }

    /// The same where squares of the readings count so many times as much.
    fn times(self, weight: f64) -> Products {
        if weight == 1.0 {
            return self;
        }
        let times = |own: &Arc<TestGram>| {
            let sums = own.sums.iter().map(|sum| weight * sum).collect();
            Arc::new(TestGram { present: own.present.clone(), sums })
        };
        let gram = match self.gram {
            Gram::Whole(gram) => Gram::Whole(gram * weight),
            Gram::ByTest(tests) => Gram::ByTest(tests.iter().map(|own| own.as_ref().map(times)).collect()),
        };
        Products { gram, cross: self.cross * weight, z: self.z * weight }
    }

    /// The sum with products of the same columns over other tests.
    fn with(self, other: Products) -> Products {
        let gram = match (self.gram, other.gram) {
            (Gram::ByTest(own), Gram::ByTest(others)) => {
                Gram::ByTest(own.into_iter().zip(others).map(|(own, other)| own.or(other)).collect())
            }
            (own, others) => {
                let count = self.z.len();
                Gram::Whole(own.whole(count) + others.whole(count))
            }
        };
        Products { gram, cross: self.cross + other.cross, z: self.z + other.z }
    }
}

impl Gram {
    /// Products of `count` columns over all tests.
    fn whole(&self, count: usize) -> DMatrix<f64> {
        match self {
            Gram::Whole(gram) => gram.clone(),
            Gram::ByTest(tests) => sum(tests.iter().flatten(), count),
        }
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
    pub(super) fn product(&self, a: usize, b: usize) -> f64 {
        self.sums[a.max(b) * self.present.len() + a.min(b)]
    }
}
