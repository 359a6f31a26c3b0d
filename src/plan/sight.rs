//! What lengths of reachable setups can show at all, whatever stands in their way and however long it takes. It chooses nothing.

use super::choose::Desk;
use super::knowledge::Knowledge;
use super::words::HALF;
use crate::machine::AxisKind;

/// What lengths show of one wanted error.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sight {
    /// Reachable setups, clear or not, would fix it with pivots and bars unknown.
    pub is_seen: bool,
    /// Unseen errors that lengths show in one sum with it.
    partners: Vec<usize>,
    /// Lengths would fix it if places of pivots were known to be where they are told to.
    by_pivot: bool,
}

/// Setups of each axis that stand for all when it is asked what lengths can show.
const SAMPLE: usize = 16;
/// Setups in which errors that the sample does not show are looked for.
const LOOKED_AT: usize = 12_000;
/// Correlation from which two errors that no length shows are named together: three that share a sum have about a half.
const TOGETHER: f64 = 0.4;

/// What reachable setups show of each wanted error.
pub(super) fn sights(desk: &Desk) -> Vec<Sight> {
    let unknowns = desk.unknowns.with_exact_linear_axes();
    let mut loose = Knowledge::before_with_loose_setups(&unknowns);
    let mut known = Knowledge::before(&unknowns);
    for axis in 0..desk.machine.axes.len() {
        let mine: Vec<_> = desk.all.list.iter().filter(|candidate| candidate.axis == axis).collect();
        let step = mine.len().div_ceil(SAMPLE).max(1);
        for candidate in mine.iter().step_by(step) {
            let block = desk.entry(candidate, None).block;
            loose.add(&block);
            known.add(&block);
        }
    }
    // what the sample does not show, some other setup may
    for candidate in desk.all.list.iter().step_by(desk.all.list.len().div_ceil(LOOKED_AT).max(1)) {
        let is_unseen = |k: &usize| loose.prior_share(*k) >= HALF;
        let unseen: Vec<usize> = (0..unknowns.wanted).filter(is_unseen).collect();
        if unseen.is_empty() {
            break;
        }
        let block = desk.entry(candidate, None).block;
        let with = loose.variances_with(&block);
        if unseen.iter().any(|&k| with[k] < HALF * loose.covariance(k, k)) {
            loose.add(&block);
            known.add(&block);
        }
    }
    let is_seen: Vec<bool> = (0..unknowns.wanted).map(|k| loose.prior_share(k) < HALF).collect();
    let correlation = |k: usize, other: usize| {
        loose.covariance(k, other) / (loose.covariance(k, k) * loose.covariance(other, other)).sqrt()
    };
    (0..unknowns.wanted)
        .map(|k| Sight {
            is_seen: is_seen[k],
            partners: (0..unknowns.wanted)
                .filter(|&other| other != k && !is_seen[k] && !is_seen[other])
                .filter(|&other| correlation(k, other).abs() > TOGETHER)
                .collect(),
            by_pivot: known.covariance(k, k) < HALF * unknowns.prior(k).powi(2),
        })
        .collect()
}

/// Why no length tells an error, where that is so: each rotary axis has setups within its reach and none of them shows it.
pub(super) fn no_length_tells(desk: &Desk, k: usize) -> Option<String> {
    let has_setups = |axis: usize| desk.all.list.iter().any(|candidate| candidate.axis == axis);
    let mut rotary = (0..desk.machine.axes.len()).filter(|&k| desk.machine.axes[k].kind == AxisKind::Rotary);
    let sight = &desk.sights[k];
    if sight.is_seen || !rotary.all(has_setups) {
        return None;
    }
    let names: Vec<String> = sight.partners.iter().map(|&other| desk.unknowns.errors[other].2.to_string()).collect();
    Some(match (names.is_empty(), sight.by_pivot) {
        (false, by_pivot) => only_together(&names, by_pivot),
        (true, true) => ONLY_BY_PIVOT.into(),
        (true, false) => {
            "no ball-bar length tells it, whichever setups are chosen: what moves both balls alike changes none".into()
        }
    })
}

/// Errors that lengths show in one sum only.
fn only_together(names: &[String], by_pivot: bool) -> String {
    let shared = if by_pivot { " and the pivot's place" } else { "" };
    format!("only together with {}{shared}: what moves both alike changes no ball-bar length", names.join(", "))
}

/// An error that stands for the pivot's own place.
const ONLY_BY_PIVOT: &str =
    "only through how well the pivot's place is known: what moves the whole branch changes no ball-bar length";
