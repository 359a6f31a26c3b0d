//! Deflection of a joint under a load that was measured: a torque or a force that stands in a column of the recordings. Loads that are only known from masses are in `gravity`.
//!
//! `E = c·τ`, τ the channel at the row, c the compliance: angle or shift per unit of the channel. What a constant load does is part of the
//! location errors.

use super::candidates::{CandidateFamily, Observations, PLAUSIBLE_OF_ARMS, directions, motion, none, with_word};
use super::context::Profile;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, Signature, Unseen, every_component, measure_per_load,
    no_check, single_function, word,
};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::machine::{AxisKind, Effect, Outlet, Place};

/// A joint that yields to a measured load.
pub static LOAD_COMPLIANCE: Kind = Kind {
    name: "load-compliance",
    driver: Driver::Load,
    formula: "E = c tau, tau the channel (its column in Nm or N)",
    size_meaning: "deflection per unit of the channel",
    cause: "the gear winds up or the bearing tilts under the load that the channel measured",
    remedy: "compensate by the measured load, or stiffen the gear",
    titles: &[("", "Compliance of joint {place} ({moving}) under a measured load")],
    measures: Some("of deflection per Nm (or N) of the channel"),
    notable: Notable { length: 0.1, angle: 0.1 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::Payload },
    unseen: Unseen::Never,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: false,
    signature: Signature::Load,
    candidates: none,
    candidates_of_poses: yields,
    documented: Documented {
        place: "rotary axis",
        components: "all",
        functions: "`c·τ`, τ the channel at the row: a load that was measured",
        parameters: "`channel` (column in Nm or N)",
        unit: "um, arcsec per Nm or N",
    },
    parameters: &[Parameter::word(
        "channel",
        &[],
        DefaultValue::Required,
        "column of the recordings that holds the load",
    )],
    check: no_check,
    outlets: |machine, place| match place {
        Place::Axis(axis) if machine.axes[axis].kind == AxisKind::Rotary => every_component(machine, axis),
        _ => Vec::new(),
    },
    measure: measure_per_load,
    functions: single_function,
    profiles,
};

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let channel = word(effect, "channel").unwrap_or_default();
    let mut profile = context.profile(|_, _| 0.0);
    for (test, values) in profile.iter_mut().enumerate() {
        let entry = &context.session().tests[test];
        let channels = entry.recording.as_ref().map(|recording| recording.channels.as_slice()).unwrap_or_default();
        let Some((_, column)) = channels.iter().find(|(name, _)| name == channel) else {
            let found: Vec<&str> = channels.iter().map(|(name, _)| name.as_str()).collect();
            return Err(EffectError::NoChannel {
                effect: effect.kind.clone(),
                test: entry.name.clone(),
                channel: channel.to_string(),
                found: if found.is_empty() { "none".into() } else { found.join(", ") },
            });
        };
        if let Some(row) = column.iter().position(|value| !value.is_finite()) {
            return Err(EffectError::NoLoad {
                effect: effect.kind.clone(),
                test: entry.name.clone(),
                channel: channel.to_string(),
                row: row + 1,
            });
        }
        values.iter_mut().zip(column).for_each(|(value, load)| *value = *load);
    }
    Ok(vec![profile])
}

/// Columns of loads, in Nm or N, that every recording has, with a load at every row.
fn loads(seen: &Observations) -> Vec<String> {
    let is_full = |name: &String| {
        let tests = seen.context.session().tests.iter();
        let mut columns = tests.filter_map(|test| {
            let recording = test.recording.as_ref()?;
            recording.channels.iter().find(|(own, _)| own == name).map(|(_, column)| column)
        });
        columns.all(|column| column.iter().all(|value| value.is_finite()))
    };
    let mut names = seen.context.common_channels(|name| name.ends_with("_Nm") || name.ends_with("_N"));
    names.retain(is_full);
    names
}

/// The number in a name: 2 of `J2` and of `tau2_Nm`.
fn number_in(name: &str) -> Option<usize> {
    let digits: String = name.chars().skip_while(|c| !c.is_ascii_digit()).take_while(char::is_ascii_digit).collect();
    digits.parse().ok()
}

/// What a joint yields to loads that were measured: about its own line, and across.
fn yields(seen: &Observations) -> Vec<CandidateFamily> {
    let machine = seen.machine();
    // a joint yields to its own torque; a channel that no joint's number claims may act anywhere
    let is_of = |channel: &str, axis: usize| {
        number_in(channel).is_some_and(|own| number_in(&machine.axes[axis].name) == Some(own))
    };
    let is_free = |channel: &str| !(0..machine.axes.len()).any(|axis| is_of(channel, axis));
    let loads = loads(seen);
    let mut list = Vec::new();
    for (axis, _) in seen.moving(AxisKind::Rotary) {
        let place = Place::Axis(axis);
        let channels = loads.iter().filter(|channel| is_of(channel, axis) || is_free(channel));
        let grid: Vec<Effect> =
            channels.map(|channel| with_word(LOAD_COMPLIANCE.name, place, "channel", channel)).collect();
        for outlets in [vec![Outlet::own(machine, axis)], motion(axis, &directions(machine, axis).tilts)] {
            let family = CandidateFamily::new(LOAD_COMPLIANCE.name, place, outlets, PLAUSIBLE_OF_ARMS);
            list.push(family.over(grid.clone()));
        }
    }
    list
}
