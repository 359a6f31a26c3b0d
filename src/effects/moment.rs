//! The moment form of a sag: deflection of a joint under the moment of weight that a link beyond it turns about. Masses need not be known: they are in the sizes.
//!
//! A weight of size one whose lever from the joint is `r` gives the moment `z·(r × g)` about a direction z, g the unit vector of
//! gravity. Levers of a serial arm are sums of vectors fixed in its links, so the moment of all that hangs on a joint is
//! `Σ_links h·m`, `m = Rᵀ(g × z)`, R the rotation of the link and h what is fixed in it. `E = Σ_k s_k (m_k − m_k0)`, index 0 with
//! all axes at zero: what is there then is part of the location errors.

use nalgebra::Vector3;

use super::candidates::{CandidateFamily, Observations, PLAUSIBLE_OF_ARMS, directions, motion, with_word};
use super::context::Profile;
use super::contract::word;
use super::load_frame::{of_link, rotations};
use super::{Context, EffectError};
use crate::chain::LinkId;
use crate::machine::{AxisKind, Effect, Outlet, ParameterValue, Place};

/// Directions about which a moment may act: the joint's own line, or one of R at the zero position.
pub(super) const ABOUT: [&str; 4] = ["own", "x", "y", "z"];

/// The moment of a load about a direction, one profile for each coordinate of the load's frame along which its lever stands out.
pub(super) fn profiles(context: &Context, effect: &Effect, about: &str) -> Result<Vec<Profile>, EffectError> {
    let Place::Axis(axis) = effect.place else { return Ok(Vec::new()) };
    let machine = context.machine();
    let about = match ABOUT.iter().skip(1).position(|known| *known == about) {
        Some(direction) => Vector3::ith(direction, 1.0),
        None => machine.axes[axis].direction,
    };
    let own = context.chain().carried_by(axis);
    let load = match word(effect, "load") {
        None => of_link(context, own),
        Some(name) => rotations(context, &effect.kind, name)?,
    };
    let carrier = of_link(context, LinkId { depth: own.depth.saturating_sub(1), ..own });
    let at_zero = machine.gravity.cross(&about);
    let moment = |test: usize, row: usize| {
        load[test][row].transpose() * machine.gravity.cross(&(carrier[test][row] * about)) - at_zero
    };
    Ok((0..3).map(|k| context.profile(|test, row| moment(test, row)[k])).collect())
}

/// Share of the full moment below which there is none.
const LEAST_MOMENT: f64 = 0.02;

/// Whether a weight beyond an axis may have a moment about a direction of R that stands in the link before it.
fn has_moment(context: &Context, axis: usize, about: Vector3<f64>) -> bool {
    let own = context.chain().carried_by(axis);
    let carrier = of_link(context, LinkId { depth: own.depth.saturating_sub(1), ..own });
    let gravity = context.machine().gravity;
    carrier.iter().flatten().any(|rotation| gravity.cross(&(rotation * about)).norm() > LEAST_MOMENT)
}

/// Links of the branches that hang beyond an axis.
fn levers(seen: &Observations, axis: usize) -> Vec<String> {
    let (machine, chain) = (seen.machine(), seen.context.chain());
    let hanging =
        machine.carried.iter().filter(|branch| branch.on.is_some_and(|on| chain.carries(axis, chain.carried_by(on))));
    hanging.flat_map(|branch| &branch.joints).map(|joint| joint.name.clone()).collect()
}

/// Sag of a joint about its line and across under branches that hang beyond it: the moment of another arm depends on where that points.
pub(super) fn moments(seen: &Observations, sag: &'static str) -> Vec<CandidateFamily> {
    let machine = seen.machine();
    let mut list = Vec::new();
    for (axis, _) in seen.moving(AxisKind::Rotary) {
        let place = Place::Axis(axis);
        let new = |outlets, effect| CandidateFamily::new(sag, place, outlets, PLAUSIBLE_OF_ARMS).over(vec![effect]);
        let turns = has_moment(seen.context, axis, machine.axes[axis].direction);
        let mut tilts = directions(machine, axis).tilts.to_vec();
        tilts.retain(|tilt| has_moment(seen.context, axis, Vector3::ith(tilt.direction_index(), 1.0)));
        for load in levers(seen, axis) {
            let under = with_word(sag, place, "load", &load);
            if turns {
                let about = ParameterValue::Word(ABOUT[0].into());
                list.push(new(vec![Outlet::own(machine, axis)], under.clone().with("moment", about)));
            }
            for &tilt in &tilts {
                let about = ParameterValue::Word(ABOUT[1 + tilt.direction_index()].into());
                list.push(new(motion(axis, &[tilt]), under.clone().with("moment", about)));
            }
        }
    }
    list
}
