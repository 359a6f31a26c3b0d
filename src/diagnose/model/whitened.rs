//! A session under one noise: readings and unknowns whitened once, and the products of shapes that were judged before. It fits nothing.

use crate::statistics::{NoiseModel, Whitener, add_cross_products, add_products};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::linear_model::{Column, LinearModel, Term};
use super::shapes::name;
use crate::effects::Profile;
use crate::machine::Effect;

/// Most values of products that are kept, 8 bytes each.
const MOST_VALUES: usize = 32_000_000;

/// Readings and unknowns of a session, whitened.
pub struct WhitenedData<'g, 'a> {
    pub model: &'g LinearModel<'a>,
    whiteners: Vec<Whitener>,
    /// By test: whitened columns of the unknowns that it sees, one after the other, the whitened readings last.
    white: Vec<Vec<f64>>,
    known: Mutex<Known>,
}

/// Products of shapes that were judged before.
#[derive(Default)]
struct Known {
    by_shape: HashMap<(usize, String), Arc<Products>>,
    values: usize,
}

/// Products of a block's whitened columns: with each other, with the unknowns and with the readings.
#[derive(Debug, Clone)]
pub struct Products {
    gram: Gram,
    /// Unknowns × columns.
    pub cross: DMatrix<f64>,
    pub z: DVector<f64>,
}

/// Products with each other over all tests, or by test where every column acts in one test alone.
#[derive(Debug, Clone)]
enum Gram {
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

    /// Numbers that it holds.
    fn values(&self) -> usize {
        let gram = match &self.gram {
            Gram::Whole(gram) => gram.len(),
            Gram::ByTest(tests) => tests.iter().flatten().map(|own| own.sums.len()).sum(),
        };
        gram + self.cross.len() + self.z.len()
    }
}

/// Sum over tests of the products of `count` columns.
fn sum<'t>(tests: impl Iterator<Item = &'t Arc<TestGram>>, count: usize) -> DMatrix<f64> {
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
struct TestGram {
    present: Vec<usize>,
    /// Row by row, lower triangle.
    sums: Vec<f64>,
}

impl TestGram {
    /// Product of two of the present columns.
    fn product(&self, a: usize, b: usize) -> f64 {
        self.sums[a.max(b) * self.present.len() + a.min(b)]
    }
}

/// Products of a block in one test: with each other, and with what the test sees, the readings last.
#[derive(Debug, Clone)]
struct TestProducts {
    gram: Arc<TestGram>,
    cross: Vec<f64>,
}

/// Columns in one test with their products.
type Remembered = (Vec<Vec<f64>>, TestProducts);

/// The columns last judged with their products, by test: neighbouring shapes share those of most tests.
#[derive(Default)]
pub struct LastShape {
    by_test: Vec<Option<Remembered>>,
}

impl<'g, 'a> WhitenedData<'g, 'a> {
    /// Whitens the rows `kept` of the ground.
    pub fn new(model: &'g LinearModel<'a>, noise: &[NoiseModel], kept: &[Vec<bool>]) -> WhitenedData<'g, 'a> {
        let parts: Vec<_> = (0..model.tests())
            .into_par_iter()
            .map(|test| {
                let whitener = Whitener::new(&noise[test], &kept[test]);
                let residual = &model.residual_mm[test];
                let seen = &model.problem.tests[test].columns;
                let mut white = Vec::with_capacity((seen.len() + 1) * residual.len());
                seen.iter().for_each(|&k| white.extend(model.nuisance[test].column(k).iter()));
                white.extend(residual);
                whitener.apply_all(&mut white);
                (whitener, white)
            })
            .collect();
        let (whiteners, white) = parts.into_iter().unzip();
        WhitenedData { model, whiteners, white, known: Mutex::default() }
    }

    /// Whitened columns of the unknowns that a test sees, and its readings.
    pub fn columns(&self, test: usize) -> (&[f64], &[f64]) {
        let readings = self.model.residual_mm[test].len();
        self.white[test].split_at(self.white[test].len() - readings)
    }

    /// Whitens columns of a test that lie one after the other, in place.
    pub fn whiten(&self, test: usize, columns: &mut [f64]) {
        self.whiteners[test].apply_all(columns);
    }

    /// The transpose of the filter, in place.
    pub fn whiten_transposed(&self, test: usize, column: &mut [f64]) {
        self.whiteners[test].apply_transposed(column);
    }

    /// Products of a shape of the family with this number.
    pub fn products_of(
        &self,
        (family, effect): (usize, &Effect),
        (profiles, terms): (&[Profile], &[Term]),
        last: &mut LastShape,
    ) -> Arc<Products> {
        let key = (family, name(effect));
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(products) = known().by_shape.get(&key) {
            return products.clone();
        }
        let products = Arc::new(self.products(&self.model.columns_of(profiles, terms), last));
        let mut known = known();
        if known.values + products.values() <= MOST_VALUES {
            known.values += products.values();
            known.by_shape.insert(key, products.clone());
        }
        products
    }

    /// Products of a block.
    pub fn products(&self, columns: &[Column], last: &mut LastShape) -> Products {
        let count = columns.len();
        let mut grams = Vec::with_capacity(self.model.tests());
        let mut products = Products {
            gram: Gram::ByTest(Vec::new()),
            cross: DMatrix::zeros(self.model.problem.unknowns.len(), count),
            z: DVector::zeros(count),
        };
        last.by_test.resize(self.model.tests(), None);
        for (test, memory) in last.by_test.iter_mut().enumerate() {
            let same = |(remembered, _): &Remembered| {
                columns.len() == remembered.len()
                    && columns.iter().zip(remembered).all(|(column, before)| column.by_test[test] == *before)
            };
            if !memory.as_ref().is_some_and(same) {
                let own = || columns.iter().map(|column| column.by_test[test].clone()).collect();
                *memory = self.test_products(test, columns).map(|sums| (own(), sums));
            }
            grams.push(memory.as_ref().map(|(_, sums)| sums.gram.clone()));
            let Some((_, sums)) = memory else { continue };
            let own = sums.gram.present.len();
            let seen = &self.model.problem.tests[test].columns;
            for (local, &k) in seen.iter().enumerate() {
                for (a, &j) in sums.gram.present.iter().enumerate() {
                    products.cross[(k, j)] += sums.cross[local * own + a];
                }
            }
            for (a, &j) in sums.gram.present.iter().enumerate() {
                products.z[j] += sums.cross[seen.len() * own + a];
            }
        }
        let acts_once = |column: &Column| column.by_test.iter().filter(|rows| !rows.is_empty()).count() < 2;
        products.gram = match columns.iter().all(acts_once) {
            true => Gram::ByTest(grams),
            false => Gram::Whole(sum(grams.iter().flatten(), count)),
        };
        products
    }

    /// What one test adds to the products of a block; `None` when the block does nothing there.
    fn test_products(&self, test: usize, columns: &[Column]) -> Option<TestProducts> {
        let present: Vec<usize> = (0..columns.len()).filter(|&j| !columns[j].by_test[test].is_empty()).collect();
        if present.is_empty() {
            return None;
        }
        let rows = self.model.residual_mm[test].len();
        let (own, seen) = (present.len(), self.model.problem.tests[test].columns.len());
        let mut block = Vec::with_capacity(rows * own);
        present.iter().for_each(|&j| block.extend_from_slice(&columns[j].by_test[test]));
        self.whiteners[test].apply_all(&mut block);
        let (mut sums, mut cross) = (vec![0.0; own * own], vec![0.0; (seen + 1) * own]);
        add_products(&block, rows, own, &mut sums);
        add_cross_products(&self.white[test], &block, rows, &mut cross);
        Some(TestProducts { gram: Arc::new(TestGram { present, sums }), cross })
    }
}
