//! A column that joins a model, whitened once for all sets of effects that it is tried in. It fits nothing.

use std::sync::{Arc, OnceLock};

use super::linear_model::Column;
use crate::statistics::add_cross_products;

/// A column of a model under one noise.
pub struct FittedColumn {
    /// The column as it is: what keeps its values where they are.
    column: Column,
    /// The one test in which it acts, if it is one.
    pub home: Option<usize>,
    /// By test, over the rows that are kept; empty where it does nothing.
    pub white: Vec<Vec<f64>>,
    /// By test: products with the unknowns that the test sees, and with the readings.
    pub with_base: Vec<Vec<f64>>,
    /// Whitened twice: its products with a column are those of both whitened.
    twice: OnceLock<Vec<Vec<f64>>>,
}

impl FittedColumn {
    /// A column under a noise: `whiten` filters a test's column and leaves the kept rows, `base` holds what the test's sums are taken with.
    pub fn new<'w>(
        column: &Column,
        whiten: impl Fn(usize, &mut Vec<f64>),
        base: impl Fn(usize) -> &'w [f64],
    ) -> FittedColumn {
        let in_test = |(test, rows): (usize, &Vec<f64>)| {
            let (mut own, mut sums) = (rows.clone(), Vec::new());
            if !own.is_empty() {
                whiten(test, &mut own);
                sums.resize(base(test).len() / own.len(), 0.0);
                add_cross_products(base(test), &own, own.len(), &mut sums);
            }
            (own, sums)
        };
        let (white, with_base) = column.by_test.iter().enumerate().map(in_test).unzip();
        FittedColumn { column: column.clone(), home: column.home(), white, with_base, twice: OnceLock::new() }
    }

    /// What tells it from all other columns.
    pub fn id(&self) -> u64 {
        self.column.id
    }

    /// Whether anyone else still has the column.
    pub fn is_in_use(&self) -> bool {
        Arc::strong_count(&self.column.by_test) > 1
    }

    /// Its values whitened and, by the transpose of the filter, once more; by test, over the rows that are kept.
    pub fn twice(&self, whiten_again: impl Fn(usize, &mut Vec<f64>)) -> &[Vec<f64>] {
        self.twice.get_or_init(|| {
            let mut twice = self.white.clone();
            let acting = twice.iter_mut().enumerate().filter(|(_, rows)| !rows.is_empty());
            acting.for_each(|(test, rows)| whiten_again(test, rows));
            twice
        })
    }

    /// Numbers that it holds.
    pub fn values(&self) -> usize {
        2 * self.white.iter().map(Vec::len).sum::<usize>()
    }
}
