//! Candidates that grow with time, friction or temperature. It judges nothing.

use super::family::{CandidateFamily, Refined, list_of};
use crate::diagnose::model::linear_model::LinearModel;
use crate::effects::{OWN, ROTARY, SLIDES, THERMAL_GROWTH};
use crate::machine::{AxisKind, Effect, Outlet, ParameterValue, Place};

/// Growth over session time (fast and slow node) or with a temperature channel.
pub(super) fn growth(model: &LinearModel, place: Place, outlets: Vec<Outlet>) -> CandidateFamily {
    let span = model.context.order().iter().map(|&test| model.context.ends_at_s(test)).fold(60.0, f64::max);
    let pair = |fast: f64, slow: f64| Effect::new(THERMAL_GROWTH.name, place).with("tau", list_of(vec![fast, slow]));
    let single = |share: f64| Effect::new(THERMAL_GROWTH.name, place).with("tau", list_of(vec![share * span]));
    // one node first: two of them may cancel far beyond what the readings see
    let mut grid = [0.1, 0.3, 1.0].map(single).to_vec();
    grid.extend([pair(0.05 * span, 0.3 * span), pair(0.15 * span, 1.0 * span)]);
    grid.extend(heat_sources(model, place).into_iter().flat_map(|source| {
        [pair(0.03 * span, 0.3 * span), pair(0.08 * span, 1.0 * span)]
            .map(|nodes| nodes.with("heat", ParameterValue::Word(source.into())))
    }));
    grid.extend(channels(model).into_iter().flat_map(|channel| {
        lagging(&Effect::new(THERMAL_GROWTH.name, place).with("channel", ParameterValue::Word(channel)), span)
    }));
    CandidateFamily::new(THERMAL_GROWTH.name, place, outlets, 100.0).over(grid).refine(vec![
        Refined { name: "tau", least: 20.0, most: 5.0 * span, step: 0.05 * span, element: Some(0) },
        Refined { name: "tau", least: 20.0, most: 5.0 * span, step: 0.2 * span, element: Some(1) },
        lag_refined(span),
    ])
}

/// Frictions that may heat a place: its own axis where it moves, and all axes of its kind where others move as well.
fn heat_sources(model: &LinearModel, place: Place) -> Vec<&'static str> {
    let axes = &model.context.machine().axes;
    let Some(axis) = place.axis() else { return Vec::new() };
    let moves = |axis: usize| (0..model.tests()).any(|test| model.context.motion(test).moving.contains(&axis));
    let others = (0..axes.len()).any(|other| other != axis && axes[other].kind == axes[axis].kind && moves(other));
    let alike = match axes[axis].kind {
        AxisKind::Linear => SLIDES,
        AxisKind::Rotary => ROTARY,
    };
    [moves(axis).then_some(OWN), others.then_some(alike)].into_iter().flatten().collect()
}

/// Lags of a part behind a temperature channel, as shares of the session.
const LAGS: [f64; 5] = [0.0, 0.02, 0.06, 0.2, 0.6];

pub(super) fn lagging(effect: &Effect, span: f64) -> Vec<Effect> {
    LAGS.iter().map(|share| effect.clone().with("lag", ParameterValue::Number(share * span))).collect()
}

pub(super) fn lag_refined(span: f64) -> Refined {
    Refined { name: "lag", least: 0.0, most: 2.0 * span, step: 0.03 * span, element: None }
}

/// Temperature columns that every recording has.
pub fn channels(model: &LinearModel) -> Vec<String> {
    common_channels(model, |name| name.starts_with("temp"))
}

/// Columns of loads, in Nm or N, that every recording has, with a load at every row.
pub fn loads(model: &LinearModel) -> Vec<String> {
    let is_full = |name: &String| {
        let tests = model.context.session().tests.iter();
        let mut columns = tests.filter_map(|test| {
            let recording = test.recording.as_ref()?;
            recording.channels.iter().find(|(own, _)| own == name).map(|(_, column)| column)
        });
        columns.all(|column| column.iter().all(|value| value.is_finite()))
    };
    let mut names = common_channels(model, |name| name.ends_with("_Nm") || name.ends_with("_N"));
    names.retain(is_full);
    names
}

fn common_channels(model: &LinearModel, is_wanted: fn(&str) -> bool) -> Vec<String> {
    let tests = &model.context.session().tests;
    let names = |index: usize| -> Vec<String> {
        let recording = tests.get(index).and_then(|test| test.recording.as_ref());
        recording.map(|recording| recording.channels.iter().map(|(name, _)| name.clone()).collect()).unwrap_or_default()
    };
    let common = names(0);
    common
        .into_iter()
        .filter(|name| is_wanted(name) && (0..tests.len()).all(|test| names(test).contains(name)))
        .collect()
}
