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

/// Correlation of neighbours beyond which noise counts no less.
const MOST_CORRELATED: f64 = 0.95;

/// Share of values that count as independent, by how far neighbours in a trace agree: `(1 − r) / (1 + r)`, r their correlation, as of
/// a first-order autoregressive process (Bartlett 1946). What is not finite is left out; without neighbours all do.
pub fn independent_share(traces: &[Vec<f64>]) -> f64 {
    let pairs = || traces.iter().flat_map(|trace| trace.windows(2)).filter(|pair| pair.iter().all(|x| x.is_finite()));
    let products: f64 = pairs().map(|pair| pair[0] * pair[1]).sum();
    let squares: f64 = pairs().map(|pair| 0.5 * (pair[0] * pair[0] + pair[1] * pair[1])).sum();
    let correlated = if squares > 0.0 { (products / squares).clamp(0.0, MOST_CORRELATED) } else { 0.0 };
    (1.0 - correlated) / (1.0 + correlated)
}

/// Noise of values from row to row, whatever slow curve they follow; rows without one are passed over.
pub fn noise_of_rows(values: &[f64]) -> f64 {
    let finite: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    robust_sigma(third_differences(&finite)) / OF_THIRD_DIFFERENCES.sqrt()
}
