//! The one number by which a finding is known: half width, height, amplitude, growth; with its uncertainty. It fits nothing.

use crate::diagnose::cause::Cause;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::collections::HashSet;

use super::finding::SizeFound;
use crate::diagnose::model::linear_model::{LinearModel, Term};
use crate::diagnose::model::regression::Regression;
use crate::diagnose::selection::naming::unit;
use crate::diagnose::selection::selected::Candidate;
use crate::diagnose::selection::shapes::trajectory::{Trajectories, grows, is_once_per_turn, told_along_its_axis};
use crate::effects::{Signature, is_a, kind, signature};
use crate::machine::{Effect, Outlet};
use crate::statistics::{mean, rms, standard_deviation};
use crate::units::Measure;

/// Size of a finding's leading effect; `parts` are the accepted columns of its terms, once for every shape whose
/// amplitudes add.
pub fn size_of(
    model: &LinearModel,
    lead: &Candidate,
    cause: &Cause,
    regression: &Regression,
    covariance: &DMatrix<f64>,
    parts: &[Vec<usize>],
) -> SizeFound {
    let nuisance = model.problem.unknowns.len();
    let count = lead.terms.len();
    let amplitudes: Vec<f64> =
        (0..count).map(|k| parts.iter().map(|part| regression.accepted(part[k])).sum()).collect();
    let sub = DMatrix::from_fn(count, count, |i, j| {
        let rows = parts.iter().flat_map(|one| parts.iter().map(move |other| (one[i], other[j])));
        rows.map(|(one, other)| covariance[(nuisance + one, nuisance + other)]).sum::<f64>()
    });
    // terms in the unit of the finding: lengths if it has any
    let main: Vec<usize> = main_terms(model, &lead.effect, cause, &lead.terms);
    let measure = main.first().map_or(Measure::Length, |&k| lead.terms[k].measure);
    let prior = lead.judgement.tau.max(1.0);
    let courses = Trajectories::of(model, lead, &main);
    let value_at = |a: &[f64]| size_function(lead, cause, &main, &courses, a);
    let value = value_at(&amplitudes);
    let (value, sigma) = match signature(&cause.effect) {
        Some(Signature::Oscillation) => super::vibration_size::size_alone(model, lead, &amplitudes, &sub, prior),
        // many amplitudes of equal rank, none of them hidden
        Some(Signature::FreeCurve) => (value, first_order(&value_at, &amplitudes, &sub)),
        _ => {
            // orders that placement takes up are left as they were fitted
            let held: Vec<bool> = lead.terms.iter().map(|term| is_once_per_turn(&lead.effect, term)).collect();
            // a jump may be any number of times longer along a direction that the recordings hide; placement takes up
            // most of a sag
            let is_slip = is_a(&cause.effect, Signature::Jump);
            let longer = match signature(&cause.effect) {
                Some(Signature::Sag) => WIDENED_SAG,
                _ if is_slip => WIDENED_JUMP,
                _ => WIDENED_MOTION,
            };
            let over = |longer: f64| drawn(&value_at, &amplitudes, &sub, &held, (HIDDEN_SHARE * prior, longer));
            let spread = over(longer).unwrap_or((value, first_order(&value_at, &amplitudes, &sub)));
            // these have no favourite direction: the hidden part is likely as long as a seen one
            let even = match is_slip {
                true => over(1.0),
                false if courses.is_whole_turn() => over(HIDDEN_ORDERS),
                false => None,
            };
            even.map_or(spread, |(value, _)| (value, spread.1))
        }
    };
    let is_part_of_turn = is_a(&cause.effect, Signature::ErrorMotion) && !courses.is_whole_turn();
    let form = if is_part_of_turn { PART_OF_TURN } else { form_error(model, &lead.effect) };
    let sigma = sigma.hypot(form * value);
    let meaning = match signature(&cause.effect) {
        _ if grows(&lead.effect) => "peak to peak over the session",
        Some(Signature::Straightness) => "height of the bump, or of the bow over its end points",
        Some(Signature::ErrorMotion) if courses.is_whole_turn() => {
            "largest of a component, without what turns once across the axis"
        }
        Some(Signature::ErrorMotion) => "half the range of a component over the arc travelled",
        _ => kind(&cause.effect).map_or("largest", |kind| kind.size_meaning),
    };
    let meaning = meaning.to_string();
    SizeFound { value, sigma, unit: unit(measure), meaning }
}

/// Size of an effect that several accepted shapes tell together, each given with its first column: the largest value of the
/// sum of their courses. `lead` is the size of the first one alone.
pub(crate) fn size_together(
    model: &LinearModel,
    parts: &[(&Candidate, usize)],
    cause: &Cause,
    regression: &Regression,
    covariance: &DMatrix<f64>,
    lead: SizeFound,
) -> SizeFound {
    let nuisance = model.problem.unknowns.len();
    let columns: Vec<usize> =
        parts.iter().flat_map(|(part, first)| (*first..first + part.terms.len()).collect::<Vec<_>>()).collect();
    let amplitudes: Vec<f64> = columns.iter().map(|&column| regression.accepted(column)).collect();
    let sub = DMatrix::from_fn(columns.len(), columns.len(), |one, other| {
        covariance[(nuisance + columns[one], nuisance + columns[other])]
    });
    let main = |part: &Candidate| main_terms(model, &part.effect, cause, &part.terms);
    let courses = Trajectories::of_all(model, parts.iter().map(|(part, _)| (*part, main(part))));
    let value_at = |amplitudes: &[f64]| courses.largest(cause, amplitudes);
    let value = value_at(&amplitudes);
    let sigma = first_order(&value_at, &amplitudes, &sub).hypot(form_error(model, &parts[0].0.effect) * value);
    SizeFound { value, sigma, ..lead }
}

/// First-order propagation of the amplitudes' covariance.
fn first_order(value_at: &impl Fn(&[f64]) -> f64, amplitudes: &[f64], covariance: &DMatrix<f64>) -> f64 {
    let gradient = DVector::from_iterator(
        amplitudes.len(),
        (0..amplitudes.len()).map(|k| {
            let step = covariance[(k, k)].sqrt().max(1e-6);
            let mut up = amplitudes.to_vec();
            up[k] += step;
            let mut down = amplitudes.to_vec();
            down[k] -= step;
            (value_at(&up) - value_at(&down)) / (2.0 * step)
        }),
    );
    (gradient.transpose() * covariance * &gradient)[(0, 0)].max(0.0).sqrt()
}

/// Share of the prior that a direction keeps when it is hidden, and the factors by which a jump, a sag and another motion
/// may then be larger.
const HIDDEN_SHARE: f64 = 0.6;
const WIDENED_JUMP: f64 = 2.5;
const WIDENED_SAG: f64 = 5.0;
const WIDENED_MOTION: f64 = 1.5;
/// The same for orders of a whole turn: the largest of several components is a little more than a typical one.
const HIDDEN_ORDERS: f64 = 1.15;
/// Uncertainty of an error motion over part of a turn, as a share: what of it placement takes up differs from arc to arc.
const PART_OF_TURN: f64 = 0.25;
/// Draws of the amplitudes.
const DRAWS: usize = 120;

/// Mean and standard deviation of a size over what the amplitudes may be: motions that the recordings hide count with
/// what they may add. `None` where the covariance is not one.
fn drawn(
    value_at: &impl Fn(&[f64]) -> f64,
    amplitudes: &[f64],
    covariance: &DMatrix<f64>,
    held: &[bool],
    (hidden_from, longer): (f64, f64),
) -> Option<(f64, f64)> {
    let count = amplitudes.len();
    let eigen = SymmetricEigen::new(covariance.clone());
    let spread: Vec<f64> = eigen.eigenvalues.iter().map(|value| value.max(0.0).sqrt()).collect();
    // what is hidden is as large as what is seen
    let along = eigen.eigenvectors.tr_mul(&DVector::from_column_slice(amplitudes));
    let typical = rms((0..count).filter(|&k| spread[k] <= hidden_from).map(|k| along[k]));
    let spread: Vec<f64> =
        spread.into_iter().map(|own| if own > hidden_from { longer * own.min(typical) } else { own }).collect();
    // the symmetric root: it does not depend on the signs of the eigenvectors, which are chance
    let scales = DMatrix::from_diagonal(&DVector::from_vec(spread));
    let root = &eigen.eigenvectors * scales * eigen.eigenvectors.transpose();
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let sizes: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let drawn = DVector::from_iterator(count, (0..count).map(|_| rng.sample::<f64, _>(StandardNormal)));
            let off = &root * drawn;
            let amplitudes: Vec<f64> = (0..count).map(|k| amplitudes[k] + if held[k] { 0.0 } else { off[k] }).collect();
            value_at(&amplitudes)
        })
        .collect();
    let mean = mean(sizes.iter().copied()).filter(|mean| mean.is_finite())?;
    Some((mean, standard_deviation(&sizes)))
}

/// Size of a candidate with the amplitudes that it was judged with.
pub fn size_as_judged(model: &LinearModel, candidate: &Candidate, cause: &Cause) -> f64 {
    let main = main_terms(model, &candidate.effect, cause, &candidate.terms);
    let courses = Trajectories::of(model, candidate, &main);
    size_function(candidate, cause, &main, &courses, &candidate.judgement.amplitudes)
}

/// Whether a term moves along a direction, per kelvin or not.
pub(crate) fn is_length(term: &Term) -> bool {
    matches!(term.measure, Measure::Length | Measure::LengthPerKelvin | Measure::LengthPerLoad)
}

/// Terms that carry the size: of a lag the lag, of what grows the growth along its axis, else lengths where there are any,
/// else all.
fn main_terms(model: &LinearModel, effect: &Effect, cause: &Cause, terms: &[Term]) -> Vec<usize> {
    let of = |outlet: &dyn Fn(&Outlet) -> bool| -> Vec<usize> {
        (0..terms.len()).filter(|&k| outlet(&terms[k].outlet)).collect()
    };
    let lags = of(&|outlet| matches!(outlet, Outlet::Lag { .. }));
    if !lags.is_empty() {
        return lags;
    }
    let machine = model.context.machine();
    let along = told_along_its_axis(machine, effect, cause);
    let growth = of(&|outlet| Some(*outlet) == along);
    if !growth.is_empty() {
        return growth;
    }
    let lengths: Vec<usize> = (0..terms.len()).filter(|&k| is_length(&terms[k])).collect();
    if lengths.is_empty() { (0..terms.len()).collect() } else { lengths }
}

/// The size for given amplitudes (display units).
fn size_function(lead: &Candidate, cause: &Cause, main: &[usize], courses: &Trajectories, amplitudes: &[f64]) -> f64 {
    use Signature::*;
    match signature(&cause.effect) {
        // a height of 1 at the centre, whether or not a test stood there
        Some(Straightness) if is_bump(lead, main) && courses.hold(lead) => courses.height(amplitudes),
        // as large as it is in most tests: the largest of many is mostly noise
        Some(Course) if lead.differs_by_test() => rms_of_tests(lead, main, amplitudes),
        Some(Straightness | FreeCurve | Growth | Spike | Play | ErrorMotion | Sag | Arrival | BallForm | Course) => {
            courses.largest(cause, amplitudes)
        }
        // the first period is the effect, the others are its form
        Some(Period) => courses.cyclic(lead, amplitudes),
        // two waves, one with and one against the position
        Some(Beat) => {
            let wave = |with: bool| main.iter().filter(move |&&k| (lead.terms[k].function < 2) == with);
            [true, false].map(|with| wave(with).map(|&k| amplitudes[k].powi(2)).sum::<f64>().sqrt()).iter().sum()
        }
        Some(BarLength) if grows(&lead.effect) => courses.largest(cause, amplitudes),
        _ => main.iter().map(|&k| amplitudes[k].powi(2)).sum::<f64>().sqrt(),
    }
}

/// Amplitude of the largest motion, rms over the tests in which it has one.
fn rms_of_tests(lead: &Candidate, main: &[usize], amplitudes: &[f64]) -> f64 {
    let mean_square = |outlet: &Outlet| {
        let own: Vec<usize> = main.iter().copied().filter(|&k| lead.terms[k].outlet == *outlet).collect();
        let tests: HashSet<Option<usize>> = own.iter().map(|&k| lead.terms[k].test).collect();
        own.iter().map(|&k| amplitudes[k].powi(2)).sum::<f64>() / tests.len().max(1) as f64
    };
    main.iter().map(|&k| mean_square(&lead.terms[k].outlet)).fold(0.0, f64::max).sqrt()
}

/// Whether the main terms are the height of one bump.
fn is_bump(lead: &Candidate, main: &[usize]) -> bool {
    lead.effect.parameter("width").is_some() && main.iter().all(|&k| lead.terms[k].measure == Measure::Length)
}

/// Uncertainty of a size from the form of its effect, as a share. Where the axis only stands, readings show the effect at single
/// places: what it is between them, its form must tell.
pub(crate) fn form_error(model: &LinearModel, effect: &Effect) -> f64 {
    let own = kind(&effect.kind).map_or(0.0, |kind| kind.form_error);
    let bends = matches!(signature(&effect.kind), Some(Signature::Period | Signature::Straightness));
    let only_stands = effect.place.axis().is_some_and(|axis| model.context.travelled(axis).is_none());
    if bends && only_stands { own.max(FORM_BETWEEN_PLACES) } else { own }
}

/// Form error of a curve over the position that is seen at single places: a screw's second harmonic, the skew of a bump.
const FORM_BETWEEN_PLACES: f64 = 0.3;
