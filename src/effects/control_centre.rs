//! A control that holds a rotary axis to be elsewhere than it is: an offset that acts only while slides follow that axis. Where the
//! axis really stands are its location errors; a compensation that was entered twice or reversed is in `compensation`.
//!
//! A slide that follows about a centre `d` beside the true one leads the tool to `c + d + R(q)(p − c − d)`, which is
//! `(1 − R(q)) d` beside the place meant. Seen from the table, in the directions of its carrier, the table is moved by
//! `(R(q) − 1) d`: `cos q − 1` and `sin q` through the two components across the axis.
//!
//! It needs a session that states the path meant (`sweep`, `follow`): positions read from the control hold the offset themselves.

use super::backlash::across;
use super::candidates::{CandidateFamily, Observations, directions, motion, none};
use super::context::Profile;
use super::contract::{Documented, Driver, Kind, Notable, Signature, Unseen, no_check, plain_measure};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::machine::{AxisKind, Effect, Machine, Place};

/// A wrong rotary centre in the control.
pub static CONTROL_CENTRE: Kind = Kind {
    name: "control-centre",
    driver: Driver::Position,
    formula: "E = a (cos q - 1) + b sin q across the axis, in tests in which slides move with it",
    size_meaning: "largest shift of the table against the slides (on a full turn twice the offset of the centre)",
    cause: "the kinematics of the control hold another place of the axis than the one where it stands: not updated after an alignment, wrong sign or units",
    remedy: "compare the centre in the control with the location errors identified from tests in which no slide moves, correct it, repeat one following sweep",
    titles: &[("", "While slides follow {place}, they turn about another centre ({moving})")],
    measures: Some("at its largest"),
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy { arm: None, rotary: Some(ShowingTest::Tangential), other: ShowingTest::Circles },
    unseen: Unseen::Never,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: true,
    signature: Signature::Course,
    candidates: followed,
    candidates_of_poses: none,
    documented: Documented {
        place: "rotary axis",
        components: "all but own",
        functions: "`cos = cos q − 1`, `sin = sin q` in tests in which a slide moves with the axis",
        parameters: "–",
        unit: "um",
    },
    parameters: &[],
    check: no_check,
    outlets: |machine, place| match place {
        Place::Axis(axis) if machine.axes[axis].kind == AxisKind::Rotary && has_slides(machine) => {
            across(machine, place)
        }
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions: |_| vec!["cos".into(), "sin".into()],
    profiles,
};

fn has_slides(machine: &Machine) -> bool {
    machine.axes.iter().any(|axis| axis.kind == AxisKind::Linear)
}

/// Whether slides move with an axis in a test.
fn follows(context: &Context, axis: usize, test: usize) -> bool {
    let moving = &context.motion(test).moving;
    moving.contains(&axis) && moving.iter().any(|&other| context.machine().axes[other].kind == AxisKind::Linear)
}

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let Place::Axis(axis) = effect.place else { return Ok(Vec::new()) };
    let sign = context.chain().joint(axis).sign;
    let of = |value: fn(f64) -> f64| {
        context.profile(|test, row| match follows(context, axis, test) {
            true => value(sign * context.motion(test).row(row)[axis]),
            false => 0.0,
        })
    };
    Ok(vec![of(|q| q.cos() - 1.0), of(f64::sin)])
}

/// Log odds against a control that was set up wrongly beside wear and heat.
const SET_UP_WELL: f64 = 2.0;

/// Largest plausible distance, µm.
const PLAUSIBLE: f64 = 100.0;

fn followed(seen: &Observations) -> Vec<CandidateFamily> {
    let is_followed = |axis: &usize| (0..seen.context.tests()).any(|test| follows(seen.context, *axis, test));
    let of_axis = |axis: usize| {
        let outlets = motion(axis, &directions(seen.machine(), axis).across);
        CandidateFamily::new(CONTROL_CENTRE.name, Place::Axis(axis), outlets, PLAUSIBLE).rare(SET_UP_WELL)
    };
    seen.axes(AxisKind::Rotary).filter(is_followed).map(of_axis).collect()
}
