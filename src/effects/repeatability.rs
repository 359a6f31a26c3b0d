//! An axis that does not come back to the same place: it stands or runs elsewhere in every test. What returns as the direction of
//! motion does is in `backlash`; what moves once in a session is in `axis_shift`.
//!
//! `E = s_t` in test t: the spread of the s_t is the repeatability of positioning of ISO 230-2 for its own motion, and that of
//! its clamping or of its bearing across it.

use super::candidates::{CandidateFamily, Observations, directions, motion, none};
use super::contract::{
    Documented, Driver, Kind, Notable, Signature, Unseen, no_check, of_any_axis, plain_measure, single_function,
};
use super::showing_test::{ShowingTest, ShownBy};
use crate::machine::{AxisKind, Outlet, Place};

/// Repeatability of positioning.
pub static REPEATABILITY: Kind = Kind {
    name: "repeatability",
    driver: Driver::Time,
    formula: "E = s, of each test its own s",
    size_meaning: "rms of the tests",
    cause: "clamp, brake or reference that takes hold elsewhere each time, a loose bearing or key, stick-slip as the axis stops",
    remedy: "measure unidirectional repeatability of that axis (ISO 230-2), with and without its clamp",
    titles: &[("", "{place} stands elsewhere from test to test ({moving})")],
    measures: Some("rms of the tests"),
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::RepeatAtEnd },
    unseen: Unseen::Never,
    unmoved: &[],
    form_error: 0.05,
    needs_runs: true,
    signature: Signature::Course,
    candidates: places,
    candidates_of_poses: none,
    documented: Documented {
        place: "any axis",
        components: "all",
        functions: "1",
        parameters: "– (`tests`: each test has a size of its own)",
        unit: "um, arcsec",
    },
    parameters: &[],
    check: no_check,
    outlets: of_any_axis,
    measure: plain_measure,
    functions: single_function,
    profiles: |context, _| Ok(vec![context.profile(|_, _| 1.0)]),
};

/// Displacements up to this are plausible, µm or arcsec.
const PLAUSIBLE: f64 = 30.0;
/// Log odds against it beside what repeats or happens once: the zero of a gauge differs from test to test as well.
const LOG_ODDS_AGAINST: f64 = 15.0;
/// Tests from which on what differs from test to test is told from what happens once.
const LEAST_TESTS: usize = 4;

fn places(seen: &Observations) -> Vec<CandidateFamily> {
    if seen.context.tests() < LEAST_TESTS {
        return Vec::new();
    }
    let family = |axis: usize, outlets: Vec<Outlet>| {
        CandidateFamily::new(REPEATABILITY.name, Place::Axis(axis), outlets, PLAUSIBLE)
            .rare(LOG_ODDS_AGAINST)
            .by_test((0..seen.context.tests()).collect())
    };
    let machine = seen.machine();
    let of_axis = |axis: usize| {
        let d = directions(machine, axis);
        let own = vec![Outlet::own(machine, axis)];
        let outlets = match machine.axes[axis].kind {
            AxisKind::Rotary => {
                let single = d.across.map(|component| motion(axis, &[component]));
                [own, motion(axis, &[d.along])].into_iter().chain(single).collect()
            }
            AxisKind::Linear => vec![own],
        };
        outlets.into_iter().map(move |outlets| family(axis, outlets)).collect::<Vec<_>>()
    };
    (0..machine.axes.len()).flat_map(of_axis).collect()
}
