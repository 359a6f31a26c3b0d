//! Mean and scatter of numbers that count alike. Where some may be gross, see `robust`.

/// A number that was fitted, with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fitted {
    pub value: f64,
    pub sigma: f64,
}

/// Mean; `None` of none.
pub fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / count as f64)
}

/// Standard deviation about their own mean, over their number; 0 of none.
pub fn standard_deviation(values: &[f64]) -> f64 {
    let middle = mean(values.iter().copied()).unwrap_or(0.0);
    rms(values.iter().map(|value| value - middle))
}

/// Root mean square of the finite values.
pub fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values
        .filter(|value| value.is_finite())
        .fold((0.0, 0usize), |(sum, count), value| (sum + value * value, count + 1));
    (sum / count.max(1) as f64).sqrt()
}
