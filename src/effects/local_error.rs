//! Errors of an axis's own motion about one of its positions: dirt on a scale or an encoder disc, a damaged tooth. What repeats along
//! the axis is in `harmonics`.
//!
//! `E = s (1 + cos 2π(q − c)/w) / 2` within w/2 of the centre c, zero outside; on a rotary axis q − c is the nearest way round. With
//! a skew k the rising half is `w (1 + k) / 2` wide and the falling one `w (1 − k) / 2`.

use super::candidates::{CandidateFamily, Observations, Refined, none};
use super::context::Profile;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, no_check,
    plain_measure,
};
use super::showing_test::{ShowingTest, ShownBy};
use super::straightness::{SKEW, bumps, raised_cosine};
use super::{Context, EffectError};
use crate::machine::{AxisKind, Effect, Outlet, Place};
use std::f64::consts::{PI, TAU};

/// Positioning error about one position.
pub static LOCAL_ERROR: Kind = Kind {
    name: "local-positioning-error",
    driver: Driver::Position,
    formula: "own = s (1 + cos 2 pi (q - c)/w)/2 near c",
    size_meaning: "height of the bump",
    cause: "dirt or a scratch on the scale or encoder disc, a damaged tooth of worm or gear, a dent in the screw",
    remedy: "clean scale and reading head, inspect tooth or screw at that position; compensate by a table if it repeats",
    titles: &[("", "{place} is off about one position")],
    measures: Some("at its highest"),
    notable: Notable { length: 1.5, angle: 2.0 },
    shown_by: ShownBy { arm: None, rotary: Some(ShowingTest::Tangential), other: ShowingTest::Circles },
    // a bump may lie anywhere: `unknown` lists the axes whose own motion would not show
    unseen: Unseen::Never,
    unmoved: &[],
    // no damage has the form of a raised cosine: as the bumps of a guideway
    form_error: 0.07,
    needs_runs: false,
    signature: Signature::Straightness,
    candidates: local_errors,
    candidates_of_poses: none,
    documented: Documented {
        place: "any axis",
        components: "own",
        functions: "`bump = (1 + cos 2π(q−c)/w)/2` within w/2 of c, on a rotary axis the nearest way round",
        parameters: "`centre`, `width`, `skew`",
        unit: "arcsec, um",
    },
    parameters: &[
        Parameter::number(
            "centre",
            ParameterUnit::Position,
            DefaultValue::Required,
            (-1e5, 1e5),
            "where it is largest, mm or deg",
        ),
        Parameter::number(
            "width",
            ParameterUnit::Position,
            DefaultValue::Number(20.0),
            (1e-3, 1e5),
            "width between its feet, mm or deg",
        ),
        SKEW,
    ],
    check: no_check,
    outlets: |machine, place| match place {
        Place::Axis(axis) => vec![Outlet::own(machine, axis)],
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions: |_| vec!["bump".into()],
    profiles,
};

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let Place::Axis(axis) = effect.place else { return Ok(Vec::new()) };
    let number = |name| LOCAL_ERROR.number(context, effect, name);
    let (centre, width, skew) = (number("centre"), number("width"), number("skew"));
    let turns = context.machine().axes[axis].kind == AxisKind::Rotary;
    let from_centre = |q: f64| if turns { (q - centre + PI).rem_euclid(TAU) - PI } else { q - centre };
    Ok(vec![context.position_profile(axis, |q| raised_cosine(from_centre(q), width / 2.0, skew))])
}

/// Heights up to this are plausible, arcsec or µm.
const PLAUSIBLE: f64 = 30.0;

/// Widths that are tried, as shares of the way.
const WIDTHS: [f64; 5] = [0.5, 0.25, 0.12, 0.06, 0.03];

fn local_errors(seen: &Observations) -> Vec<CandidateFamily> {
    // single poses stand on few positions of a joint: a bump would fit what is left of any of them
    if !seen.context.has_sweeps() {
        return Vec::new();
    }
    let moving = [AxisKind::Rotary, AxisKind::Linear].into_iter().flat_map(|kind| seen.moving(kind));
    moving.map(|(axis, ends)| of_axis(seen, axis, ends)).collect()
}

/// Bumps along the way of an axis, at most a turn.
fn of_axis(seen: &Observations, axis: usize, (from, to): (f64, f64)) -> CandidateFamily {
    let (place, entry) = (Place::Axis(axis), &seen.machine().axes[axis]);
    let span = match entry.kind {
        AxisKind::Rotary => (to - from).min(TAU),
        AxisKind::Linear => to - from,
    };
    let widths = WIDTHS.map(|share| share * span);
    let grid = bumps(LOCAL_ERROR.name, place, from, &widths, |centre| centre < from + span);
    let shape = vec![
        Refined::number("centre", (from - 0.1 * span, from + 1.1 * span), 0.02 * span),
        Refined::number("width", (0.01 * span, span), 0.03 * span),
        Refined::number("skew", (-0.8, 0.8), 0.2),
    ];
    let own = vec![Outlet::own(seen.machine(), axis)];
    CandidateFamily::new(LOCAL_ERROR.name, place, own, PLAUSIBLE).over(grid).refine(shape).turning_within_rows()
}
