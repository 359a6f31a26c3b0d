//! Deflection under the acceleration of a slide: a column or a carriage leans back as the drive pushes it off its centre of mass.
//! What the position loop loses along the motion is `radius-loss` in `timing`.
//!
//! `E = s·a`, a the slide's acceleration in mm/s². On a circle a = −v²·(q − centre)/radius²: at one feed it is as good as linear in the
//! position, and told from squareness and straightness by a second feed alone.

use super::Context;
use super::backlash::across;
use super::candidates::{CandidateFamily, Observations, beside_own, motion, none};
use super::contract::{Documented, Driver, Kind, Notable, Signature, Unseen, no_check, plain_measure};
use super::showing_test::{ShowingTest, ShownBy};
use crate::machine::{AxisKind, Place};

/// Motion of a slide beside its own in proportion to its acceleration.
pub static INERTIA_DEFLECTION: Kind = Kind {
    name: "inertia-deflection",
    driver: Driver::Speed,
    formula: "E = s a",
    size_meaning: "deflection per mm/s² of acceleration",
    cause: "column, carriage or table driven off its centre of mass, soft guideways or feet",
    remedy: "lower feed or jerk on precise paths, check preload of the guideways and the feet; measure at the feed of use",
    titles: &[("", "{place} deflects as it accelerates ({moving})")],
    measures: Some("per mm/s²"),
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::TwoFeeds },
    unseen: Unseen::Never,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: true,
    signature: Signature::Radius,
    candidates: deflections,
    candidates_of_poses: none,
    documented: Documented {
        place: "slide",
        components: "all but own",
        functions: "a, its acceleration in mm/s²",
        parameters: "–",
        unit: "um, arcsec per mm/s²",
    },
    parameters: &[],
    check: no_check,
    outlets: |machine, place| match place {
        Place::Axis(axis) if machine.axes[axis].kind == AxisKind::Linear => across(machine, place),
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions: |_| vec!["a".into()],
    profiles: |context: &Context, effect| {
        let Place::Axis(axis) = effect.place else { return Ok(Vec::new()) };
        Ok(vec![context.profile(|test, row| context.acceleration(test, row, axis))])
    },
};

/// Deflections up to this per mm/s² are plausible, µm or arcsec.
const PLAUSIBLE: f64 = 20.0;

/// Log odds against it, one in fifty: ball bars run at accelerations of a few mm/s², which bend few machines.
const RARE: f64 = 3.9;

fn deflections(seen: &Observations) -> Vec<CandidateFamily> {
    let of_slide = |(axis, _)| {
        beside_own(seen.machine(), axis).map(|component| {
            let family =
                CandidateFamily::new(INERTIA_DEFLECTION.name, Place::Axis(axis), motion(axis, &[component]), PLAUSIBLE);
            family.rare(RARE)
        })
    };
    seen.moving(AxisKind::Linear).flat_map(of_slide).collect()
}
