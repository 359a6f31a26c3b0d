//! The thesis's chapters 4 to 7 as choices from the generic solver's setups; nothing here knows a particular machine.

use std::collections::BTreeMap;

use super::candidates::Candidate;
use super::choose::{Choice, Desk, Entry};
use super::knowledge::Knowledge;
use super::reach::ClearArc;
use super::unfit::{no_lengths, no_pivot_for_all, no_places};
use crate::machine::AxisKind;

/// A measuring method of the thesis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Each rotary axis from its own pivot: the short bar at h = 0, then the extended bar.
    Chapter4,
    /// As chapter 4 with one pivot setup for all axes.
    Chapter5,
    /// The short bar only, at two places along each axis.
    Chapter6,
    /// As chapter 4, the ball of tilting heads on a flat fixture and the pivot on an angle plate where needed.
    Chapter7,
}

/// Why a method gave no plan.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{method} does not fit this machine: {reason}")]
pub struct MethodError {
    pub method: &'static str,
    pub reason: String,
}

/// Least distance between the two places of chapter 6, mm.
pub(super) const APART_MM: f64 = 30.0;
/// Groups looked at for each axis before the best is taken.
const GROUPS: usize = 40;
/// h = 0 within this, mm.
pub(super) const LEVEL_MM: f64 = 1e-3;

/// The tests of a method.
pub(super) fn method_choice<'a>(desk: &mut Desk<'a>, method: Method) -> Result<Choice<'a>, MethodError> {
    let axes: Vec<usize> =
        (0..desk.machine.axes.len()).filter(|&k| desk.machine.axes[k].kind == AxisKind::Rotary).collect();
    let name = match method {
        Method::Chapter4 => "chapter4",
        Method::Chapter5 => "chapter5",
        Method::Chapter6 => "chapter6",
        Method::Chapter7 => "chapter7",
    };
    let refuse = |reason: String| MethodError { method: name, reason };
    let found = match method {
        Method::Chapter5 => match one_pivot(desk, &axes) {
            Some(found) => found,
            None => return Err(refuse(no_pivot_for_all(desk, &axes))),
        },
        Method::Chapter6 => each(desk, &axes, two_places, |desk, axis| refuse(no_places(desk, axis)))?,
        Method::Chapter4 | Method::Chapter7 => {
            each(desk, &axes, two_lengths, |desk, axis| refuse(no_lengths(desk, axis)))?
        }
    };
    let entries: Vec<Entry> = found.into_iter().map(|(candidate, sweep)| desk.entry(candidate, Some(sweep))).collect();
    let chosen = (0..entries.len()).collect();
    Ok(Choice { entries, chosen })
}

type Pair<'a> = Vec<(&'a Candidate, ClearArc)>;

fn each<'a>(
    desk: &mut Desk<'a>,
    axes: &[usize],
    tests_of: impl Fn(&mut Desk<'a>, usize) -> Option<Pair<'a>>,
    refuse: impl Fn(&Desk<'a>, usize) -> MethodError,
) -> Result<Pair<'a>, MethodError> {
    let mut all = Vec::new();
    for &axis in axes {
        match tests_of(desk, axis) {
            Some(tests) => all.extend(tests),
            None => return Err(refuse(desk, axis)),
        }
    }
    Ok(all)
}

/// Candidates of an axis by what is mounted and where the other rotary axes stand.
fn groups<'a>(desk: &Desk<'a>, axis: usize) -> BTreeMap<(usize, usize, Vec<i64>), Vec<&'a Candidate>> {
    let list: &'a [Candidate] = &desk.all.list;
    let mut groups: BTreeMap<_, Vec<&Candidate>> = BTreeMap::new();
    for candidate in list.iter().filter(|candidate| candidate.axis == axis && candidate.is_plain()) {
        let turned = (0..desk.machine.axes.len())
            .filter(|&k| k != axis && desk.machine.axes[k].kind == AxisKind::Rotary)
            .map(|k| (candidate.solved.positions[k] * 1e6).round() as i64)
            .collect();
        groups.entry((candidate.site, candidate.place, turned)).or_default().push(candidate);
    }
    groups
}

/// Short bar level with the carried ball and the next longer bar, with the longest sweeps that are clear.
fn lengths_in<'a>(desk: &mut Desk<'a>, group: &[&'a Candidate]) -> Option<Pair<'a>> {
    let level = *group.iter().find(|candidate| candidate.solved.h_mm.abs() < LEVEL_MM)?;
    let extended: Vec<&Candidate> = next_longer(group, level.bar_mm);
    let short = desk.clear(level)?;
    let mut best: Option<(&Candidate, ClearArc)> = None;
    for candidate in extended {
        if let Some(sweep) = desk.clear(candidate)
            && best.as_ref().is_none_or(|(_, other)| width(&sweep) > width(other) + 0.5)
        {
            best = Some((candidate, sweep));
        }
    }
    Some(vec![(level, short), best?])
}

fn next_longer<'a>(group: &[&'a Candidate], bar_mm: f64) -> Vec<&'a Candidate> {
    let next = group.iter().map(|c| c.bar_mm).filter(|&bar| bar > bar_mm + 1.0).fold(f64::MAX, f64::min);
    group.iter().filter(|candidate| (candidate.bar_mm - next).abs() < 1e-6).copied().collect()
}

fn width(sweep: &ClearArc) -> f64 {
    sweep.to_deg - sweep.from_deg
}

/// Sum of the sweeps: what a method's setups are ranked by.
fn total(pair: &Pair) -> f64 {
    pair.iter().map(|(_, sweep)| width(sweep)).sum()
}

fn two_lengths<'a>(desk: &mut Desk<'a>, axis: usize) -> Option<Pair<'a>> {
    let groups = groups(desk, axis);
    let mut level: Vec<_> = groups
        .values()
        .filter_map(|group| {
            let bar = group.iter().filter(|c| c.solved.h_mm.abs() < LEVEL_MM).map(|c| c.bar_mm).next()?;
            let moved: f64 = group.iter().map(|c| travel(desk, c)).fold(f64::MAX, f64::min);
            Some((bar, group.first()?.place, moved, group))
        })
        .collect();
    // the ball as near the nose as works: a longer stem is only for where nothing else does
    level.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.total_cmp(&b.2)));
    best_of(desk, level.into_iter().map(|(.., group)| group.clone()))
}

fn best_of<'a>(desk: &mut Desk<'a>, groups: impl Iterator<Item = Vec<&'a Candidate>>) -> Option<Pair<'a>> {
    let mut best: Option<Pair> = None;
    for (looked, group) in groups.enumerate() {
        // more than enough once something is found; without it, go on through everything
        let place = group.first().map(|candidate| candidate.place);
        let settled = best.as_ref().is_some_and(|pair| pair.first().map(|(c, _)| c.place) != place);
        if settled || looked >= GROUPS && best.is_some() {
            break;
        }
        if let Some(pair) = lengths_in(desk, &group)
            && best.as_ref().is_none_or(|other| total(&pair) > total(other) + 0.5)
        {
            best = Some(pair);
        }
    }
    best
}

/// How far the linear axes stand from zero, mm: setups near zero feel their errors least.
fn travel(desk: &Desk, candidate: &Candidate) -> f64 {
    (0..desk.machine.axes.len())
        .filter(|&k| desk.machine.axes[k].kind == AxisKind::Linear)
        .map(|k| candidate.solved.positions[k].powi(2))
        .sum::<f64>()
        .sqrt()
}

/// One pivot with both bars for every axis, the other rotary axes at zero.
fn one_pivot<'a>(desk: &mut Desk<'a>, axes: &[usize]) -> Option<Pair<'a>> {
    let by_axis: Vec<_> = axes.iter().map(|&axis| groups(desk, axis)).collect();
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
        group.iter().map(|c| (travel(desk, c) * 1e3) as i64).min().unwrap_or(i64::MAX)
    };
    let mut ranked: Vec<_> =
        keys.drain(..).filter_map(|key| bar(&key).map(|bars| (bars, key.1, moved(&key), key))).collect();
    ranked.sort();
    let mut best: Option<Pair> = None;
    for (looked, (_, place, _, key)) in ranked.iter().enumerate() {
        let settled = best.as_ref().is_some_and(|pair| pair.first().is_some_and(|(c, _)| c.place != *place));
        if settled || looked >= GROUPS && best.is_some() {
            break;
        }
        let pairs: Option<Vec<Pair>> = by_axis.iter().map(|groups| lengths_in(desk, groups.get(key)?)).collect();
        if let Some(pairs) = pairs {
            let all: Pair = pairs.into_iter().flatten().collect();
            if best.as_ref().is_none_or(|other| total(&all) > total(other) + 0.5) {
                best = Some(all);
            }
        }
    }
    best
}

/// Tests of one place along an axis that are paired with those of other places: the ones that tell most alone.
const BEST_OF_PLACE: usize = 3;

/// The short bar at h = 0 at two places along the axis: the pair that together tells most of the axis's errors. The spindle
/// ball stays where it is unless only another stem or arm brings the second place.
fn two_places<'a>(desk: &mut Desk<'a>, axis: usize) -> Option<Pair<'a>> {
    let list: &'a [Candidate] = &desk.all.list;
    let level = || list.iter().filter(|c| c.axis == axis && c.is_plain() && c.solved.h_mm.abs() < LEVEL_MM);
    let bar = level().map(|c| c.bar_mm).fold(f64::MAX, f64::min);
    let short: Vec<&Candidate> = level().filter(|c| (c.bar_mm - bar).abs() < 1e-6).collect();
    let nearest = short.iter().map(|c| c.place).min()?;
    let unmoved: Vec<&Candidate> = short.iter().copied().filter(|c| c.place == nearest).collect();
    most_telling_pair(desk, axis, &unmoved).or_else(|| most_telling_pair(desk, axis, &short))
}

/// Of clear tests at two places the pair that leaves the least Σ ln σ² of the axis's errors, pivots and bars unknown.
fn most_telling_pair<'a>(desk: &mut Desk<'a>, axis: usize, level: &[&'a Candidate]) -> Option<Pair<'a>> {
    let mut by_along: BTreeMap<i64, Vec<&Candidate>> = BTreeMap::new();
    for candidate in level {
        by_along.entry((candidate.solved.along_mm * 10.0).round() as i64).or_default().push(candidate);
    }
    let before = Knowledge::before_with_loose_setups(&desk.unknowns);
    let mine: Vec<usize> = (0..desk.unknowns.wanted).filter(|&k| desk.unknowns.errors[k].0 == axis).collect();
    let unknown = |variances: &[f64]| mine.iter().map(|&k| variances[k].ln()).sum::<f64>();
    let mut clear: Vec<Entry> = Vec::new();
    for candidates in by_along.values_mut() {
        candidates.sort_by(|a, b| a.place.cmp(&b.place).then(travel(desk, a).total_cmp(&travel(desk, b))));
        let mut here: Vec<(f64, Entry)> = Vec::new();
        for candidate in candidates.iter().take(GROUPS) {
            if let Some(sweep) = desk.clear(candidate) {
                let entry = desk.entry(candidate, Some(sweep));
                here.push((unknown(&before.variances_with(&entry.block)), entry));
            }
        }
        here.sort_by(|a, b| a.0.total_cmp(&b.0));
        clear.extend(here.into_iter().take(BEST_OF_PLACE).map(|(_, entry)| entry));
    }
    let mut best: Option<(f64, usize, usize)> = None;
    for (first, low) in clear.iter().enumerate() {
        let mut knowledge = before.clone();
        knowledge.add(&low.block);
        for (second, high) in clear.iter().enumerate().skip(first + 1) {
            if high.candidate.solved.along_mm - low.candidate.solved.along_mm <= APART_MM {
                continue;
            }
            let left = unknown(&knowledge.variances_with(&high.block));
            if best.is_none_or(|(least, ..)| left < least - 1e-9) {
                best = Some((left, first, second));
            }
        }
    }
    let (_, low, high) = best?;
    [low, high].into_iter().map(|k| Some((clear[k].candidate, clear[k].sweep.clone()?))).collect()
}
