//! Which accepted effects belong to one finding. It words nothing.

use crate::diagnose::noise::spectrum::shown_at;
use crate::diagnose::selection::naming::{candidate_driver, driver_class};
use crate::diagnose::selection::selected::{Search, SelectedEffect};
use crate::effects::{Driver, Signature, is_a};

/// Accepted effects by finding: those of one place and like drivers, and the rest of a form with the form.
///
/// `rates_hz` are those of the tests: what one frequency shows at each of them is one vibration.
pub(crate) fn groups(search: &Search, rates_hz: &[f64], rest_of_form: f64) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (index, found) in search.found.iter().enumerate() {
        let joins = |group: &Vec<usize>| belongs(&search.found[group[0]], found, rates_hz, rest_of_form);
        match groups.iter_mut().find(|group| joins(group)) {
            Some(group) => group.push(index),
            None => groups.push(vec![index]),
        }
    }
    groups.iter_mut().for_each(|group| strongest_leads(search, group));
    groups.iter_mut().for_each(|group| every_direction_leads(search, group));
    join_rests(search, &mut groups, rest_of_form);
    groups
}

/// Whether an effect belongs to what an effect taken before it tells.
fn belongs(lead: &SelectedEffect, found: &SelectedEffect, rates_hz: &[f64], rest_of_form: f64) -> bool {
    let same_place = lead.chosen.effect.place == found.chosen.effect.place
        && lead.chosen.effect.parameter("of") == found.chosen.effect.parameter("of");
    let same_kind = lead.chosen.effect.kind == found.chosen.effect.kind;
    let alike = driver_class(candidate_driver(&lead.chosen)) == driver_class(candidate_driver(&found.chosen));
    let same_cause = same_kind && !found.chosen.is_event();
    // another way to draw the curve of a place names no second cause, whichever was taken first
    let moves =
        |found: &SelectedEffect| matches!(candidate_driver(&found.chosen), Driver::Position | Driver::Direction);
    let is_drawn_on = lead.chosen.is_free() && moves(lead) && moves(found);
    let is_rest = found.chosen.is_free() || (alike && found.gain < rest_of_form * lead.gain) || is_drawn_on;
    same_place && !are_two_jumps(lead, found) && (same_cause || is_rest) || is_same_line(lead, found, rates_hz)
}

/// Jumps further apart in time are two, s; a jump that creeps may be told in two steps.
pub const ONE_JUMP_S: f64 = 30.0;

fn are_two_jumps(one: &SelectedEffect, other: &SelectedEffect) -> bool {
    match (one.chosen.effect.number("time"), other.chosen.effect.number("time")) {
        (Some(first), Some(second)) => (first - second).abs() > ONE_JUMP_S,
        _ => false,
    }
}

/// A named part that adds so many times what the first one does, beside all others, speaks for the whole.
const SPEAKS_FOR_ALL: f64 = 2.0;

/// Puts the part first that adds most: a search may have taken a rest of the form before the form.
fn strongest_leads(search: &Search, group: &mut [usize]) {
    let adds = |index: usize| search.found[index].beside_gain;
    let is_free = |index: usize| search.found[index].chosen.is_free();
    let named = (0..group.len()).filter(|&place| !is_free(group[place]));
    let Some(strongest) = named.max_by(|&a, &b| adds(group[a]).total_cmp(&adds(group[b]))) else { return };
    let ahead = if is_free(group[0]) { 1.0 } else { SPEAKS_FOR_ALL };
    if adds(group[strongest]) > ahead * adds(group[0]) {
        group[..=strongest].rotate_right(1);
    }
}

/// Puts a vibration in several directions before one in a single direction that cannot stand for what other tests show.
fn every_direction_leads(search: &Search, group: &mut [usize]) {
    let candidate = |index: usize| &search.found[index].chosen;
    let is_vibration = |index: usize| is_a(&candidate(index).effect.kind, Signature::Oscillation);
    let directions = |index: usize| crate::diagnose::selection::ranking::directions(&candidate(index).terms);
    if !is_vibration(group[0]) || directions(group[0]) > 1 {
        return;
    }
    let is_wider = |&place: &usize| {
        is_vibration(group[place])
            && directions(group[place]) > 1
            && super::vibration_size::moves_elsewhere(candidate(group[place]), candidate(group[0]), &search.noise_after)
    };
    if let Some(place) = (1..group.len()).find(is_wider) {
        group[..=place].rotate_right(1);
    }
}

/// Share of the stronger one's gain below which a named effect is the rest of its form: weight and position of one
/// joint say the same in other forms.
fn rest_share(own: &SelectedEffect, stronger: &SelectedEffect, rest_of_form: f64) -> f64 {
    let weighs = |found: &SelectedEffect| candidate_driver(&found.chosen) == Driver::Gravity;
    if weighs(own) != weighs(stronger) { 1.0 } else { rest_of_form }
}

/// Joins named effects of one place and kind of driver where one adds little beside the other, whichever was taken first.
fn join_rests(search: &Search, groups: &mut Vec<Vec<usize>>, rest_of_form: f64) {
    let lead = |group: &[usize]| &search.found[group[0]];
    groups.sort_by(|a, b| lead(b).beside_gain.total_cmp(&lead(a).beside_gain));
    let mut kept: Vec<Vec<usize>> = Vec::new();
    for group in groups.drain(..) {
        let own = lead(&group);
        let is_rest = |other: &&mut Vec<usize>| {
            let stronger = lead(other);
            own.chosen.effect.place == stronger.chosen.effect.place
                && !own.chosen.is_free()
                && !stronger.chosen.is_free()
                && driver_class(candidate_driver(&own.chosen)) == driver_class(candidate_driver(&stronger.chosen))
                && !own.chosen.is_event()
                && own.beside_gain < rest_share(own, stronger, rest_of_form) * stronger.beside_gain
        };
        match kept.iter_mut().find(is_rest) {
            Some(stronger) => stronger.extend(group),
            None => kept.push(group),
        }
    }
    *groups = kept;
}

/// Frequencies nearer than this, as a share of them, are one vibration.
const ONE_LINE: f64 = 0.03;

/// Frequencies nearer than this are, where the second one gains less than this share of the first: what shakes a resonance by
/// chance has no line but a band.
const ONE_BAND: f64 = 0.1;
const SIDE_OF_A_BAND: f64 = 0.3;

/// Vibrations of one frequency or band, or of what most rates show of it, are one that wanders, wherever the rest of it seems to act.
fn is_same_line(lead: &SelectedEffect, found: &SelectedEffect, rates_hz: &[f64]) -> bool {
    let frequency = |found: &SelectedEffect| {
        found.chosen.effect.number("frequency").filter(|_| is_a(&found.chosen.effect.kind, Signature::Oscillation))
    };
    match (frequency(lead), frequency(found)) {
        (Some(one), Some(other)) => {
            let is_near = |one: f64, other: f64| (one - other).abs() < ONE_LINE * one;
            let alike = rates_hz.iter().filter(|&&rate| is_near(shown_at(rate, one), shown_at(rate, other))).count();
            let is_side = (one - other).abs() < ONE_BAND * one && found.gain < SIDE_OF_A_BAND * lead.gain;
            is_near(one, other) || is_side || 2 * alike > rates_hz.len()
        }
        _ => false,
    }
}
