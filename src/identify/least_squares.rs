//! The fit itself: robust start, gross outliers, noise and errors in turn, summary.

use nalgebra::DMatrix;

use super::absorbed::absorbed;
use super::ambiguity::ambiguities;
use super::estimate::{Fit, FittedSlides, TestFit};
use super::outliers::kept_rows;
use super::solve::{Solution, Weighting, minimise, normal_equations, residual_mm};
use super::uncertainty::{covariance, estimates};
use crate::chain::Chain;
use crate::identify::model::error::FitError;
use crate::identify::model::options::Options;
use crate::identify::model::problem::Problem;
use crate::identify::model::unknowns::{Quantity, Unknown};
use crate::readings::NOISE_CLASSES;
use crate::session::{Session, Setups};
use crate::statistics::{NOISE_FLOOR_MM, NoiseModel, fit_noise, rms, robust_sigma, white_noise};

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
    let mut scale = robust_sigma(residual_mm(problem, &values).iter().flatten().copied()).max(NOISE_FLOOR_MM);
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
    let ambiguities = ambiguities(problem, &solution, &noise);
    let unknowns = problem.unknowns[..problem.asked].to_vec();
    Fit { unknowns, estimates, covariance, linear_axes, noise, tests, rms_mm, ambiguities }
}

fn test_fit(name: &str, residual: &[f64], kept: Vec<bool>) -> TestFit {
    let rms_mm = rms(residual.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(value, _)| *value));
    let left_out = (0..residual.len()).filter(|&row| residual[row].is_finite() && !kept[row]).collect();
    TestFit { name: name.to_string(), residual_mm: residual.to_vec(), kept, rms_mm, left_out }
}
