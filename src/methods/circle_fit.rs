//! The thesis's algebraic circle fit (section 4.2): centre and radius from points of a plane. It knows no machine.
//!
//! Minimises `Σ (x² + y² + D·x + E·y + F)²`. The normal equations are
//!
//! ```text
//! | Σx²  Σxy  Σx | |D|     | Σx(x² + y²) |
//! | Σxy  Σy²  Σy | |E| = − | Σy(x² + y²) |
//! | Σx   Σy   n  | |F|     | Σ(x² + y²)  |
//! ```
//!
//! (the thesis prints the right-hand side without its minus sign); centre (−D/2, −E/2), radius √(D²/4 + E²/4 − F).

use nalgebra::{Matrix3, Vector2, Vector3};

/// A circle fitted to points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedCircle {
    /// Centre in the plane, mm.
    pub centre_mm: Vector2<f64>,
    pub radius_mm: f64,
    /// Root mean square of the points' distances from the circle, mm.
    pub rms_mm: f64,
}

/// Fits a circle; `None` when there are fewer than three points or they lie on a line. Public for the tests of the thesis's errata.
pub fn fit_circle(points: &[Vector2<f64>]) -> Option<FittedCircle> {
    if points.len() < 3 {
        return None;
    }
    // about the mean and in units of the points' spread: the equations are then well scaled
    let count = points.len() as f64;
    let middle = points.iter().sum::<Vector2<f64>>() / count;
    let spread = (points.iter().map(|point| (point - middle).norm_squared()).sum::<f64>() / count).sqrt();
    if !spread.is_finite() || spread == 0.0 {
        return None;
    }
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for point in points {
        let place = (point - middle) / spread;
        let row = Vector3::new(place.x, place.y, 1.0);
        normal += row * row.transpose();
        right -= row * place.norm_squared();
    }
    let solution = normal.cholesky()?.solve(&right);
    let centre = Vector2::new(-solution.x / 2.0, -solution.y / 2.0);
    let radius_squared = centre.norm_squared() - solution.z;
    if !radius_squared.is_finite() || radius_squared <= 0.0 {
        return None;
    }
    let centre_mm = middle + centre * spread;
    let radius_mm = radius_squared.sqrt() * spread;
    let squares: f64 = points.iter().map(|point| ((point - centre_mm).norm() - radius_mm).powi(2)).sum();
    Some(FittedCircle { centre_mm, radius_mm, rms_mm: (squares / count).sqrt() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_quarter_circle_give_their_circle_back() {
        let arc = |from: i32, to: i32| -> Vec<Vector2<f64>> {
            let place = |k: i32| f64::from(k).to_radians();
            (from..=to).map(|k| Vector2::new(0.03 + 100.0 * place(k).cos(), -0.05 + 100.0 * place(k).sin())).collect()
        };
        let circle = fit_circle(&arc(-20, 70)).unwrap();
        assert!((circle.centre_mm - Vector2::new(0.03, -0.05)).norm() < 1e-11, "{circle:?}");
        assert!((circle.radius_mm - 100.0).abs() < 1e-11 && circle.rms_mm < 1e-12);
        assert!(fit_circle(&arc(0, 1)).is_none());
        let line: Vec<Vector2<f64>> = (0..9).map(|k| Vector2::new(f64::from(k), 0.0)).collect();
        assert!(fit_circle(&line).is_none());
    }
}
