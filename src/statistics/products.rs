//! Products of the columns of a block with each other, in SIMD registers; no statistics.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

/// Adds the products of all pairs of columns to the lower triangle of `sums` (`count × count`, row by row).
///
/// `columns` holds `count` columns of `rows` numbers one after the other.
pub fn add_products(columns: &[f64], rows: usize, count: usize, sums: &mut [f64]) {
    if rows > 0 && count > 0 {
        let columns = Stacked { columns: &columns[..rows * count], rows };
        Arch::new().dispatch(Products { left: columns, right: columns, rows, pairs: Pairs::Lower, sums });
    }
}

/// Adds the products of the columns of `left` with those of `right` to `sums` (left × right, row by row); columns have
/// `rows` numbers each.
pub fn add_cross_products(left: &[f64], right: &[f64], rows: usize, sums: &mut [f64]) {
    if rows > 0 && !left.is_empty() && !right.is_empty() {
        let (left, right) = (Stacked { columns: left, rows }, Stacked { columns: right, rows });
        Arch::new().dispatch(Products { left, right, rows, pairs: Pairs::All, sums });
    }
}

/// The same with columns that lie anywhere on the right.
pub fn add_products_with(left: &[f64], right: &[&[f64]], rows: usize, sums: &mut [f64]) {
    if rows > 0 && !left.is_empty() && !right.is_empty() {
        let left = Stacked { columns: left, rows };
        Arch::new().dispatch(Products { left, right, rows, pairs: Pairs::All, sums });
    }
}

/// Columns of one length.
trait Columns: Copy {
    /// How many they are.
    fn count(self) -> usize;

    /// One of them.
    fn column(&self, index: usize) -> &[f64];
}

/// Columns one after the other.
#[derive(Clone, Copy)]
struct Stacked<'a> {
    columns: &'a [f64],
    rows: usize,
}

impl Columns for Stacked<'_> {
    #[inline(always)]
    fn count(self) -> usize {
        self.columns.len() / self.rows
    }

    #[inline(always)]
    fn column(&self, index: usize) -> &[f64] {
        &self.columns[index * self.rows..(index + 1) * self.rows]
    }
}

impl Columns for &[&[f64]] {
    #[inline(always)]
    fn count(self) -> usize {
        self.len()
    }

    #[inline(always)]
    fn column(&self, index: usize) -> &[f64] {
        self[index]
    }
}

/// Which pairs of columns are multiplied.
#[derive(Clone, Copy, PartialEq)]
enum Pairs {
    All,
    /// A column of the right with itself and those behind it on the left.
    Lower,
}

/// Rows of all columns that are multiplied before the next ones: so many numbers of a hundred columns stay in the second cache,
/// 800 kB.
const ROWS_AT_ONCE: usize = 1024;

struct Products<'a, C> {
    left: Stacked<'a>,
    right: C,
    rows: usize,
    pairs: Pairs,
    sums: &'a mut [f64],
}

impl<C: Columns> WithSimd for Products<'_, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        // sixteen sums and eight operands need thirty-two registers, eight sums and six operands sixteen
        if S::REGISTER_COUNT >= 32 { self.all_tiles::<S, 4, 4>(simd) } else { self.all_tiles::<S, 4, 2>(simd) }
    }
}

impl<C: Columns> Products<'_, C> {
    #[inline(always)]
    fn all_tiles<S: Simd, const L: usize, const R: usize>(&mut self, simd: S) {
        let (left_count, right_count) = (self.left.count(), self.right.count());
        for from in (0..self.rows).step_by(ROWS_AT_ONCE) {
            let rows = from..self.rows.min(from + ROWS_AT_ONCE);
            for a in (0..left_count).step_by(L) {
                let last = if self.pairs == Pairs::All { right_count } else { right_count.min(a + L) };
                for b in (0..last).step_by(R) {
                    self.tile::<S, L, R>(simd, rows.clone(), (a, left_count), (b, right_count));
                }
            }
        }
    }

    /// Columns `a..a+L` times columns `b..b+R` over some rows; columns beyond the last repeat it and are dropped.
    #[inline(always)]
    fn tile<S: Simd, const L: usize, const R: usize>(
        &mut self,
        simd: S,
        rows: Range<usize>,
        (a, left_count): (usize, usize),
        (b, right_count): (usize, usize),
    ) {
        let whole = rows.len() / S::F64_LANES;
        let (left, left_ends) = columns::<S, _, L>(&self.left, rows.clone(), (a, left_count));
        let (right, right_ends) = columns::<S, _, R>(&self.right, rows.clone(), (b, right_count));
        let left = left.map(|column| &column[..whole]);
        let right = right.map(|column| &column[..whole]);
        let mut sums = [[simd.splat_f64s(0.0); R]; L];
        for row in 0..whole {
            let y: [S::f64s; R] = std::array::from_fn(|j| right[j][row]);
            for i in 0..L {
                let x = left[i][row];
                for j in 0..R {
                    sums[i][j] = simd.mul_add_e_f64s(x, y[j], sums[i][j]);
                }
            }
        }
        if rows.len() > whole * S::F64_LANES {
            let y: [S::f64s; R] = std::array::from_fn(|j| simd.partial_load_f64s(right_ends[j]));
            for i in 0..L {
                let x = simd.partial_load_f64s(left_ends[i]);
                for j in 0..R {
                    sums[i][j] = simd.mul_add_e_f64s(x, y[j], sums[i][j]);
                }
            }
        }
        let is_lower = self.pairs == Pairs::Lower;
        for (i, row) in sums.iter().enumerate().take_while(|(i, _)| a + i < left_count) {
            let last = if is_lower { a + i } else { right_count - 1 };
            for (j, sum) in row.iter().enumerate().take_while(|(j, _)| b + j <= last) {
                self.sums[(a + i) * right_count + b + j] += simd.reduce_sum_f64s(*sum);
            }
        }
    }
}

/// Some columns in whole registers, and what is left of each.
#[inline(always)]
fn columns<S: Simd, C: Columns, const T: usize>(
    all: &C,
    rows: Range<usize>,
    (first, count): (usize, usize),
) -> ([&[S::f64s]; T], [&[f64]; T]) {
    let parts: [(&[S::f64s], &[f64]); T] =
        std::array::from_fn(|k| S::as_simd_f64s(&all.column((first + k).min(count - 1))[rows.clone()]));
    (parts.map(|(whole, _)| whole), parts.map(|(_, end)| end))
}
