//! Location and scale of numbers among which some are gross.

/// Median of the finite values, of an even number the upper one of the middle; `None` of none.
pub fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut finite: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    finite.sort_by(f64::total_cmp);
    finite.get(finite.len() / 2).copied()
}

/// Robust standard deviation: 1.4826 times the median of absolute values (equal to σ for a normal distribution).
pub fn robust_sigma(values: impl Iterator<Item = f64>) -> f64 {
    let mut sizes: Vec<f64> = values.filter(|value| value.is_finite()).map(f64::abs).collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let middle = sizes.len() / 2;
    let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
    1.4826 * *median
}

/// Variance of the third difference of independent values of variance one: 1 + 9 + 9 + 1.
pub const OF_THIRD_DIFFERENCES: f64 = 20.0;

/// Third differences of values from row to row: smooth curves leave nothing of them.
pub fn third_differences(values: &[f64]) -> impl Iterator<Item = f64> {
    values.windows(4).map(|v| v[0] - 3.0 * v[1] + 3.0 * v[2] - v[3])
}

/// Noise of values from row to row, whatever slow curve they follow; rows without one are passed over.
pub fn noise_of_rows(values: &[f64]) -> f64 {
    let finite: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    robust_sigma(third_differences(&finite)) / OF_THIRD_DIFFERENCES.sqrt()
}
