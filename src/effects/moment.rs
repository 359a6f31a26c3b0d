//! Deflection of a joint under the moment of weight that a link beyond it turns about. Masses need not be known: they are in the sizes.
//!
//! A weight of size one whose lever from the joint is `r` gives the moment `z·(r × g)` about a direction z, g the unit vector of
//! gravity. Levers of a serial arm are sums of vectors fixed in its links, so the moment of all that hangs on a joint is
//! `Σ_links h·m`, `m = Rᵀ(g × z)`, R the rotation of the link and h what is fixed in it. `E = Σ_k s_k (m_k − m_k0)`, index 0 with
//! all axes at zero: what is there then is part of the location errors.

use nalgebra::Vector3;

use super::candidates::{
    CandidateFamily, Observations, PLAUSIBLE_OF_ARMS, directions, motion, none, some_rows, with_word,
};
use super::context::Profile;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ShowingTest, ShownBy, Signature, Unseen,
    every_component, no_check, plain_measure, word,
};
use super::load_frame::{of_link, rotations};
use super::{Context, EffectError};
use crate::chain::LinkId;
use crate::machine::{AxisKind, Effect, Outlet, ParameterValue, Place};

/// Coordinates of the load's frame along which levers stand out.
const FUNCTIONS: [&str; 3] = ["x", "y", "z"];
/// Directions of R about which a moment may act.
const ABOUT: [&str; 3] = ["x", "y", "z"];

/// Sag of a joint under a moment.
pub static GRAVITY_MOMENT: Kind = Kind {
    name: "gravity-moment",
    driver: Driver::Gravity,
    formula: "E = sum s_k m_k, m = R^T (g x z) less its value at zero; R the load's rotation, z the direction of the moment",
    size_meaning: "deflection under the full moment",
    cause: "weight beyond the joint stands out from its line: the gear winds up, the bearing tips",
    remedy: "compensate by the moment of the pose, balance the load, or stiffen gear and bearing",
    titles: &[("", "Sag at {place} under the moment of weight ({moving})")],
    measures: Some("under the full moment"),
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::Payload },
    unseen: Unseen::Never,
    unmoved: &[AxisKind::Rotary],
    form_error: 0.03,
    needs_runs: false,
    signature: Signature::Sag,
    candidates: none,
    candidates_of_poses: moments,
    documented: Documented {
        place: "rotary axis",
        components: "all",
        functions: "`x y z`: `Rᵀ(g × z)` less its value at zero, R the rotation of the load, z the direction of the moment",
        parameters: "`load` (link), `moment` (x, y, z)",
        unit: "um, arcsec at the full moment",
    },
    parameters: &[
        Parameter::word(
            "load",
            &[],
            DefaultValue::Absent,
            "link in which the lever is fixed, of the chain or of a branch under 'carried'; the link that the joint carries when not stated",
        ),
        Parameter::word(
            "moment",
            &ABOUT,
            DefaultValue::Absent,
            "direction of R at the zero position about which the moment acts; the joint's own line when not stated",
        ),
    ],
    check: no_check,
    outlets: |machine, place| match place {
        Place::Axis(axis) if machine.axes[axis].kind == AxisKind::Rotary => every_component(machine, axis),
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions: |_| FUNCTIONS.map(String::from).to_vec(),
    profiles,
};

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let Place::Axis(axis) = effect.place else { return Ok(Vec::new()) };
    let machine = context.machine();
    let about = match word(effect, "moment").and_then(|name| ABOUT.iter().position(|known| *known == name)) {
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
    Ok((0..FUNCTIONS.len()).map(|k| context.profile(|test, row| moment(test, row)[k])).collect())
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

/// Links beyond an axis in which a lever may turn against gravity, and those of branches that hang there.
fn levers(seen: &Observations, axis: usize) -> Vec<String> {
    let (machine, chain) = (seen.machine(), seen.context.chain());
    let beyond = (0..machine.axes.len()).filter(|&beyond| chain.carries(axis, chain.carried_by(beyond)));
    let turning = beyond.filter(|&beyond| seen.context.gravity_turns_in(beyond, some_rows));
    let hanging =
        machine.carried.iter().filter(|branch| branch.on.is_some_and(|on| chain.carries(axis, chain.carried_by(on))));
    let joints = hanging.flat_map(|branch| &branch.joints).map(|joint| joint.name.clone());
    turning.map(|beyond| machine.axes[beyond].name.clone()).chain(joints).collect()
}

/// Sag of a joint about its line and across under every lever beyond it: the moment of a forearm depends on where it points.
fn moments(seen: &Observations) -> Vec<CandidateFamily> {
    let machine = seen.machine();
    let mut list = Vec::new();
    for (axis, _) in seen.moving(AxisKind::Rotary) {
        let place = Place::Axis(axis);
        let new = |outlets, effect| {
            CandidateFamily::new(GRAVITY_MOMENT.name, place, outlets, PLAUSIBLE_OF_ARMS).over(vec![effect])
        };
        let turns = has_moment(seen.context, axis, machine.axes[axis].direction);
        let mut tilts = directions(machine, axis).tilts.to_vec();
        tilts.retain(|tilt| has_moment(seen.context, axis, Vector3::ith(tilt.direction_index(), 1.0)));
        for load in levers(seen, axis) {
            let under = with_word(GRAVITY_MOMENT.name, place, "load", &load);
            if turns {
                list.push(new(vec![Outlet::own(machine, axis)], under.clone()));
            }
            for &tilt in &tilts {
                let about = ParameterValue::Word(ABOUT[tilt.direction_index()].into());
                list.push(new(motion(axis, &[tilt]), under.clone().with("moment", about)));
            }
        }
    }
    list
}
