//! Deviations over the direction of the bar without the offset of the centre: setup hides form, and users of ball bars take it off.

use nalgebra::{Matrix3, Vector3};

/// Deviations with the centre taken off.
#[derive(Debug, Clone, PartialEq)]
pub struct Centred {
    /// Offset of the centre to the right and up, in the unit of the deviations.
    pub centre: [f64; 2],
    /// Mean that was taken off with it; zero for a full turn, whose mean is the radius.
    pub mean: f64,
}

/// Arcs that lack more than this of a full turn lose their mean with the centre: a short arc cannot tell them apart, rad.
const MEAN_LOST_BEYOND_RAD: f64 = 0.1;

impl Centred {
    /// Least-squares centre of deviations (not finite: left out) over directions, rad; `None` where fewer than four rows or
    /// less than an eighth of a turn hold it.
    pub fn of(rows: impl Iterator<Item = (f64, f64)> + Clone) -> Option<Centred> {
        let rows = rows.filter(|(angle, deviation)| angle.is_finite() && deviation.is_finite());
        let (low, high) = rows.clone().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (a, _)| (l.min(a), h.max(a)));
        if rows.clone().count() < 4 || high - low < std::f64::consts::FRAC_PI_4 {
            return None;
        }
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (angle, deviation) in rows {
            let row = Vector3::new(1.0, angle.cos(), angle.sin());
            normal += row * row.transpose();
            right += row * deviation;
        }
        let parts = normal.cholesky()?.solve(&right);
        let is_full = high - low > std::f64::consts::TAU - MEAN_LOST_BEYOND_RAD;
        Some(Centred { centre: [parts[1], parts[2]], mean: if is_full { 0.0 } else { parts[0] } })
    }

    /// A deviation without the centre.
    pub fn apply(&self, angle_rad: f64, deviation: f64) -> f64 {
        deviation - self.mean - self.centre[0] * angle_rad.cos() - self.centre[1] * angle_rad.sin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shifted_circle_is_centred_and_keeps_its_radius_and_form() {
        let angle = |k: usize| (k as f64).to_radians();
        let deviation = |a: f64| 3.0 + 90.0 * a.cos() - 40.0 * a.sin() + 2.0 * (3.0 * a).cos();
        let centred = Centred::of((0..360).map(|k| (angle(k), deviation(angle(k))))).expect("a full turn");
        assert!((centred.centre[0] - 90.0).abs() < 1e-9 && (centred.centre[1] + 40.0).abs() < 1e-9);
        assert!((centred.apply(0.5, deviation(0.5)) - 3.0 - 2.0 * 1.5f64.cos()).abs() < 1e-9);
        assert_eq!(Centred::of((0..20).map(|k| (angle(k), 1.0))), None);
    }
}
