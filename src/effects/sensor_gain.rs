//! A displacement sensor whose scale is off: what it reads is a share more or less than the displacement. Capacitive and eddy-current sensors
//! are calibrated for one material and a flat face.
//!
//! `reading = distance + s (distance − m)`, m the mean over the sensor's readings, which belongs to its zero. One scale of all sensors is
//! the size of what they see: of several sensors the scales against each other show.

use super::candidates::{CandidateFamily, Observations, none};
use super::context::Profile;
use super::contract::{Documented, Driver, Kind, Notable, Signature, Unseen, no_check, plain_measure, single_function};
use super::named_ball::{self, NamedBall, naming};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::chain::Geometry;
use crate::machine::{Effect, Outlet, Place};
use crate::readings::Kind as Readings;
use crate::session::Setup;
use crate::statistics::mean;

/// Scale of a displacement sensor.
pub static SENSOR_GAIN: Kind = Kind {
    name: "sensor-gain",
    driver: Driver::Position,
    formula: "reading = distance + s (distance - m), m its mean over the sensor's readings",
    size_meaning: "change of the reading over 1 mm",
    cause: "the sensor was calibrated for another material, another form of the face, another range or amplifier",
    remedy: "calibrate the sensor against a micrometer on the part that it looks at",
    titles: &[("", "A displacement sensor reads a share too much or too little")],
    measures: Some("over 1 mm of displacement"),
    notable: Notable { length: 5.0, angle: 5.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::BothWays },
    unseen: Unseen::Never,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: false,
    signature: Signature::Course,
    candidates: scales,
    candidates_of_poses: none,
    documented: Documented {
        place: "`pivot`",
        components: "`length`",
        functions: "distance of the nominal chain less its mean over the sensor's readings, mm",
        parameters: "`link`, `at`",
        unit: "um",
    },
    parameters: &named_ball::parameters(
        "link of the sensor concerned",
        "place of the sensor concerned, mm; without link and at: all of them",
    ),
    check: no_check,
    outlets: |_, place| if place == Place::Pivot { vec![Outlet::Reading] } else { Vec::new() },
    measure: plain_measure,
    functions: single_function,
    profiles,
};

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let concerned = NamedBall::of(effect);
    let distances = context
        .session()
        .tests
        .iter()
        .enumerate()
        .map(|(test, entry)| if concerned.is(&entry.pivot) { distances_mm(context, test) } else { None });
    let distances: Vec<Option<Vec<f64>>> = distances.collect();
    let middle = mean(distances.iter().flatten().flatten().copied()).unwrap_or_default();
    Ok(vec![context.profile(|test, row| distances[test].as_ref().map_or(0.0, |rows| rows[row] - middle))])
}

/// What the nominal chain displaces the point along the sensor of a test, mm, by row; `None` of other readings.
fn distances_mm(context: &Context, test: usize) -> Option<Vec<f64>> {
    let (chain, entry) = (context.chain(), &context.session().tests[test]);
    let part = entry.reading.part().filter(|part| part.kind == Readings::Displacement)?;
    let (sensor, point) = (chain.link(&entry.pivot.link)?, chain.link(&entry.spindle_ball.link)?);
    let (geometry, motion) = (Geometry::nominal(chain), context.motion(test));
    let along = part.instrument_axes.column(0).into_owned();
    let of_row = |row: usize| {
        let frame = geometry.pose(sensor, motion.row(row), None);
        let way =
            geometry.pose(point, motion.row(row), None).point(&entry.spindle_ball.at) - frame.point(&entry.pivot.at);
        (frame.rotation * along).dot(&way)
    };
    Some((0..motion.rows()).map(of_row).collect())
}

/// Sizes up to this are plausible, µm over 1 mm: a sensor on another metal than its own is off by tens of percent.
const PLAUSIBLE: f64 = 300.0;

/// Every sensor.
fn scales(seen: &Observations) -> Vec<CandidateFamily> {
    let tests = &seen.context.session().tests;
    let of_setup = |setup: &Setup| {
        let test = &tests[setup.first_test];
        test.reading.part().filter(|part| part.kind == Readings::Displacement)?;
        let effect = naming(Effect::new(SENSOR_GAIN.name, Place::Pivot), &test.pivot);
        let family = CandidateFamily::new(SENSOR_GAIN.name, Place::Pivot, vec![Outlet::Reading], PLAUSIBLE);
        Some(family.over(vec![effect]))
    };
    seen.setups.pivots.iter().filter_map(of_setup).collect()
}
