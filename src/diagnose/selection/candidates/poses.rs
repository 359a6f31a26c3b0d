//! Further candidates for sessions of static poses: what drives and gravity do to an arm. The general ones are in the other files.

use super::family::{CandidateFamily, list_of};
use super::growth::loads;
use super::motions::{directions, gravity_turns_in, has_moment, motion, travelled};
use crate::diagnose::model::linear_model::LinearModel;
use crate::effects::{
    ARRIVAL_LAG, CYCLIC_ERROR, GRAVITY_MOMENT, GRAVITY_SAG, LOAD_COMPLIANCE, ROTARY_ERROR_MOTION, Signature,
    THERMAL_GROWTH, is_a, kind,
};
use crate::machine::{AxisKind, Component, Effect, Outlet, ParameterValue, Place};
use nalgebra::Vector3;

/// Amplitudes up to this are plausible for an arm, µm or arcsec: it is softer than a machine tool.
const PLAUSIBLE: f64 = 300.0;
/// Orders per turn of a joint's own angle: eccentric encoder or gear, and, below one, a scale error of the angle.
const OWN_ORDERS: [&[f64]; 6] = [&[0.25], &[0.5], &[1.0], &[2.0], &[2.0, 3.0], &[1.0, 2.0, 3.0]];
/// Low orders of a joint's line: a bearing race or a flange out of true.
const LINE_ORDERS: [&[f64]; 2] = [&[1.0], &[1.0, 2.0]];
/// Rows of a session looked at to see whether gravity turns in a link.
const LOOKED_AT: usize = 50;

/// Replaces the list by what static poses can show.
pub(super) fn for_poses(model: &LinearModel, list: &mut Vec<CandidateFamily>) {
    list.retain(|family| !needs_runs(family));
    for family in list.iter_mut() {
        family.plausible = family.plausible.max(PLAUSIBLE);
        // all rows are looked at anyway; only long grids of periods get the quick look that fast families have
        family.fast = is_a(family.kind, Signature::Period);
    }
    let machine = model.context.machine();
    let moving: Vec<usize> = (0..machine.axes.len()).filter(|&axis| travelled(model, axis).is_some()).collect();
    for &axis in &moving {
        arrivals(model, axis, &moving, list);
        list.push(warming_up(model, axis));
        if machine.axes[axis].kind == AxisKind::Rotary {
            yields(model, axis, list);
            sags(model, axis, list);
            periodic(model, axis, list);
        }
    }
}

/// Whether a family depends on times or runs, which static poses do not have.
fn needs_runs(family: &CandidateFamily) -> bool {
    let Some(kind) = kind(family.kind) else { return false };
    let grows = matches!(kind.signature, Signature::Growth | Signature::BarLength);
    kind.needs_runs || grows && family.grid.iter().all(|effect| effect.parameter("tau").is_some())
}

/// What the speed of arrival leaves: at the joint itself, and in the bearings of others that its braking bends.
fn arrivals(model: &LinearModel, axis: usize, moving: &[usize], list: &mut Vec<CandidateFamily>) {
    let machine = model.context.machine();
    let place = Place::Axis(axis);
    let own = CandidateFamily::new(ARRIVAL_LAG.name, place, vec![Outlet::own(machine, axis)], PLAUSIBLE);
    list.push(CandidateFamily { functions: &["speed"], ..own.clone() });
    list.push(own.clone());
    // an arm stretched out from another joint's line makes the whole move slower or softer
    for &about in moving.iter().filter(|&&about| about != axis && machine.axes[about].kind == AxisKind::Rotary) {
        let name = ParameterValue::Word(machine.axes[about].name.clone());
        let stretched = Effect::new(ARRIVAL_LAG.name, place).with("about", name);
        list.push(CandidateFamily { functions: &["inertia"], ..own.clone() }.over(vec![stretched]));
    }
    let chain = model.context.chain();
    for &of in moving.iter().filter(|&&of| of != axis && chain.carries(of, chain.carried_by(axis))) {
        let braked =
            Effect::new(ARRIVAL_LAG.name, place).with("of", ParameterValue::Word(machine.axes[of].name.clone()));
        // a tilt about the line of the joint before is that joint's own error
        let mut tilts = motion(axis, &directions(machine, axis).tilts);
        tilts.retain(|outlet| !is_own_of(model, of, axis, outlet));
        list.push(CandidateFamily::new(ARRIVAL_LAG.name, place, tilts, PLAUSIBLE).over(vec![braked]));
    }
}

/// Time constants of warming up that are tried, in poses.
const WARMING_POSES: [f64; 4] = [15.0, 40.0, 100.0, 250.0];

/// A joint that drifts while the arm warms up, by the number of the pose.
fn warming_up(model: &LinearModel, axis: usize) -> CandidateFamily {
    let place = Place::Axis(axis);
    let clock = Effect::new(THERMAL_GROWTH.name, place).with("clock", ParameterValue::Word("poses".into()));
    let grid = WARMING_POSES.map(|tau| clock.clone().with("tau", list_of(vec![tau])));
    CandidateFamily::new(THERMAL_GROWTH.name, place, vec![Outlet::own(model.context.machine(), axis)], PLAUSIBLE)
        .over(grid.to_vec())
}

/// Whether a tilt of an axis turns about the direction of another axis that carries it, at zero and nearly always.
fn is_own_of(model: &LinearModel, of: usize, axis: usize, outlet: &Outlet) -> bool {
    let chain = model.context.chain();
    let Outlet::Motion { component, .. } = outlet else { return false };
    let (before, after) = (chain.carried_by(of), chain.carried_by(axis));
    let follows = before.branch == after.branch && after.depth == before.depth + 1;
    follows && chain.joint(of).direction[component.direction_index()].abs() > 0.9
}

/// The number in a name: 2 of `J2` and of `tau2_Nm`.
fn number_in(name: &str) -> Option<usize> {
    let digits: String = name.chars().skip_while(|c| !c.is_ascii_digit()).take_while(char::is_ascii_digit).collect();
    digits.parse().ok()
}

/// What a joint yields to loads that were measured: about its own line, and across.
fn yields(model: &LinearModel, axis: usize, list: &mut Vec<CandidateFamily>) {
    let place = Place::Axis(axis);
    let under =
        |channel: String| Effect::new(LOAD_COMPLIANCE.name, place).with("channel", ParameterValue::Word(channel));
    let machine = model.context.machine();
    // a joint yields to its own torque; a channel that no joint's number claims may act anywhere
    let is_of = |channel: &str, axis: usize| {
        number_in(channel).is_some_and(|own| number_in(&machine.axes[axis].name) == Some(own))
    };
    let is_free = |channel: &str| !(0..machine.axes.len()).any(|axis| is_of(channel, axis));
    let channels = loads(model).into_iter().filter(|channel| is_of(channel, axis) || is_free(channel));
    let grid: Vec<Effect> = channels.map(under).collect();
    if grid.is_empty() {
        return;
    }
    for outlets in [vec![Outlet::own(machine, axis)], motion(axis, &directions(machine, axis).tilts)] {
        list.push(CandidateFamily::new(LOAD_COMPLIANCE.name, place, outlets, PLAUSIBLE).over(grid.clone()));
    }
}

/// Sag of a joint under each link beyond it and under branches that hang there: the moment of a forearm depends on where it points.
fn sags(model: &LinearModel, axis: usize, list: &mut Vec<CandidateFamily>) {
    let machine = model.context.machine();
    let chain = model.context.chain();
    let place = Place::Axis(axis);
    let d = directions(machine, axis);
    let looked_at = |rows: usize| (0..rows).step_by((rows / LOOKED_AT).max(1)).collect::<Vec<_>>();
    let own = Outlet::own(machine, axis);
    let letter = |component: Component| ["x", "y", "z"][component.direction_index()];
    let mut loads: Vec<String> = Vec::new();
    for beyond in (0..machine.axes.len()).filter(|&beyond| chain.carries(axis, chain.carried_by(beyond))) {
        if gravity_turns_in(model, beyond, looked_at) {
            loads.push(machine.axes[beyond].name.clone());
            let load = Effect::new(GRAVITY_SAG.name, place)
                .with("load", ParameterValue::Word(machine.axes[beyond].name.clone()));
            let shifts = motion(axis, &[d.across[0], d.across[1], d.along]);
            let family = CandidateFamily::new(GRAVITY_SAG.name, place, shifts, PLAUSIBLE).over(vec![load]);
            list.push(CandidateFamily { functions: &["x", "y", "z"], ..family });
        }
    }
    let hanging =
        machine.carried.iter().filter(|branch| branch.on.is_some_and(|on| chain.carries(axis, chain.carried_by(on))));
    loads.extend(hanging.flat_map(|branch| &branch.joints).map(|joint| joint.name.clone()));
    for load in loads {
        let under = Effect::new(GRAVITY_MOMENT.name, place).with("load", ParameterValue::Word(load));
        let family =
            |outlets, effect| CandidateFamily::new(GRAVITY_MOMENT.name, place, outlets, PLAUSIBLE).over(vec![effect]);
        if has_moment(model, axis, machine.axes[axis].direction) {
            list.push(family(vec![own], under.clone()));
        }
        for tilt in d.tilts {
            if has_moment(model, axis, Vector3::ith(tilt.direction_index(), 1.0)) {
                let about = under.clone().with("moment", ParameterValue::Word(letter(tilt).into()));
                list.push(family(motion(axis, &[tilt]), about));
            }
        }
    }
}

/// Low orders of a joint's own angle and of its line.
fn periodic(model: &LinearModel, axis: usize, list: &mut Vec<CandidateFamily>) {
    let machine = model.context.machine();
    let place = Place::Axis(axis);
    let d = directions(machine, axis);
    let with_orders = |kind: &str, orders: &[f64]| Effect::new(kind, place).with("orders", list_of(orders.to_vec()));
    for orders in OWN_ORDERS {
        let own = CandidateFamily::new(CYCLIC_ERROR.name, place, vec![Outlet::own(machine, axis)], PLAUSIBLE);
        list.push(own.over(vec![with_orders(CYCLIC_ERROR.name, orders)]));
    }
    for orders in LINE_ORDERS {
        for outlets in [motion(axis, &[d.across[0], d.across[1], d.along]), motion(axis, &d.tilts)] {
            let line = CandidateFamily::new(ROTARY_ERROR_MOTION.name, place, outlets, PLAUSIBLE);
            list.push(line.over(vec![with_orders(ROTARY_ERROR_MOTION.name, orders)]));
        }
    }
}
