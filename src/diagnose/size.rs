//! The one number by which a finding is known: half width, height, amplitude, growth; with its uncertainty. It fits nothing.

use nalgebra::{DMatrix, DVector};

use super::finding::{Cause, SizeFound, unit};
use super::ground::{Ground, Term};
use super::search::Candidate;
use super::stage::Stage;
use crate::effects::{Profile, kind};
use crate::machine::Outlet;
use crate::units::Measure;

/// Size of a finding's leading effect; `parts` are the accepted columns of its terms, once for every shape whose
/// amplitudes add.
pub fn size_of(
    ground: &Ground,
    lead: &Candidate,
    cause: &Cause,
    stage: &Stage,
    covariance: &DMatrix<f64>,
    parts: &[Vec<usize>],
) -> SizeFound {
    let nuisance = ground.problem.unknowns.len();
    let count = lead.terms.len();
    let amplitudes: Vec<f64> = (0..count).map(|k| parts.iter().map(|part| stage.accepted(part[k])).sum()).collect();
    let sub = DMatrix::from_fn(count, count, |i, j| {
        let rows = parts.iter().flat_map(|one| parts.iter().map(move |other| (one[i], other[j])));
        rows.map(|(one, other)| covariance[(nuisance + one, nuisance + other)]).sum::<f64>()
    });
    // terms in the unit of the finding: lengths if it has any
    let main: Vec<usize> = main_terms(&lead.terms);
    let measure = main.first().map_or(Measure::Length, |&k| lead.terms[k].measure);
    let known: Vec<f64> = (0..count).map(|k| 1.0 / sub[(k, k)].max(f64::MIN_POSITIVE)).collect();
    let value_at = |a: &[f64]| match cause.effect.as_str() {
        "vibration" => vibration(&lead.terms, a, &known),
        _ => size_function(ground, lead, cause, &main, a),
    };
    let value = value_at(&amplitudes);
    // first-order propagation of the amplitudes' covariance
    let gradient = DVector::from_iterator(
        amplitudes.len(),
        (0..amplitudes.len()).map(|k| {
            let step = sub[(k, k)].sqrt().max(1e-6);
            let mut up = amplitudes.clone();
            up[k] += step;
            let mut down = amplitudes.clone();
            down[k] -= step;
            (value_at(&up) - value_at(&down)) / (2.0 * step)
        }),
    );
    let sigma = (gradient.transpose() * &sub * &gradient)[(0, 0)].max(0.0).sqrt();
    // directions that the recordings do not show count with what they may hide
    let hidden = if cause.effect.ends_with("-slip") { sub.trace() / (2.0 * value.max(1e-9)) } else { 0.0 };
    let sigma = sigma.hypot(hidden);
    // a form is never exact: three per cent of the size stands for that
    let sigma = sigma.hypot(FORM_SIGMA * value);
    let meaning = kind(&cause.effect).map_or("largest", |kind| kind.size_meaning).to_string();
    SizeFound { value, sigma, unit: unit(measure), meaning }
}

/// Size of a candidate with the amplitudes that it was judged with.
pub fn size_as_judged(ground: &Ground, candidate: &Candidate, cause: &Cause) -> f64 {
    let main = main_terms(&candidate.terms);
    size_function(ground, candidate, cause, &main, &candidate.judgement.amplitudes)
}

/// Uncertainty of a size from the form of its effect, as a share.
const FORM_SIGMA: f64 = 0.03;

/// Terms that carry the size: lengths where there are any, else all.
fn main_terms(terms: &[Term]) -> Vec<usize> {
    let lengths: Vec<usize> = (0..terms.len()).filter(|&k| terms[k].measure == Measure::Length).collect();
    if lengths.is_empty() || terms.iter().all(|term| term.measure == Measure::Length) {
        return (0..terms.len()).collect();
    }
    lengths
}

/// Amplitude over tests that have a cosine and a sine each, weighted by how well each is known: some tests hardly show it.
/// Directions at right angles add as their squares.
fn vibration(terms: &[Term], amplitudes: &[f64], weights: &[f64]) -> f64 {
    // by outlet: weighted squares and weights
    let mut by_outlet: Vec<(Outlet, f64, f64)> = Vec::new();
    for ((term, amplitude), weight) in terms.iter().zip(amplitudes).zip(weights) {
        let square = weight * amplitude * amplitude;
        match by_outlet.iter_mut().find(|(outlet, ..)| *outlet == term.outlet) {
            Some((_, squares, sum)) => (*squares, *sum) = (*squares + square, *sum + weight),
            None => by_outlet.push((term.outlet, square, *weight)),
        }
    }
    by_outlet.iter().map(|(_, squares, weights)| 2.0 * squares / weights).sum::<f64>().sqrt()
}

/// The size for given amplitudes (display units).
fn size_function(ground: &Ground, lead: &Candidate, cause: &Cause, main: &[usize], amplitudes: &[f64]) -> f64 {
    match cause.effect.as_str() {
        "rotary-error-motion" | "straightness" | "unknown" | "thermal-growth" | "reversal-spike" | "lateral-play" => {
            largest_curve(ground, lead, cause, main, amplitudes)
        }
        // the first period is the effect, the others are its form
        "cyclic-error" => {
            let first = main.iter().filter(|&&k| lead.terms[k].function < 2);
            first.map(|&k| amplitudes[k].powi(2)).sum::<f64>().sqrt()
        }
        "gravity-sag" | "arrival-lag" => largest_curve(ground, lead, cause, main, amplitudes),
        "bar-length" if lead.effect.parameter("tau").is_some() => largest_curve(ground, lead, cause, main, amplitudes),
        _ => main.iter().map(|&k| amplitudes[k].powi(2)).sum::<f64>().sqrt(),
    }
}

/// Largest value, or range, of the curves that the outlets follow over the session.
fn largest_curve(ground: &Ground, lead: &Candidate, cause: &Cause, main: &[usize], amplitudes: &[f64]) -> f64 {
    let Some(kind) = kind(&lead.effect.kind) else { return 0.0 };
    let Ok(profiles) = kind.shape(ground.context, &lead.effect) else { return 0.0 };
    let mut outlets: Vec<Outlet> = Vec::new();
    for &k in main {
        if !outlets.contains(&lead.terms[k].outlet) {
            outlets.push(lead.terms[k].outlet);
        }
    }
    let curves = outlets.iter().map(|outlet| {
        let terms: Vec<usize> = main.iter().copied().filter(|&k| lead.terms[k].outlet == *outlet).collect();
        curve(ground, lead, &profiles, &terms, amplitudes)
    });
    let size = |curve: Vec<f64>| -> f64 {
        let (low, high) =
            curve.iter().fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(*value), high.max(*value)));
        if low > high {
            return 0.0;
        }
        match cause.effect.as_str() {
            // growth counts from the session's beginning, where it is zero by form
            "thermal-growth" | "bar-length" => high.max(0.0) - low.min(0.0),
            "rotary-error-motion" | "unknown" => 0.5 * (high - low),
            _ => high.abs().max(low.abs()),
        }
    };
    curves.map(size).fold(0.0, f64::max)
}

/// Sum of functions times amplitudes over the rows in which the place's axis moves (all rows for other places).
fn curve(ground: &Ground, lead: &Candidate, profiles: &[Profile], terms: &[usize], amplitudes: &[f64]) -> Vec<f64> {
    let axis = lead.effect.place.axis();
    // a joint that stands still sags as the one that carries it tilts
    let everywhere =
        matches!(lead.effect.kind.as_str(), "thermal-growth" | "straightness" | "bar-length" | "gravity-sag");
    let mut curve: Vec<f64> = Vec::new();
    for (test, residual) in ground.residual_mm.iter().enumerate() {
        let moving = axis.is_none_or(|axis| ground.context.motion(test).moving.contains(&axis));
        if !(moving || everywhere) {
            continue;
        }
        let start = curve.len();
        curve.resize(start + residual.len(), 0.0);
        for &k in terms {
            let profile = &profiles[lead.terms[k].function][test];
            curve[start..].iter_mut().zip(profile).for_each(|(sum, value)| *sum += amplitudes[k] * value);
        }
    }
    curve
}
