//! Forward models of machine physics beyond constant location errors. It finds nothing; that is what diagnosis is for.
//!
//! Every effect is a small motion at a place times functions of a driver:
//! `outlet(row) = Σ size · function(row)`, `ΔL = Σ ∂L/∂outlet · outlet` to first order. A [`Kind`] says which outlets
//! a place has, which functions there are and computes their [`Profile`]s over a whole session; sizes are linear,
//! everything else is a shape parameter. One file per kind (or per family that shares a function), registered in
//! [`KINDS`] by one line.

mod arrival;
mod asynchronous;
mod axis_shift;
mod backlash;
mod ball_seat;
mod bar_change;
mod bar_sag;
mod beat;
mod candidates;
mod channel;
mod clamp_lift;
mod compensation;
mod compliance;
mod context;
mod contract;
mod control_centre;
mod curve_driver;
mod free_curves;
mod friction_heat;
mod gravity;
mod harmonics;
mod history;
mod imbalance;
mod inertia;
mod load_frame;
mod local_error;
mod memory;
mod moment;
mod mount_drift;
mod named_ball;
mod repeatability;
mod reversal_spike;
mod sensor_gain;
mod showing_test;
mod slide;
mod slip;
mod straightness;
mod surface_form;
mod thermal;
mod timing;
mod unknown;
mod vibration;
mod weight;

pub(crate) use backlash::ROTARY_BACKLASH;
pub use candidates::{CandidateFamily, Observations, PRESENT, Refined, Ripple};
pub(crate) use candidates::{DESCRIBED_BY_CURVE, DESCRIBED_BY_NAME, UNLISTED_BY_CURVES};
pub use context::{Context, Profile};
pub use contract::{
    Bounds, DefaultValue, Documented, Driver, EffectError, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen,
};
pub(crate) use harmonics::{CYCLIC_ERROR, ROTARY_ERROR_MOTION, wave_numbers};
pub use memory::{MemoryLaw, Past};
pub use named_ball::NamedBall;
pub(crate) use named_ball::name_place;
pub use showing_test::{ShowingTest, ShownBy};
pub(crate) use straightness::STRAIGHTNESS;
pub use thermal::ROTARY;
pub(crate) use thermal::{COLD, OWN, SLIDES, THERMAL_GROWTH, WARM};
pub(crate) use unknown::UNKNOWN;
pub(crate) use vibration::VIBRATION;
pub use weight::WEIGHT_COMPLIANCE;

use crate::machine::{Effect, Machine};

/// The catalogue.
pub static KINDS: &[&Kind] = &[
    &backlash::ROTARY_BACKLASH,
    &backlash::LINEAR_BACKLASH,
    &backlash::LATERAL_PLAY,
    &reversal_spike::REVERSAL_SPIKE,
    &harmonics::ROTARY_ERROR_MOTION,
    &asynchronous::ASYNCHRONOUS_ERROR_MOTION,
    &harmonics::CYCLIC_ERROR,
    &local_error::LOCAL_ERROR,
    &imbalance::IMBALANCE,
    &surface_form::SURFACE_FORM,
    &sensor_gain::SENSOR_GAIN,
    &beat::BEAT,
    &gravity::GRAVITY_SAG,
    &compliance::LOAD_COMPLIANCE,
    &weight::WEIGHT_COMPLIANCE,
    &thermal::THERMAL_GROWTH,
    &thermal::BAR_LENGTH,
    &bar_change::BAR_CHANGE,
    &bar_sag::BAR_SAG,
    &straightness::STRAIGHTNESS,
    &clamp_lift::CLAMP_LIFT,
    &slide::SQUARENESS,
    &slide::LINEAR_SCALE,
    &timing::SERVO_LAG,
    &arrival::ARRIVAL_LAG,
    &timing::RADIUS_LOSS,
    &inertia::INERTIA_DEFLECTION,
    &timing::TRIGGER_LATENCY,
    &slip::PIVOT_SLIP,
    &slip::BALL_SLIP,
    &axis_shift::AXIS_SHIFT,
    &repeatability::REPEATABILITY,
    &mount_drift::MOUNT_DRIFT,
    &ball_seat::BALL_FORM,
    &ball_seat::CUP_STICTION,
    &vibration::VIBRATION,
    &control_centre::CONTROL_CENTRE,
    &compensation::COMPENSATION,
    &unknown::TABLE,
    &unknown::UNKNOWN,
];

/// The kind with this name.
pub fn kind(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.name == name).copied()
}

/// The law of an effect and the axis whose travel drives it; `None` where it has no memory, or one of times too.
pub fn memory(machine: &Machine, effect: &Effect) -> Option<(MemoryLaw, usize)> {
    let axis = effect.place.axis()?;
    backlash::law(machine, effect, axis).or_else(|| Some((reversal_spike::law(machine, effect, axis)?, axis)))
}

/// What kind of trace the effect with this name leaves; `None` for names that are no effect's.
pub fn signature(name: &str) -> Option<Signature> {
    kind(name).map(|kind| kind.signature)
}

/// Whether the effect with this name leaves such a trace.
pub fn is_a(name: &str, signature: Signature) -> bool {
    self::signature(name) == Some(signature)
}

/// Names of all kinds, for messages.
pub fn kind_names() -> Vec<&'static str> {
    KINDS.iter().map(|kind| kind.name).collect()
}
