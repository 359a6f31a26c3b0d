//! Deflection of a joint under loads whose direction turns with the machine. Payload that changes during a session is not modelled.
//!
//! `E = S g`, g the unit vector of gravity in the frame of the load (a link), S the sizes: mm or rad per g.
//! Bending, bearing shift and wind-up by an eccentric mass are all of this form.

use super::kind::{Default, Driver, Kind, Parameter, Profile, every_component, no_check, plain_measure, word};
use super::{Context, EffectError};
use crate::chain::Geometry;
use crate::machine::{AxisKind, Effect, Place};

/// Sag of a tilting joint.
pub static GRAVITY_SAG: Kind = Kind {
    name: "gravity-sag",
    driver: Driver::Gravity,
    formula: "E = Sx gx + Sy gy + Sz gz, g gravity in the load's frame",
    size_meaning: "deflection per g",
    cause: "weight of table, head or workpiece off the tilting line: bearing and structure bend, the drive winds up",
    remedy: "balance the load, check the counterbalance, or compensate by the tilt angle; identify with the payload of use",
    parameters: &[Parameter::word(
        "load",
        &[],
        Default::Absent,
        "link whose frame the load keeps; the link that the joint carries when not stated",
    )],
    check: no_check,
    outlets: |machine, place| match place {
        Place::Axis(axis) if machine.axes[axis].kind == AxisKind::Rotary => every_component(machine, axis),
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions: |_| ["x", "y", "z"].map(String::from).to_vec(),
    profiles,
};

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let Place::Axis(axis) = effect.place else { return Ok(Vec::new()) };
    let chain = context.chain();
    let link = match word(effect, "load") {
        None => chain.carried_by(axis),
        Some(name) => chain.link(name).ok_or_else(|| EffectError::NoLink {
            effect: effect.kind.clone(),
            link: name.to_string(),
            known: chain.link_names().join(" "),
        })?,
    };
    let geometry = Geometry::nominal(chain);
    let gravity = context.machine().gravity;
    let direction = |test: usize, row: usize| {
        geometry.pose(link, context.motion(test).row(row), None).rotation.transpose() * gravity
    };
    Ok((0..3).map(|k| context.profile(|test, row| direction(test, row)[k])).collect())
}
