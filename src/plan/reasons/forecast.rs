//! What a set of tests determines, how well, and in words what it does not and why. It chooses nothing.

use std::collections::HashSet;

use super::no_length::no_length_tells;
use super::untested::untested;
use crate::machine::AxisKind;
use crate::plan::context::choice::Entry;
use crate::plan::context::evaluation::Evaluation;
use crate::plan::information::block::{Block, HELD, LOOSE, Nuisance};
use crate::plan::information::fitted::{HALF, fitted};
use crate::plan::information::posterior::Posterior;

/// Forecast for one location error.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorForecast {
    pub name: String,
    pub is_angle: bool,
    /// The data fix it, given the spindle balls: less than half of its variance stems from priors. The same as a fit's.
    pub determined: bool,
    /// Lengths of reachable setups would fix it if nothing stood in their way: what is not visible, no ball bar determines.
    pub visible: bool,
    /// Standard deviation with all priors, mm or rad.
    pub sigma: f64,
    /// The same with the spindle ball's place taken as given.
    pub sigma_relative: f64,
    /// Share of the priors in its variance, given the spindle balls: below a half it is determined.
    pub prior_share: f64,
    /// What the linear axes get wrong keeps it above its goal.
    pub by_linear_axes: bool,
    /// Why not, or relative to what.
    pub reason: String,
}

/// Correlation from which two errors are named together.
const TOGETHER: f64 = 0.9;

/// Forecast of all wanted errors for a set of tests.
pub(crate) fn forecasts(evaluation: &Evaluation, entries: &[&Entry]) -> Vec<ErrorForecast> {
    let unknowns = &evaluation.context.unknowns;
    let blocks: Vec<&Block> = entries.iter().map(|entry| &*entry.block).collect();
    let after = |mut posterior: Posterior, change: &dyn Fn(&Block) -> Block| {
        blocks.iter().for_each(|block| posterior.add(&change(block)));
        posterior
    };
    let before = || Posterior::before(unknowns);
    let is_pivot = |nuisance: &Nuisance| matches!(nuisance, Nuisance::Pivot(..));
    let is_spindle = |nuisance: &Nuisance| matches!(nuisance, Nuisance::SpindleBall(_));
    let is_given =
        |nuisance: &Nuisance| matches!(nuisance, Nuisance::SpindleBall(_) | Nuisance::Stand(_) | Nuisance::Scale(_));
    let plain = after(before(), &|block| block.clone());
    let loose_pivot = after(before(), &|block| block.with_prior_scaled(is_pivot, LOOSE));
    let given_spindle = after(before(), &|block| block.with_prior_scaled(is_spindle, HELD));
    // with circles the squareness is wanted itself and no floor
    let square = unknowns.with_exact_linear_axes();
    let given_square = after(Posterior::before(&square), &|block| block.with_prior_scaled(is_spindle, HELD));
    let given_slides = after(Posterior::before(&square), &|block| block.with_prior_scaled(is_given, HELD));
    let fitted = fitted(&evaluation.context.unknowns, &blocks);
    let tested: HashSet<usize> =
        entries.iter().filter(|entry| !entry.candidate.is_circle()).map(|entry| entry.candidate.axis).collect();
    (0..unknowns.wanted)
        .map(|k| {
            let (_, component, name) = &unknowns.errors[k];
            let sigma = plain.covariance(k, k).sqrt();
            let sigma_relative = given_spindle.covariance(k, k).sqrt();
            let determined = fitted[k].is_determined();
            let missed = determined && sigma_relative > evaluation.goals[k] * 1.001;
            let [by_square, by_slides] = [&given_square, &given_slides]
                .map(|given| given.covariance(k, k) < LIMITS_BELOW * given_spindle.covariance(k, k));
            let mut words = Vec::new();
            if !determined {
                // without the pivots' spread nothing would be left of what was known before
                let by_pivot = plain.covariance(k, k) < HALF * unknowns.prior(k).powi(2);
                words.push(reason(evaluation, &loose_pivot, k, &tested, by_pivot));
            }
            if missed {
                words.extend(missed_goal(evaluation, k, by_square, by_slides));
            }
            if determined && sigma_relative < 0.7 * sigma {
                words.push(if evaluation.is_indexed {
                    "relative to the spindle ball's place along the spindle: no index shows it; measure the gauge length"
                        .to_string()
                } else {
                    "relative to the spindle ball, whose own placement is the floor of absolute positions".to_string()
                });
            }
            ErrorForecast {
                name: name.to_string(),
                is_angle: *component >= 3,
                determined,
                visible: determined || evaluation.observability[k].is_seen,
                sigma,
                sigma_relative,
                prior_share: fitted[k].prior_share,
                by_linear_axes: missed && by_slides,
                reason: words.join("; "),
            }
        })
        .collect()
}

/// Share of a variance left with a cause taken away below which that cause is named.
const LIMITS_BELOW: f64 = 0.7;

/// What keeps a determined error above its goal.
fn missed_goal(evaluation: &Evaluation, k: usize, by_square: bool, by_slides: bool) -> Option<String> {
    let of = evaluation.context.unknowns.linear_axes();
    if evaluation.untimed.as_ref().is_some_and(|untimed| untimed.reaches[k]) {
        return out_of_time(evaluation);
    }
    match (by_square, by_slides) {
        (true, _) => {
            Some(format!("above the goal: the linear axes may be {:.0} urad out of square", of.squareness_rad * 1e6))
        }
        (false, true) => Some(format!(
            "above the goal: the linear axes may stand {:.0} um per metre from where they are told to",
            of.positioning.max(of.straightness) * 1e6
        )),
        (false, false) if evaluation.context.settings.method.is_some() => Some(
            "above the goal: what noise and setups leave in the tests of this --method; a plan without it may tell more"
                .into(),
        ),
        (false, false) => {
            Some("above the goal: what noise and setups leave, and no further test that was tried pays".into())
        }
    }
}

/// What the time allowed leaves out, and the time that the plan found for the whole goal takes, which is no least one.
fn out_of_time(evaluation: &Evaluation) -> Option<String> {
    let (allowed, untimed) = (evaluation.context.settings.goal.minutes?, evaluation.untimed.as_ref()?);
    Some(format!(
        "not within {allowed} minutes: the shortest plan found for the whole goal has it and takes {:.1} (--minutes {:.0}); shorter ones may exist",
        untimed.minutes,
        untimed.minutes.ceil()
    ))
}

/// Why an error stays undetermined.
fn reason(evaluation: &Evaluation, plain: &Posterior, k: usize, tested: &HashSet<usize>, by_pivot: bool) -> String {
    let unknowns = &evaluation.context.unknowns;
    let axis = unknowns.errors[k].0;
    let name = &evaluation.context.machine.axes[axis].name;
    if evaluation.untimed.as_ref().is_some_and(|untimed| untimed.determined[k])
        && let Some(why) = out_of_time(evaluation)
    {
        return why;
    }
    if let Some(why) = evaluation.untimed.as_ref().and_then(|untimed| untimed.reasons[k].clone()) {
        return why;
    }
    if evaluation.context.machine.axes[axis].kind == AxisKind::Linear {
        return format!(
            "no circle or other test that is chosen tells how square {name} is, and no further one that was tried pays"
        );
    }
    if let Some(why) = no_length_tells(evaluation, k) {
        return why;
    }
    if !tested.contains(&axis)
        && let Some(why) = untested(evaluation, axis)
    {
        return why;
    }
    if let Some(why) = by_method(evaluation, k) {
        return why;
    }
    let partners: Vec<usize> = (0..unknowns.wanted)
        .filter(|&other| other != k)
        .filter(|&other| {
            let r = plain.covariance(k, other) / (plain.covariance(k, k) * plain.covariance(other, other)).sqrt();
            r.abs() > TOGETHER
        })
        .collect();
    if !partners.is_empty() && !tested.is_empty() {
        let names: Vec<String> = partners.iter().map(|&other| unknowns.errors[other].2.to_string()).collect();
        let untested = partners.iter().map(|&other| unknowns.errors[other].0).find_map(|other| {
            let is_rotary = evaluation.context.machine.axes[other].kind == AxisKind::Rotary;
            if is_rotary && !tested.contains(&other) { untested(evaluation, other) } else { None }
        });
        return match untested {
            Some(why) => format!("only together with {}: {why}", names.join(", ")),
            None => told_together(&names, by_pivot),
        };
    }
    if by_pivot {
        return "the chosen tests tell it only through how well the pivot's place is known, and no further test that was tried pays"
            .into();
    }
    let rotary = evaluation.context.machine.axes_of(AxisKind::Rotary);
    let other =
        rotary.filter(|other| *other != axis && !tested.contains(other)).find_map(|other| untested(evaluation, other));
    match (untested(evaluation, axis), other) {
        (Some(why), _) => why,
        (None, Some(why)) => format!("tests of axis {name} alone do not tell it, and {why}"),
        (None, None) if !tested.contains(&axis) => {
            format!(
                "no test of axis {name} is chosen: none of its setups that were tried pays within what the plan may take"
            )
        }
        (None, None) => format!("no chosen test of axis {name} tells it, and no further one that was tried pays"),
    }
}

/// Errors that the chosen tests show in one sum only, which other tests might part.
fn told_together(names: &[String], by_pivot: bool) -> String {
    let shared = if by_pivot { " and the pivot's place" } else { "" };
    format!(
        "the chosen tests tell it only together with {}{shared}, and no further test that was tried parts them at a price that pays",
        names.join(", ")
    )
}

/// The method asked for, and no property of the machine, leaves an error out that lengths show.
fn by_method(evaluation: &Evaluation, k: usize) -> Option<String> {
    let by_method = evaluation.observability[k].is_seen && evaluation.context.settings.method.is_some();
    by_method.then(|| {
        "the tests of this --method do not show it; lengths of other reachable setups would, clear or not: plan without --method"
            .into()
    })
}
