//! Products of the columns of a block with each other, in SIMD registers, and small symmetric solves; no statistics.

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

/// Rows of [`weighted_products`] are filled up to a multiple of this.
pub const ROW_STEP: usize = 8;

/// `JᵀWJ` for a few rows: `rows` holds J row by row with `stride` numbers each (a multiple of [`ROW_STEP`]), `weight`
/// is symmetric, `weighted` takes WJ and `sums` the result, both row by row with the same stride.
pub fn weighted_products(rows: &[f64], stride: usize, weight: &[f64], weighted: &mut [f64], sums: &mut [f64]) {
    let count = rows.len() / stride;
    Arch::new().dispatch(RowSums { rows, stride, factors: weight, next_row: count, next_factor: 1, into: weighted });
    Arch::new().dispatch(RowSums {
        rows: weighted,
        stride,
        factors: rows,
        next_row: 1,
        next_factor: stride,
        into: sums,
    });
}

/// `into[r] = Σ_n factors[r·next_row + n·next_factor] · rows[n]`.
struct RowSums<'a> {
    rows: &'a [f64],
    stride: usize,
    factors: &'a [f64],
    next_row: usize,
    next_factor: usize,
    into: &'a mut [f64],
}

impl WithSimd for RowSums<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (r, into) in self.into.chunks_exact_mut(self.stride).enumerate() {
            let (into, _) = S::as_mut_simd_f64s(into);
            for (v, into) in into.iter_mut().enumerate() {
                let mut sum = simd.splat_f64s(0.0);
                for (n, row) in self.rows.chunks_exact(self.stride).enumerate() {
                    let (row, _) = S::as_simd_f64s(row);
                    let factor = self.factors[r * self.next_row + n * self.next_factor];
                    sum = simd.mul_add_e_f64s(simd.splat_f64s(factor), row[v], sum);
                }
                *into = sum;
            }
        }
    }
}

/// Lower Cholesky factor of a symmetric matrix given by its lower triangle, in units of its diagonal.
pub struct Factor {
    count: usize,
    lower: Vec<f64>,
    /// `1/√diagonal` of the matrix.
    scale: Vec<f64>,
}

/// Pivots below this share of the diagonal are rounding: the matrix has no inverse.
const SMALLEST_PIVOT: f64 = 1e-13;

impl Factor {
    /// Factors `matrix` (`count × count`, row by row, lower triangle read); `Err` names the first dependent row.
    pub fn of(matrix: &[f64], count: usize) -> Result<Factor, usize> {
        let scale: Vec<f64> = (0..count).map(|k| 1.0 / matrix[k * count + k].sqrt()).collect();
        let mut lower = vec![0.0; count * count];
        for i in 0..count {
            let (above, row) = lower.split_at_mut(i * count);
            for j in 0..=i {
                let other: &[f64] = if j < i { &above[j * count..j * count + j] } else { &[] };
                let entry = matrix[i * count + j] * scale[i] * scale[j];
                if j < i {
                    let dot: f64 = row[..j].iter().zip(other).map(|(x, y)| x * y).sum();
                    row[j] = (entry - dot) / above[j * count + j];
                } else {
                    let pivot = entry - row[..i].iter().map(|x| x * x).sum::<f64>();
                    if pivot.is_nan() || pivot < SMALLEST_PIVOT {
                        return Err(i);
                    }
                    row[i] = pivot.sqrt();
                }
            }
        }
        Ok(Factor { count, lower, scale })
    }

    /// Solution x of `matrix·x = right`.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let n = self.count;
        let mut x: Vec<f64> = right.iter().zip(&self.scale).map(|(r, s)| r * s).collect();
        for i in 0..n {
            let dot: f64 = self.lower[i * n..i * n + i].iter().zip(&x).map(|(lower, x)| lower * x).sum();
            x[i] = (x[i] - dot) / self.lower[i * n + i];
        }
        for i in (0..n).rev() {
            x[i] /= self.lower[i * n + i];
            let solved = x[i];
            for (x, lower) in x[..i].iter_mut().zip(&self.lower[i * n..i * n + i]) {
                *x -= lower * solved;
            }
        }
        x.iter_mut().zip(&self.scale).for_each(|(x, s)| *x *= s);
        x
    }
}
