//! Deflection of a joint under loads whose direction turns with the machine. Payload that changes during a session is not modelled.
//!
//! `E = Σ s_k (g_k − g_k0) + Σ s_jk (g_j g_k − g_j0 g_k0)`, g the unit vector of gravity in the frame of the load (a link),
//! index 0 with all axes at zero: the sag there is part of the location errors. Wind-up by an eccentric mass and bearing
//! shift are linear in g; a body that bends in its own frame is seen turned in the carrier's, which gives the products.

use super::contract::{
    DefaultValue, Driver, Kind, Notable, Parameter, Profile, ShowingTest, ShownBy, Signature, Unseen, every_component,
    no_check, plain_measure, word,
};
use super::load_frame::{of_link, rotations};
use super::{Context, EffectError};
use crate::machine::{AxisKind, Effect, Place};
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
    parameters: &[Parameter::word(
        "load",
        &[],
        DefaultValue::Absent,
        "link whose frame the load keeps, of the chain or of a branch under 'carried'; the link that the joint carries when not stated",
    )],
    check: no_check,
    outlets: |machine, place| match place {
        Place::Axis(axis) if machine.axes[axis].kind == AxisKind::Rotary => every_component(machine, axis),
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions: |_| FUNCTIONS.map(|(name, _)| name.to_string()).to_vec(),
    profiles,
};

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let Place::Axis(axis) = effect.place else { return Ok(Vec::new()) };
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
