//! How the links turn that load a joint: links of the chain, and links of a branch that only hangs on it. No sizes.

use nalgebra::{Matrix3, Rotation3, Unit};

use super::{Context, EffectError};
use crate::chain::{Geometry, LinkId};
use crate::machine::CarriedJoint;

/// Rotation of a link in the bed's frame, by test and row.
pub(super) type Rotations = Vec<Vec<Matrix3<f64>>>;

/// Rotations of a link by name, of the nominal machine.
pub(super) fn rotations(context: &Context, effect: &str, name: &str) -> Result<Rotations, EffectError> {
    if let Some(link) = context.chain().link(name) {
        return Ok(of_link(context, link));
    }
    let machine = context.machine();
    let Some((branch, joints)) = machine.carried_link(name) else {
        let mut known: Vec<&str> = context.chain().link_names();
        known.extend(machine.carried.iter().flat_map(|branch| &branch.joints).map(|joint| joint.name.as_str()));
        return Err(EffectError::NoLink { effect: effect.to_string(), link: name.to_string(), known: known.join(" ") });
    };
    let carrier = branch.on.map_or(LinkId::BED, |axis| context.chain().carried_by(axis));
    let mut turned = of_link(context, carrier);
    for (test, rows) in turned.iter_mut().enumerate() {
        for joint in joints {
            let positions = positions(context, effect, test, joint)?;
            let sign = if joint.reversed { -1.0 } else { 1.0 };
            let about = Unit::new_normalize(joint.direction);
            for (rotation, q) in rows.iter_mut().zip(positions) {
                *rotation *= Rotation3::from_axis_angle(&about, sign * q.to_radians()).into_inner();
            }
        }
    }
    Ok(turned)
}

/// Rotations of a link of the chain.
pub(super) fn of_link(context: &Context, link: LinkId) -> Rotations {
    let geometry = Geometry::nominal(context.chain());
    let in_test = |test: usize| {
        let motion = context.motion(test);
        (0..motion.rows()).map(|row| geometry.pose(link, motion.row(row), None).rotation).collect()
    };
    (0..context.tests()).map(in_test).collect()
}

/// Positions of a joint that is no axis of the chain, degrees, from its column.
pub(super) fn positions<'a>(
    context: &'a Context,
    effect: &str,
    test: usize,
    joint: &CarriedJoint,
) -> Result<&'a [f64], EffectError> {
    let entry = &context.session().tests[test];
    let channels = entry.recording.as_ref().map(|recording| recording.channels.as_slice()).unwrap_or_default();
    let channel = joint.channel();
    let Some((_, column)) = channels.iter().find(|(name, _)| *name == channel) else {
        let found: Vec<&str> = channels.iter().map(|(name, _)| name.as_str()).collect();
        return Err(EffectError::NoChannel {
            effect: effect.to_string(),
            test: entry.name.clone(),
            channel,
            found: if found.is_empty() { "none".into() } else { found.join(", ") },
        });
    };
    match column.iter().position(|value| !value.is_finite()) {
        None => Ok(column),
        Some(row) => {
            Err(EffectError::NoLoad { effect: effect.to_string(), test: entry.name.clone(), channel, row: row + 1 })
        }
    }
}
