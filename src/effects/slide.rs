//! Errors that grow with a slide's position: squareness and scale. Periodic and local errors have files of their own.

use super::candidates::{CandidateFamily, Observations, directions, none};
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, no_check,
    plain_measure, single_function,
};
use super::showing_test::{ShowingTest, ShownBy};
use crate::machine::{AxisKind, Component, Outlet, Place};
use crate::units::Measure;

/// Squareness of a slide: a location error under the name by which it is found.
pub static SQUARENESS: Kind = Kind {
    name: "squareness",
    driver: Driver::Position,
    formula: "location error E(A,B,C)0 of the slide",
    size_meaning: "angle out of square",
    cause: "alignment of guideways to each other, foundation settled, collision",
    remedy: "level the bed, realign the slide, or set the control's squareness compensation",
    titles: &[("", "{place} is out of square ({moving})")],
    measures: Some(""),
    notable: Notable { length: 5.0, angle: 5.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::Circles },
    unseen: Unseen::Listed,
    unmoved: &[AxisKind::Linear],
    form_error: 0.01,
    needs_runs: false,
    signature: Signature::Squareness,
    candidates: tilts,
    candidates_of_poses: none,
    documented: Documented {
        place: "slide",
        components: "location errors (EC0Y)",
        functions: "1",
        parameters: "–",
        unit: "arcsec",
    },
    parameters: &[],
    check: no_check,
    outlets: |machine, place| match place {
        Place::Axis(axis) if machine.axes[axis].kind == AxisKind::Linear => {
            let own = machine.axes[axis].own_component().direction_index();
            let turns = Component::ALL.into_iter().filter(|c| c.is_angle() && c.direction_index() != own);
            turns.map(|component| Outlet::Location { axis, component }).collect()
        }
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions: single_function,
    profiles: |context, _| Ok(vec![context.profile(|_, _| 1.0)]),
};

/// Scale of a slide.
pub static LINEAR_SCALE: Kind = Kind {
    name: "linear-scale",
    driver: Driver::Position,
    formula: "own = s q (1 + curvature (q/2 - centre)): dE/dq = s (1 + curvature (q - centre))",
    size_meaning: "length error per length",
    cause: "temperature of scale or screw, pitch compensation missing or doubled",
    remedy: "check the scale's temperature and mounting, then set pitch compensation against an interferometer",
    titles: &[("", "Scale of {place} is wrong")],
    measures: Some(""),
    notable: Notable { length: 10.0, angle: 10.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::Circles },
    unseen: Unseen::Listed,
    unmoved: &[AxisKind::Linear],
    form_error: 0.013,
    needs_runs: false,
    signature: Signature::Scale,
    candidates: scales,
    candidates_of_poses: none,
    documented: Documented {
        place: "slide",
        components: "own",
        functions: "q (1 + curvature · (q/2 − centre)): s is the error per length at `centre`, larger by the share `curvature` a metre on",
        parameters: "`curvature` (1/m), `centre`",
        unit: "um/m",
    },
    parameters: &[
        Parameter::number(
            "curvature",
            ParameterUnit::Plain,
            DefaultValue::Number(0.0),
            (-100.0, 100.0),
            "share by which the error per length is larger a metre on: a screw warmer at one end",
        ),
        Parameter::number(
            "centre",
            ParameterUnit::Position,
            DefaultValue::Number(0.0),
            (-1e5, 1e5),
            "position at which the size holds, mm",
        ),
    ],
    check: no_check,
    outlets: |machine, place| match place {
        Place::Axis(axis) if machine.axes[axis].kind == AxisKind::Linear => vec![Outlet::own(machine, axis)],
        _ => Vec::new(),
    },
    measure: |_, _, _| Measure::Strain,
    functions: single_function,
    profiles: |context, effect| match effect.place {
        Place::Axis(axis) => {
            let sign = context.chain().joint(axis).sign;
            let number = |name| LINEAR_SCALE.number(context, effect, name);
            let (per_mm, centre) = (1e-3 * number("curvature"), number("centre"));
            Ok(vec![context.position_profile(axis, |q| sign * q * (1.0 + per_mm * (0.5 * q - centre)))])
        }
        _ => Ok(Vec::new()),
    },
};

/// Squareness up to this is plausible, arcsec: 0.2 mm/m, ten times what a machine in use has.
const PLAUSIBLE_ARCSEC: f64 = 40.0;

/// A scale up to this is plausible, µm/m: ten kelvins of steel.
const PLAUSIBLE_UM_PER_M: f64 = 120.0;

/// Squareness errors by which a machine's coordinates are customarily fixed: of Y, and of Z (directions of R: 0, 1, 2).
const CUSTOMARY: [(Component, usize); 3] = [(Component::EC, 1), (Component::EB, 2), (Component::EA, 2)];

fn tilts(seen: &Observations) -> Vec<CandidateFamily> {
    let axes = &seen.machine().axes;
    let of_axis = |axis: usize| {
        let along = axes[axis].coordinate_direction();
        directions(seen.machine(), axis).tilts.map(|component| {
            let is_customary = CUSTOMARY.iter().any(|(c, k)| *c == component && along == Some(*k));
            let outlets = vec![Outlet::Location { axis, component }];
            let budget = Measure::Angle.to_output(seen.machine().linear_axes.squareness_rad);
            CandidateFamily::new(SQUARENESS.name, Place::Axis(axis), outlets, PLAUSIBLE_ARCSEC)
                .ranked(usize::from(!is_customary))
                .within(budget)
        })
    };
    seen.displaced_slides().flat_map(|(axis, _)| of_axis(axis)).collect()
}

fn scales(seen: &Observations) -> Vec<CandidateFamily> {
    let own = |axis: usize| vec![Outlet::own(seen.machine(), axis)];
    let budget = Measure::Strain.to_output(seen.machine().linear_axes.positioning);
    let scale =
        |axis| CandidateFamily::new(LINEAR_SCALE.name, Place::Axis(axis), own(axis), PLAUSIBLE_UM_PER_M).within(budget);
    seen.displaced_slides().map(|(axis, _)| scale(axis)).collect()
}
