//! Repeat runs of one test: their circles, averaged with standard deviations as the thesis's tables print them.

use nalgebra::Vector2;

use super::error::MethodError;
use super::turning::{TurningCircle, turning_axis, turning_circle};
use crate::chain::Chain;
use crate::session::{Session, Setups};

/// Spread of repeat runs; `None` when there was a single run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Scatter {
    /// Variance of one run.
    pub of_one_run: Option<f64>,
    /// Variance of the mean of all runs.
    pub of_mean: Option<f64>,
}

impl Scatter {
    /// Of a value that does not vary.
    pub const NONE: Scatter = Scatter { of_one_run: Some(0.0), of_mean: Some(0.0) };

    /// Scatter of `Σ factor·value` over independent values.
    pub fn combined(parts: &[(f64, Scatter)]) -> Scatter {
        let sum = |part: fn(&Scatter) -> Option<f64>| {
            parts
                .iter()
                .filter(|(factor, _)| *factor != 0.0)
                .try_fold(0.0, |sum, (factor, scatter)| Some(sum + factor * factor * part(scatter)?))
        };
        Scatter { of_one_run: sum(|scatter| scatter.of_one_run), of_mean: sum(|scatter| scatter.of_mean) }
    }
}

/// Length of the bar against its turning plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bar {
    /// Both balls in one turning plane: the test without extension.
    Short,
    /// The bar sweeps a cone: the test with extension.
    Extended,
}

/// Balls closer together along the axis than this are in one turning plane, mm.
const IN_PLANE_MM: f64 = 1.0;

/// The runs of one test, both directions.
#[derive(Debug, Clone, PartialEq)]
pub struct Runs {
    pub axis: usize,
    pub bar: Bar,
    /// Place of the standing ball along the axis, from the axis's origin, mm.
    pub at_mm: f64,
    /// Pivot setup that the runs share, by index.
    pub pivot: usize,
    pub circles: Vec<TurningCircle>,
    /// Mean of the centres, mm.
    pub centre_mm: Vector2<f64>,
    /// Scatter of the two coordinates.
    pub centre_scatter: [Scatter; 2],
    /// Mean of the radii, mm.
    pub radius_mm: f64,
}

impl Runs {
    /// All sweeps of single rotary axes in a session that a circle can be fitted to, grouped into repeats of one test.
    pub fn of(session: &Session, chain: &Chain) -> Result<Vec<Runs>, MethodError> {
        let setups = Setups::of(session);
        let mut groups: Vec<(Key, Vec<TurningCircle>)> = Vec::new();
        for test in 0..session.tests.len() {
            let Some(axis) = turning_axis(session, chain, test) else { continue };
            let circle = turning_circle(session, chain, test, axis)?;
            let key = Key {
                axis,
                reach_um: (circle.reach_mm * 1e3).round() as i64,
                at_um: (circle.at_mm * 1e3).round() as i64,
                balls: [setups.pivot_of[test], setups.spindle_ball_of[test]],
            };
            match groups.iter_mut().find(|(other, _)| *other == key) {
                Some((_, circles)) => circles.push(circle),
                None => groups.push((key, vec![circle])),
            }
        }
        Ok(groups.into_iter().map(|(key, circles)| average(key, circles)).collect())
    }
}

/// What repeats of one test have in common; lengths in whole µm so that they compare.
#[derive(PartialEq, Eq)]
struct Key {
    axis: usize,
    reach_um: i64,
    at_um: i64,
    balls: [usize; 2],
}

fn average(key: Key, circles: Vec<TurningCircle>) -> Runs {
    let count = circles.len() as f64;
    let centre_mm = circles.iter().map(|circle| circle.centre_mm).sum::<Vector2<f64>>() / count;
    let centre_scatter = [0, 1].map(|k| {
        let squares: f64 = circles.iter().map(|circle| (circle.centre_mm[k] - centre_mm[k]).powi(2)).sum();
        let variance = (circles.len() > 1).then(|| squares / (count - 1.0));
        Scatter { of_one_run: variance, of_mean: variance.map(|variance| variance / count) }
    });
    let (reach_mm, at_mm) = (circles[0].reach_mm, circles[0].at_mm);
    Runs {
        axis: key.axis,
        bar: if reach_mm.abs() < IN_PLANE_MM { Bar::Short } else { Bar::Extended },
        at_mm,
        pivot: key.balls[0],
        centre_mm,
        centre_scatter,
        radius_mm: circles.iter().map(|circle| circle.radius_mm).sum::<f64>() / count,
        circles,
    }
}
