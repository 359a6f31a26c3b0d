//! When the evidence demands an effect, beside none and beside others. It compares no candidates.

use super::limits::Limits;
use super::selected::{Candidate, SelectedEffect};
use crate::diagnose::noise::noise_floor::mean_noise_mm2;
use crate::diagnose::thresholds::Thresholds;
use crate::statistics::NoiseModel;

/// Whether an effect brings several balls or bars back to where they were stated to be; an event, which is a ball's own,
/// does not.
pub(crate) fn relieves(thresholds: &Thresholds, chosen: &Candidate, shared_relief: f64) -> bool {
    !chosen.is_event() && shared_relief > thresholds.relief
}

/// Whether the evidence demands a candidate beside what was found: by what it takes off the mean square, mm², by its log
/// odds, by how far it brings balls and bars back, and, where these leave it open, off the mean square within sweeps.
pub(crate) fn is_demanded(
    limits: &Limits,
    found: &[SelectedEffect],
    chosen: &Candidate,
    (fall_mm2, log_odds, relief): (f64, f64, f64),
    fall_within_mm2: impl FnOnce() -> f64,
    floor: &[NoiseModel],
) -> bool {
    let thresholds = &limits.thresholds;
    let noise_mm2 = mean_noise_mm2(floor);
    let in_noise = |fall_mm2: f64, share: f64| fall_mm2 > share * share * noise_mm2;
    let is_event = chosen.is_event();
    if found.is_empty() {
        let (odds, rms) = match (is_event, chosen.is_free()) {
            (true, _) => (limits.accept_event, thresholds.rms_further),
            (false, true) => (limits.accept, thresholds.rms_first),
            (false, false) => (limits.accept_form, thresholds.rms_first),
        };
        // beside slow growth that still counts as noise a true effect may take nothing off the mean square
        let shows_within = !is_event && log_odds > thresholds.beyond_doubt && in_noise(fall_within_mm2(), rms);
        return log_odds > odds && (in_noise(fall_mm2, rms) || shows_within || relieves(thresholds, chosen, relief));
    }
    let explained: f64 = found.iter().map(|found| found.fall_mm2.max(0.0)).sum();
    let there: Vec<&SelectedEffect> =
        found.iter().filter(|other| other.chosen.effect.place == chosen.effect.place).collect();
    let same_place = !there.is_empty();
    let same_kind = there.iter().any(|other| other.chosen.effect.kind == chosen.effect.kind);
    let is_sure_rest = same_kind && !is_event && log_odds > limits.sure_rest;
    let odds = if same_place { limits.accept } else { limits.accept_further };
    log_odds > if is_event { odds.max(limits.accept_event) } else { odds }
        && (adds_enough(thresholds, same_place, fall_mm2, explained, noise_mm2)
            || relieves(thresholds, chosen, relief)
            || is_sure_rest)
}

/// Whether an effect takes enough off the mean square beside what the others explain.
pub(crate) fn adds_enough(
    thresholds: &Thresholds,
    same_place: bool,
    fall_mm2: f64,
    explained_mm2: f64,
    noise_mm2: f64,
) -> bool {
    match same_place {
        true => fall_mm2 > thresholds.inexact * explained_mm2,
        false => {
            fall_mm2 > thresholds.share_elsewhere * explained_mm2
                && fall_mm2 > thresholds.rms_further.powi(2) * noise_mm2
        }
    }
}
