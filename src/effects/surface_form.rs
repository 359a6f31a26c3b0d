//! The form of a turning surface that displacement sensors see: it turns with the part, so that sensors about it see it one after the other.
//!
//! `reading = Σ_n a_n cos n ψ + b_n sin n ψ`, ψ where on the part the sensor points: its direction seen from the part. Error motion of the
//! axis moves all sensors at once by its component along each; with three sensors about the surface the two are told apart
//! (Donaldson 1972; Whitehouse 1976), but for order 1, which is the surface's eccentricity. Form along the axis is not modelled.

use nalgebra::{Matrix3, Vector3};

use super::candidates::{CandidateFamily, Observations, none, with_list};
use super::context::Profile;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, list, no_check,
    plain_measure,
};
use super::load_frame::of_link;
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::machine::{AxisKind, Effect, Outlet, Place};
use crate::readings::Kind as Readings;

/// Form of a surface under displacement sensors.
pub static SURFACE_FORM: Kind = Kind {
    name: "surface-form",
    driver: Driver::Position,
    formula: "reading = sum a_n cos n psi + b_n sin n psi, psi where on the part the sensor points",
    size_meaning: "amplitude of an order",
    cause: "the surface that the sensors see is not round: it is no error of the axis",
    remedy: "take it out of the readings, or use a round artefact",
    titles: &[("", "Form of the surface on {place} that the sensors see")],
    measures: Some("at its largest"),
    notable: Notable { length: 1.0, angle: 2.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::BothWays },
    unseen: Unseen::Never,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: true,
    signature: Signature::ErrorMotion,
    candidates: seen_by_sensors,
    candidates_of_poses: none,
    documented: Documented {
        place: "rotary axis",
        components: "`length`",
        functions: "`cosN`, `sinN` of N ψ, ψ where on the part the sensor points",
        parameters: "`orders`",
        unit: "um",
    },
    parameters: &[Parameter::list(
        "orders",
        ParameterUnit::Plain,
        DefaultValue::Required,
        (2.0, 1e4),
        "periods per turn, from 2 on",
    )],
    check: no_check,
    outlets: |machine, place| match place {
        Place::Axis(axis) if machine.axes[axis].kind == AxisKind::Rotary => vec![Outlet::Reading],
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions: |effect| {
        list(effect, "orders").iter().flat_map(|order| [format!("cos{order}"), format!("sin{order}")]).collect()
    },
    profiles,
};

/// Sensors that point nearer to the axis line than this (sine of the angle between them) see no form about it.
const ALONG_THE_AXIS: f64 = 0.5;

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let Place::Axis(axis) = effect.place else { return Ok(Vec::new()) };
    let angles = angles(context, axis);
    let of = |value: &dyn Fn(f64) -> f64| {
        context.profile(|test, row| angles[test].as_ref().map_or(0.0, |angles| value(angles[row])))
    };
    let orders = list(effect, "orders").iter();
    Ok(orders.flat_map(|order| [of(&|psi| (order * psi).cos()), of(&|psi| (order * psi).sin())]).collect())
}

/// Where on the part that an axis carries the sensor of a test points, rad, by row; `None` for tests that do not look at it from aside.
fn angles(context: &Context, axis: usize) -> Vec<Option<Vec<f64>>> {
    let chain = context.chain();
    let part_turned = of_link(context, chain.carried_by(axis));
    let line = context.machine().axes[axis].direction;
    let first = (Vector3::ith(line.iamin(), 1.0) - line * line[line.iamin()]).normalize();
    let second = line.cross(&first);
    let in_test = |test: usize| {
        let entry = &context.session().tests[test];
        let part = entry.reading.part().filter(|part| part.kind == Readings::Displacement)?;
        let target = chain.link(&entry.spindle_ball.link)?;
        let instrument = chain.link(&entry.pivot.link)?;
        if !chain.carries(axis, target) || chain.carries(axis, instrument) {
            return None;
        }
        let sensor_turned = of_link(context, instrument);
        let points = part.instrument_axes.column(0).into_owned();
        let seen = |(sensor, part): (&Matrix3<f64>, &Matrix3<f64>)| part.transpose() * (sensor * points);
        let directions: Vec<Vector3<f64>> = sensor_turned[test].iter().zip(&part_turned[test]).map(seen).collect();
        let is_aside = directions.iter().all(|direction| direction.cross(&line).norm() > ALONG_THE_AXIS);
        is_aside.then(|| directions.iter().map(|to| to.dot(&second).atan2(to.dot(&first))).collect())
    };
    (0..context.tests()).map(in_test).collect()
}

/// Orders of the form of a surface: few, some, many.
const FORM_ORDERS: [usize; 3] = [3, 6, 12];

/// Sizes up to this are plausible, µm: a large rotor is rough beside a machine tool.
const PLAUSIBLE: f64 = 300.0;

fn seen_by_sensors(seen: &Observations) -> Vec<CandidateFamily> {
    let of_axis = |axis: usize| {
        let place = Place::Axis(axis);
        let up_to =
            |most: usize| with_list(SURFACE_FORM.name, place, "orders", (2..=most).map(|order| order as f64).collect());
        let family = CandidateFamily::new(SURFACE_FORM.name, place, vec![Outlet::Reading], PLAUSIBLE);
        family.over(FORM_ORDERS.map(up_to).to_vec())
    };
    seen.under_sensors().map(of_axis).collect()
}
