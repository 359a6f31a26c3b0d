//! The course of one number over time: scatter, drift or a step.

use crate::statistics::mean;

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
    /// How much better the course is than a constant: twice the logarithm of the odds.
    pub evidence: f64,
}

/// Variance below which a point is exact, in the square of its unit.
const EXACT: f64 = 1e-12;

impl Trend {
    /// The course's value on a day, among the points that it was found in: through their means, weighted as they were.
    pub fn at(&self, points: &[Point], day: f64) -> f64 {
        let weighted = |of: fn(&Point) -> f64, is_taken: &dyn Fn(&Point) -> bool| {
            let weight = |point: &Point| 1.0 / (point.sigma.powi(2) + self.scatter.powi(2)).max(EXACT);
            let taken = || points.iter().filter(|point| is_taken(point));
            taken().map(|point| weight(point) * of(point)).sum::<f64>() / taken().map(weight).sum::<f64>()
        };
        match self.course {
            Course::Steady => self.mean,
            Course::Drift { per_day, .. } => {
                let is_any = |_: &Point| true;
                weighted(|point| point.value, &is_any) + per_day * (day - weighted(|point| point.day, &is_any))
            }
            Course::Step { before_day, .. } => {
                weighted(|point| point.value, &|point| (point.day >= before_day) == (day >= before_day))
            }
        }
    }
}

/// A course is told when the odds for it are beyond these, as twice their logarithm: 1 in 74. Of machines that only scatter, eight
/// numbers each, one in twenty at most is told as moving then (tests/history.rs).
const LEAST_TWICE_LOG_ODDS: f64 = 8.6;
/// Fewer sessions tell no course: a line goes through any two.
const LEAST_SESSIONS: usize = 4;
/// Sessions on either side of a step.
const LEAST_SIDE: usize = 2;

/// The course of values in the order of time.
///
/// The scatter between sessions is not known; where sessions are few, one of them may look like a trend because the scatter
/// was small by chance. So it is averaged over, each value weighted by how likely it makes the sessions.
pub fn trend(points: &[Point]) -> Trend {
    let grid = Unknowns::of(points);
    let constant = grid.weigh(points, None);
    let steady = Trend {
        course: Course::Steady,
        mean: constant.value,
        mean_sigma: constant.sigma,
        scatter: constant.scatter,
        evidence: 0.0,
    };
    if points.len() < LEAST_SESSIONS {
        return steady;
    }
    let line = grid.weigh(points, Some(&|point| point.day));
    let drift = (line.log_likelihood, Course::Drift { per_day: line.value, sigma: line.sigma }, line.scatter);
    let splits: Vec<usize> =
        (LEAST_SIDE..=points.len() - LEAST_SIDE).filter(|&split| points[split - 1].day != points[split].day).collect();
    let steps = splits.iter().map(|&split| {
        let (before, after) = (points[split - 1].day, points[split].day);
        let step = grid.weigh(points, Some(&|point| if point.day >= after { 1.0 } else { 0.0 }));
        let course = Course::Step { by: step.value, sigma: step.sigma, after_day: before, before_day: after };
        // each place of the step is as likely as any other
        (step.log_likelihood - (splits.len() as f64).ln(), course, step.scatter)
    });
    let best = steps.fold(drift, |best, step| if step.0 > best.0 { step } else { best });
    let evidence = 2.0 * (best.0 - constant.log_likelihood);
    match evidence > LEAST_TWICE_LOG_ODDS {
        true => Trend { course: best.1, scatter: best.2, evidence, ..steady },
        false => steady,
    }
}

/// What values say of one number: the constant, or what a column adds to it.
struct Weighed {
    value: f64,
    sigma: f64,
    scatter: f64,
    log_likelihood: f64,
}

/// What is added to a constant, as a function of the session.
type Column<'c> = &'c dyn Fn(&Point) -> f64;

/// What is averaged over.
struct Unknowns {
    /// Scatters between sessions, each as likely as the others.
    scatters: Vec<f64>,
    sizes: Sizes,
}

impl Unknowns {
    /// Scatters from a thousandth to ten times the spread of the values, in steps of 12 %, and none at all.
    fn of(points: &[Point]) -> Unknowns {
        let mean = mean(points.iter().map(|point| point.value)).unwrap_or(f64::NAN);
        let spread = points.iter().map(|point| (point.value - mean).powi(2)).sum::<f64>().sqrt();
        let some = (0..=80).map(|k| spread * 10f64.powf(-3.0 + 0.05 * f64::from(k)));
        Unknowns { scatters: std::iter::once(0.0).chain(some).collect(), sizes: Sizes::of(points.len() as f64) }
    }

    /// Averages over the scatters. The constant is flat before; of what a column adds [`Sizes`] tell what was thought possible.
    fn weigh(&self, points: &[Point], column: Option<Column>) -> Weighed {
        let column = column.map(|column| (column, &self.sizes));
        let each: Vec<Weighed> = self.scatters.iter().filter_map(|&scatter| weighed(points, scatter, column)).collect();
        let most = each.iter().map(|one| one.log_likelihood).fold(f64::NEG_INFINITY, f64::max);
        let weights: Vec<f64> = each.iter().map(|one| (one.log_likelihood - most).exp()).collect();
        let all: f64 = weights.iter().sum();
        let mean = |of: &dyn Fn(&Weighed) -> f64| {
            each.iter().zip(&weights).map(|(one, weight)| weight * of(one)).sum::<f64>() / all
        };
        let value = mean(&|one| one.value);
        Weighed {
            value,
            sigma: mean(&|one| one.sigma.powi(2) + (one.value - value).powi(2)).sqrt(),
            scatter: mean(&|one| one.scatter),
            log_likelihood: most + (all / self.scatters.len() as f64).ln(),
        }
    }
}

/// For one scatter; `None` where values without any uncertainty cannot be weighed.
fn weighed(points: &[Point], scatter: f64, column: Option<(Column, &Sizes)>) -> Option<Weighed> {
    let precision: Vec<f64> = points.iter().map(|point| 1.0 / (point.sigma.powi(2) + scatter * scatter)).collect();
    let all: f64 = precision.iter().sum();
    if !all.is_finite() {
        return None;
    }
    let mean_of = |of: &dyn Fn(&Point) -> f64| -> f64 {
        points.iter().zip(&precision).map(|(point, weight)| weight * of(point)).sum::<f64>() / all
    };
    let mean = mean_of(&|point| point.value);
    let squares =
        points.iter().zip(&precision).map(|(point, weight)| weight * (point.value - mean).powi(2)).sum::<f64>();
    let logarithms: f64 = precision.iter().map(|precision| precision.ln()).sum();
    let of_constant = -0.5 * (squares - logarithms + all.ln());
    let Some((column, sizes)) = column else {
        return Some(Weighed { value: mean, sigma: all.sqrt().recip(), scatter, log_likelihood: of_constant });
    };
    let middle = mean_of(column);
    let off = |point: &Point| column(point) - middle;
    let known = all * mean_of(&|point| off(point).powi(2));
    let value = all * mean_of(&|point| off(point) * (point.value - mean)) / known;
    let log_likelihood = of_constant + sizes.log_gain(value * value * known);
    (known > 0.0).then(|| Weighed { value, sigma: known.sqrt().recip(), scatter, log_likelihood })
}

/// Sizes that are tried for what a column adds, in those as which one session would know it: from a thousandth to ten million million, in
/// steps of 58 %.
const SIZES: std::ops::RangeInclusive<i32> = -15..=65;
const SIZES_PER_DECADE: f64 = 5.0;

/// How large what a column adds may be: g, its variance over that of the column's own σ, with the density of Zellner and Siow (1980), the inverse
/// gamma of shape 1/2 and scale n/2: most likely g = n/3, and any size now and then.
///
/// With g fixed at n a share of 1/(1 + n) of the largest step would stay as scatter, and the more so the larger it is (Liang et al. 2008).
struct Sizes(Vec<Size>);

/// One of them.
struct Size {
    /// Half of g / (1 + g): what of the squares that a column lowers speaks for it.
    speaks: f64,
    /// Log of its probability, less ln(1 + g) / 2.
    log_weight: f64,
}

impl Sizes {
    fn of(sessions: f64) -> Sizes {
        let sizes = || SIZES.map(|k| sessions * 10f64.powf(f64::from(k) / SIZES_PER_DECADE));
        // over equal steps of the logarithm
        let log_prior = |g: f64| -0.5 * g.ln() - 0.5 * sessions / g;
        let all = sizes().map(|g| log_prior(g).exp()).sum::<f64>().ln();
        let size = |g: f64| Size { speaks: 0.5 * g / (1.0 + g), log_weight: log_prior(g) - all - 0.5 * g.ln_1p() };
        Sizes(sizes().map(size).collect())
    }

    /// Log of how much likelier a column makes the sessions whose squares it lowers by `gained`:
    /// `ln ∫ (1 + g)^(−1/2) exp(gained · g / (2 (1 + g))) p(g) dg`.
    fn log_gain(&self, gained: f64) -> f64 {
        let logs = || self.0.iter().map(|size| size.log_weight + gained * size.speaks);
        let most = logs().fold(f64::NEG_INFINITY, f64::max);
        most + logs().map(|log| (log - most).exp()).sum::<f64>().ln()
    }
}
