//! Errors that repeat with the position of an axis: error motion of rotary bearings and cyclic errors of drives and encoders.
//!
//! `E(q) = Σ_n a_n (cos n q − 1) + b_n sin n q`, n the order per turn (any number, bearings have odd ones) or
//! `n q = 2π q / period` on a slide: zero at position 0. Sidebands of an order are orders of their own.

use super::backlash::across;
use super::contract::{
    DefaultValue, Driver, Kind, Notable, Parameter, ParameterUnit, Profile, ShowingTest, ShownBy, Signature, Unseen,
    list, plain_measure,
};
use super::{Context, EffectError};
use crate::machine::{AxisKind, Effect, Machine, Outlet, Place};
use std::f64::consts::TAU;

const PARAMETERS: &[Parameter] = &[
    Parameter::list(
        "orders",
        ParameterUnit::Plain,
        DefaultValue::Absent,
        (1e-3, 1e6),
        "periods per turn of a rotary axis",
    ),
    Parameter::list("periods", ParameterUnit::Plain, DefaultValue::Absent, (1e-3, 1e5), "periods of a linear axis, mm"),
];

/// Error motion of a rotary axis across its own motion.
pub static ROTARY_ERROR_MOTION: Kind = Kind {
    name: "rotary-error-motion",
    driver: Driver::Position,
    formula: "E = sum a_n (cos n q - 1) + b_n sin n q",
    size_meaning: "amplitude of an order",
    cause: "out-of-round bearing races, worn or dirty table bearing, coupling pushing at its order",
    remedy: "inspect bearing and preload; orders at ball-pass numbers name the race",
    titles: &[("", "Error motion of the axis of {place} ({moving})")],
    measures: Some("at its largest"),
    notable: Notable { length: 1.0, angle: 2.0 },
    shown_by: ShownBy {
        arm: Some(ShowingTest::WholeRange),
        rotary: Some(ShowingTest::Radial),
        other: ShowingTest::BothWays,
    },
    unseen: Unseen::Listed,
    unmoved: &[AxisKind::Rotary],
    form_error: 0.03,
    needs_runs: false,
    signature: Signature::ErrorMotion,
    parameters: PARAMETERS,
    check: periods_of_its_axis,
    outlets: |machine, place| match place {
        Place::Axis(axis) if machine.axes[axis].kind == AxisKind::Rotary => across(machine, place),
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions,
    profiles,
};

/// Error of an axis's own motion at any period.
pub static CYCLIC_ERROR: Kind = Kind {
    name: "cyclic-error",
    driver: Driver::Position,
    formula: "own = sum a_n (cos n q - 1) + b_n sin n q",
    size_meaning: "amplitude at its period",
    cause: "worm or gear tooth (orders at the tooth number), eccentric encoder disc (1 per turn), screw pitch",
    remedy: "centre the encoder, renew worm or screw bearing, or use the control's pitch compensation at that period",
    titles: &[("", "Cyclic error of {place}")],
    measures: Some("amplitude"),
    notable: Notable { length: 1.0, angle: 2.0 },
    shown_by: ShownBy {
        arm: Some(ShowingTest::WholeRange),
        rotary: Some(ShowingTest::Tangential),
        other: ShowingTest::Circles,
    },
    unseen: Unseen::Listed,
    unmoved: &[AxisKind::Rotary, AxisKind::Linear],
    form_error: 0.07,
    needs_runs: false,
    signature: Signature::Period,
    parameters: PARAMETERS,
    check: periods_of_its_axis,
    outlets: |machine, place| match place {
        Place::Axis(axis) => vec![Outlet::own(machine, axis)],
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions,
    profiles,
};

/// Orders go with a rotary axis, periods with a linear one.
fn periods_of_its_axis(machine: &Machine, effect: &Effect) -> Result<(), String> {
    let kind = effect.place.axis().map(|axis| machine.axes[axis].kind);
    let (orders, periods) = (list(effect, "orders").len(), list(effect, "periods").len());
    match kind {
        Some(AxisKind::Rotary) if orders == 0 || periods > 0 => {
            Err("a rotary axis has orders, e.g. orders: [2, 3]".into())
        }
        Some(AxisKind::Linear) if periods == 0 || orders > 0 => {
            Err("a linear axis has periods in mm, e.g. periods: [10]".into())
        }
        _ => Ok(()),
    }
}

/// `cos2`, `sin2`, … in the order of the parameters.
fn functions(effect: &Effect) -> Vec<String> {
    let orders = list(effect, "orders").iter().chain(list(effect, "periods"));
    orders.flat_map(|order| [format!("cos{order}"), format!("sin{order}")]).collect()
}

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let Place::Axis(axis) = effect.place else { return Ok(Vec::new()) };
    let frequencies = list(effect, "orders").iter().copied();
    let frequencies = frequencies.chain(list(effect, "periods").iter().map(|period| TAU / period));
    Ok(frequencies
        .flat_map(|n| {
            [context.position_profile(axis, |q| (n * q).cos() - 1.0), context.position_profile(axis, |q| (n * q).sin())]
        })
        .collect())
}
