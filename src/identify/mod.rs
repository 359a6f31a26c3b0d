//! Location errors from recordings: one weighted nonlinear least-squares fit over all tests of a session.
//!
//! Minimises `Σ ‖W(reading − L(errors, balls) − bar)‖² + Σ ((x − prior)/σ_prior)²` over the free location errors, the
//! place of every pivot and spindle ball, the reading error of every bar and what the linear axes do within their budget; W whitens each trace by a noise model
//! (white + AR(1) + drift) fitted to the residuals, so that uncertainties hold for autocorrelated noise.

mod absorbed;
mod ambiguity;
mod axis_lines;
mod candidates;
mod compressed;
mod fitted;
mod outliers;
mod problem;
mod senses;
mod slides;
mod solve;
mod unknowns;
mod white;

pub use ambiguity::Ambiguity;
pub use axis_lines::{AxisLine, CentreReading, axis_lines};
pub use candidates::{Candidate, candidate_tests};
pub use compressed::{SweepBasis, SweepStatistics};
pub use fitted::fitted_session;
pub use outliers::kept_rows;
pub use problem::{Prediction, PreparedTest, Problem};
pub use senses::{SenseTest, TurnedSense, turned_senses};
pub use solve::{Normal, Solution, Weighting, minimise, minimise_until, normal_equations};
pub use unknowns::{FreeError, FreePrior, Quantity, Unknown, default_free, is_arm, parse_free, unknowns};
pub use white::{Evidence, WhiteFit, fit_white};

use absorbed::absorbed;
use nalgebra::{Cholesky, DMatrix, SymmetricEigen};

use crate::chain::Chain;
use crate::effects::EffectError;
use crate::machine::{Component, ComponentError, ErrorName};
use crate::readings::NOISE_CLASSES;
use crate::session::{MotionError, Session, Setups};
use crate::statistics::{Absorbed, NOISE_FLOOR_MM, NoiseModel, fit_noise, rms, robust_sigma};

/// What to fit and how.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Free location errors; `None`: [`default_free`].
    pub free: Option<Vec<ErrorName>>,
    /// Prior of the free location errors; `None`: [`FreePrior::of`].
    pub prior: Option<FreePrior>,
}

impl Options {
    /// Unknowns of a fit to a session: what is asked for, or what the machine suggests.
    pub fn unknowns(&self, session: &Session, setups: &Setups) -> Vec<Unknown> {
        let free = self.free.clone().unwrap_or_else(|| default_free(&session.machine));
        unknowns(session, setups, &free, self.prior.unwrap_or_else(|| FreePrior::of(&session.machine)))
    }
}

/// Why a fit was not possible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FitError {
    #[error(transparent)]
    Motion(#[from] MotionError),
    #[error(transparent)]
    Effect(#[from] EffectError),
    #[error("the session has no recording; record its tests first, or use 'fiveaxis simulate' to make some")]
    NoRecording,
    #[error("the fit did not converge; check ball places, bar lengths and the signs of the axes in the session")]
    NoConvergence,
    #[error(
        "test '{test}' has component errors or effects, which a fit of constant errors leaves out; use the general fit"
    )]
    NotConstant { test: String },
    #[error("errors of the linear axes are left out by a fit of constant errors; use the general fit")]
    LinearAxes,
    #[error("the recordings do not determine {unknown}, alone or beside the unknowns before it; give it a prior")]
    Undetermined { unknown: String },
    #[error("only {readings} readings for {unknowns} unknowns; record more or free fewer errors")]
    TooFew { readings: usize, unknowns: usize },
}

/// Result of a fit.
#[derive(Debug, Clone)]
pub struct Fit {
    pub unknowns: Vec<Unknown>,
    pub estimates: Vec<Estimate>,
    /// Covariance of the estimates, priors and the budget of the linear axes included, mm and rad.
    pub covariance: DMatrix<f64>,
    /// What the linear axes do within their budget, as fitted beside the unknowns.
    pub linear_axes: FittedSlides,
    /// Noise of a reading, by test.
    pub noise: Vec<NoiseModel>,
    pub tests: Vec<TestFit>,
    /// Root mean square of all residuals that were kept, mm.
    pub rms_mm: f64,
    pub ambiguities: Vec<Ambiguity>,
}

impl Fit {
    /// Location errors among the unknowns, as place in the list, axis and component, with their covariance, mm and rad.
    pub fn location_covariance(&self) -> (Vec<(usize, usize, usize)>, DMatrix<f64>) {
        let location = |(k, unknown): (usize, &Unknown)| match unknown.quantity {
            Quantity::Location { axis, component } => Some((k, axis, component.index())),
            _ => None,
        };
        let free: Vec<(usize, usize, usize)> = self.unknowns.iter().enumerate().filter_map(location).collect();
        let covariance = DMatrix::from_fn(free.len(), free.len(), |i, j| self.covariance[(free[i].0, free[j].0)]);
        (free, covariance)
    }

    /// Values of the unknowns, mm or rad.
    pub fn values(&self) -> Vec<f64> {
        self.estimates.iter().map(|estimate| estimate.value).collect()
    }

    /// Readings that were left out as gross outliers.
    pub fn left_out(&self) -> usize {
        self.tests.iter().map(|test| test.left_out.len()).sum()
    }

    /// Rows that took part, by test.
    pub fn kept_rows(&self) -> Vec<Vec<bool>> {
        self.tests.iter().map(|test| test.kept.clone()).collect()
    }

    /// Estimate of a location error by its ISO 230-1 name; `None` for one that was not free.
    ///
    /// ```
    /// use fiveaxis::identify::{Options, identify};
    /// use fiveaxis::load::load_session;
    ///
    /// let session = load_session("examples/thesis/chapter5/session.yaml".as_ref())?;
    /// let fit = identify(&session, &Options::default())?;
    /// let y = fit.error("EY0C").ok_or("not free")?;
    /// println!("EY0C {:.1} ± {:.1} µm", 1e3 * y.value, 1e3 * y.sigma);
    /// assert!(y.determined && (1e3 * y.value + 52.5).abs() < 0.5);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn error(&self, name: &str) -> Option<&Estimate> {
        let is_it = |unknown: &Unknown| {
            matches!(unknown.quantity, Quantity::Location { .. }) && unknown.label.eq_ignore_ascii_case(name)
        };
        self.unknowns.iter().position(is_it).map(|index| &self.estimates[index])
    }

    /// Leaves values and residuals as they are, but says of none that the data determine it: for a fit that does not fit.
    pub fn claim_nothing(&mut self) {
        for estimate in &mut self.estimates {
            estimate.determined = false;
            estimate.relative_to_spindle_ball = false;
        }
    }
}

/// Estimate of one unknown, mm or rad.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    pub value: f64,
    /// Standard deviation, priors and the budget of the linear axes included.
    pub sigma: f64,
    /// Standard deviation if the spindle balls stood exactly where the session says.
    pub sigma_to_spindle_ball: f64,
    /// Standard deviation if the linear axes were exact too: what the noise of the readings leaves.
    pub sigma_noise: f64,
    /// Share of the variance that comes from priors other than the spindle balls', which are held here as the linear axes
    /// are, 0 to 1: `Σ_j (C_kj/σ_j)² / C_kk` on a machine without location errors; the rest comes from the noise of the data.
    pub prior_share: f64,
    /// Share of the variance that comes from the priors of pivots, spindle balls and bars, 0 to 1.
    pub setup_share: f64,
    /// The data fix it, given the spindle balls and exact linear axes: prior share below half. How well is said by `sigma`.
    pub determined: bool,
    /// It is fixed only relative to the spindle ball: without that ball's prior the data say little.
    pub relative_to_spindle_ball: bool,
}

/// Errors of the linear axes that a fit took from their budget.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FittedSlides {
    /// Squareness: axis, component, value in rad.
    pub squareness: Vec<(usize, Component, f64)>,
    /// Displacements, by axis.
    pub displacements: Vec<(usize, ComponentError)>,
}

impl FittedSlides {
    fn of(problem: &Problem, values: &[f64]) -> FittedSlides {
        let fitted: Vec<(Quantity, f64)> =
            problem.unknowns.iter().map(|unknown| unknown.quantity).zip(values.iter().copied()).collect();
        let budget = &fitted[problem.asked..];
        let square = budget.iter().filter_map(|&(quantity, value)| match quantity {
            Quantity::Location { axis, component } => Some((axis, component, value)),
            _ => None,
        });
        FittedSlides { squareness: square.collect(), displacements: problem.slides.component_errors(budget) }
    }
}

/// Fit of one test.
#[derive(Debug, Clone, PartialEq)]
pub struct TestFit {
    pub name: String,
    /// Reading minus model, mm; NaN where there is no reading.
    pub residual_mm: Vec<f64>,
    /// Rows that took part.
    pub kept: Vec<bool>,
    /// Root mean square over the rows that took part, mm.
    pub rms_mm: f64,
    /// Rows with a reading that were left out.
    pub left_out: Vec<usize>,
}

/// How much tighter or wider the spindle balls' priors become when they are held or released.
const WIDENED: f64 = 1e3;

/// Fits a session.
pub fn identify(session: &Session, options: &Options) -> Result<Fit, FitError> {
    let chain = Chain::of(&session.machine);
    let setups = Setups::of(session);
    let problem = Problem::new(session, &chain, &setups, options.unknowns(session, &setups))?;
    fit(&problem.with_linear_axes(&session.machine.linear_axes))
}

/// Rounds of fitting errors and noise in turn; each brings the noise some five times nearer to its end.
const NOISE_ROUNDS: usize = 5;

/// Fits a prepared problem: robust start, outliers, noise, weighted fit.
pub fn fit(problem: &Problem) -> Result<Fit, FitError> {
    let readings: usize =
        problem.tests.iter().map(|test| test.reading_mm.iter().filter(|v| v.is_finite()).count()).sum();
    if readings == 0 {
        return Err(FitError::NoRecording);
    }
    if readings < 4 {
        return Err(FitError::TooFew { readings, unknowns: problem.unknowns.len() });
    }
    let rough = robust_start(problem);
    let mut kept = kept_rows(problem, &rough.residual_mm);
    let mut noise = fitted_noise(problem, &rough, &kept, None);
    let mut solution = rough;
    for _ in 0..NOISE_ROUNDS {
        solution = minimise(problem, &solution.values, &Weighting::Whitened { noise: &noise, kept: &kept });
        kept = kept_rows(problem, &solution.residual_mm);
        let last = noise.clone();
        noise = fitted_noise(problem, &solution, &kept, Some(&last));
        let settled = noise.iter().zip(&last).all(|(new, old)| (new.rms_mm() / old.rms_mm() - 1.0).abs() < 0.01);
        if settled {
            break;
        }
    }
    let weighting = Weighting::Whitened { noise: &noise, kept: &kept };
    let solution = minimise(problem, &solution.values, &weighting);
    if !solution.converged {
        return Err(FitError::NoConvergence);
    }
    let of_design = information_of_design(problem, &solution, &weighting);
    Ok(summary(problem, solution, &of_design, noise, kept))
}

/// What the readings say of the unknowns asked for on a machine without location errors, as a plan counts it: there one error
/// does not lean on another by their product. With 10″ of tilt a wide prior of 1 mm would leave 0.05 µm in a neighbour that
/// the readings fix, and more than their noise does.
fn information_of_design(problem: &Problem, solution: &Solution, weighting: &Weighting) -> DMatrix<f64> {
    let is_location = |unknown: &Unknown| matches!(unknown.quantity, Quantity::Location { .. });
    let without = |(unknown, value): (&Unknown, &f64)| if is_location(unknown) { unknown.prior_mean } else { *value };
    let values: Vec<f64> = problem.unknowns.iter().zip(&solution.values).map(without).collect();
    let count = problem.asked;
    normal_equations(problem, &values, weighting).0.information.view((0, 0), (count, count)).into_owned()
}

/// Huber fit whose scale shrinks to the residuals' robust sigma.
fn robust_start(problem: &Problem) -> Solution {
    let mut values: Vec<f64> = problem.unknowns.iter().map(|unknown| unknown.prior_mean).collect();
    let residual = |values: &[f64]| normal_equations(problem, values, &Weighting::Huber { scale_mm: 1.0 }).1;
    let mut scale = robust_sigma(residual(&values).iter().flatten().copied()).max(NOISE_FLOOR_MM);
    loop {
        let solution = minimise(problem, &values, &Weighting::Huber { scale_mm: scale });
        let next = robust_sigma(solution.residual_mm.iter().flatten().copied()).max(NOISE_FLOOR_MM);
        if next > 0.7 * scale {
            return solution;
        }
        (values, scale) = (solution.values, next);
    }
}

/// Noise of every test: for lengths, coordinates and turns one model for all sweeps, white noise of common size for static poses.
///
/// Without `last` the solution is a rough one, whose covariance says nothing of the noise that it absorbed.
fn fitted_noise(
    problem: &Problem,
    solution: &Solution,
    kept: &[Vec<bool>],
    last: Option<&[NoiseModel]>,
) -> Vec<NoiseModel> {
    let masked: Vec<Vec<f64>> = solution
        .residual_mm
        .iter()
        .zip(kept)
        .map(|(residual, kept)| {
            residual.iter().zip(kept).map(|(value, kept)| if *kept { *value } else { f64::NAN }).collect()
        })
        .collect();
    let is_pose = |index: usize| problem.tests[index].motion.time_s.is_none();
    let class = |index: usize| problem.session.tests[index].reading.noise_class();
    let absorbed = |tests: &[usize]| last.map_or_else(Vec::new, |_| absorbed(problem, solution, kept, tests));
    let noise_of = |class_wanted: usize| {
        let of_class = (0..masked.len()).filter(|&index| class(index) == class_wanted);
        let (poses, sweeps): (Vec<usize>, Vec<usize>) = of_class.partition(|&index| is_pose(index));
        let pose_noise = white_noise(poses.iter().flat_map(|&index| &masked[index]).copied(), &absorbed(&poses));
        let sweep_noise = if sweeps.is_empty() {
            pose_noise
        } else {
            let traces: Vec<Vec<f64>> = sweeps.iter().map(|&index| masked[index].clone()).collect();
            fit_noise(&traces, &absorbed(&sweeps), last.map(|last| last[sweeps[0]]))
        };
        (pose_noise, sweep_noise)
    };
    let by_class: Vec<_> = (0..NOISE_CLASSES).map(noise_of).collect();
    let chosen = |index: usize| match problem.session.tests[index].reading.stated_noise_mm() {
        Some(noise_mm) => NoiseModel::white(noise_mm),
        None if is_pose(index) => by_class[class(index)].0,
        None => by_class[class(index)].1,
    };
    (0..masked.len()).map(chosen).collect()
}

/// White noise of residuals and of what a fit has absorbed of it.
fn white_noise(residual_mm: impl Iterator<Item = f64>, absorbed: &[Absorbed]) -> NoiseModel {
    let (sum, count) = residual_mm
        .filter(|value| value.is_finite())
        .fold((0.0, 0usize), |(sum, count), value| (sum + value * value, count + 1));
    let absorbed: f64 = absorbed.iter().flat_map(|group| &group.columns).flatten().map(|value| value * value).sum();
    NoiseModel::white(((sum + absorbed) / count.max(1) as f64).sqrt().max(NOISE_FLOOR_MM))
}

fn summary(
    problem: &Problem,
    solution: Solution,
    of_design: &DMatrix<f64>,
    noise: Vec<NoiseModel>,
    kept: Vec<Vec<bool>>,
) -> Fit {
    let covariance = covariance(problem, &solution.information);
    let estimates = estimates(problem, &solution, &covariance, of_design);
    let linear_axes = FittedSlides::of(problem, &solution.values);
    let tests: Vec<TestFit> = solution
        .residual_mm
        .iter()
        .zip(kept)
        .zip(&problem.session.tests)
        .map(|((residual, kept), test)| test_fit(&test.name, residual, kept))
        .collect();
    let all_kept = tests
        .iter()
        .flat_map(|test| test.residual_mm.iter().zip(&test.kept).filter(|(_, kept)| **kept).map(|(value, _)| *value));
    let rms_mm = rms(all_kept);
    let ambiguities = ambiguity::ambiguities(problem, &solution, &noise);
    let unknowns = problem.unknowns[..problem.asked].to_vec();
    Fit { unknowns, estimates, covariance, linear_axes, noise, tests, rms_mm, ambiguities }
}

fn test_fit(name: &str, residual: &[f64], kept: Vec<bool>) -> TestFit {
    let rms_mm = rms(residual.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(value, _)| *value));
    let left_out = (0..residual.len()).filter(|&row| residual[row].is_finite() && !kept[row]).collect();
    TestFit { name: name.to_string(), residual_mm: residual.to_vec(), kept, rms_mm, left_out }
}

/// Covariance `D(H + 1)⁻¹D` of the unknowns asked for, H the data information in units of the priors D.
fn covariance(problem: &Problem, information: &DMatrix<f64>) -> DMatrix<f64> {
    let inverse = inverse_with_prior(information, &vec![1.0; problem.unknowns.len()]);
    let sigma = |k: usize| problem.unknowns[k].prior_sigma;
    DMatrix::from_fn(problem.asked, problem.asked, |i, j| inverse[(i, j)] * sigma(i) * sigma(j))
}

/// `(H + diag(weights))⁻¹`; weights above zero make it solvable. Unknowns are scaled to equal size first: what the data say
/// of them differs by many powers of ten.
fn inverse_with_prior(information: &DMatrix<f64>, weights: &[f64]) -> DMatrix<f64> {
    let count = weights.len();
    let scale: Vec<f64> = (0..count).map(|k| (information[(k, k)].max(0.0) + weights[k]).sqrt().recip()).collect();
    let scaled = DMatrix::from_fn(count, count, |i, j| {
        let weight = if i == j { weights[i] } else { 0.0 };
        (information[(i, j)] + weight) * scale[i] * scale[j]
    });
    let inverse = match Cholesky::new(scaled.clone()) {
        Some(factor) => factor.inverse(),
        // rounding spoiled directions of which nearly nothing is known: they stay at what rounding leaves of one
        None => {
            let parts = SymmetricEigen::new(scaled);
            let factors = parts.eigenvalues.map(|value| value.max(f64::EPSILON).recip());
            &parts.eigenvectors * DMatrix::from_diagonal(&factors) * parts.eigenvectors.transpose()
        }
    };
    DMatrix::from_fn(count, count, |i, j| inverse[(i, j)] * scale[i] * scale[j])
}

fn estimates(
    problem: &Problem,
    solution: &Solution,
    covariance: &DMatrix<f64>,
    of_design: &DMatrix<f64>,
) -> Vec<Estimate> {
    let unknowns = &problem.unknowns[..problem.asked];
    let is_reference = |unknown: &Unknown| {
        matches!(unknown.quantity, Quantity::SpindleBall { setup, .. }
            if problem.setups.spindle_balls[setup].spread_mm <= problem.session.spread.spindle_ball_mm)
    };
    // a held quantity gets a prior a thousand times tighter, a released one a thousand times wider
    let reference_weight = |unknowns: &[Unknown], weight: f64| -> Vec<f64> {
        unknowns.iter().map(|unknown| if is_reference(unknown) { weight } else { 1.0 }).collect()
    };
    let (hold, release) = (WIDENED * WIDENED, 1.0 / (WIDENED * WIDENED));
    let held_with_budget = inverse_with_prior(&solution.information, &reference_weight(&problem.unknowns, hold));
    // with exact linear axes
    let information = solution.information_of(unknowns.len());
    let held = inverse_with_prior(&information, &reference_weight(unknowns, hold));
    let by_design = inverse_with_prior(of_design, &reference_weight(unknowns, hold));
    let released = inverse_with_prior(&information, &reference_weight(unknowns, release));
    unknowns
        .iter()
        .enumerate()
        .map(|(k, unknown)| {
            // of the variance C_kk, Σ_j C_kj² stems from the priors j (C in units of the priors)
            let from_priors: f64 =
                (0..unknowns.len()).filter(|&j| !is_reference(&unknowns[j])).map(|j| by_design[(k, j)].powi(2)).sum();
            let prior_share = (from_priors / by_design[(k, k)]).clamp(0.0, 1.0);
            let from_setups: f64 = (0..unknowns.len())
                .filter(|&j| unknowns[j].quantity.is_setup())
                .map(|j| (covariance[(k, j)] / unknowns[j].prior_sigma).powi(2))
                .sum();
            let determined = prior_share < 0.5;
            Estimate {
                value: solution.values[k],
                sigma: covariance[(k, k)].sqrt(),
                sigma_to_spindle_ball: held_with_budget[(k, k)].sqrt() * unknown.prior_sigma,
                sigma_noise: held[(k, k)].sqrt() * unknown.prior_sigma,
                prior_share,
                setup_share: (from_setups / covariance[(k, k)]).clamp(0.0, 1.0),
                determined,
                relative_to_spindle_ball: determined && released[(k, k)] > 4.0 * held[(k, k)] && !is_reference(unknown),
            }
        })
        .collect()
}
