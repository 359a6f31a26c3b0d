//! How far a size depends on the shape that was chosen: shapes near by, weighted by their evidence. It chooses no shape.

use rayon::prelude::*;

use super::judged_shape::judged;
use super::trajectory::settles;
use crate::diagnose::model::last_shape::LastShape;
use crate::diagnose::model::linear_model::Term;
use crate::diagnose::model::regression::Regression;
use crate::diagnose::selection::selected::Candidate;
use crate::effects::CandidateFamily;
use crate::effects::{COLD, Signature, WARM, is_a};
use crate::machine::{Effect, ParameterValue};

/// Time constants of growth that are tried, as shares of the session.
const SLOW: [f64; 9] = [0.05, 0.1, 0.17, 0.25, 0.35, 0.5, 0.7, 1.0, 2.0];
/// Ratios of the slow to the fast node of a growth.
const NODES: [f64; 3] = [2.0, 3.0, 5.0];
/// Factors of the chosen time constants that are tried.
const NEAR: [f64; 5] = [0.5, 0.7, 1.0, 1.4, 2.0];
/// Shifts of a bump's centre, as shares of its width, and factors of its width.
const SHIFTS: [f64; 5] = [-0.2, -0.08, 0.0, 0.08, 0.2];
const WIDTHS: [f64; 9] = [0.5, 0.7, 0.85, 1.0, 1.2, 1.45, 2.0, 3.0, 5.0];
/// Skews of a bump.
const SKEWS: [f64; 5] = [-0.6, -0.3, 0.0, 0.3, 0.6];

/// Warmth of a part as the session begins, in units of long work at a steady speed.
const WARMTHS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// Parameter of an effect that is kept from where an axis came to stand before the session.
const START: &str = "start";

/// Shapes of a family that are all tried: the customary leads of a screw that is seen at single places.
const FEW_SHAPES: usize = 16;

/// Log odds by which shapes are no longer near by, and by which they are not even with another state in the beginning.
const FAR_OFF: f64 = 8.0;
const STATES_FAR_OFF: f64 = 16.0;

/// Mean and standard deviation of a size over the shapes near a candidate's; `None` where its shape has no such freedom.
///
/// `regression` lays out all other effects; `size` tells the size of a shape with its amplitudes. No idealised form is exactly
/// right: one that is wrong by a share ρ of its size misses about `2 ρ² gain` of χ², and shapes whose log odds differ by
/// less than that are as good as each other. So log odds are divided by `1 + 2 ρ² gain` before they weigh.
pub fn over_shapes<'s>(
    regression: impl FnOnce() -> Regression<'s, 's>,
    (lead, gain, form_error): (&Candidate, f64, f64),
    family: &CandidateFamily,
    size: impl Fn(&Candidate) -> f64 + Sync,
) -> Option<(f64, f64)> {
    let few = is_a(&lead.effect.kind, Signature::Period) && family.grid.len() <= FEW_SHAPES;
    let starts = starts(&lead.effect, family);
    let has_shapes = ["tau", "channel", "width"].iter().any(|name| lead.effect.parameter(name).is_some());
    if !few && !has_shapes && starts.len() < 2 {
        return None;
    }
    let regression = regression();
    let softened = 1.0 + 2.0 * form_error * form_error * gain.max(0.0);
    let tests = 0..regression.model.tests();
    let length_s = tests.map(|test| regression.model.context.ends_at_s(test)).fold(0.0, f64::max);
    let judged = |effect: Effect| judged(&regression, family, lead.family, effect, 0.0, &mut LastShape::default());
    let counting = |effects: Vec<Effect>| -> Vec<Candidate> {
        let shapes = effects.into_par_iter().filter_map(judged);
        shapes.filter(|shape| settles(&shape.effect) || !cancels(&shape.terms, &shape.judgement.amplitudes)).collect()
    };
    let near = match few {
        true => family.grid.clone(),
        false if has_shapes => near_shapes(&lead.effect, length_s),
        false => starts,
    };
    let mut shapes = counting(near);
    let best = shapes.iter().map(|shape| shape.log_odds).max_by(f64::total_cmp)?;
    if has_states(&lead.effect) {
        shapes.retain(|shape| shape.log_odds > best - STATES_FAR_OFF * softened);
        shapes = counting(shapes.iter().flat_map(|shape| states(&shape.effect, family)).collect());
    }
    let sizes: Vec<(f64, f64)> = shapes.par_iter().map(|shape| (shape.log_odds, size(shape))).collect();
    let chosen = judged(lead.effect.clone())?;
    let best = sizes.iter().map(|(odds, _)| *odds).max_by(f64::total_cmp)?;
    let weight = |odds: &f64| ((odds - best) / softened).exp();
    let weights: f64 = sizes.iter().map(|(odds, _)| weight(odds)).sum();
    let mean = sizes.iter().map(|(odds, size)| weight(odds) * size).sum::<f64>() / weights;
    let variance = sizes.iter().map(|(odds, size)| weight(odds) * (size - mean).powi(2)).sum::<f64>() / weights;
    let are_near = best > chosen.log_odds - FAR_OFF * softened;
    (are_near && mean.is_finite()).then(|| (mean, variance.sqrt()))
}

/// The effect with every start of its family: where an axis came to stand before the session shows in its first moves alone.
fn starts(effect: &Effect, family: &CandidateFamily) -> Vec<Effect> {
    values(family, START).into_iter().map(|start| effect.clone().with(START, start.clone())).collect()
}

/// Values of a parameter on the grid of a family, each once.
fn values<'f>(family: &'f CandidateFamily, name: &str) -> Vec<&'f ParameterValue> {
    let mut values = Vec::new();
    for value in family.grid.iter().filter_map(|shape| shape.parameter(name)) {
        if !values.contains(&value) {
            values.push(value);
        }
    }
    values
}

/// Sum of two nodes below this share of the larger one: nodes that nearly cancel say nothing of the time before the readings.
const LEAST_SUM: f64 = 0.7;

/// Whether functions of one outlet nearly cancel.
pub(crate) fn cancels(terms: &[Term], amplitudes: &[f64]) -> bool {
    let pairs = terms.iter().zip(amplitudes);
    pairs.clone().any(|(term, amplitude)| {
        let own = pairs.clone().filter(|(other, _)| other.outlet == term.outlet).map(|(_, amplitude)| amplitude);
        own.clone().count() > 1 && own.sum::<f64>().abs() < LEAST_SUM * amplitude.abs()
    })
}

/// Whether a part may have been out of balance as the session began.
fn has_states(effect: &Effect) -> bool {
    is_a(&effect.kind, Signature::Growth)
        && (effect.parameter("heat").is_some() || effect.parameter("channel").is_some())
}

/// A growth with every friction that may heat the part, and with what it may have brought along as the session began: a
/// warm part has less to grow.
fn states(effect: &Effect, family: &CandidateFamily) -> Vec<Effect> {
    let begins = |effect: &Effect, state: &str| effect.clone().with("begins", ParameterValue::Word(state.into()));
    if effect.parameter("heat").is_none() {
        let warm = effect.number("lag").filter(|lag| *lag > 0.0).map(|_| begins(effect, WARM));
        return warm.into_iter().chain([begins(effect, COLD)]).collect();
    }
    let heated = values(family, "heat").into_iter().map(|source| effect.clone().with("heat", source.clone()));
    let of_a_source = |effect: Effect| {
        let cold = begins(&effect, COLD);
        let alike = WARMTHS.map(|warmth| cold.clone().with("warmth", ParameterValue::Number(warmth)));
        alike.into_iter().chain([begins(&effect, WARM)])
    };
    heated.flat_map(of_a_source).collect()
}

/// Shapes beside that of an effect, itself among them, in a session of a length.
fn near_shapes(effect: &Effect, length_s: f64) -> Vec<Effect> {
    // poses have no times
    let timed = effect.parameter("clock").is_none();
    if timed && (effect.parameter("tau").is_some() || effect.parameter("channel").is_some()) {
        let mut list = Vec::new();
        if effect.parameter("channel").is_some() {
            list.push(effect.clone());
            let lags = std::iter::once(0.0).chain(SLOW).map(|share| share * length_s);
            list.extend(lags.map(|lag| effect.clone().with("lag", ParameterValue::Number(lag))));
            return list;
        }
        let with = |values: Vec<f64>| effect.clone().with("tau", ParameterValue::List(values));
        if let Some(ParameterValue::List(nodes)) = effect.parameter("tau") {
            match nodes[..] {
                // the factors have 1 among them: the chosen shape itself
                [fast, slow] => list.extend(NEAR.iter().flat_map(|f| NEAR.map(|g| with(vec![f * fast, g * slow])))),
                [single] => list.extend(NEAR.map(|f| with(vec![f * single]))),
                _ => list.push(effect.clone()),
            }
        }
        for first in SLOW.map(|share| share * length_s) {
            list.push(with(vec![first]));
            if is_a(&effect.kind, Signature::Growth) {
                list.extend(NODES.map(|ratio| with(vec![first, ratio * first])));
            }
        }
        return list;
    }
    if let (Some(centre), Some(width)) = (effect.number("centre"), effect.number("width")) {
        let shapes = SHIFTS.iter().flat_map(|shift| WIDTHS.iter().map(move |factor| (shift, factor)));
        let moved = shapes.map(|(shift, factor)| {
            let moved = effect.clone().with("centre", ParameterValue::Number(centre + shift * width));
            moved.with("width", ParameterValue::Number(factor * width))
        });
        let skewed = |shape: Effect| SKEWS.map(|skew| shape.clone().with("skew", ParameterValue::Number(skew)));
        return match effect.number("skew") {
            Some(_) => moved.flat_map(skewed).chain([effect.clone()]).collect(),
            None => moved.collect(),
        };
    }
    Vec::new()
}
