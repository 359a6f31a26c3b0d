//! How large a vibration is that several accepted effects tell together: their motions overlap, so that each alone may have
//! any size while the sum is sure. It fits nothing.

use crate::effects::VIBRATION;
use crate::statistics::{NoiseModel, mean};
use nalgebra::DMatrix;

use super::finding::SizeFound;
use crate::diagnose::model::linear_model::{LinearModel, Term};
use crate::diagnose::selection::selected::Candidate;
use crate::machine::Outlet;

/// Share by which gains of one direction may differ from outlet to outlet: a slide and the ball that it carries.
const ONE_DIRECTION: f64 = 1e-3;

/// Share of an amplitude that the readings must tell, of one as large as the lead's.
const LEAST_KNOWN: f64 = 0.3;

/// Motion along one direction in one test.
#[derive(Clone, Copy)]
struct Motion {
    /// Square of the amplitude, without the prior's pull, µm².
    square: f64,
    /// How well it is known, µm⁻².
    weight: f64,
}

/// Amplitude of one vibration and its standard deviation, the form not counted: over all tests by how well each tells it.
/// Directions at right angles add as their squares.
pub(crate) fn size_alone(
    model: &LinearModel,
    lead: &Candidate,
    amplitudes: &[f64],
    covariance: &DMatrix<f64>,
    prior: f64,
) -> (f64, f64) {
    let Ok(profiles) = model.profiles(&lead.effect) else { return (0.0, 0.0) };
    let mut outlets: Vec<Outlet> = Vec::new();
    for term in &lead.terms {
        if !outlets.contains(&term.outlet) {
            outlets.push(term.outlet);
        }
    }
    let (mut square, mut variance) = (0.0, 0.0);
    for outlet in outlets {
        let motions: Vec<Motion> = (0..model.tests())
            .filter_map(|test| {
                let acts = |term: &Term| term.outlet == outlet && term.test.is_none_or(|own| own == test);
                let own: Vec<usize> = (0..lead.terms.len()).filter(|&k| acts(&lead.terms[k])).collect();
                motion_of(&own, amplitudes, covariance, prior, |k| &profiles[lead.terms[k].function][test])
            })
            .collect();
        let weights: f64 = motions.iter().map(|motion| motion.weight).sum();
        if weights > 0.0 {
            let mean = motions.iter().map(|motion| motion.weight * motion.square).sum::<f64>() / weights;
            let scatter = motions.iter().map(|motion| (motion.weight * (motion.square - mean)).powi(2)).sum::<f64>();
            square += mean.max(0.0);
            // by what the tests say, and at least by what the noise of each does
            variance += (scatter / weights.powi(2)).max(4.0 * mean.max(0.0) / weights);
        }
    }
    let value = square.sqrt();
    if value > 0.0 {
        return (value, 0.5 * variance.sqrt() / value);
    }
    // no test tells it by itself: as large as it was fitted, and no surer than that
    let fitted = amplitudes.iter().map(|size| size * size).sum::<f64>() / model.tests().max(1) as f64;
    (fitted.sqrt(), fitted.sqrt())
}

/// What the amplitudes `own` of functions in one test say of the motion there; `None` where that is little.
fn motion_of<'p>(
    own: &[usize],
    amplitudes: &[f64],
    covariance: &DMatrix<f64>,
    prior: f64,
    profile: impl Fn(usize) -> &'p Vec<f64>,
) -> Option<Motion> {
    let rows = own.iter().map(|&k| profile(k).len()).max().filter(|rows| *rows > 0)?;
    let mean = |one: usize, other: usize| {
        profile(one).iter().zip(profile(other)).map(|(a, b)| a * b).sum::<f64>() / rows as f64
    };
    let (mut square, mut noise, mut hidden) = (0.0, 0.0, 0.0);
    for (a, &one) in own.iter().enumerate() {
        for (b, &other) in own.iter().enumerate().take(a + 1) {
            let share = mean(one, other) * if a == b { 1.0 } else { 2.0 };
            square += share * amplitudes[one] * amplitudes[other];
            noise += share * covariance[(one, other)];
            hidden += if a == b { share * prior.powi(2) } else { 0.0 };
        }
    }
    // share that the readings have in the amplitudes, the prior the rest
    let known = 1.0 - noise / hidden.max(f64::MIN_POSITIVE);
    if known < LEAST_KNOWN {
        return None;
    }
    // a sine has half of its amplitude's square; without the prior's pull; noise alone has a square as well
    let square = 2.0 * square / known.powi(2) - 2.0 * noise / known;
    Some(Motion { square, weight: known * own.len() as f64 / (2.0 * noise).max(f64::MIN_POSITIVE) })
}

/// Size of vibrations of one line, in the directions of the first one; `lead` is its size alone.
pub(crate) fn size_together(
    model: &LinearModel,
    parts: &[(&Candidate, Vec<f64>)],
    noise: &[NoiseModel],
    lead: SizeFound,
) -> SizeFound {
    let mut directions: Vec<Term> = Vec::new();
    for term in parts.iter().take(1).flat_map(|(part, _)| &part.terms) {
        if !directions.iter().any(|other| (other.outlet, other.along) == (term.outlet, term.along)) {
            directions.push(*term);
        }
    }
    let prior = parts.iter().map(|(part, _)| part.judgement.tau).fold(1.0, f64::max);
    let mut sums = vec![(0.0, 0.0); directions.len()];
    for (test, noise) in noise.iter().enumerate() {
        let motions = motions(model, parts, (noise.white_mm, prior), &directions, test);
        for ((squares, weights), motion) in sums.iter_mut().zip(motions) {
            *squares += motion.weight * motion.square;
            *weights += motion.weight;
        }
    }
    let seen = || sums.iter().filter(|(_, weights)| *weights > 0.0);
    let value = seen().map(|(squares, weights)| (squares / weights).max(0.0)).sum::<f64>().sqrt();
    let variance: f64 = seen().map(|(_, weights)| 1.0 / weights).sum();
    if value <= 0.0 {
        return lead;
    }
    SizeFound { value, sigma: (VIBRATION.form_error * value).hypot(variance.sqrt()), ..lead }
}

/// Motion in one test by direction; of no weight where the test hardly shows it. `white_mm` is the noise from row to row,
/// `prior` the standard deviation of an amplitude, µm.
fn motions(
    model: &LinearModel,
    parts: &[(&Candidate, Vec<f64>)],
    (white_mm, prior): (f64, f64),
    directions: &[Term],
    test: usize,
) -> Vec<Motion> {
    let gains: Vec<_> = directions.iter().map(|term| model.gains_of_term(term)).collect();
    let rows = model.residual_mm[test].len();
    // a sine has half of its amplitude's square
    let shown = |one: usize, other: usize| {
        let products = gains[one][test].iter().zip(&gains[other][test]).map(|(a, b)| a * b);
        0.5 * products.sum::<f64>() / white_mm.powi(2).max(f64::MIN_POSITIVE)
    };
    let precision = DMatrix::from_fn(directions.len(), directions.len(), |one, other| {
        shown(one, other) + if one == other { prior.powi(-2) } else { 0.0 }
    });
    let Some(covariance) = precision.cholesky().map(|factor| factor.inverse()) else { return Vec::new() };
    let motion = |(k, direction): (usize, &Term)| {
        let variance = covariance[(k, k)];
        let known = 1.0 - variance / prior.powi(2);
        if known < LEAST_KNOWN {
            return Motion { square: 0.0, weight: 0.0 };
        }
        let course = course(model, parts, direction, test, rows);
        let mean_square = mean(course.iter().map(|value| value * value)).unwrap_or(0.0);
        // noise alone has a square as well, of a cosine and of a sine
        Motion { square: 2.0 * mean_square / known.powi(2) - 2.0 * variance / known, weight: known / variance }
    };
    directions.iter().enumerate().map(motion).collect()
}

/// Course of the motion along one direction in a test, summed over all parts, µm.
fn course(
    model: &LinearModel,
    parts: &[(&Candidate, Vec<f64>)],
    direction: &Term,
    test: usize,
    rows: usize,
) -> Vec<f64> {
    let mut course = vec![0.0; rows];
    for (part, sizes) in parts {
        let Ok(profiles) = model.profiles(&part.effect) else { continue };
        for (term, size) in part.terms.iter().zip(sizes) {
            if term.test.is_some_and(|own| own != test) {
                continue;
            }
            let Some(sign) = same_direction(model, direction, term, test) else { continue };
            let profile = &profiles[term.function][test];
            course.iter_mut().zip(profile).for_each(|(sum, value)| *sum += sign * size * value);
        }
    }
    course
}

/// Sign with which a term moves the readings of a test as another one does, if it does.
fn same_direction(model: &LinearModel, one: &Term, other: &Term, test: usize) -> Option<f64> {
    if (one.outlet, one.along) == (other.outlet, other.along) {
        return Some(1.0);
    }
    let (one, other) = (model.gains_of_term(one), model.gains_of_term(other));
    let (one, other) = (one.get(test)?, other.get(test)?);
    let product: f64 = one.iter().zip(other).map(|(a, b)| a * b).sum();
    let largest = one.iter().map(|a| a * a).sum::<f64>().max(other.iter().map(|b| b * b).sum());
    (one.len() == other.len() && product.abs() > (1.0 - ONE_DIRECTION) * largest).then(|| product.signum())
}

/// Fall of the weighted squares from which a test shows what the lead has no part in, and the least loudness there, as a share
/// of the lead's own: a vibration along one direction shakes the others a little.
const LEAST_FALL_OF_SQUARES: f64 = 100.0;
const UNSEEN_SHARE: f64 = 0.12;

/// Whether a vibration moves tests that another one of its line, along one direction, cannot move: by what both were judged
/// with.
pub(crate) fn moves_elsewhere(wider: &Candidate, lead: &Candidate, noise: &[NoiseModel]) -> bool {
    // sum of squares over the rows of a test, mm², and rows
    let squares = |candidate: &Candidate, test: usize, sizes: &dyn Fn(usize) -> f64| -> (f64, usize) {
        let mut rows: Vec<f64> = Vec::new();
        for (k, column) in candidate.columns.iter().enumerate() {
            let column = &column.by_test[test];
            rows.resize(rows.len().max(column.len()), 0.0);
            rows.iter_mut().zip(column).for_each(|(sum, value)| *sum += sizes(k) * value);
        }
        (rows.iter().map(|value| value * value).sum(), rows.len())
    };
    let white = |test: usize| noise[test].white_mm.powi(2).max(f64::MIN_POSITIVE);
    let (mut shown, mut elsewhere, mut own) = (0.0, (0.0, 0), (0.0, 0));
    for test in 0..noise.len() {
        if squares(lead, test, &|_| lead.judgement.tau).0 < white(test) {
            let (sum, rows) = squares(wider, test, &|k| wider.judgement.amplitudes[k]);
            shown += sum / white(test);
            elsewhere = (elsewhere.0 + sum, elsewhere.1 + rows);
        } else {
            let (sum, rows) = squares(lead, test, &|k| lead.judgement.amplitudes[k]);
            own = (own.0 + sum, own.1 + rows);
        }
    }
    let loudness = |(sum, rows): (f64, usize)| (sum / rows.max(1) as f64).sqrt();
    shown > LEAST_FALL_OF_SQUARES && loudness(elsewhere) > UNSEEN_SHARE * loudness(own)
}
