//! The course of one number over time: scatter, drift or a step.

use nalgebra::{DMatrix, DVector};

/// One session's value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Days since the first session.
    pub day: f64,
    /// Value and standard deviation in one unit.
    pub value: f64,
    pub sigma: f64,
}

/// What the values do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Course {
    /// Nothing beyond their scatter.
    Steady,
    /// They move by so much a day.
    Drift { per_day: f64, sigma: f64 },
    /// They jump by so much between two sessions.
    Step { by: f64, sigma: f64, after_day: f64, before_day: f64 },
}

/// The course of one number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trend {
    pub course: Course,
    /// Weighted mean and its standard deviation.
    pub mean: f64,
    pub mean_sigma: f64,
    /// Scatter between sessions beyond what they say of themselves.
    pub scatter: f64,
    /// How much better the course is than a constant: difference of the information criteria.
    pub evidence: f64,
}

/// A course is told when its criterion is lower by this: odds of twenty to one (2 ln 20).
const TOLD: f64 = 6.0;
/// Fewer sessions tell no course: a line goes through any two.
const LEAST_SESSIONS: usize = 4;
/// Sessions on either side of a step.
const LEAST_SIDE: usize = 2;

/// The course of values in the order of time.
pub fn trend(points: &[Point]) -> Trend {
    let constant = fit(points, &|_| Vec::new());
    let steady = Trend {
        course: Course::Steady,
        mean: constant.parameters[0],
        mean_sigma: constant.sigmas[0],
        scatter: constant.scatter,
        evidence: 0.0,
    };
    if points.len() < LEAST_SESSIONS {
        return steady;
    }
    let middle = points.iter().map(|point| point.day).sum::<f64>() / points.len() as f64;
    let line = fit(points, &|point| vec![point.day - middle]);
    let mut best = (line.criterion, Course::Drift { per_day: line.parameters[1], sigma: line.sigmas[1] }, line.scatter);
    for split in LEAST_SIDE..=points.len() - LEAST_SIDE {
        let (before, after) = (points[split - 1].day, points[split].day);
        if before == after {
            continue;
        }
        let step = fit(points, &|point| vec![if point.day >= after { 0.5 } else { -0.5 }]);
        // the place of the step is a number of its own
        let criterion = step.criterion + (points.len() as f64).ln();
        if criterion < best.0 {
            let course =
                Course::Step { by: step.parameters[1], sigma: step.sigmas[1], after_day: before, before_day: after };
            best = (criterion, course, step.scatter);
        }
    }
    let evidence = constant.criterion - best.0;
    match evidence > TOLD {
        true => Trend { course: best.1, scatter: best.2, evidence, ..steady },
        false => steady,
    }
}

struct Fitted {
    parameters: Vec<f64>,
    sigmas: Vec<f64>,
    scatter: f64,
    criterion: f64,
}

/// Weighted least squares of a constant and `columns`, with the scatter between sessions that makes the values likeliest.
fn fit(points: &[Point], columns: &dyn Fn(&Point) -> Vec<f64>) -> Fitted {
    let spread = {
        let mean = points.iter().map(|point| point.value).sum::<f64>() / points.len() as f64;
        points.iter().map(|point| (point.value - mean).powi(2)).sum::<f64>().sqrt()
    };
    let with = |scatter: f64| -> Fitted {
        let rows: Vec<Vec<f64>> =
            points.iter().map(|point| std::iter::once(1.0).chain(columns(point)).collect()).collect();
        let count = rows.first().map_or(1, Vec::len);
        let variance: Vec<f64> = points.iter().map(|point| point.sigma.powi(2) + scatter * scatter).collect();
        let design = DMatrix::from_fn(points.len(), count, |i, j| rows[i][j] / variance[i].sqrt());
        let right = DVector::from_fn(points.len(), |i, _| points[i].value / variance[i].sqrt());
        let covariance = (design.tr_mul(&design)).try_inverse().unwrap_or_else(|| DMatrix::zeros(count, count));
        let parameters: DVector<f64> = &covariance * design.tr_mul(&right);
        let chi_square = (&right - &design * &parameters).norm_squared();
        let logarithms: f64 = variance.iter().map(|variance| variance.ln()).sum();
        Fitted {
            sigmas: (0..count).map(|k| covariance[(k, k)].max(0.0).sqrt()).collect(),
            parameters: parameters.iter().copied().collect(),
            scatter,
            // the scatter is a number of every course
            criterion: chi_square + logarithms + (count + 1) as f64 * (points.len() as f64).ln(),
        }
    };
    // scatters from none to all of the spread
    let tried = std::iter::once(0.0).chain((0..=60).map(|k| spread * 10f64.powf(-3.0 + 0.05 * f64::from(k))));
    let mut best = with(0.0);
    for scatter in tried.skip(1) {
        let next = with(scatter);
        if next.criterion < best.criterion {
            best = next;
        }
    }
    best
}
