//! The shape judged last, by test: what a shape has in common with it is not worked out again. It whitens nothing.

use std::sync::Arc;

use super::kept_rows::KeptRows;
use super::products::TestGram;
use crate::statistics::{add_cross_products, add_products, add_products_with};

/// The columns last judged with their products, by test: neighbouring shapes share those of most tests, and a shape that is
/// tried with further periods shares those of its first ones.
#[derive(Default)]
pub struct LastShape {
    by_test: Vec<Option<TestProducts>>,
    with: Vec<Option<ProductsWith>>,
    block: Vec<f64>,
    present: Vec<usize>,
}

/// Products of a block in one test: with each other, and with what the test sees, the readings last.
pub(super) struct TestProducts {
    /// The columns that act there, as they are, one after the other.
    block: Vec<f64>,
    /// The same whitened, over the rows that are kept.
    white: Vec<f64>,
    pub gram: Arc<TestGram>,
    /// What the test sees × own.
    pub cross: Vec<f64>,
}

/// Products of a block in one test with columns of a model.
struct ProductsWith {
    block: Vec<f64>,
    model: Vec<u64>,
    /// Own × model.
    sums: Vec<f64>,
}

impl LastShape {
    /// Products of a block in one test of `rows` rows with each other and with the columns of `base`; `None` where no column acts.
    /// `fill` tells the block and which of the columns act, `whiten` filters columns.
    pub(super) fn products_in(
        &mut self,
        test: usize,
        rows: usize,
        base: &[f64],
        whiten: impl Fn(&mut Vec<f64>),
        fill: impl Fn(usize, &mut Vec<f64>, &mut Vec<usize>),
    ) -> Option<&TestProducts> {
        fill(test, &mut self.block, &mut self.present);
        let LastShape { by_test, block, present, .. } = self;
        let memory = of_test(by_test, test);
        if present.is_empty() {
            *memory = None;
            return None;
        }
        if memory.as_ref().is_some_and(|memory| memory.gram.present == *present && memory.block == *block) {
            return memory.as_ref();
        }
        let before = memory.take();
        let known = before.as_ref().map_or(vec![None; present.len()], |before| equal(block, &before.block, rows));
        let new = of_unknown(block, &known, rows);
        let mut white = new.concat();
        whiten(&mut white);
        let products = match before.filter(|_| known.iter().any(Option::is_some)) {
            Some(before) => before.joined(&known, base, white),
            None => TestProducts::of(base, white, present.len()),
        };
        let gram = Arc::new(TestGram { present: present.clone(), sums: products.gram });
        *memory = Some(TestProducts { block: block.clone(), white: products.white, gram, cross: products.cross });
        memory.as_ref()
    }

    /// Products of a block in one test with columns of a model that were whitened twice, each with what tells it from others: which of
    /// the columns act, and own × model; `None` where none acts.
    pub(super) fn products_with<'c>(
        &mut self,
        test: usize,
        kept: &KeptRows,
        model: impl Iterator<Item = (u64, &'c [f64])>,
        fill: impl Fn(usize, &mut Vec<f64>, &mut Vec<usize>),
    ) -> Option<(&[usize], &[f64])> {
        fill(test, &mut self.block, &mut self.present);
        let LastShape { with, block, present, .. } = self;
        if present.is_empty() {
            return None;
        }
        let (model, columns): (Vec<u64>, Vec<&[f64]>) = model.unzip();
        let memory = of_test(with, test);
        let before = memory.take().filter(|before| before.model == model);
        let known = before.as_ref().map_or(vec![None; present.len()], |before| equal(block, &before.block, kept.all()));
        let mut new = of_unknown(block, &known, kept.all()).concat();
        kept.gather(&mut new);
        let mut of_new = vec![0.0; new.len() / kept.count().max(1) * columns.len()];
        add_products_with(&new, &columns, kept.count(), &mut of_new);
        let mut of_new = of_new.chunks_exact(columns.len());
        let before = before.as_ref().map_or(&[][..], |before| &before.sums);
        let own = |known: &Option<usize>| match known {
            Some(at) => &before[at * columns.len()..(at + 1) * columns.len()],
            None => of_new.next().unwrap_or_default(),
        };
        let sums: Vec<f64> = known.iter().flat_map(own).copied().collect();
        let now = memory.insert(ProductsWith { block: block.clone(), model, sums });
        Some((present, &now.sums))
    }
}

/// Products of some columns.
struct Sums {
    white: Vec<f64>,
    /// Row by row, lower triangle.
    gram: Vec<f64>,
    cross: Vec<f64>,
}

impl TestProducts {
    /// Products of `count` whitened columns, none of which is known.
    fn of(base: &[f64], white: Vec<f64>, count: usize) -> Sums {
        let rows = white.len() / count;
        let mut gram = vec![0.0; count * count];
        add_products(&white, rows, count, &mut gram);
        let mut cross = vec![0.0; base.len() / rows * count];
        add_cross_products(base, &white, rows, &mut cross);
        Sums { white, gram, cross }
    }

    /// Those of a block with columns of this one, `known`, and others, `new` whitened.
    fn joined(&self, known: &[Option<usize>], base: &[f64], new: Vec<f64>) -> Sums {
        let (count, before) = (known.len(), self.gram.present.len());
        let rows = self.white.len() / before;
        let seen = base.len() / rows;
        // by column: its place among the new ones
        let mut places = 0;
        let place_of = |known: &Option<usize>| {
            places += usize::from(known.is_none());
            places.saturating_sub(1)
        };
        let place: Vec<usize> = known.iter().map(place_of).collect();
        let column = |k: usize| match known[k] {
            Some(at) => &self.white[at * rows..(at + 1) * rows],
            None => &new[place[k] * rows..(place[k] + 1) * rows],
        };
        let white: Vec<f64> = (0..count).flat_map(column).copied().collect();
        let mut with_all = vec![0.0; new.len() / rows * count];
        add_cross_products(&new, &white, rows, &mut with_all);
        let mut with_base = vec![0.0; seen * (new.len() / rows)];
        add_cross_products(base, &new, rows, &mut with_base);
        let mut gram = vec![0.0; count * count];
        for a in 0..count {
            for b in 0..=a {
                gram[a * count + b] = match (known[a], known[b]) {
                    (Some(one), Some(other)) => self.gram.product(one, other),
                    (None, _) => with_all[place[a] * count + b],
                    (_, None) => with_all[place[b] * count + a],
                };
            }
        }
        let in_row = |row: usize| {
            let (place, new) = (&place, new.len() / rows);
            let with_base = &with_base;
            known.iter().enumerate().map(move |(k, known)| match known {
                Some(at) => self.cross[row * before + at],
                None => with_base[row * new + place[k]],
            })
        };
        let cross = (0..seen).flat_map(in_row).collect();
        Sums { white, gram, cross }
    }
}

/// What is remembered of a test.
fn of_test<T>(by_test: &mut Vec<Option<T>>, test: usize) -> &mut Option<T> {
    if by_test.len() <= test {
        by_test.resize_with(test + 1, || None);
    }
    &mut by_test[test]
}

/// By column of a block: the column of another one that is equal, each of `rows` numbers.
fn equal(block: &[f64], other: &[f64], rows: usize) -> Vec<Option<usize>> {
    block.chunks_exact(rows).map(|column| other.chunks_exact(rows).position(|known| known == column)).collect()
}

/// Columns of a block that are not known.
fn of_unknown<'b>(block: &'b [f64], known: &[Option<usize>], rows: usize) -> Vec<&'b [f64]> {
    let unknown = block.chunks_exact(rows).zip(known).filter(|(_, known)| known.is_none());
    unknown.map(|(column, _)| column).collect()
}
