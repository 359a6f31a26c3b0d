//! A displacement sensor whose scale is off: what it reads is a share more or less than the displacement. Capacitive and eddy-current sensors
//! are calibrated for one material and a flat face.
//!
//! `reading = distance + s (distance − d₀)`, d₀ the distance with all axes at zero, which belongs to the sensor's zero. One scale of all sensors is
//! the size of what they see, or the scale of the axis that moves it: of several sensors the scales against each other show.

use super::candidates::{CandidateFamily, Observations, none};
use super::context::Profile;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, Signature, Unseen, no_check, plain_measure,
    single_function, word,
};
use super::named_ball::{self, NamedBall, naming};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::chain::Geometry;
use crate::machine::{Effect, Outlet, ParameterValue, Place};
use crate::readings::Kind as Readings;
use crate::session::{Ball, Test};

/// Scale of a displacement sensor.
pub static SENSOR_GAIN: Kind = Kind {
    name: "sensor-gain",
    driver: Driver::Position,
    formula: "reading = distance + s (distance - d0), d0 with all axes at zero",
    size_meaning: "largest change of a reading",
    cause: "the sensor was calibrated for another material, another form of the face, another range or amplifier",
    remedy: "calibrate the sensor against a micrometer on the part that it looks at",
    titles: &[("", "A displacement sensor reads a share too much or too little")],
    measures: Some("at its largest"),
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
        functions: "distance of the nominal chain less that with all axes at zero, mm: a size of 1 um is 0.1 %",
        parameters: "`link`, `setup` or `at`",
        unit: "um",
    },
    parameters: &PARAMETERS,
    check: no_check,
    outlets: |_, place| if place == Place::Pivot { vec![Outlet::Reading] } else { Vec::new() },
    measure: plain_measure,
    functions: single_function,
    profiles,
};

/// Sensors are named by their tag, for those that are zeroed at the same pose stand at one place; else by their place.
const SETUP: &str = "setup";

static PARAMETERS: [Parameter; 3] = {
    let [link, at] = named_ball::parameters(
        "link of the sensor concerned",
        "place of the sensor concerned, mm; without link, at and setup: all of them",
    );
    [link, at, Parameter::word(SETUP, &[], DefaultValue::Absent, "tag of the sensor concerned")]
};

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let (ball, setup) = (NamedBall::of(effect), word(effect, SETUP));
    let is_concerned = |sensor: &Ball| ball.is(sensor) && setup.is_none_or(|tag| sensor.setup.as_deref() == Some(tag));
    let tests = context.session().tests.iter().enumerate();
    let distances = tests.map(|(test, entry)| distances_mm(context, test).filter(|_| is_concerned(&entry.pivot)));
    let distances: Vec<Option<Vec<f64>>> = distances.collect();
    Ok(vec![context.profile(|test, row| distances[test].as_ref().map_or(0.0, |rows| rows[row]))])
}

/// What the nominal chain displaces the point along the sensor of a test from where it is with all axes at zero, mm, by row; `None` of other
/// readings.
fn distances_mm(context: &Context, test: usize) -> Option<Vec<f64>> {
    let (chain, entry) = (context.chain(), &context.session().tests[test]);
    let part = entry.reading.part().filter(|part| part.kind == Readings::Displacement)?;
    let (sensor, point) = (chain.link(&entry.pivot.link)?, chain.link(&entry.spindle_ball.link)?);
    let (geometry, motion) = (Geometry::nominal(chain), context.motion(test));
    let along = part.instrument_axes.column(0).into_owned();
    let distance = |positions: &[f64]| {
        let frame = geometry.pose(sensor, positions, None);
        let way = geometry.pose(point, positions, None).point(&entry.spindle_ball.at) - frame.point(&entry.pivot.at);
        (frame.rotation * along).dot(&way)
    };
    let at_zero = distance(&vec![0.0; motion.axis_count]);
    Some((0..motion.rows()).map(|row| distance(motion.row(row)) - at_zero).collect())
}

/// Changes of a reading up to this are plausible, µm: a sensor on another metal than its own is off by tens of percent.
const PLAUSIBLE: f64 = 300.0;

/// Every sensor, where several see one target: the scale of one alone is that of the axis that moves what it sees.
fn scales(seen: &Observations) -> Vec<CandidateFamily> {
    let tests = &seen.context.session().tests;
    let is_sensor = |test: &Test| test.reading.part().is_some_and(|part| part.kind == Readings::Displacement);
    let sees_same = |test: &Test, other: &Test| {
        (&test.spindle_ball.link, &test.spindle_ball.setup) == (&other.spindle_ball.link, &other.spindle_ball.setup)
    };
    let sensors = || seen.setups.pivots.iter().map(|setup| &tests[setup.first_test]).filter(|test| is_sensor(test));
    let of_sensor = |test: &Test| {
        let named = Effect::new(SENSOR_GAIN.name, Place::Pivot);
        let effect = match &test.pivot.setup {
            Some(tag) => {
                let link = ParameterValue::Word(test.pivot.link.clone());
                named.with("link", link).with(SETUP, ParameterValue::Word(tag.clone()))
            }
            None => naming(named, &test.pivot),
        };
        CandidateFamily::new(SENSOR_GAIN.name, Place::Pivot, vec![Outlet::Reading], PLAUSIBLE).over(vec![effect])
    };
    let is_beside_others = |test: &&Test| sensors().filter(|other| sees_same(test, other)).count() > 1;
    sensors().filter(is_beside_others).map(of_sensor).collect()
}
