//! When the evidence demands an effect, beside none and beside others. It compares no candidates.

use super::limits::Limits;
use super::selected::{Candidate, SelectedEffect};
use crate::diagnose::model::linear_model::LinearModel;
use crate::diagnose::noise::noise_floor::mean_noise_mm2;
use crate::effects::{Signature, is_a};
use crate::identify::Quantity;
use crate::statistics::NoiseModel;

/// Share of the mean square that all effects found before explain which a further one at the same place must explain.
const LEAST_SHARE: f64 = 0.002;

/// Rms that the first effect must take off the residual, in noise floors.
const LEAST_RMS: f64 = 0.18;

/// The same for an event: somewhere in a session noise looks like a jump.
const LEAST_EVENT_RMS: f64 = 0.25;

/// Log odds from which it is enough to show within sweeps; stray readings in a row may look like jumps.
const BEYOND_DOUBT: f64 = 150.0;

/// Fall of the misfit of what was stated of balls, bars and location errors, without the one that falls most, with which
/// nothing need show in the residual.
const RELIEF: f64 = 22.0;

/// Whether an effect brings several balls or bars back to where they were stated to be; an event, which is a ball's own,
/// does not.
pub(crate) fn relieves(chosen: &Candidate, shared_relief: f64) -> bool {
    !chosen.is_event() && shared_relief > RELIEF
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
    let noise_mm2 = mean_noise_mm2(floor);
    let in_noise = |fall_mm2: f64, share: f64| fall_mm2 > share * share * noise_mm2;
    let is_event = chosen.is_event();
    if found.is_empty() {
        let (odds, rms) = match is_event {
            true => (limits.accept_event, LEAST_EVENT_RMS),
            false => (limits.accept, LEAST_RMS),
        };
        // beside slow growth that still counts as noise a true effect may take nothing off the mean square
        let shows_within = !is_event && log_odds > BEYOND_DOUBT && in_noise(fall_within_mm2(), rms);
        return log_odds > odds && (in_noise(fall_mm2, rms) || shows_within || relieves(chosen, relief));
    }
    let explained: f64 = found.iter().map(|found| found.fall_mm2.max(0.0)).sum();
    let there: Vec<&SelectedEffect> =
        found.iter().filter(|other| other.chosen.effect.place == chosen.effect.place).collect();
    let same_place = !there.is_empty();
    let same_kind = there.iter().any(|other| other.chosen.effect.kind == chosen.effect.kind);
    let is_sure_rest = same_kind && !is_event && log_odds > limits.sure_rest;
    let odds = if same_place { limits.accept } else { limits.accept_further };
    log_odds > if is_event { odds.max(limits.accept_event) } else { odds }
        && (adds_enough(limits, same_place, fall_mm2, explained, noise_mm2) || relieves(chosen, relief) || is_sure_rest)
}

/// Whether an effect takes enough off the mean square beside what the others explain.
pub(crate) fn adds_enough(
    limits: &Limits,
    same_place: bool,
    fall_mm2: f64,
    explained_mm2: f64,
    noise_mm2: f64,
) -> bool {
    match same_place {
        true => fall_mm2 > LEAST_SHARE * explained_mm2,
        false => {
            fall_mm2 > limits.share_elsewhere * explained_mm2 && fall_mm2 > limits.rms_elsewhere.powi(2) * noise_mm2
        }
    }
}

/// Growth of the bar below its own uncertainty: a gauge's zero may wander as far in a session.
pub(crate) fn is_below_the_bar(model: &LinearModel, chosen: &Candidate) -> bool {
    if !is_a(&chosen.effect.kind, Signature::BarLength) || chosen.effect.parameter("bar").is_some() {
        return false;
    }
    let uncertain_mm = model
        .problem
        .unknowns
        .iter()
        .filter(|unknown| matches!(unknown.quantity, Quantity::Bar { .. }))
        // a zero that was set by hand does not make a gauge worse
        .map(|unknown| unknown.prior_sigma.min(model.problem.session.spread.bar_length_mm))
        .fold(0.0, f64::max);
    let mut ends = (f64::MAX, f64::MIN);
    for test in 0..model.tests() {
        for row in (0..model.kept[test].len()).filter(|&row| model.kept[test][row]) {
            let columns = chosen.columns.iter().zip(&chosen.judgement.amplitudes);
            let grown: f64 =
                columns.map(|(column, size)| size * column.by_test[test].get(row).copied().unwrap_or(0.0)).sum();
            ends = (ends.0.min(grown), ends.1.max(grown));
        }
    }
    ends.1 - ends.0 < uncertain_mm
}
