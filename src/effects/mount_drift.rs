//! The place of an instrument or a socket that wanders while poses are read: a stand that settles, a plate that the arm pushes along. A ball that moved at once is in `slip`.
//!
//! `displacement = s p`, p from 0 at the first pose of a recording to 1 at its last, by their numbers. Where it stood at first belongs to
//! its place; a walk is told by its slope.

use super::candidates::{CandidateFamily, Observations, none};
use super::context::Profile;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, ShowingTest, ShownBy, Signature, Unseen,
    list, no_check, plain_measure, single_function, word,
};
use super::{Context, EffectError};
use crate::machine::{Effect, Outlet, ParameterValue, Place};
use crate::session::{Ball, Setup};
use nalgebra::Vector3;

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
    parameters: &[
        Parameter::word("link", &[], DefaultValue::Absent, "link of the instrument or socket concerned"),
        Parameter {
            name: "at",
            unit: ParameterUnit::Plain,
            count: 3,
            default: DefaultValue::Absent,
            bounds: (-1e6, 1e6),
            meaning: "place of the instrument or socket concerned, mm; without link and at: all of them",
        },
    ],
    check: no_check,
    outlets: |_, place| {
        if place == Place::Pivot { (0..3).map(Outlet::Pivot).collect() } else { Vec::new() }
    },
    measure: plain_measure,
    functions: single_function,
    profiles,
};

/// Places closer than this are one place, mm.
const SAME_PLACE_MM: f64 = 1e-3;

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let at = match list(effect, "at") {
        [x, y, z] => Some(Vector3::new(*x, *y, *z)),
        _ => None,
    };
    let link = word(effect, "link");
    let concerned = |ball: &Ball| {
        at.is_none_or(|at| (ball.at - at).norm() < SAME_PLACE_MM) && link.is_none_or(|link| ball.link == link)
    };
    Ok(vec![context.profile(|test, row| {
        let entry = &context.session().tests[test];
        if entry.reading.is_gap() || !concerned(&entry.pivot) {
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
        let ball = &test.pivot;
        let effect = Effect::new(MOUNT_DRIFT.name, Place::Pivot)
            .with("link", ParameterValue::Word(ball.link.clone()))
            .with("at", ParameterValue::List(vec![ball.at.x, ball.at.y, ball.at.z]));
        let outlets = (0..3).map(Outlet::Pivot).collect();
        Some(CandidateFamily::new(MOUNT_DRIFT.name, Place::Pivot, outlets, PLAUSIBLE).over(vec![effect]))
    };
    seen.setups.pivots.iter().filter_map(of_setup).collect()
}
