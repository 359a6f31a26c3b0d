//! What a ball and its cup add to the reading of the bar: form of the ball, and friction as a run begins. Seats that move are
//! in `slip`.
//!
//! `ball-form`: spherical harmonics of the bar's direction in the frame that carries the cup, degree 2 and up, each at
//! most one: degree 0 is the bar's length and degree 1 the place of the cup. `cup-stiction`: `s e^(−φ/d)`, φ the angle by
//! which the bar has turned in its cup since the run began.

use super::candidates::{CandidateFamily, Observations, Refined, none, with_number};
use super::context::Profile;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, no_check,
    plain_measure, single_function,
};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::machine::{Effect, Machine, Outlet, ParameterValue, Place};
use nalgebra::Vector3;

/// Form error of a ball, by the direction in which the bar reads it.
pub static BALL_FORM: Kind = Kind {
    name: "ball-form",
    driver: Driver::Position,
    formula: "reading = s Y(u), Y spherical harmonics of degree 2 .. degree, u the bar's direction in the cup's frame",
    size_meaning: "largest over the directions read",
    cause: "ball out of round, worn or dirty, or a cup whose seats are",
    remedy: "clean ball and cup, turn the ball in its cup and repeat, check the ball's form",
    titles: &[
        ("spindle-ball", "The ball at the spindle is out of round"),
        ("", "The ball at the {place} is out of round"),
    ],
    measures: Some("at its largest"),
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::BallTurned },
    unseen: Unseen::Listed,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: true,
    signature: Signature::BallForm,
    candidates: forms,
    candidates_of_poses: none,
    documented: Documented {
        place: "`pivot`, `spindle-ball`",
        components: "`length`",
        functions: "spherical harmonics `yN±M` of the bar's direction in the cup's frame, degrees 2 to `degree`, each at most 1",
        parameters: "`degree` (2 to 4)",
        unit: "um",
    },
    parameters: &[Parameter::number(
        "degree",
        ParameterUnit::Plain,
        DefaultValue::Number(2.0),
        (2.0, HIGHEST as f64),
        "highest degree of the harmonics",
    )],
    check: |_, effect| match effect.number("degree") {
        Some(degree) if degree.fract() != 0.0 => Err("degree is 2, 3 or 4".into()),
        _ => Ok(()),
    },
    outlets: read_at_a_ball,
    measure: plain_measure,
    functions: |effect| (2..=degree(effect)).flat_map(names).collect(),
    profiles: |context, effect| {
        let directions = context.bar_directions(effect.place);
        let values: Vec<Vec<Vec<f64>>> =
            directions.iter().map(|rows| rows.iter().map(|u| harmonics(degree(effect), u)).collect()).collect();
        let count = (2..=degree(effect)).flat_map(names).count();
        let profile = |k: usize| values.iter().map(|rows| rows.iter().map(|row| row[k]).collect()).collect();
        Ok((0..count).map(profile).collect())
    },
};

/// Friction of a ball in its cup as a run begins.
pub static CUP_STICTION: Kind = Kind {
    name: "cup-stiction",
    driver: Driver::Direction,
    formula: "reading = s e^(-phi/d), phi the angle that the bar has turned in its cup since the run began",
    size_meaning: "reading as a run begins",
    cause: "dry or dirty cup, magnet too strong: the ball sticks until the bar has turned some degrees",
    remedy: "clean and oil ball and cup; let the run-up be longer than the stick",
    titles: &[
        ("spindle-ball", "The ball at the spindle sticks in its cup as runs begin"),
        ("", "The ball at the {place} sticks in its cup as runs begin"),
    ],
    measures: Some("as a run begins"),
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::NoRunUp },
    unseen: Unseen::Listed,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: true,
    signature: Signature::Stiction,
    candidates: sticking,
    candidates_of_poses: none,
    documented: Documented {
        place: "`pivot`, `spindle-ball`",
        components: "`length`",
        functions: "e^(−φ/d), φ the angle that the bar has turned in the cup since the run began",
        parameters: "`turned` d, deg",
        unit: "um",
    },
    parameters: &[Parameter::number(
        "turned",
        ParameterUnit::Plain,
        DefaultValue::Number(5.0),
        (1e-3, 360.0),
        "angle of the bar in its cup after which it has let go (1/e), deg",
    )],
    check: no_check,
    outlets: read_at_a_ball,
    measure: plain_measure,
    functions: single_function,
    profiles: stiction,
};

/// Highest degree of a form.
const HIGHEST: usize = 4;

fn read_at_a_ball(_machine: &Machine, place: Place) -> Vec<Outlet> {
    if matches!(place, Place::Pivot | Place::SpindleBall) { vec![Outlet::Reading] } else { Vec::new() }
}

fn degree(effect: &Effect) -> usize {
    match effect.parameter("degree") {
        Some(ParameterValue::Number(degree)) => (*degree as usize).clamp(2, HIGHEST),
        _ => 2,
    }
}

/// Names of the harmonics of a degree by their order: `y2-2 … y2+2`.
fn names(degree: usize) -> impl Iterator<Item = String> {
    let degree = degree as i32;
    (-degree..=degree).map(move |order| format!("y{degree}{order:+}"))
}

/// Harmonics of all degrees up to one, in the order of their names, each scaled to at most one.
fn harmonics(highest: usize, u: &Vector3<f64>) -> Vec<f64> {
    // cos and sin of the order times the azimuth, times the same power of the sine of the angle from z
    let mut turns = vec![(1.0, 0.0)];
    for order in 0..highest {
        let (cos, sin): (f64, f64) = turns[order];
        turns.push((cos * u.x - sin * u.y, sin * u.x + cos * u.y));
    }
    let mut all = Vec::with_capacity((highest + 1).pow(2) - 4);
    for degree in 2..=highest {
        all.extend((1..=degree).rev().map(|order| zonal(degree, order, u.z) * turns[order].1));
        all.extend((0..=degree).map(|order| zonal(degree, order, u.z) * turns[order].0));
    }
    all
}

/// Largest values over the sphere of harmonics whose maximum is no simple fraction, inverted: degree 3 of orders 1 and 2,
/// degree 4 of orders 1 and 3.
const MOST_31: f64 = 0.726_184_4;
const MOST_32: f64 = 2.598_076_2;
const MOST_41: f64 = 0.946_946_2;
const MOST_43: f64 = 3.079_201_4;

/// What a harmonic has along z: the Legendre polynomial of a degree derived as often as its order, scaled for the whole
/// harmonic to have one as its largest value.
fn zonal(degree: usize, order: usize, z: f64) -> f64 {
    match (degree, order) {
        (2, 0) => (3.0 * z * z - 1.0) / 2.0,
        (2, 1) => 2.0 * z,
        (3, 0) => (5.0 * z * z - 3.0) * z / 2.0,
        (3, 1) => MOST_31 * (5.0 * z * z - 1.0),
        (3, 2) => MOST_32 * z,
        (4, 0) => (35.0 * z.powi(4) - 30.0 * z * z + 3.0) / 8.0,
        (4, 1) => MOST_41 * (7.0 * z * z - 3.0) * z,
        (4, 2) => 7.0 / 9.0 * (7.0 * z * z - 1.0),
        (4, 3) => MOST_43 * z,
        // of the highest order the sine of the angle from z alone is left
        _ => 1.0,
    }
}

fn stiction(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let lets_go = CUP_STICTION.number(context, effect, "turned").to_radians();
    let of_test = |rows: &Vec<Vector3<f64>>| {
        let mut turned = 0.0;
        let mut last = rows.first().copied().unwrap_or_default();
        let row = |u: &Vector3<f64>| {
            turned += u.cross(&last).norm().atan2(u.dot(&last));
            last = *u;
            (-turned / lets_go).exp()
        };
        rows.iter().map(row).collect()
    };
    Ok(vec![context.bar_directions(effect.place).iter().map(of_test).collect()])
}

/// Log odds against balls that are out of round or stick: they are gauges.
const GOOD_BALLS: f64 = 4.0;
/// Amplitudes of form, and of sticking, that are plausible, µm.
const PLAUSIBLE_FORM: f64 = 0.6;
/// Largest form of a ball, µm: those of gauges are round to some tenths.
const MOST_FORM: f64 = 1.1;
const PLAUSIBLE_STICKING: f64 = 2.0;
/// Angles of the bar that are tried, deg.
const TURNED_DEG: [f64; 3] = [2.0, 5.0, 12.0];

fn forms(_seen: &Observations) -> Vec<CandidateFamily> {
    let of_ball = |place| {
        let up_to = |degree: f64| with_number(BALL_FORM.name, place, "degree", degree);
        let family = CandidateFamily::new(BALL_FORM.name, place, vec![Outlet::Reading], PLAUSIBLE_FORM);
        family.over([2.0, 3.0, 4.0].map(up_to).to_vec()).rare(GOOD_BALLS).at_most(MOST_FORM)
    };
    [Place::Pivot, Place::SpindleBall].map(of_ball).to_vec()
}

fn sticking(_seen: &Observations) -> Vec<CandidateFamily> {
    let of_ball = |place| {
        let sticks = |turned: f64| with_number(CUP_STICTION.name, place, "turned", turned);
        let family = CandidateFamily::new(CUP_STICTION.name, place, vec![Outlet::Reading], PLAUSIBLE_STICKING);
        let turned = Refined::number("turned", (0.3, 60.0), 0.4);
        family.over(TURNED_DEG.map(sticks).to_vec()).refine(vec![turned]).rare(GOOD_BALLS).fast()
    };
    [Place::Pivot, Place::SpindleBall].map(of_ball).to_vec()
}
