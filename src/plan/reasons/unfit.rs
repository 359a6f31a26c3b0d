//! Why a method of the thesis does not fit a machine: which bar is missing, which limit or pair is in the way. It chooses nothing.

use std::collections::BTreeSet;

use super::untested::{most_in_the_way, untested};
use crate::plan::context::evaluation::Evaluation;
use crate::plan::context::method::{APART_MM, LEVEL_MM};
use crate::plan::places::candidate::Candidate;

/// Why an axis has no pair of a short bar at h = 0 and the next longer one.
pub(crate) fn no_lengths(evaluation: &Evaluation, axis: usize) -> String {
    lengths(evaluation, axis).unwrap_or_else(|| {
        let name = &evaluation.context.machine.axes[axis].name;
        let bars =
            level_bars(evaluation, axis).first().map(|short| bar_and_next(evaluation, *short)).unwrap_or_default();
        format!(
            "axis {name} has no pair of tests{bars} that is clear by {} mm from the places tried{}",
            evaluation.context.settings.margin_mm,
            pairs(evaluation, axis)
        )
    })
}

/// Why no single pivot serves all axes.
pub(crate) fn no_pivot_for_all(evaluation: &Evaluation, axes: &[usize]) -> String {
    if let Some(why) = axes.iter().find_map(|&axis| lengths(evaluation, axis)) {
        return why;
    }
    let at_level =
        |axis: usize| -> BTreeSet<(usize, usize)> { level(evaluation, axis).map(|c| (c.site, c.place)).collect() };
    let common = axes.iter().map(|&axis| at_level(axis)).reduce(|all, mine| &all & &mine).unwrap_or_default();
    if common.is_empty() {
        let names: Vec<&str> = axes.iter().map(|&axis| evaluation.context.machine.axes[axis].name.as_str()).collect();
        return format!(
            "none of the {} pivot places tried, with {} places of the spindle ball, stands a bar's length from the lines of {} alike; add a mount or a stand that does; chapter4 and chapter7 use several pivots",
            evaluation.context.all.sites.len(),
            evaluation.context.all.places.len(),
            names.join(" and ")
        );
    }
    let ways: String = axes.iter().map(|&axis| pairs(evaluation, axis)).collect();
    format!(
        "none of the {} pivot places tried carries both bars for all rotary axes clear by {} mm, the others at zero{ways}; chapter4 and chapter7 use several pivots",
        evaluation.context.all.sites.len(),
        evaluation.context.settings.margin_mm
    )
}

/// Why an axis has no two places for the short bar.
pub(crate) fn no_places(evaluation: &Evaluation, axis: usize) -> String {
    let name = &evaluation.context.machine.axes[axis].name;
    let Some(&short) = level_bars(evaluation, axis).first() else { return no_level(evaluation, axis) };
    let along: Vec<f64> =
        level(evaluation, axis).filter(|c| same(c.bar_mm, short)).map(|c| c.solved.along_mm).collect();
    let (low, high) = along.iter().fold((f64::MAX, f64::MIN), |(low, high), &at| (low.min(at), high.max(at)));
    if high - low <= APART_MM {
        return format!(
            "axis {name}: the places tried for the short bar ({short} mm) lie {:.1} mm apart along it, and {APART_MM:.0} mm are needed; add a mount or a stand of another height",
            high - low
        );
    }
    format!(
        "axis {name} has no two places {APART_MM:.0} mm apart along it, of those tried, where the short bar ({short} mm) is clear by {} mm{}",
        evaluation.context.settings.margin_mm,
        pairs(evaluation, axis)
    )
}

/// Why lengths alone forbid the pair of an axis, if they do.
fn lengths(evaluation: &Evaluation, axis: usize) -> Option<String> {
    let name = &evaluation.context.machine.axes[axis].name;
    let bars = level_bars(evaluation, axis);
    let Some(&short) = bars.first() else { return Some(no_level(evaluation, axis)) };
    let kit = kit_lengths(evaluation);
    let longest = evaluation.context.kit.lengths_mm().last().copied().unwrap_or(0.0);
    if short > longest - 1.0 {
        return Some(format!(
            "axis {name} has the short bar ({short} mm), but a second bar longer than that is missing: the kit '{}' makes {kit}; add an extension",
            evaluation.context.kit.name
        ));
    }
    let has_next = level(evaluation, axis).any(|short| {
        let beside = |c: &&Candidate| (c.site, c.place) == (short.site, short.place) && c.bar_mm > short.bar_mm + 1.0;
        plain(evaluation, axis).any(|c| beside(&c))
    });
    (!has_next).then(|| {
        let limit = evaluation.context.all.misses.get(&axis).and_then(|misses| {
            let (limit, (at, beyond)) = misses.limits.iter().min_by(|a, b| a.1.1.total_cmp(&b.1.1))?;
            let name = &evaluation.context.machine.axes[*limit].name;
            Some(format!(": the nearest setup needs {name} = {at:.1} mm, {beyond:.1} mm beyond its range"))
        });
        format!(
            "axis {name}: no longer bar reaches from the places tried where the short one ({short} mm) is level{}",
            limit.unwrap_or_default()
        )
    })
}

/// Nothing stands a bar's length from the axis.
fn no_level(evaluation: &Evaluation, axis: usize) -> String {
    let name = &evaluation.context.machine.axes[axis].name;
    if plain(evaluation, axis).next().is_none()
        && let Some(why) = untested(evaluation, axis)
    {
        return why;
    }
    let lever = plain(evaluation, axis).map(|candidate| candidate.solved.rho_mm).fold(f64::MAX, f64::min);
    let most = plain(evaluation, axis).map(|candidate| candidate.solved.rho_mm).fold(0.0, f64::max);
    let slots = evaluation.context.bodies.mounts.iter().find_map(|mount| Some((&mount.name, mount.slot_pitch_mm?)));
    let slots =
        slots.map(|(mount, pitch)| format!(", and the slots of mount '{mount}' every {pitch} mm leave none there"));
    let least = if lever < f64::MAX {
        format!(" (levers of the places tried: {lever:.1} to {most:.1} mm)")
    } else {
        String::new()
    };
    format!(
        "no place tried brings a ball a bar's length from the line of axis {name}, as the short bar needs{least}: the kit '{}' makes {}{}; add a mount at that distance, or plan without --method",
        evaluation.context.kit.name,
        kit_lengths(evaluation),
        slots.unwrap_or_default()
    )
}

fn plain<'a>(evaluation: &'a Evaluation, axis: usize) -> impl Iterator<Item = &'a Candidate> {
    evaluation.context.all.list.iter().filter(move |candidate| candidate.axis == axis && candidate.is_plain())
}

/// Setups with the bar across the axis.
fn level<'a>(evaluation: &'a Evaluation, axis: usize) -> impl Iterator<Item = &'a Candidate> {
    plain(evaluation, axis).filter(|candidate| candidate.solved.h_mm.abs() < LEVEL_MM)
}

/// Bars that can be level, shortest first, mm.
fn level_bars(evaluation: &Evaluation, axis: usize) -> Vec<f64> {
    let mut bars: Vec<f64> = level(evaluation, axis).map(|candidate| candidate.bar_mm).collect();
    bars.sort_by(f64::total_cmp);
    bars.dedup();
    bars
}

fn same(one: f64, other: f64) -> bool {
    (one - other).abs() < 1e-6
}

fn bar_and_next(evaluation: &Evaluation, short: f64) -> String {
    let next = evaluation.context.kit.lengths_mm().into_iter().find(|&length| length > short + 1.0);
    next.map(|next| format!(" with {short} and {next} mm bars")).unwrap_or_default()
}

fn kit_lengths(evaluation: &Evaluation) -> String {
    let lengths: Vec<String> = evaluation.context.kit.lengths_mm().iter().map(f64::to_string).collect();
    format!("{} mm", lengths.join(", "))
}

/// The pair that stood in the way most often.
fn pairs(evaluation: &Evaluation, axis: usize) -> String {
    let name = &evaluation.context.machine.axes[axis].name;
    most_in_the_way(evaluation, axis).map(|most| format!("; of {name} {most}")).unwrap_or_default()
}
