//! Accepted effects to findings: how large they are, where and how surely they act. Grouping and names stand beside it.

use super::finding::{Finding, RangeFound};
use super::grouping::groups;
use super::standing::Standing;
use super::{size, vibration_size};
use crate::diagnose::cause::Cause;
use crate::diagnose::model::linear_model::{LinearModel, Term, display};
use crate::diagnose::model::regression::{Accepted, Regression};
use crate::diagnose::noise::spectrum::rates_of_tests;
use crate::diagnose::selection::naming::{cause, component_name, components};
use crate::diagnose::selection::ranking::directions;
use crate::diagnose::selection::screening::candidates::ALONG;
use crate::diagnose::selection::selected::{Candidate, Search, SelectedEffect};
use crate::diagnose::selection::shapes::shape_average::over_shapes;
use crate::diagnose::selection::shapes::trajectory::{growing_outlets, growth};
use crate::effects::CandidateFamily;
use crate::effects::{Signature, UNKNOWN, is_a, kind, signature};
use crate::machine::{Effect, Outlet, ParameterValue, Size};

/// Groups what a search accepted and words each group as one finding, strongest first.
pub fn findings(
    model: &LinearModel,
    families: &[CandidateFamily],
    search: &Search,
    regression: &Regression,
    columns: &[Accepted],
) -> Vec<Finding> {
    let groups = groups(search, &rates_of_tests(model), model.thresholds.rest_of_form);
    let mut first_column = Vec::new();
    let mut next = 0;
    for found in &search.found {
        first_column.push(next);
        next += found.chosen.columns.len();
    }
    let covariance = regression.covariance();
    let mut list: Vec<Finding> = groups
        .iter()
        .map(|group| finding(model, families, search, group, &first_column, regression, &covariance, columns))
        .collect();
    if list.len() > 1 {
        // what each adds beside all others: the first one that a search takes seems to explain everything
        let strength = |finding: &Finding| {
            let others = (0..columns.len()).filter(|k| !finding.columns.contains(k)).map(|k| columns[k].clone());
            Regression::new(model, &search.noise_after, &others.collect::<Vec<_>>(), &model.kept).misfit
        };
        list.sort_by_cached_key(|finding| std::cmp::Reverse(strength(finding).max(0.0).to_bits()));
    }
    list
}

#[allow(clippy::too_many_arguments)]
fn finding(
    model: &LinearModel,
    families: &[CandidateFamily],
    search: &Search,
    group: &[usize],
    first_column: &[usize],
    regression: &Regression,
    covariance: &nalgebra::DMatrix<f64>,
    columns: &[Accepted],
) -> Finding {
    let machine = model.context.machine();
    let lead = &search.found[group[0]];
    let mut effects = Vec::new();
    let mut own_columns = Vec::new();
    for &index in group {
        let found = &search.found[index];
        let first = first_column[index];
        let sizes: Vec<f64> = (0..found.chosen.columns.len()).map(|k| regression.accepted(first + k)).collect();
        own_columns.extend(first..first + found.chosen.columns.len());
        effects.extend(sized(&found.chosen, &sizes, model));
    }
    let gain: f64 = group.iter().map(|&index| search.found[index].gain).sum();
    let free_gain: f64 = group
        .iter()
        .skip(1)
        .filter(|&&index| search.found[index].chosen.is_free())
        .map(|&index| search.found[index].gain)
        .sum();
    let is_unknown = lead.chosen.is_free() || free_gain > model.thresholds.form_unknown * gain;
    let mut cause = cause(machine, &lead.chosen, &effects);
    let growing = match is_a(&lead.chosen.effect.kind, Signature::Growth) {
        true => with_sizes(search, group, first_column, regression, Signature::Growth),
        false => Vec::new(),
    };
    if !growing.is_empty() {
        let shown = growing_outlets(model, &growing);
        cause.components = shown.iter().map(|outlet| component_name(machine, outlet)).collect();
    }
    if is_unknown {
        cause.effect = UNKNOWN.name.into();
        for &index in group.iter().skip(1) {
            for component in components(machine, &search.found[index].chosen.terms) {
                if !cause.components.contains(&component) {
                    cause.components.push(component);
                }
            }
        }
    }
    // the part that is surest of its cause speaks for the whole
    let parts = group.iter().map(|&index| &search.found[index]);
    let (mut probability, mut rivals): (f64, Vec<(Cause, f64)>) = parts
        .filter(|part| {
            (&part.chosen.effect.kind, part.chosen.effect.place) == (&lead.chosen.effect.kind, lead.chosen.effect.place)
        })
        .map(|part| {
            let standing = Standing::of(model, families, part);
            (standing.probability, standing.rivals)
        })
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap_or((1.0, Vec::new()));
    // a rival in more motions, of which one is too small to be told, is the same cause
    rivals.retain(|(rival, share)| {
        let is_same = *rival == cause;
        probability += if is_same { *share } else { 0.0 };
        !is_same
    });
    // lost motion told in two shapes is one play
    let parts: Vec<Vec<usize>> = group
        .iter()
        .filter(|&&index| index == group[0] || is_same_play(lead, &search.found[index]))
        .map(|&index| (first_column[index]..first_column[index] + lead.chosen.columns.len()).collect())
        .collect();
    let mut size = size::size_of(model, &lead.chosen, &cause, regression, covariance, &parts);
    // a vibration that wanders between neighbouring frequencies is the sum of all of them
    let vibrating = with_sizes(search, group, first_column, regression, Signature::Oscillation);
    let is_sure = directions(&lead.chosen.terms) > 1 && size.sigma < SURE_SIZE * size.value;
    if vibrating.len() > 1 && is_a(&cause.effect, Signature::Oscillation) && !is_sure {
        size = vibration_size::size_together(model, &vibrating, &search.noise_after, size);
    }
    // a spike whose servo is no simple one is the sum of several
    let spikes: Vec<(&Candidate, usize)> = of_kind(search, group, first_column, Signature::Spike).collect();
    if spikes.len() > 1 && is_a(&cause.effect, Signature::Spike) {
        size = size::size_together(model, &spikes, &cause, regression, covariance, size);
    }
    let without_own = || {
        let others = (0..columns.len()).filter(|k| !own_columns.contains(k)).map(|k| columns[k].clone());
        Regression::new(model, &search.noise_after, &others.collect::<Vec<_>>(), &model.kept)
    };
    let family = &families[lead.chosen.family];
    let as_judged = |shape: &Candidate| size::size_as_judged(model, shape, &cause);
    if let Some((mean, sigma)) = over_shapes(without_own, (&lead.chosen, gain), family, as_judged) {
        size.value = mean;
        size.sigma = size.sigma.hypot(sigma);
    }
    if growing.len() > 1 {
        // growth told in several shapes: the others add to the lead's
        size.value += growth(model, &growing, &cause) - growth(model, &growing[..1], &cause);
    }
    size.sigma = size.sigma.hypot(over_rivals(model, lead, size.value));
    let (tests, rms_um) = shows(model, columns, &own_columns, regression);
    let range = range(model, lead);
    if lead.form_withdrawn {
        cause.effect = UNKNOWN.name.into();
    }
    Finding {
        cause,
        effects,
        size,
        tests,
        range,
        probability,
        rivals,
        gain,
        single: lead.chosen.is_event(),
        columns: own_columns,
        next_test: None,
        rms_um,
    }
}

/// Uncertainty, as a share, up to which a vibration in several directions has the size of its first part: what wanders is
/// little, and may be told in directions that hardly show it.
const SURE_SIZE: f64 = 0.1;

/// The parts of a finding that are effects of a kind, each with its first column.
fn of_kind<'s>(
    search: &'s Search,
    group: &'s [usize],
    first_column: &'s [usize],
    signature: Signature,
) -> impl Iterator<Item = (&'s Candidate, usize)> {
    let parts = group.iter().map(|&index| (&search.found[index].chosen, first_column[index]));
    parts.filter(move |(part, _)| is_a(&part.effect.kind, signature))
}

/// The same with their sizes (display units).
fn with_sizes<'s>(
    search: &'s Search,
    group: &'s [usize],
    first_column: &'s [usize],
    regression: &Regression,
    signature: Signature,
) -> Vec<(&'s Candidate, Vec<f64>)> {
    let sizes = |part: &Candidate, first| (0..part.terms.len()).map(|k| regression.accepted(first + k)).collect();
    of_kind(search, group, first_column, signature).map(|(part, first)| (part, sizes(part, first))).collect()
}

/// Standard deviation of a size over rivals that are the same effect in other components or of another driver.
fn over_rivals(model: &LinearModel, lead: &SelectedEffect, value: f64) -> f64 {
    let machine = model.context.machine();
    let own = &lead.chosen.effect;
    let is_length = |candidate: &Candidate| candidate.terms.iter().any(size::is_length);
    // the amplitudes of a vibration are those of single tests: its size is no matter of the shape
    if is_a(&own.kind, Signature::Oscillation) {
        return 0.0;
    }
    let mut squares = 0.0;
    let mut weights = 1.0;
    for (rival, odds) in &lead.rivals {
        let is_same = rival.effect.kind == own.kind && rival.effect.place == own.place;
        if is_same && is_length(rival) == is_length(&lead.chosen) {
            let size = size::size_as_judged(model, rival, &cause(machine, rival, &[]));
            let weight = odds.min(0.0).exp();
            squares += weight * (size - value).powi(2);
            weights += weight;
        }
    }
    (squares / weights).sqrt()
}

/// Another shape of the lead's lost motion: their half widths add.
fn is_same_play(lead: &SelectedEffect, other: &SelectedEffect) -> bool {
    lead.chosen.effect.kind.ends_with("-backlash")
        && lead.chosen.effect.kind == other.chosen.effect.kind
        && lead.chosen.terms == other.chosen.terms
}

/// The effect with its fitted sizes; effects with amplitudes by test become one effect per test.
fn sized(candidate: &Candidate, sizes: &[f64], model: &LinearModel) -> Vec<Effect> {
    let Some(kind) = kind(&candidate.effect.kind) else { return Vec::new() };
    let functions = (kind.functions)(&candidate.effect);
    let sizes_of = |term: &Term, value: f64| -> Vec<Size> {
        let of = |(outlet, share): (Outlet, f64)| Size {
            outlet,
            function: functions[term.function].clone(),
            value: share * value / display(term.measure),
        };
        term.shares().into_iter().map(of).collect()
    };
    let mut list: Vec<Effect> = Vec::new();
    for (term, &value) in candidate.terms.iter().zip(sizes) {
        let tests = match term.test {
            Some(test) => Some(vec![model.context.session().tests[test].name.clone()]),
            None => candidate.effect.tests.clone(),
        };
        match list.iter_mut().find(|effect| effect.tests == tests) {
            Some(effect) => effect.sizes.extend(sizes_of(term, value)),
            None => {
                let mut effect = candidate.effect.clone();
                effect.parameters.retain(|(name, _)| name != ALONG);
                effect.tests = tests;
                effect.sizes = sizes_of(term, value);
                list.push(effect);
            }
        }
    }
    list
}

/// Tests in which the columns show, most visible first, and their rms there, µm.
fn shows(model: &LinearModel, columns: &[Accepted], own: &[usize], regression: &Regression) -> (Vec<String>, f64) {
    let mut shares: Vec<(usize, f64)> = Vec::new();
    for test in 0..model.tests() {
        let rows = model.residual_mm[test].len();
        let mut sum = vec![0.0; rows];
        for &k in own {
            let size = regression.accepted(k);
            for (total, value) in sum.iter_mut().zip(&columns[k].column.by_test[test]) {
                *total += size * value;
            }
        }
        let mean = sum.iter().sum::<f64>() / rows.max(1) as f64;
        let rms = (sum.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / rows.max(1) as f64).sqrt();
        shares.push((test, rms * 1e3));
    }
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    let largest = shares.first().map_or(0.0, |(_, rms)| *rms);
    shares.retain(|(_, rms)| *rms > 0.3 * largest);
    let rms = (shares.iter().map(|(_, rms)| rms * rms).sum::<f64>() / shares.len().max(1) as f64).sqrt();
    (shares.iter().take(12).map(|(test, _)| model.context.session().tests[*test].name.clone()).collect(), rms)
}

/// Where along its driver the lead acts.
fn range(model: &LinearModel, lead: &SelectedEffect) -> Option<RangeFound> {
    let machine = model.context.machine();
    let effect = &lead.chosen.effect;
    let last = model.context.order().iter().map(|&test| model.context.ends_at_s(test)).fold(0.0, f64::max);
    if let Some(time) = effect.number("time") {
        return Some(RangeFound { axis: "time_s".into(), from: time, to: last });
    }
    let driving = match effect.parameter("of") {
        Some(ParameterValue::Word(name)) => machine.axis_index(name),
        _ => None,
    };
    let axis = driving.or(effect.place.axis())?;
    let entry = &machine.axes[axis];
    let file = |q: f64| entry.kind.to_file_unit(q);
    if let (Some(centre), Some(width)) = (effect.number("centre"), effect.number("width")) {
        return Some(RangeFound {
            axis: entry.name.clone(),
            from: file(centre - width / 2.0),
            to: file(centre + width / 2.0),
        });
    }
    // static poses have no times
    if is_a(&effect.kind, Signature::Growth) && effect.parameter("clock").is_none() {
        return Some(RangeFound { axis: "time_s".into(), from: 0.0, to: last });
    }
    let ends = (0..model.tests())
        .flat_map(|test| model.context.motion(test).axis(axis))
        .fold((f64::MAX, f64::MIN), |(from, to), q| (from.min(q), to.max(q)));
    // what lies beyond the readings nobody knows
    let ends = match (signature(&effect.kind), effect.number("from"), effect.number("to")) {
        (Some(Signature::Lift), Some(from), Some(to)) => (from.max(ends.0), to.min(ends.1)),
        _ => ends,
    };
    Some(RangeFound { axis: entry.name.clone(), from: file(ends.0), to: file(ends.1) })
}
