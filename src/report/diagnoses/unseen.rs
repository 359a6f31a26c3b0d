//! What a session cannot show, grouped by the test that would show it. It computes no results.

use std::collections::BTreeMap;

use super::diagnosis::{BlindJson, DiagnosisJson};
use super::finding_words::what;
use super::quantity_words::{digits, unit};
use crate::chain::sense_in_words;
use crate::diagnose::AXIS_SENSE;
use crate::effects::{Driver, kind};
use crate::session::Session;

/// Causes that one thing to do would show.
pub struct Cure<'j> {
    /// What to do.
    pub says: String,
    /// Time on the machine, minutes, where it is known.
    pub minutes: Option<f64>,
    pub causes: Vec<&'j BlindJson>,
}

/// Kinds of cause named beside a cure.
const MOST_KINDS: usize = 4;

/// Causes by cure: looking at the axes first, since a wrong sense makes every number wrong; then what shows most.
pub fn cures<'j>(session: &Session, json: &'j DiagnosisJson) -> Vec<Cure<'j>> {
    let mut list = Vec::new();
    let (senses, others): (Vec<_>, Vec<_>) =
        json.blind_to.iter().enumerate().partition(|(_, blind)| blind.effect == AXIS_SENSE);
    if !senses.is_empty() {
        let zero = vec![0.0; session.machine.axes.len()];
        let machine = &session.machine;
        let is_open = |axis: &usize| {
            senses.iter().any(|(_, blind)| blind.components.iter().any(|name| *name == machine.axes[*axis].name))
        };
        let open = (0..machine.axes.len()).filter(is_open);
        let looks: Vec<String> = open.map(|axis| sense_in_words(machine, axis, &zero)).collect();
        list.push(Cure {
            says: format!("move each a little in + and look: {}", looks.join("; ")),
            minutes: None,
            causes: senses.into_iter().map(|(_, blind)| blind).collect(),
        });
    }
    for test in &json.uncovered_by {
        let causes = test.uncovers.iter().filter_map(|&k| json.blind_to.get(k)).collect();
        list.push(Cure { says: test.says.clone(), minutes: Some(test.minutes), causes });
    }
    let uncovered = |k: &usize| json.uncovered_by.iter().any(|test| test.uncovers.contains(k));
    let mut rest: Vec<Cure> = Vec::new();
    for (_, blind) in others.into_iter().filter(|(k, _)| !uncovered(k)) {
        match rest.iter_mut().find(|cure| cure.says == blind.test) {
            Some(cure) => cure.causes.push(blind),
            None => rest.push(Cure { says: blind.test.clone(), minutes: None, causes: vec![blind] }),
        }
    }
    let first = usize::from(list.first().is_some_and(|cure| cure.minutes.is_none()));
    list.extend(rest);
    list[first..].sort_by_key(|cure| std::cmp::Reverse(cure.causes.len()));
    list
}

/// How long a test takes.
pub fn minutes_words(minutes: f64) -> String {
    format!("{:.0} min", minutes.max(1.0).ceil())
}

/// Causes by name with their places: `thermal growth (C, A), lost motion (Y)`.
pub fn kinds_words(causes: &[&BlindJson]) -> String {
    let mut places: BTreeMap<usize, (&str, Vec<&str>)> = BTreeMap::new();
    for (k, blind) in causes.iter().enumerate() {
        let first = causes.iter().position(|other| other.effect == blind.effect).unwrap_or(k);
        let (_, of) = places.entry(first).or_insert((&blind.effect, Vec::new()));
        if !of.contains(&blind.place.as_str()) {
            of.push(&blind.place);
        }
    }
    let name = |effect: &str| if effect == AXIS_SENSE { "sense".to_string() } else { effect.replace('-', " ") };
    let named = places.values().map(|(effect, of)| format!("{} ({})", name(effect), of.join(", ")));
    let mut words = named.take(MOST_KINDS).collect::<Vec<_>>().join(", ");
    if places.len() > MOST_KINDS {
        words.push_str(&format!(" and {} more", places.len() - MOST_KINDS));
    }
    words
}

/// What is not seen, and from which size it would be.
pub fn blind_words(blind: &BlindJson) -> String {
    if blind.effect == AXIS_SENSE {
        return format!("the sense of {}: turned round it would fit as well; {}", blind.place, blind.test);
    }
    let mut name = what(&blind.effect, &blind.place, &blind.components);
    if !name.contains('(') && !blind.components.is_empty() {
        name.push_str(&format!(" ({})", blind.components.join(" ")));
    }
    match blind.smallest_visible.value {
        Some(value) => {
            // what happens once is listed by its least visible moment
            let is_event = kind(&blind.effect).is_some_and(|kind| kind.driver == Driver::Event);
            let when = if is_event { " at the moment that shows it least" } else { "" };
            format!("{name}, below {} {}{when}", digits(value, Some(0.1 * value)), unit(blind.smallest_visible.unit))
        }
        None => format!("{name}, of any size"),
    }
}
