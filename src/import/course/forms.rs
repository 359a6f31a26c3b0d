//! The few forms that many columns have between them. Whose columns they are is the caller's.

use nalgebra::DMatrix;

use crate::statistics::principal;

/// Principal forms of columns, each at one standard deviation: so many at most, none below an rms in the columns' unit.
pub(super) fn principal_forms(columns: &DMatrix<f64>, (most, least): (usize, f64)) -> Vec<Vec<f64>> {
    let rows = columns.nrows() as f64;
    principal(columns)
        .into_iter()
        .take(most)
        .take_while(|(variance, _)| (variance.max(0.0) / rows).sqrt() > least)
        .map(|(_, way)| (columns * way).iter().copied().collect())
        .collect()
}
