//! The thesis's chapters 4 to 7 as choices from the generic solver's setups; nothing here knows a particular machine.

use std::collections::{BTreeMap, BTreeSet};

use crate::machine::AxisKind;
use crate::plan::context::choice::{Choice, Entry};
use crate::plan::context::evaluation::{Evaluation, SAME_WORTH};
use crate::plan::context::method::{APART_MM, LEVEL_MM, Method, MethodError};
use crate::plan::information::posterior::Posterior;
use crate::plan::places::candidate::Candidate;
use crate::plan::reach::sweep_reach::ClearArc;
use crate::plan::reasons::unfit::{no_lengths, no_pivot_for_all, no_places};

/// Places looked at before the best is taken, by the methods that have few.
const GROUPS: usize = 40;
/// The same for pairs of lengths, which are looked at in the order of what they would tell at most.
const MOST_GROUPS: usize = 4000;
/// The tests of a method.
pub(crate) fn method_choice<'a>(evaluation: &mut Evaluation<'a>, method: Method) -> Result<Choice<'a>, MethodError> {
    let axes: Vec<usize> = evaluation.context.machine.axes_of(AxisKind::Rotary).collect();
    let name = match method {
        Method::Chapter4 => "chapter4",
        Method::Chapter5 => "chapter5",
        Method::Chapter6 => "chapter6",
        Method::Chapter7 => "chapter7",
    };
    let refuse = |reason: String| MethodError { method: name, reason };
    let found = match method {
        Method::Chapter5 => match one_pivot(evaluation, &axes) {
            Some(found) => found,
            None => return Err(refuse(no_pivot_for_all(evaluation, &axes))),
        },
        Method::Chapter6 => {
            each(evaluation, &axes, two_places, |evaluation, axis| refuse(no_places(evaluation, axis)))?
        }
        Method::Chapter4 | Method::Chapter7 => {
            each(evaluation, &axes, two_lengths, |evaluation, axis| refuse(no_lengths(evaluation, axis)))?
        }
    };
    let entries: Vec<Entry> =
        found.into_iter().map(|(candidate, sweep)| evaluation.entry(candidate, Some(sweep))).collect();
    let chosen = (0..entries.len()).collect();
    Ok(Choice { entries, chosen })
}

type Pair<'a> = Vec<(&'a Candidate, ClearArc)>;

fn each<'a>(
    evaluation: &mut Evaluation<'a>,
    axes: &[usize],
    tests_of: impl Fn(&mut Evaluation<'a>, usize) -> Option<Pair<'a>>,
    refuse: impl Fn(&Evaluation<'a>, usize) -> MethodError,
) -> Result<Pair<'a>, MethodError> {
    let mut all = Vec::new();
    for &axis in axes {
        match tests_of(evaluation, axis) {
            Some(tests) => all.extend(tests),
            None => return Err(refuse(evaluation, axis)),
        }
    }
    Ok(all)
}

/// Candidates of an axis by what is mounted and where the other rotary axes stand.
fn groups<'a>(evaluation: &Evaluation<'a>, axis: usize) -> BTreeMap<(usize, usize, Vec<i64>), Vec<&'a Candidate>> {
    let list: &'a [Candidate] = &evaluation.context.all.list;
    let mut groups: BTreeMap<_, Vec<&Candidate>> = BTreeMap::new();
    for candidate in list.iter().filter(|candidate| candidate.axis == axis && candidate.is_plain()) {
        let turned = (0..evaluation.context.machine.axes.len())
            .filter(|&k| k != axis && evaluation.context.machine.axes[k].kind == AxisKind::Rotary)
            .map(|k| (candidate.solved.positions[k] * 1e6).round() as i64)
            .collect();
        groups.entry((candidate.site, candidate.place, turned)).or_default().push(candidate);
    }
    groups
}

/// Short bar level with the carried ball and the next longer bar, with the longest sweeps that are clear: of the places of the
/// longer one that which tells most of the axis.
fn lengths_in<'a>(evaluation: &mut Evaluation<'a>, group: &[&'a Candidate]) -> Option<Pair<'a>> {
    let level = *group.iter().find(|candidate| candidate.solved.h_mm.abs() < LEVEL_MM)?;
    let short = evaluation.clear(level)?;
    let mut best: Option<(f64, &Candidate, ClearArc)> = None;
    for candidate in next_longer(group, level.bar_mm) {
        if let Some(sweep) = evaluation.clear(candidate) {
            let left = left_by(evaluation, [(level, Some(&short)), (candidate, Some(&sweep))].into_iter());
            if best.as_ref().is_none_or(|(least, ..)| left < least - SAME_WORTH) {
                best = Some((left, candidate, sweep));
            }
        }
    }
    let (_, extended, sweep) = best?;
    Some(vec![(level, short), (extended, sweep)])
}

fn next_longer<'a>(group: &[&'a Candidate], bar_mm: f64) -> Vec<&'a Candidate> {
    let next = group.iter().map(|c| c.bar_mm).filter(|&bar| bar > bar_mm + 1.0).fold(f64::MAX, f64::min);
    group.iter().filter(|candidate| (candidate.bar_mm - next).abs() < 1e-6).copied().collect()
}

/// What tests leave unknown of the errors of the axes that they sweep, pivots and bars unknown: Σ ln σ². Without an arc the
/// whole one wanted is taken, which leaves no more than any part of it.
fn left_by<'a: 'b, 'b>(
    evaluation: &Evaluation<'a>,
    tests: impl Iterator<Item = (&'a Candidate, Option<&'b ClearArc>)>,
) -> f64 {
    let mut posterior = Posterior::before_with_loose_setups(&evaluation.context.unknowns);
    let mut swept = BTreeSet::new();
    for (candidate, arc) in tests {
        posterior.add(&evaluation.entry(candidate, arc.cloned()).block);
        swept.insert(candidate.axis);
    }
    let mine =
        (0..evaluation.context.unknowns.wanted).filter(|&k| swept.contains(&evaluation.context.unknowns.errors[k].0));
    mine.map(|k| posterior.covariance(k, k).ln()).sum()
}

fn left_by_pair<'a>(evaluation: &Evaluation<'a>, pair: &Pair<'a>) -> f64 {
    left_by(evaluation, pair.iter().map(|(candidate, sweep)| (*candidate, Some(sweep))))
}

/// The pair of lengths that tells most of an axis, with the shortest bar that is clear anywhere.
fn two_lengths<'a>(evaluation: &mut Evaluation<'a>, axis: usize) -> Option<Pair<'a>> {
    let groups = groups(evaluation, axis);
    let mut by_bar: BTreeMap<i64, Vec<Vec<&'a Candidate>>> = BTreeMap::new();
    for group in groups.into_values() {
        if let Some(level) = group.iter().find(|c| c.solved.h_mm.abs() < LEVEL_MM) {
            by_bar.entry((level.bar_mm * 1e3).round() as i64).or_default().push(group);
        }
    }
    by_bar.into_values().find_map(|groups| most_telling_lengths(evaluation, groups))
}

/// The group whose clear sweeps tell most; of equals the one with the ball nearest the nose, then the linear axes nearest zero.
fn most_telling_lengths<'a>(evaluation: &mut Evaluation<'a>, groups: Vec<Vec<&'a Candidate>>) -> Option<Pair<'a>> {
    let mut ranked: Vec<_> = groups
        .into_iter()
        .filter_map(|group| {
            let level = *group.iter().find(|c| c.solved.h_mm.abs() < LEVEL_MM)?;
            let whole = |extended: &'a Candidate| left_by(evaluation, [(level, None), (extended, None)].into_iter());
            let least = next_longer(&group, level.bar_mm).into_iter().map(whole).reduce(f64::min)?;
            let moved: f64 = group.iter().map(|c| travel(evaluation, c)).fold(f64::MAX, f64::min);
            Some(((least / SAME_WORTH).floor(), level.place, moved, group))
        })
        .collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.total_cmp(&b.2)));
    let mut best: Option<(f64, usize, Pair)> = None;
    for (looked, (bound, place, _, group)) in ranked.into_iter().enumerate() {
        let is_settled = |(least, ..): &(f64, usize, Pair)| looked >= MOST_GROUPS || bound * SAME_WORTH >= *least;
        if best.as_ref().is_some_and(is_settled) {
            break;
        }
        let Some(pair) = lengths_in(evaluation, &group) else { continue };
        let left = left_by_pair(evaluation, &pair);
        let is_better = |(least, nearest, _): &(f64, usize, Pair)| {
            left < least - SAME_WORTH || left < least + SAME_WORTH && place < *nearest
        };
        if best.as_ref().is_none_or(is_better) {
            best = Some((left, place, pair));
        }
    }
    best.map(|(.., pair)| pair)
}

/// How far the linear axes stand from zero, mm: setups near zero feel their errors least.
fn travel(evaluation: &Evaluation, candidate: &Candidate) -> f64 {
    evaluation
        .context
        .machine
        .axes_of(AxisKind::Linear)
        .map(|k| candidate.solved.positions[k].powi(2))
        .sum::<f64>()
        .sqrt()
}

/// One pivot with both bars for every axis, the other rotary axes at zero.
fn one_pivot<'a>(evaluation: &mut Evaluation<'a>, axes: &[usize]) -> Option<Pair<'a>> {
    let by_axis: Vec<_> = axes.iter().map(|&axis| groups(evaluation, axis)).collect();
    let first = by_axis.first()?;
    let mut keys: Vec<_> = first.keys().filter(|(_, _, turned)| turned.iter().all(|&q| q == 0)).cloned().collect();
    let bar = |key: &(usize, usize, Vec<i64>)| {
        by_axis
            .iter()
            .map(|groups| {
                groups.get(key).and_then(|group| {
                    group.iter().filter(|c| c.solved.h_mm.abs() < LEVEL_MM).map(|c| (c.bar_mm * 1e3) as i64).min()
                })
            })
            .collect::<Option<Vec<i64>>>()
    };
    let moved = |key: &(usize, usize, Vec<i64>)| {
        let group = first.get(key).map(Vec::as_slice).unwrap_or_default();
        group.iter().map(|c| (travel(evaluation, c) * 1e3) as i64).min().unwrap_or(i64::MAX)
    };
    let mut ranked: Vec<_> =
        keys.drain(..).filter_map(|key| bar(&key).map(|bars| (bars, key.1, moved(&key), key))).collect();
    ranked.sort();
    let mut best: Option<(f64, Pair)> = None;
    for (looked, (_, place, _, key)) in ranked.iter().enumerate() {
        let settled = best.as_ref().is_some_and(|(_, pair)| pair.first().is_some_and(|(c, _)| c.place != *place));
        if settled || looked >= GROUPS && best.is_some() {
            break;
        }
        let pairs: Option<Vec<Pair>> = by_axis.iter().map(|groups| lengths_in(evaluation, groups.get(key)?)).collect();
        if let Some(pairs) = pairs {
            let all: Pair = pairs.into_iter().flatten().collect();
            let left = left_by_pair(evaluation, &all);
            if best.as_ref().is_none_or(|(least, _)| left < least - SAME_WORTH) {
                best = Some((left, all));
            }
        }
    }
    best.map(|(_, pair)| pair)
}

/// Tests of one place along an axis that are paired with those of other places: the ones that tell most alone.
const BEST_OF_PLACE: usize = 3;

/// The short bar at h = 0 at two places along the axis: the pair that together tells most of the axis's errors. The spindle
/// ball stays where it is unless only another stem or arm brings the second place.
fn two_places<'a>(evaluation: &mut Evaluation<'a>, axis: usize) -> Option<Pair<'a>> {
    let list: &'a [Candidate] = &evaluation.context.all.list;
    let level = || list.iter().filter(|c| c.axis == axis && c.is_plain() && c.solved.h_mm.abs() < LEVEL_MM);
    let bar = level().map(|c| c.bar_mm).fold(f64::MAX, f64::min);
    let short: Vec<&Candidate> = level().filter(|c| (c.bar_mm - bar).abs() < 1e-6).collect();
    let nearest = short.iter().map(|c| c.place).min()?;
    let unmoved: Vec<&Candidate> = short.iter().copied().filter(|c| c.place == nearest).collect();
    most_telling_pair(evaluation, axis, &unmoved).or_else(|| most_telling_pair(evaluation, axis, &short))
}

/// Of clear tests at two places the pair that leaves the least Σ ln σ² of the axis's errors, pivots and bars unknown.
fn most_telling_pair<'a>(evaluation: &mut Evaluation<'a>, axis: usize, level: &[&'a Candidate]) -> Option<Pair<'a>> {
    let mut by_along: BTreeMap<i64, Vec<&Candidate>> = BTreeMap::new();
    for candidate in level {
        by_along.entry((candidate.solved.along_mm * 10.0).round() as i64).or_default().push(candidate);
    }
    let before = Posterior::before_with_loose_setups(&evaluation.context.unknowns);
    let mine: Vec<usize> =
        (0..evaluation.context.unknowns.wanted).filter(|&k| evaluation.context.unknowns.errors[k].0 == axis).collect();
    let unknown = |variances: &[f64]| mine.iter().map(|&k| variances[k].ln()).sum::<f64>();
    let mut clear: Vec<Entry> = Vec::new();
    for candidates in by_along.values_mut() {
        candidates.sort_by(|a, b| a.place.cmp(&b.place).then(travel(evaluation, a).total_cmp(&travel(evaluation, b))));
        let mut here: Vec<(f64, Entry)> = Vec::new();
        for candidate in candidates.iter().take(GROUPS) {
            if let Some(sweep) = evaluation.clear(candidate) {
                let entry = evaluation.entry(candidate, Some(sweep));
                here.push((unknown(&before.variances_with(&entry.block)), entry));
            }
        }
        here.sort_by(|a, b| a.0.total_cmp(&b.0));
        clear.extend(here.into_iter().take(BEST_OF_PLACE).map(|(_, entry)| entry));
    }
    let mut best: Option<(f64, usize, usize)> = None;
    for (first, low) in clear.iter().enumerate() {
        let mut posterior = before.clone();
        posterior.add(&low.block);
        for (second, high) in clear.iter().enumerate().skip(first + 1) {
            if high.candidate.solved.along_mm - low.candidate.solved.along_mm <= APART_MM {
                continue;
            }
            let left = unknown(&posterior.variances_with(&high.block));
            if best.is_none_or(|(least, ..)| left < least - 1e-9) {
                best = Some((left, first, second));
            }
        }
    }
    let (_, low, high) = best?;
    [low, high].into_iter().map(|k| Some((clear[k].candidate, clear[k].sweep.clone()?))).collect()
}
