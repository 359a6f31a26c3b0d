//! Principal components of columns. How many of them matter is the caller's.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Mixtures of the columns X, the one of most variance first: eigenvalues of `X'X` with their eigenvectors v, components `X v`;
/// none when a column is not finite.
pub fn principal(columns: &DMatrix<f64>) -> Vec<(f64, DVector<f64>)> {
    // nalgebra's own product with a transposed matrix goes entry by entry, this one in blocks
    let gram = columns.transpose() * columns;
    if gram.is_empty() || gram.iter().any(|value| !value.is_finite()) {
        return Vec::new();
    }
    let eigen = SymmetricEigen::new(gram);
    let ways = eigen.eigenvectors.column_iter().map(|way| way.into_owned());
    let mut list: Vec<(f64, DVector<f64>)> = eigen.eigenvalues.iter().copied().zip(ways).collect();
    list.sort_by(|(one, _), (other, _)| other.total_cmp(one));
    list
}
