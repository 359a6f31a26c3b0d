//! Deflection of a joint under loads whose direction turns with the machine. Payload that changes during a session is not modelled.
//!
//! `E = Σ s_k (g_k − g_k0) + Σ s_jk (g_j g_k − g_j0 g_k0)`, g the unit vector of gravity in the frame of the load (a link),
//! index 0 with all axes at zero: the sag there is part of the location errors. Wind-up by an eccentric mass and bearing
//! shift are linear in g; a body that bends in its own frame is seen turned in the carrier's, which gives the products.

use super::candidates::{CandidateFamily, Observations, PLAUSIBLE_OF_ARMS, directions, motion, some_rows, with_word};
use super::context::Profile;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, Signature, Unseen, every_component, no_check,
    plain_measure, word,
};
use super::load_frame::{of_link, rotations};
use super::moment::{self, ABOUT};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::machine::{AxisKind, Effect, Outlet, Place};
use nalgebra::{Matrix3, Vector3};

/// Functions with the components of gravity that they multiply.
const FUNCTIONS: [(&str, &[usize]); 9] = [
    ("x", &[0]),
    ("y", &[1]),
    ("z", &[2]),
    ("xx", &[0, 0]),
    ("yy", &[1, 1]),
    ("zz", &[2, 2]),
    ("xy", &[0, 1]),
    ("xz", &[0, 2]),
    ("yz", &[1, 2]),
];

/// Sag of a tilting joint.
pub static GRAVITY_SAG: Kind = Kind {
    name: "gravity-sag",
    driver: Driver::Gravity,
    formula: "E = sum s_k g_k + sum s_jk g_j g_k, less their values at zero; g gravity in the load's frame",
    size_meaning: "deflection per g",
    cause: "weight of table, head or workpiece off the tilting line: bearing and structure bend, the drive winds up",
    remedy: "balance the load, check the counterbalance, or compensate by the tilt angle; identify with the payload of use",
    titles: &[("", "Sag at {place} under gravity ({moving})")],
    measures: Some("per g"),
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::Payload },
    unseen: Unseen::Listed,
    unmoved: &[AxisKind::Rotary],
    form_error: 0.03,
    needs_runs: false,
    signature: Signature::Sag,
    candidates: sags,
    candidates_of_poses: |seen| moment::moments(seen, GRAVITY_SAG.name).into_iter().chain(sags_of_arms(seen)).collect(),
    documented: Documented {
        place: "rotary axis",
        components: "all",
        functions: "`x y z`: unit gravity in the frame of the load, `xx xy …`: its products, for a body that bends in its own frame; less their values at the zero position; with `moment` `x y z`: `Rᵀ(g × z)` less its value there, R the rotation of the load, z the direction of the moment: what a weight turns about z whose lever is fixed in the load",
        parameters: "`load` (link), `moment` (own, x, y, z)",
        unit: "um, arcsec per g",
    },
    parameters: &[
        Parameter::word(
            "load",
            &[],
            DefaultValue::Absent,
            "link whose frame the load keeps, of the chain or of a branch under 'carried'; the link that the joint carries when not stated",
        ),
        Parameter::word(
            "moment",
            &ABOUT,
            DefaultValue::Absent,
            "the load's moment about the joint's own line or a direction of R drives, in place of gravity in the load's frame",
        ),
    ],
    check: no_check,
    outlets: |machine, place| match place {
        Place::Axis(axis) if machine.axes[axis].kind == AxisKind::Rotary => every_component(machine, axis),
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions: |effect| {
        let count = if word(effect, "moment").is_some() { LINEAR.len() } else { FUNCTIONS.len() };
        FUNCTIONS.iter().take(count).map(|(name, _)| name.to_string()).collect()
    },
    profiles,
};

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let Place::Axis(axis) = effect.place else { return Ok(Vec::new()) };
    if let Some(about) = word(effect, "moment") {
        return moment::profiles(context, effect, about);
    }
    let turned = match word(effect, "load") {
        None => of_link(context, context.chain().carried_by(axis)),
        Some(name) => rotations(context, &effect.kind, name)?,
    };
    let gravity = context.machine().gravity;
    let seen = |rows: &Vec<Matrix3<f64>>| rows.iter().map(|rotation| rotation.transpose() * gravity).collect();
    let direction: Vec<Vec<Vector3<f64>>> = turned.iter().map(seen).collect();
    Ok(FUNCTIONS
        .iter()
        .map(|(_, factors)| {
            let product = |g: &Vector3<f64>| factors.iter().map(|&k| g[k]).product::<f64>();
            let at_zero = product(&gravity);
            context.profile(|test, row| product(&direction[test][row]) - at_zero)
        })
        .collect())
}

fn sags(seen: &Observations) -> Vec<CandidateFamily> {
    let first_middle_last = |rows: usize| {
        let looked_at = [0, rows / 2, rows.saturating_sub(1)];
        looked_at.into_iter().filter(|&row| row < rows).collect()
    };
    let turning = seen.axes(AxisKind::Rotary).filter(|&axis| seen.context.gravity_turns_in(axis, first_middle_last));
    let of_axis = |axis| {
        let d = directions(seen.machine(), axis);
        let mut outlets = motion(axis, &[d.across[0], d.across[1], d.tilts[0], d.tilts[1]]);
        let own = vec![Outlet::own(seen.machine(), axis)];
        outlets.extend(&own);
        let new = |outlets| CandidateFamily::new(GRAVITY_SAG.name, Place::Axis(axis), outlets, 30.0);
        let whole = new(outlets);
        // a drive that winds up turns its axis alone; of poses the arms' sags hold that
        let wound_up = seen.context.has_sweeps().then(|| CandidateFamily { functions: LINEAR, ..new(own) });
        // a body that bends in its own frame adds products of gravity's components
        wound_up.into_iter().chain([CandidateFamily { functions: LINEAR, ..whole.clone() }, whole])
    };
    turning.flat_map(of_axis).collect()
}

/// Functions that are linear in gravity.
const LINEAR: &[&str] = &["x", "y", "z"];

/// Sag of a joint under each link beyond it: the torque of a forearm depends on where the forearm points.
fn sags_of_arms(seen: &Observations) -> Vec<CandidateFamily> {
    let (machine, chain) = (seen.machine(), seen.context.chain());
    let mut list = Vec::new();
    for (axis, _) in seen.moving(AxisKind::Rotary) {
        let (d, place) = (directions(machine, axis), Place::Axis(axis));
        for beyond in (0..machine.axes.len()).filter(|&beyond| chain.carries(axis, chain.carried_by(beyond))) {
            if !seen.context.gravity_turns_in(beyond, some_rows) {
                continue;
            }
            let load = with_word(GRAVITY_SAG.name, place, "load", &machine.axes[beyond].name);
            for outlets in [
                vec![Outlet::own(machine, axis)],
                motion(axis, &d.tilts),
                motion(axis, &[d.across[0], d.across[1], d.along]),
            ] {
                let family = CandidateFamily::new(GRAVITY_SAG.name, place, outlets, PLAUSIBLE_OF_ARMS);
                list.push(CandidateFamily { functions: LINEAR, ..family.over(vec![load.clone()]) });
            }
        }
    }
    list
}
