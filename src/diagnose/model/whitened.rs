//! A session under one noise: readings and unknowns whitened once, and the products of shapes that were judged before. It fits nothing.

use crate::statistics::{NoiseModel, Whitener, add_products};
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::fitted_column::FittedColumn;
use super::kept_rows::KeptRows;
use super::last_shape::LastShape;
use super::linear_model::{Column, LinearModel, Shape, Term};
use super::products::{ByGroup, Gram, Products, TestGram, sum};
use crate::effects::Profile;

/// Most values of products that are kept, of those with columns of models, and of these columns, 8 bytes each.
const MOST_VALUES: usize = 32_000_000;

/// Readings and unknowns of a session, whitened.
pub struct WhitenedData<'g, 'a> {
    pub model: &'g LinearModel<'a>,
    whiteners: Vec<Whitener>,
    kept: Vec<KeptRows>,
    /// By test: the group whose readings are weighted together.
    groups: Vec<usize>,
    /// By test: whitened columns of the unknowns that it sees over the rows that are kept, one after the other, the whitened
    /// readings last.
    white: Vec<Vec<f64>>,
    /// By test: their products with each other, row by row, lower triangle.
    sums: Vec<Vec<f64>>,
    known: Mutex<Known>,
    columns: Mutex<KnownColumns>,
    /// Values of products with columns of models.
    with_values: AtomicUsize,
}

/// Shapes that were judged before.
#[derive(Default)]
struct Known {
    by_shape: HashMap<String, Arc<KnownShape>>,
    values: usize,
}

/// Columns of models that were fitted before.
#[derive(Default)]
struct KnownColumns {
    by_id: HashMap<u64, Arc<FittedColumn>>,
    values: usize,
}

/// What is known of a shape.
pub struct KnownShape {
    /// Terms of its columns: those of all families that have the shape.
    terms: Vec<Term>,
    products: ByGroup,
    with: Mutex<With>,
}

/// Products of a shape with columns of models that act in several tests.
#[derive(Default)]
struct With {
    /// Places in `sums` by column.
    places: HashMap<u64, usize>,
    /// Column of a model after column, group after group, one number for each of the shape's columns.
    sums: Vec<f64>,
}

impl With {
    /// Keeps the products with these columns alone, each of `count` numbers.
    fn keep(&mut self, live: &HashSet<u64>, count: usize) {
        let (mut sums, mut kept) = (Vec::new(), 0);
        self.places.retain(|id, place| {
            let is_live = live.contains(id);
            if is_live {
                sums.extend_from_slice(&self.sums[*place * count..(*place + 1) * count]);
                *place = kept;
                kept += 1;
            }
            is_live
        });
        self.sums = sums;
    }
}

/// Products of some columns of a shape, and those with the columns of a model (model × own), both weighted.
pub struct ShapeProducts {
    pub products: Products,
    pub with: DMatrix<f64>,
}

impl<'g, 'a> WhitenedData<'g, 'a> {
    /// Whitens the rows `kept` of the model.
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
                let kept = KeptRows::of(&kept[test]);
                kept.gather(&mut white);
                let width = seen.len() + 1;
                let mut sums = vec![0.0; width * width];
                add_products(&white, kept.count(), width, &mut sums);
                ((whitener, kept), (white, sums))
            })
            .collect();
        let (filters, parts): (Vec<_>, Vec<_>) = parts.into_iter().unzip();
        let (whiteners, kept) = filters.into_iter().unzip();
        let (white, sums) = parts.into_iter().unzip();
        let groups = vec![0; model.tests()];
        let (known, columns, with_values) = (Mutex::default(), Mutex::default(), AtomicUsize::new(0));
        WhitenedData { model, whiteners, kept, groups, white, sums, known, columns, with_values }
    }

    /// The same where the readings of each group of tests, by number from 0, have a weight of their own.
    pub fn grouped(self, groups: Vec<usize>) -> WhitenedData<'g, 'a> {
        WhitenedData { groups, ..self }
    }

    /// By test: the group whose readings are weighted together.
    pub fn groups(&self) -> &[usize] {
        &self.groups
    }

    /// How many groups there are.
    pub fn group_count(&self) -> usize {
        self.groups.iter().max().map_or(1, |last| last + 1)
    }

    /// Rows of a test that are kept: so many numbers has a whitened column.
    pub fn rows(&self, test: usize) -> usize {
        self.kept[test].count()
    }

    /// Whitened columns of the unknowns that a test sees, one after the other, its readings last.
    pub fn base(&self, test: usize) -> &[f64] {
        &self.white[test]
    }

    /// Products of these with each other, row by row, lower triangle.
    pub fn base_sums(&self, test: usize) -> &[f64] {
        &self.sums[test]
    }

    /// Whitens columns of a test that lie one after the other; only kept rows remain.
    fn whiten(&self, test: usize, columns: &mut Vec<f64>) {
        self.whiteners[test].apply_all(columns);
        self.kept[test].gather(columns);
    }

    /// The transpose of the filter: from the rows that are kept to all rows, zero in the others.
    pub fn whiten_transposed(&self, test: usize, column: &mut Vec<f64>) {
        self.kept[test].spread(column);
        self.whiteners[test].apply_transposed(column);
    }

    /// A column of a model, whitened.
    pub fn fitted_column(&self, column: &Column) -> Arc<FittedColumn> {
        if let Some(known) = locked(&self.columns).by_id.get(&column.id) {
            return known.clone();
        }
        let whiten = |test: usize, rows: &mut Vec<f64>| self.whiten(test, rows);
        let fitted = Arc::new(FittedColumn::new(column, whiten, |test| self.base(test)));
        if locked(&self.columns).values + fitted.values() > MOST_VALUES {
            self.forget_unused_columns();
        }
        let mut known = locked(&self.columns);
        if known.values + fitted.values() <= MOST_VALUES {
            known.values += fitted.values();
            known.by_id.insert(fitted.id(), fitted.clone());
        }
        fitted
    }

    /// Drops what is known of columns that nobody has any more: a search replaces a shape by a better one many times.
    fn forget_unused_columns(&self) {
        let live: HashSet<u64> = {
            let mut known = locked(&self.columns);
            let before = known.by_id.len();
            known.by_id.retain(|_, column| column.is_in_use());
            if known.by_id.len() == before {
                return;
            }
            known.values = known.by_id.values().map(|column| column.values()).sum();
            known.by_id.keys().copied().collect()
        };
        let shapes: Vec<Arc<KnownShape>> = locked(&self.known).by_shape.values().cloned().collect();
        let groups = self.group_count();
        let left = shapes.iter().map(|shape| {
            let mut with = locked(&shape.with);
            with.keep(&live, groups * shape.terms.len());
            with.sums.len()
        });
        self.with_values.store(left.sum(), Ordering::Relaxed);
    }

    /// Products of the shape with this name of the family with this number, also with columns of a model.
    pub fn products_of(
        &self,
        (family, name): (usize, &str),
        (profiles, terms): (&[Profile], &[Term]),
        (model, weights): (&[Arc<FittedColumn>], &[f64]),
        last: &mut LastShape,
    ) -> ShapeProducts {
        let together = self.model.together(name).and_then(|all| Some((all, places(all, terms)?)));
        let own = || Cow::Owned(format!("{family} {name}"));
        let (key, all, places) = match together {
            Some((all, places)) => (Cow::Borrowed(name), all, Some(places)),
            None => (own(), terms, None),
        };
        let known = locked(&self.known).by_shape.get(key.as_ref()).cloned();
        let known = known.unwrap_or_else(|| {
            let products = self.products_of_shape(&self.model.shape(profiles, all), last);
            let known = Arc::new(KnownShape { terms: all.to_vec(), products, with: Mutex::default() });
            self.keep(key.into_owned(), &known);
            known
        });
        let with = self.products_with(&known, profiles, (model, weights), last);
        // of the families that share a shape most have a few of its columns
        match places {
            Some(places) => ShapeProducts {
                products: known.products.of_some(&places).weighted(weights),
                with: with.select_columns(&places),
            },
            None => ShapeProducts { products: known.products.clone().weighted(weights), with },
        }
    }

    /// Remembers a shape as long as there is room.
    fn keep(&self, key: String, shape: &Arc<KnownShape>) {
        let mut known = locked(&self.known);
        let values = shape.products.values();
        if known.values + values <= MOST_VALUES {
            known.values += values;
            known.by_shape.insert(key, shape.clone());
        }
    }

    /// Products of a shape with columns of a model: model × own. Of those that act in one test alone there may be very many,
    /// each soon worked out: they are not kept.
    fn products_with(
        &self,
        known: &Arc<KnownShape>,
        profiles: &[Profile],
        (model, weights): (&[Arc<FittedColumn>], &[f64]),
        last: &mut LastShape,
    ) -> DMatrix<f64> {
        let count = known.terms.len();
        let all_groups = count * self.group_count();
        let mut with = locked(&known.with);
        let places: Vec<Option<usize>> = model.iter().map(|column| with.places.get(&column.id()).copied()).collect();
        let is_new = |&(_, place): &(_, &Option<usize>)| place.is_none();
        let new: Vec<&Arc<FittedColumn>> = model.iter().zip(&places).filter(is_new).map(|(column, _)| column).collect();
        let mut sums = Vec::new();
        if !new.is_empty() {
            let shape = self.model.shape(profiles, &known.terms);
            sums = self.sums_with(&new, count, last, |test, block, present| shape.fill(test, block, present));
        }
        let mut all = DMatrix::zeros(model.len(), count);
        let mut of_new = sums.iter();
        for (i, place) in places.iter().enumerate() {
            let row = match place {
                Some(at) => Some(&with.sums[at * all_groups..(at + 1) * all_groups]),
                None => of_new.next().map(Vec::as_slice),
            };
            add_weighted(&mut all, i, row.unwrap_or_default(), weights);
        }
        // a shape that there was no room for goes after this
        if Arc::strong_count(known) == 1 {
            return all;
        }
        // products with a column that nothing keeps would stay for good
        let is_kept = |column: &FittedColumn| locked(&self.columns).by_id.contains_key(&column.id());
        for (column, sums) in new.iter().zip(&sums).filter(|(column, _)| column.home.is_none() && is_kept(column)) {
            if self.with_values.load(Ordering::Relaxed) + sums.len() > MOST_VALUES {
                break;
            }
            self.with_values.fetch_add(sums.len(), Ordering::Relaxed);
            let place = with.places.len();
            with.places.insert(column.id(), place);
            with.sums.extend(sums);
        }
        all
    }

    /// Products of `count` columns with columns of a model, by these, group after group; `fill` tells the columns in a test.
    pub fn sums_with(
        &self,
        model: &[&Arc<FittedColumn>],
        count: usize,
        last: &mut LastShape,
        fill: impl Fn(usize, &mut Vec<f64>, &mut Vec<usize>),
    ) -> Vec<Vec<f64>> {
        let mut all = vec![vec![0.0; self.group_count() * count]; model.len()];
        let again = |test: usize, rows: &mut Vec<f64>| {
            self.whiten_transposed(test, rows);
            self.kept[test].gather(rows);
        };
        let twice: Vec<&[Vec<f64>]> = model.iter().map(|column| column.twice(again)).collect();
        for test in 0..self.model.tests() {
            if twice.iter().all(|column| column[test].is_empty()) {
                continue;
            }
            let acting: Vec<usize> = (0..twice.len()).filter(|&k| !twice[k][test].is_empty()).collect();
            let columns = acting.iter().map(|&k| (model[k].id(), twice[k][test].as_slice()));
            let Some((present, sums)) = last.products_with(test, &self.kept[test], columns, &fill) else { continue };
            let first = self.groups[test] * count;
            for (&j, sums) in present.iter().zip(sums.chunks_exact(acting.len())) {
                acting.iter().zip(sums).for_each(|(&k, sum)| all[k][first + j] += sum);
            }
        }
        all
    }

    /// Products of a block, weighted by group.
    pub fn products(&self, columns: &[Column], weights: &[f64]) -> Products {
        self.products_in(0..self.model.tests(), columns, weights)
    }

    /// Products of a block over some tests.
    pub fn products_in(&self, tests: Range<usize>, columns: &[Column], weights: &[f64]) -> Products {
        let products = self.products_by(tests, columns.len(), &mut LastShape::default(), |test, block, present| {
            fill(columns, test, block, present);
        });
        products.weighted(weights)
    }

    /// Products of the unknowns with each other over some tests.
    pub fn normal_in(&self, tests: Range<usize>) -> DMatrix<f64> {
        let count = self.model.problem.unknowns.len();
        let mut normal = DMatrix::zeros(count, count);
        for test in tests {
            let seen = &self.model.problem.tests[test].columns;
            let product = |a: usize, b: usize| self.sums[test][a.max(b) * (seen.len() + 1) + a.min(b)];
            for (a, &i) in seen.iter().enumerate() {
                seen.iter().enumerate().for_each(|(b, &j)| normal[(i, j)] += product(a, b));
            }
        }
        normal
    }

    /// Products of a shape.
    fn products_of_shape(&self, shape: &Shape, last: &mut LastShape) -> ByGroup {
        self.products_by(0..self.model.tests(), shape.columns(), last, |test, block, present| {
            shape.fill(test, block, present)
        })
    }

    /// Products of `count` columns over some tests; `fill` tells the columns in a test.
    fn products_by(
        &self,
        tests: Range<usize>,
        count: usize,
        last: &mut LastShape,
        fill: impl Fn(usize, &mut Vec<f64>, &mut Vec<usize>),
    ) -> ByGroup {
        let groups = self.group_count();
        let mut cross = vec![DMatrix::zeros(self.model.problem.unknowns.len(), count); groups];
        let mut z = vec![DVector::zeros(count); groups];
        let mut grams: Vec<Vec<Option<Arc<TestGram>>>> = vec![vec![None; self.model.tests()]; groups];
        let mut acts = vec![0; count];
        for test in tests {
            let whiten = |columns: &mut Vec<f64>| self.whiten(test, columns);
            let rows = self.kept[test].all();
            let Some(sums) = last.products_in(test, rows, self.base(test), whiten, &fill) else { continue };
            let (group, present) = (self.groups[test], &sums.gram.present);
            let seen = &self.model.problem.tests[test].columns;
            for (&k, row) in seen.iter().zip(sums.cross.chunks_exact(present.len())) {
                present.iter().zip(row).for_each(|(&j, sum)| cross[group][(k, j)] += sum);
            }
            for (&j, sum) in present.iter().zip(&sums.cross[seen.len() * present.len()..]) {
                z[group][j] += sum;
                acts[j] += 1;
            }
            grams[group][test] = Some(sums.gram.clone());
        }
        let acts_in_one_test = acts.iter().all(|tests| *tests < 2);
        let of_group = |((tests, cross), z)| {
            let gram = match acts_in_one_test {
                true => Gram::ByTest(tests),
                false => Gram::Whole(sum(tests.iter().flatten(), count)),
            };
            Products { gram, cross, z }
        };
        ByGroup(grams.into_iter().zip(cross).zip(z).map(of_group).collect())
    }
}

/// Columns in one test, one after the other, and which of them act there.
pub fn fill(columns: &[Column], test: usize, block: &mut Vec<f64>, present: &mut Vec<usize>) {
    block.clear();
    present.clear();
    for (j, column) in columns.iter().enumerate().filter(|(_, column)| !column.by_test[test].is_empty()) {
        present.push(j);
        block.extend_from_slice(&column.by_test[test]);
    }
}

/// Adds products of a column of a model, group after group, to its row, each group with its weight.
pub fn add_weighted(all: &mut DMatrix<f64>, row: usize, sums: &[f64], weights: &[f64]) {
    for (sums, weight) in sums.chunks_exact(all.ncols().max(1)).zip(weights) {
        sums.iter().enumerate().for_each(|(j, sum)| all[(row, j)] += weight * sum);
    }
}

/// Places of terms among all of a shape; `None` where one is not among them.
fn places(all: &[Term], terms: &[Term]) -> Option<Vec<usize>> {
    terms.iter().map(|term| all.iter().position(|other| other == term)).collect()
}

/// Nothing panics while it holds a lock; what is behind it is whole in any case.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_with_columns_that_are_kept_stay_those_of_their_columns() {
        let mut with = With::default();
        for (place, id) in [7, 3, 9, 4].into_iter().enumerate() {
            with.places.insert(id, place);
            with.sums.extend([10.0 * id as f64, 10.0 * id as f64 + 1.0]);
        }
        with.keep(&HashSet::from([9, 3, 8]), 2);
        assert_eq!(with.sums.len(), 4);
        for id in [9, 3] {
            let at = with.places[&id];
            assert_eq!(with.sums[2 * at..2 * at + 2], [10.0 * id as f64, 10.0 * id as f64 + 1.0]);
        }
        assert!(!with.places.contains_key(&7) && !with.places.contains_key(&4));
    }
}
