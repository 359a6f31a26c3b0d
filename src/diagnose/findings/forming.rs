//! Accepted effects to findings: how large they are, where and how surely they act. Grouping and names stand beside it.

use super::finding::{Finding, RangeFound, SizeFound};
use super::grouping::groups;
use super::standing::{Standing, is_same};
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
use crate::statistics::rms;
use nalgebra::DMatrix;
use std::ops::Range;

/// Groups what a search accepted and words each group as one finding, strongest first.
pub fn findings(
    model: &LinearModel,
    families: &[CandidateFamily],
    search: &Search,
    regression: &Regression,
    columns: &[Accepted],
) -> Vec<Finding> {
    let mut first_column = Vec::new();
    let mut next = 0;
    for found in &search.found {
        first_column.push(next);
        next += found.chosen.columns.len();
    }
    let covariance = regression.covariance();
    let fitted = Fitted { model, families, search, regression, columns, covariance, first_column };
    let groups = groups(search, &rates_of_tests(model), model.thresholds.rest_of_form);
    let mut list: Vec<Finding> = groups.iter().map(|group| fitted.finding(group)).collect();
    if list.len() > 1 {
        // what each adds beside all others: the first one that a search takes seems to explain everything
        let strength = |finding: &Finding| fitted.without(&finding.columns).misfit;
        list.sort_by_cached_key(|finding| std::cmp::Reverse(strength(finding).max(0.0).to_bits()));
    }
    list
}

/// What a search accepted, fitted on all rows.
struct Fitted<'f, 'a> {
    model: &'f LinearModel<'a>,
    families: &'f [CandidateFamily],
    search: &'f Search,
    regression: &'f Regression<'f, 'a>,
    columns: &'f [Accepted],
    covariance: DMatrix<f64>,
    /// By accepted effect.
    first_column: Vec<usize>,
}

impl<'f, 'a> Fitted<'f, 'a> {
    /// The fit of everything but some columns, with what linear axes do within their class.
    fn without(&self, own: &[usize]) -> Regression<'f, 'a> {
        let others = (0..self.columns.len()).filter(|k| !own.contains(k)).map(|k| self.columns[k].clone());
        let others = others.chain(self.search.beside.iter().cloned());
        Regression::new(self.model, &self.search.noise_after, &others.collect::<Vec<_>>(), &self.model.kept)
    }

    fn columns_of(&self, index: usize) -> Range<usize> {
        let first = self.first_column[index];
        first..first + self.search.found[index].chosen.columns.len()
    }

    fn finding(&self, group: &[usize]) -> Finding {
        let (model, lead) = (self.model, &self.search.found[group[0]]);
        let mut effects = Vec::new();
        for &index in group {
            let sizes: Vec<f64> = self.columns_of(index).map(|column| self.regression.accepted(column)).collect();
            effects.extend(sized(&self.search.found[index].chosen, &sizes, model));
        }
        let columns: Vec<usize> = group.iter().flat_map(|&index| self.columns_of(index)).collect();
        let gain: f64 = group.iter().map(|&index| self.search.found[index].gain).sum();
        let growing = self.with_sizes(group, Signature::Growth);
        let growing = if is_a(&lead.chosen.effect.kind, Signature::Growth) { growing } else { Vec::new() };
        let mut cause = self.cause(group, gain, &effects, &growing);
        let (probability, rivals) = self.standing(group, &cause);
        let mut size = self.size_of_parts(group, &cause);
        let family = &self.families[lead.chosen.family];
        let as_judged = |shape: &Candidate| size::size_as_judged(model, shape, &cause);
        let form_error = size::form_error(model, &lead.chosen.effect);
        let near = over_shapes(|| self.without(&columns), (&lead.chosen, gain, form_error), family, as_judged);
        if let Some((mean, sigma)) = near {
            size.value = mean;
            size.sigma = size.sigma.hypot(sigma);
        }
        if growing.len() > 1 {
            // growth told in several shapes: the others add to the lead's
            size.value += growth(model, &growing, &cause) - growth(model, &growing[..1], &cause);
        }
        size.sigma = size.sigma.hypot(over_rivals(model, lead, size.value));
        let (tests, rms_um) = shows(model, self.columns, &columns, self.regression);
        // larger than its cause can be: the form only follows something else
        let is_too_large = size.value - size.sigma > family.most;
        if lead.form_withdrawn || is_too_large {
            cause.effect = UNKNOWN.name.into();
        }
        Finding {
            cause,
            effects,
            size,
            tests,
            range: range(model, lead),
            probability,
            rivals,
            gain,
            single: lead.chosen.is_event(),
            columns,
            next_test: None,
            rms_um,
        }
    }

    /// The cause of a group: that of its first part, `unknown` where a free curve leads or takes much beside it.
    fn cause(&self, group: &[usize], gain: f64, effects: &[Effect], growing: &[(&Candidate, Vec<f64>)]) -> Cause {
        let machine = self.model.context.machine();
        let found = |index: &usize| &self.search.found[*index];
        let lead = found(&group[0]);
        let rest = || group.iter().skip(1).map(found);
        let free_gain: f64 = rest().filter(|part| part.chosen.is_free()).map(|part| part.gain).sum();
        let mut cause = cause(machine, &lead.chosen, effects);
        if !growing.is_empty() {
            let shown = growing_outlets(self.model, growing);
            cause.components = shown.iter().map(|outlet| component_name(machine, outlet)).collect();
        }
        if lead.chosen.is_free() || free_gain > self.model.thresholds.form_unknown * gain {
            cause.effect = UNKNOWN.name.into();
            for component in rest().flat_map(|part| components(machine, &part.chosen.terms)) {
                if !cause.components.contains(&component) {
                    cause.components.push(component);
                }
            }
        }
        cause
    }

    /// Probability of a group's cause, and its rivals with theirs: the part that is surest of its cause speaks for the whole.
    fn standing(&self, group: &[usize], told: &Cause) -> (f64, Vec<(Cause, f64)>) {
        let machine = self.model.context.machine();
        let of = |index: &usize| &self.search.found[*index];
        let named = |part: &SelectedEffect| cause(machine, &part.chosen, &[]);
        let lead = named(of(&group[0]));
        // a rest in other components says nothing of those of the lead
        let parts = group.iter().map(of).filter(|part| is_same(&named(part), &lead));
        let standings = parts.map(|part| Standing::of(self.model, self.families, part));
        let surest = standings.max_by(|a, b| a.probability.total_cmp(&b.probability));
        let (mut probability, mut rivals) =
            surest.map_or((1.0, Vec::new()), |standing| (standing.probability, standing.rivals));
        // a rival in more motions, of which one is too small to be told, is the same cause
        rivals.retain(|(rival, share)| {
            let is_same = rival == told;
            probability += if is_same { *share } else { 0.0 };
            !is_same
        });
        (probability, rivals)
    }

    /// Size of the parts that tell one thing together.
    fn size_of_parts(&self, group: &[usize], cause: &Cause) -> SizeFound {
        let (model, lead) = (self.model, &self.search.found[group[0]]);
        // lost motion told in two shapes is one play
        let is_one = |index: &&usize| **index == group[0] || is_same_play(lead, &self.search.found[**index]);
        let own =
            |&index: &usize| (self.first_column[index]..self.first_column[index] + lead.chosen.columns.len()).collect();
        let parts: Vec<Vec<usize>> = group.iter().filter(is_one).map(own).collect();
        let mut size = size::size_of(model, &lead.chosen, cause, self.regression, &self.covariance, &parts);
        // a vibration that wanders between neighbouring frequencies is the sum of all of them
        let vibrating = self.with_sizes(group, Signature::Oscillation);
        let is_sure = directions(&lead.chosen.terms) > 1 && size.sigma < SURE_SIZE * size.value;
        if vibrating.len() > 1 && is_a(&cause.effect, Signature::Oscillation) && !is_sure {
            size = vibration_size::size_together(model, &vibrating, &self.search.noise_after, size);
        }
        // a spike whose servo is no simple one, and growth with several time constants, are the sum of several
        for summed in [Signature::Spike, Signature::Growth] {
            let parts: Vec<(&Candidate, usize)> = self.of_kind(group, summed).collect();
            if parts.len() > 1 && is_a(&cause.effect, summed) {
                size = size::size_together(model, &parts, cause, self.regression, &self.covariance, size);
            }
        }
        size
    }

    /// The parts of a finding that are effects of a kind, each with its first column.
    fn of_kind<'s>(
        &'s self,
        group: &'s [usize],
        signature: Signature,
    ) -> impl Iterator<Item = (&'f Candidate, usize)> + 's {
        let search = self.search;
        let parts = group.iter().map(move |&index| (&search.found[index].chosen, self.first_column[index]));
        parts.filter(move |(part, _)| is_a(&part.effect.kind, signature))
    }

    /// The same with their sizes (display units).
    fn with_sizes(&self, group: &[usize], signature: Signature) -> Vec<(&'f Candidate, Vec<f64>)> {
        let sizes =
            |part: &Candidate, first| (0..part.terms.len()).map(|k| self.regression.accepted(first + k)).collect();
        self.of_kind(group, signature).map(|(part, first)| (part, sizes(part, first))).collect()
    }
}

/// Uncertainty, as a share, up to which a vibration in several directions has the size of its first part: what wanders is
/// little, and may be told in directions that hardly show it.
const SURE_SIZE: f64 = 0.1;

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
    is_a(&lead.chosen.effect.kind, Signature::Reversal)
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
pub(crate) fn shows(
    model: &LinearModel,
    columns: &[Accepted],
    own: &[usize],
    regression: &Regression,
) -> (Vec<String>, f64) {
    let mut shares: Vec<(usize, f64)> = Vec::new();
    for test in 0..model.tests() {
        let mut sum = vec![0.0; model.residual_mm[test].len()];
        for &k in own {
            let size = regression.accepted(k);
            for (total, value) in sum.iter_mut().zip(&columns[k].column.by_test[test]) {
                *total += size * value;
            }
        }
        let kept = sum.into_iter().zip(&model.kept[test]).filter(|(_, kept)| **kept);
        shares.push((test, rms(kept.map(|(value, _)| value)) * 1e3));
    }
    let largest = shares.iter().map(|(_, rms)| *rms).fold(0.0, f64::max);
    shares.retain(|(_, rms)| *rms > SHOWS * largest);
    loudest(model, shares)
}

/// Share of the rms in the test that shows an effect best below which another one hardly shows it.
const SHOWS: f64 = 0.3;

/// Tests that a finding names, at most.
const MOST_TESTS: usize = 12;

/// The tests with the largest rms, µm, by name, the largest first, and the rms over all of those given.
pub(crate) fn loudest(model: &LinearModel, mut tests: Vec<(usize, f64)>) -> (Vec<String>, f64) {
    tests.sort_by(|a, b| b.1.total_cmp(&a.1));
    let rms_um = rms(tests.iter().map(|(_, rms_um)| *rms_um));
    let name = |(test, _): &(usize, f64)| model.context.session().tests[*test].name.clone();
    (tests.iter().take(MOST_TESTS).map(name).collect(), rms_um)
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
