//! How far a size depends on the shape that was chosen: shapes near by, weighted by their evidence. It chooses no shape.

use rayon::prelude::*;

use super::courses::settles;
use super::found::Candidate;
use super::ground::Term;
use super::library::Family;
use super::refining::judged;
use super::stage::Stage;
use super::whitened::LastShape;
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

/// Log odds by which shapes are no longer near by.
const FAR_OFF: f64 = 8.0;

/// Mean and standard deviation of a size over the shapes near a candidate's; `None` where its shape has no such freedom.
///
/// `stage` lays out all other effects; `size` tells the size of a shape with its amplitudes.
pub fn over_shapes<'s>(
    stage: impl FnOnce() -> Stage<'s, 's>,
    lead: &Candidate,
    family: &Family,
    size: impl Fn(&Candidate) -> f64 + Sync,
) -> Option<(f64, f64)> {
    if ["tau", "channel", "width"].iter().all(|name| lead.effect.parameter(name).is_none()) {
        return None;
    }
    let stage = stage();
    let tests = 0..stage.ground.tests();
    let length_s = tests.map(|test| stage.ground.context.ends_at_s(test)).fold(0.0, f64::max);
    let shapes = near_shapes(&lead.effect, length_s);
    if shapes.is_empty() {
        return None;
    }
    let sizes: Vec<(f64, f64)> = shapes
        .into_par_iter()
        .filter_map(|effect| {
            let shape = judged(&stage, family, lead.family, effect, 0.0, &mut LastShape::default())?;
            let counts = settles(&shape.effect) || !cancels(&shape.terms, &shape.judgement.amplitudes);
            counts.then(|| (shape.log_odds, size(&shape)))
        })
        .collect();
    let chosen = judged(&stage, family, lead.family, lead.effect.clone(), 0.0, &mut LastShape::default())?;
    let best = sizes.iter().map(|(odds, _)| *odds).fold(f64::NEG_INFINITY, f64::max);
    let weights: f64 = sizes.iter().map(|(odds, _)| (odds - best).exp()).sum();
    let mean = sizes.iter().map(|(odds, size)| (odds - best).exp() * size).sum::<f64>() / weights;
    let variance = sizes.iter().map(|(odds, size)| (odds - best).exp() * (size - mean).powi(2)).sum::<f64>() / weights;
    let are_near = best > chosen.log_odds - FAR_OFF;
    (are_near && mean.is_finite()).then(|| (mean, variance.sqrt()))
}

/// Sum of two nodes below this share of the larger one: nodes that nearly cancel say nothing of the time before the readings.
const LEAST_SUM: f64 = 0.7;

/// Whether functions of one outlet nearly cancel.
fn cancels(terms: &[Term], amplitudes: &[f64]) -> bool {
    let pairs = terms.iter().zip(amplitudes);
    pairs.clone().any(|(term, amplitude)| {
        let own = pairs.clone().filter(|(other, _)| other.outlet == term.outlet).map(|(_, amplitude)| amplitude);
        own.clone().count() > 1 && own.sum::<f64>().abs() < LEAST_SUM * amplitude.abs()
    })
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
            if effect.kind == "thermal-growth" {
                list.extend(NODES.map(|ratio| with(vec![first, ratio * first])));
            }
        }
        return list;
    }
    if let (Some(centre), Some(width)) = (effect.number("centre"), effect.number("width")) {
        let shapes = SHIFTS.iter().flat_map(|shift| WIDTHS.iter().map(move |factor| (shift, factor)));
        return shapes
            .map(|(shift, factor)| {
                let moved = effect.clone().with("centre", ParameterValue::Number(centre + shift * width));
                moved.with("width", ParameterValue::Number(factor * width))
            })
            .collect();
    }
    Vec::new()
}
