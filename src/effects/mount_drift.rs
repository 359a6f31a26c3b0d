//! The place of an instrument or a socket that wanders while poses are read: a stand that settles, a plate that the arm pushes along. A ball that moved at once is in `slip`.
//!
//! `displacement = s p`, p from 0 at the first pose of a recording to 1 at its last, by their numbers. Where it stood at first belongs to
//! its place; a walk is told by its slope.

use super::candidates::{CandidateFamily, Observations, none};
use super::context::Profile;
use super::contract::{Documented, Driver, Kind, Notable, Signature, Unseen, no_check, plain_measure, single_function};
use super::named_ball::{self, NamedBall, naming};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::machine::{Effect, Outlet, Place};
use crate::session::Setup;

/// Drift of what stands still while the machine takes its poses.
pub static MOUNT_DRIFT: Kind = Kind {
    name: "mount-drift",
    driver: Driver::Time,
    formula: "instrument or socket = s p, p from 0 at the first pose of a recording to 1 at its last",
    size_meaning: "displacement from the first pose to the last",
    cause: "the stand of the instrument or the plate of the socket settles, is pushed, or grows warm",
    remedy: "clamp and rest the stand, repeat the first poses at the end",
    titles: &[("", "The instrument or socket drifts while poses are read")],
    measures: Some("from the first pose to the last"),
    notable: Notable { length: 10.0, angle: 10.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::RepeatAtEnd },
    unseen: Unseen::Never,
    unmoved: &[],
    form_error: 0.1,
    needs_runs: false,
    signature: Signature::Course,
    candidates: none,
    candidates_of_poses: drifts,
    documented: Documented {
        place: "`pivot`",
        components: "`x y z` on its link",
        functions: "`p`, from 0 at the first pose of a recording to 1 at its last, by their numbers",
        parameters: "`link`, `at`",
        unit: "um",
    },
    parameters: &named_ball::parameters(
        "link of the instrument or socket concerned",
        "place of the instrument or socket concerned, mm; without link and at: all of them",
    ),
    check: no_check,
    outlets: |_, place| {
        if place == Place::Pivot { (0..3).map(Outlet::Pivot).collect() } else { Vec::new() }
    },
    measure: plain_measure,
    functions: single_function,
    profiles,
};

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let concerned = NamedBall::of(effect);
    Ok(vec![context.profile(|test, row| {
        let entry = &context.session().tests[test];
        if entry.reading.is_gap() || !concerned.is(&entry.pivot) {
            return 0.0;
        }
        let number = |row: usize| context.pose_number(test, row);
        let (first, last) = (number(0), number(context.motion(test).rows() - 1));
        if last > first { (number(row) - first) / (last - first) } else { 0.0 }
    })])
}

/// Displacements up to this are plausible, µm.
const PLAUSIBLE: f64 = 1000.0;

/// Every instrument and socket that poses were read by.
fn drifts(seen: &Observations) -> Vec<CandidateFamily> {
    let tests = &seen.context.session().tests;
    let of_setup = |setup: &Setup| {
        let test = &tests[setup.first_test];
        test.reading.part()?;
        let effect = naming(Effect::new(MOUNT_DRIFT.name, Place::Pivot), &test.pivot);
        let outlets = (0..3).map(Outlet::Pivot).collect();
        Some(CandidateFamily::new(MOUNT_DRIFT.name, Place::Pivot, outlets, PLAUSIBLE).over(vec![effect]))
    };
    seen.setups.pivots.iter().filter_map(of_setup).collect()
}
