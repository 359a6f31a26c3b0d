//! Vibrations as they really are: amplitude and phase that change in the course of a recording, and the one direction along
//! which a ball swings. Which lines there are is for the spectrum to say.

use nalgebra::{DMatrix, DVector};

use super::judged_shape::{PARAMETER_COST, judged};
use crate::diagnose::model::last_shape::LastShape;
use crate::diagnose::model::linear_model::Column;
use crate::diagnose::model::regression::Regression;
use crate::diagnose::noise::spectrum::aliases;
use crate::diagnose::selection::screening::candidates::ALONG;
use crate::diagnose::selection::selected::Candidate;
use crate::effects::CandidateFamily;
use crate::machine::{Effect, Outlet, ParameterValue};
use crate::statistics::log_determinant;

/// Highest degree of the wander of a vibration along one direction, and along several.
const MOST_WANDER: [i32; 2] = [3, 2];
/// Seconds between the knots of a wander that no polynomial follows, cycles that must lie between them, and most knots.
const KNOTS_S: [f64; 3] = [20.0, 10.0, 5.0];
const CYCLES: f64 = 2.0;
const MOST_KNOTS: f64 = 60.0;

/// Shares of the weighted squares from which what a vibration explains is worth a direction, and splines for its course: those
/// bend to anything that is loud and has no frequency.
const HAS_A_DIRECTION: f64 = 0.01;
const HAS_A_COURSE: f64 = 0.1;

/// A vibration whose amplitude and phase change in the course of a recording, and of a ball along one direction, as far as
/// the readings ask for it.
pub(crate) fn with_wander(regression: &Regression, family: &CandidateFamily, plain: Candidate) -> Candidate {
    let plain = of_all_rates(regression, family, plain);
    let swings_freely = family.outlets == [0, 1, 2].map(Outlet::SpindleBall);
    let best = with_polynomials(regression, family, plain, MOST_WANDER[usize::from(swings_freely)]);
    if !swings_freely {
        return with_splines(regression, family, best);
    }
    if best.judgement.chi2 < HAS_A_DIRECTION * regression.misfit {
        return best;
    }
    match along_one_direction(regression, family, &best) {
        Some(one) if one.log_odds > best.log_odds => one,
        _ => best,
    }
}

/// At the frequency, or at one of which it is an alias at one of the sampling rates, that explains most at all of them.
fn of_all_rates(regression: &Regression, family: &CandidateFamily, plain: Candidate) -> Candidate {
    let Some(hz) = plain.effect.number("frequency") else { return plain };
    let every = plain.effect.number("every");
    let is_fast = |alias: &f64| every.is_none_or(|every| has_cycles(every, *alias));
    let aliases = aliases(regression.model, hz).into_iter().filter(is_fast);
    let trials = aliases.filter_map(|alias| {
        varied(regression, family, &plain, plain.effect.clone().with("frequency", ParameterValue::Number(alias)))
    });
    match trials.max_by(|a, b| a.log_odds.total_cmp(&b.log_odds)) {
        Some(other) if other.log_odds > plain.log_odds + regression.model.thresholds.better => other,
        _ => plain,
    }
}

/// Whether a frequency has the cycles that must lie between two knots, so many seconds apart.
fn has_cycles(every: f64, hz: f64) -> bool {
    every * hz > CYCLES
}

/// With polynomials for amplitude and phase, up to a degree.
fn with_polynomials(regression: &Regression, family: &CandidateFamily, plain: Candidate, most: i32) -> Candidate {
    let effect = plain.effect.clone();
    let mut best = plain;
    for degree in 1..=most {
        match varied(
            regression,
            family,
            &best,
            effect.clone().with("wander", ParameterValue::Number(f64::from(degree))),
        ) {
            Some(trial) if trial.log_odds > best.log_odds + regression.model.thresholds.better => best = trial,
            // a phase that turns shows in the second degree, not always in the first
            _ if degree == 1 => {}
            _ => break,
        }
    }
    best
}

/// With splines for amplitude and phase, where those tell more.
fn with_splines(regression: &Regression, family: &CandidateFamily, mut best: Candidate) -> Candidate {
    if best.judgement.chi2 < HAS_A_COURSE * regression.misfit {
        return best;
    }
    let context = regression.model.context;
    let length_s = |test: usize| context.ends_at_s(test) - context.session().tests[test].started_at_s;
    let longest_s = (0..regression.model.tests()).map(length_s).fold(0.0, f64::max);
    let hz = best.effect.number("frequency").unwrap_or(0.0);
    for every in KNOTS_S.into_iter().filter(|every| has_cycles(*every, hz)) {
        let knots = (longest_s / every).ceil() + 2.0;
        if knots > MOST_KNOTS {
            break;
        }
        let effect = best.effect.clone().with("wander", ParameterValue::Number(knots.max(3.0)));
        match varied(regression, family, &best, effect.with("every", ParameterValue::Number(every))) {
            Some(trial) if trial.log_odds > best.log_odds + regression.model.thresholds.better => best = trial,
            _ => {}
        }
    }
    match best.effect.number("every") {
        // which alias it is could not be told as long as nothing followed its course
        Some(every) => of_all_rates(regression, family, in_the_middle(regression, family, best, every)),
        None => best,
    }
}

/// First step, as a share of the cycles between two knots, by which the frequency of a vibration with splines may lie better,
/// and how often it is halved.
const OFF_BY: f64 = 0.1;
const HALVINGS: usize = 2;

/// At the middle of its band: splines follow a line that is not quite at its frequency, but then less of its course.
fn in_the_middle(regression: &Regression, family: &CandidateFamily, mut best: Candidate, every: f64) -> Candidate {
    let mut step = OFF_BY / every;
    for _ in 0..=HALVINGS {
        for sign in [1.0, -1.0] {
            while let Some(hz) = best.effect.number("frequency")
                && has_cycles(every, hz + sign * step)
            {
                let moved = best.effect.clone().with("frequency", ParameterValue::Number(hz + sign * step));
                match varied(regression, family, &best, moved) {
                    Some(trial) if trial.log_odds > best.log_odds + regression.model.thresholds.better => best = trial,
                    _ => break,
                }
            }
        }
        step *= 0.5;
    }
    best
}

/// A candidate in another shape.
fn varied(
    regression: &Regression,
    family: &CandidateFamily,
    candidate: &Candidate,
    effect: Effect,
) -> Option<Candidate> {
    let cost = candidate.judgement.log_evidence - candidate.log_odds;
    judged(regression, family, candidate.family, effect, cost, &mut LastShape::default())
}

/// Steps in which direction and motion are fitted in turn, and the factor by which further ones are longer.
const TURNS: usize = 6;
const LONGER: f64 = 2.5;

/// A vibration of the ball in three directions, told along the one that explains most.
fn along_one_direction(regression: &Regression, family: &CandidateFamily, free: &Candidate) -> Option<Candidate> {
    let mut plain = free.effect.clone();
    plain.parameters.retain(|(name, _)| name != "wander");
    let along = |effect: &Effect, direction: [f64; 3]| {
        varied(regression, family, free, effect.clone().with(ALONG, ParameterValue::List(direction.to_vec())))
    };
    let better = |mut best: Candidate| {
        let mut step = 1.0;
        for _ in 0..TURNS {
            let (Some(from), Some(to)) = (along_of(&best), direction_of(regression, &best)) else { break };
            let direction = unit(from.into_iter().zip(to).map(|(from, to)| from + step * (to - from)));
            match direction.and_then(|direction| along(&best.effect, direction)) {
                Some(next) if next.log_odds > best.log_odds => (best, step) = (next, LONGER * step),
                _ if step > 1.0 => step = 1.0,
                _ => break,
            }
        }
        best
    };
    let first = better(along(&free.effect, likeliest(regression, free)?)?);
    let plain = along(&plain, along_of(&first)?)?;
    let wandering = with_polynomials(regression, family, plain, MOST_WANDER[0]);
    let mut best = better(with_splines(regression, family, wandering));
    // a direction has two angles; how many were tried first is no matter, for they are near ones of one optimum
    best.log_odds -= 2.0 * PARAMETER_COST;
    Some(best)
}

/// Direction of a swing along one.
fn along_of(candidate: &Candidate) -> Option<[f64; 3]> {
    candidate.terms.first()?.along
}

/// Directions of a half sphere that are tried first: some 7 degrees apart.
const DIRECTIONS: usize = 400;

/// Direction along which a swing explains most, of many: with amplitudes of its own in each test, their plausible size
/// being that of the free one.
fn likeliest(regression: &Regression, free: &Candidate) -> Option<[f64; 3]> {
    let profiles = regression.model.profiles(&free.effect).ok()?;
    let tests: Vec<Swing> = regression
        .products_by_test((free.family, &free.effect), (&profiles, &free.terms))
        .into_iter()
        .map(|(terms, gram, z)| {
            let is_of = |a: &usize, k: usize| free.terms[terms[*a]].outlet == Outlet::SpindleBall(k);
            let places = [0, 1, 2].map(|k| (0..terms.len()).filter(|a| is_of(a, k)).collect());
            Swing { places, gram, z }
        })
        .collect();
    let evidence =
        |direction: &[f64; 3]| -> f64 { tests.iter().map(|swing| swing.evidence(direction, free.judgement.tau)).sum() };
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let directions = (0..DIRECTIONS).map(|k| {
        let z = (k as f64 + 0.5) / DIRECTIONS as f64;
        let (sin, cos) = (golden * k as f64).sin_cos();
        let across = (1.0 - z * z).sqrt();
        [across * cos, across * sin, z]
    });
    let tried = directions.map(|direction| (evidence(&direction), direction));
    tried.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, direction)| direction)
}

/// Free swing of a ball in one test.
struct Swing {
    /// Terms of x, y and z among those that act there, function by function.
    places: [Vec<usize>; 3],
    /// Products of their columns with each other, and with what is left.
    gram: DMatrix<f64>,
    z: DVector<f64>,
}

impl Swing {
    /// Log evidence along one direction with amplitudes drawn from N(0, τ²), but for what is the same for all directions.
    fn evidence(&self, direction: &[f64; 3], tau: f64) -> f64 {
        let count = self.places.iter().map(Vec::len).min().unwrap_or(0);
        let place = |i: usize, a: usize| self.places[i][a];
        let over = |a: usize, b: usize| -> f64 {
            let pairs = (0..3).flat_map(|i| (0..3).map(move |j| (i, j)));
            pairs.map(|(i, j)| direction[i] * direction[j] * self.gram[(place(i, a), place(j, b))]).sum()
        };
        let z = DVector::from_fn(count, |a, _| (0..3).map(|i| direction[i] * self.z[place(i, a)]).sum());
        let precision = DMatrix::from_fn(count, count, over) + DMatrix::identity(count, count) / tau.powi(2);
        precision.cholesky().map_or(0.0, |factor| 0.5 * (z.dot(&factor.solve(&z)) - log_determinant(&factor)))
    }
}

/// Direction that explains most with the motion that a candidate has along its own.
fn direction_of(regression: &Regression, candidate: &Candidate) -> Option<[f64; 3]> {
    let model = regression.model;
    let profiles = model.profiles(&candidate.effect).ok()?;
    let mut motion: Vec<Vec<f64>> = model.residual_mm.iter().map(|rows| vec![0.0; rows.len()]).collect();
    for (term, size) in candidate.terms.iter().zip(&candidate.judgement.amplitudes) {
        let test = term.test?;
        motion[test].iter_mut().zip(&profiles[term.function][test]).for_each(|(sum, value)| *sum += size * value);
    }
    let columns = [0, 1, 2].map(|k| {
        let gains = model.gains(&Outlet::SpindleBall(k));
        let in_test = |(test, motion): (usize, &Vec<f64>)| -> Vec<f64> {
            gains[test].iter().zip(motion).map(|(gain, motion)| 1e-3 * gain * motion).collect()
        };
        Column::new(motion.iter().enumerate().map(in_test).collect())
    });
    unit(regression.judge(&columns, 10.0).amplitudes.into_iter())
}

fn unit(values: impl Iterator<Item = f64>) -> Option<[f64; 3]> {
    let values: Vec<f64> = values.collect();
    let length = values.iter().map(|value| value * value).sum::<f64>().sqrt();
    let [x, y, z] = <[f64; 3]>::try_from(values).ok()?;
    (length > 0.0).then(|| [x, y, z].map(|value| value / length))
}
