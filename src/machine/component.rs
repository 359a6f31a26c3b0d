//! Component errors (PDGEs): error motions of an axis as functions of its own position. Not location errors, which are constants.

use super::error_name::Component;

/// One component error of an axis, such as EXX or EAC.
#[derive(Debug, Clone, PartialEq)]
pub struct ComponentError {
    /// Which of the six small motions.
    pub component: Component,
    /// Its value as a function of the axis position.
    pub form: ComponentForm,
}

/// Form of a component error over the position q of its axis; values in mm or rad, q in mm or rad.
#[derive(Debug, Clone, PartialEq)]
pub enum ComponentForm {
    /// `Σ c_k q^k`, k = 1, 2, …: zero at q = 0.
    Polynomial(Vec<f64>),
    /// `Σ a_k (cos(n_k q) − 1) + b_k sin(n_k q)` with n_k per radian (rotary) or per mm × 2π (linear): zero at q = 0.
    Fourier(Vec<Harmonic>),
    /// Values at rising positions, straight lines between, constant beyond the ends.
    Table { position: Vec<f64>, value: Vec<f64> },
}

/// One harmonic of a Fourier form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonic {
    /// Angular frequency: rad of phase per rad (rotary) or per mm (linear).
    pub frequency: f64,
    /// Amplitude of the cosine, mm or rad.
    pub cosine: f64,
    /// Amplitude of the sine, mm or rad.
    pub sine: f64,
}

impl ComponentForm {
    /// Value at position `q` (mm or rad), in mm or rad.
    pub fn value(&self, q: f64) -> f64 {
        match self {
            ComponentForm::Polynomial(coefficients) => coefficients.iter().rev().fold(0.0, |sum, c| (sum + c) * q),
            ComponentForm::Fourier(harmonics) => harmonics
                .iter()
                .map(|h| {
                    let (sine, cosine) = (h.frequency * q).sin_cos();
                    h.cosine * (cosine - 1.0) + h.sine * sine
                })
                .sum(),
            ComponentForm::Table { position, value } => interpolate(position, value, q),
        }
    }
}

/// Straight lines between the table's points, constant beyond its ends; an empty table is zero.
fn interpolate(position: &[f64], value: &[f64], q: f64) -> f64 {
    let above = position.partition_point(|&p| p <= q);
    match (above, position.len()) {
        (_, 0) => 0.0,
        (0, _) => value[0],
        (k, n) if k == n => value[n - 1],
        (k, _) => {
            let share = (q - position[k - 1]) / (position[k] - position[k - 1]);
            value[k - 1] + share * (value[k] - value[k - 1])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms_have_the_stated_values() {
        let polynomial = ComponentForm::Polynomial(vec![2.0, 3.0]);
        assert_eq!(polynomial.value(0.0), 0.0);
        assert_eq!(polynomial.value(2.0), 2.0 * 2.0 + 3.0 * 4.0);
        let table = ComponentForm::Table { position: vec![0.0, 1.0, 3.0], value: vec![1.0, 2.0, 0.0] };
        assert_eq!([-1.0, 0.5, 2.0, 9.0].map(|q| table.value(q)), [1.0, 1.5, 1.0, 0.0]);
        let fourier = ComponentForm::Fourier(vec![Harmonic { frequency: 2.0, cosine: 1.0, sine: 0.5 }]);
        assert_eq!(fourier.value(0.0), 0.0);
    }
}
