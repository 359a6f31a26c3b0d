//! The shape judged last, by test: what a shape has in common with it is not worked out again. It whitens nothing.

use std::borrow::Cow;
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
        let mut white = of_unknown(block, &known, rows);
        whiten(&mut white);
        let products = match before.as_ref().filter(|_| known.iter().any(Option::is_some)) {
            Some(before) => before.joined(&known, base, white),
            None => TestProducts::of(base, white, present.len()),
        };
        let gram = Arc::new(TestGram { present: present.clone(), sums: products.gram });
        // the memory of the former block is written next
        let written = std::mem::replace(block, before.map(|before| before.block).unwrap_or_default());
        *memory = Some(TestProducts { block: written, white: products.white, gram, cross: products.cross });
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
        let before = memory.take();
        let same = before.as_ref().filter(|before| before.model == model);
        let known = same.map_or(vec![None; present.len()], |before| equal(block, &before.block, kept.all()));
        let of_new = products_of_unknown(block, &known, kept, &columns);
        let sums = match same.filter(|_| known.iter().any(Option::is_some)) {
            Some(same) => in_order(&known, &same.sums, &of_new, columns.len()),
            None => of_new,
        };
        let written = std::mem::replace(block, before.map(|before| before.block).unwrap_or_default());
        let now = memory.insert(ProductsWith { block: written, model, sums });
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
        let white = in_order(known, &self.white, &new, rows);
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
    let of = |(place, column): (usize, &[f64])| {
        // most stand where they stood
        let here = other.chunks_exact(rows).nth(place).filter(|known| *known == column).map(|_| place);
        here.or_else(|| other.chunks_exact(rows).position(|known| known == column))
    };
    block.chunks_exact(rows).enumerate().map(of).collect()
}

/// Columns of a block that are not known, one after the other.
fn of_unknown(block: &[f64], known: &[Option<usize>], rows: usize) -> Vec<f64> {
    let mut unknown = Vec::with_capacity(block.len());
    let all = block.chunks_exact(rows).zip(known);
    all.filter(|(_, known)| known.is_none()).for_each(|(column, _)| unknown.extend_from_slice(column));
    unknown
}

/// Products of the columns of a block that are not known with others: those × others.
fn products_of_unknown(block: &[f64], known: &[Option<usize>], kept: &KeptRows, others: &[&[f64]]) -> Vec<f64> {
    let mut new = Cow::Borrowed(block);
    if known.iter().any(Option::is_some) {
        new = Cow::Owned(of_unknown(block, known, kept.all()));
    }
    if kept.count() < kept.all() {
        kept.gather(new.to_mut());
    }
    let mut sums = vec![0.0; new.len() / kept.count().max(1) * others.len()];
    add_products_with(&new, others, kept.count(), &mut sums);
    sums
}

/// Rows of `width` numbers in the order of a block: the known ones from before, the others from `of_new`.
fn in_order(known: &[Option<usize>], before: &[f64], of_new: &[f64], width: usize) -> Vec<f64> {
    let mut of_new = of_new.chunks_exact(width);
    let mut all = Vec::with_capacity(known.len() * width);
    for known in known {
        all.extend_from_slice(match known {
            Some(at) => &before[at * width..(at + 1) * width],
            None => of_new.next().unwrap_or_default(),
        });
    }
    all
}
