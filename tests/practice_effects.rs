//! Forward models against recordings of an independent simulator whose concealed effects are known.
//!
//! With the true location errors, balls, bars and effect parameters inserted, the simulated traces explain the
//! recordings down to their noise.

use crate::shared_data;
use std::path::Path;

use fiveaxis::chain::{Chain, Composition, Geometry, Sensitivity};
use fiveaxis::disturbances::column;
use fiveaxis::effects::{Context, kind};
use fiveaxis::load::load_session;
use fiveaxis::machine::{Component, Effect, ErrorName, Outlet, ParameterValue, Place};
use fiveaxis::session::{Ball, Session};
use fiveaxis::simulate::simulate;
use nalgebra::{DMatrix, DVector, Vector3};
use serde_json::Value;

const UM: f64 = 1e-3;
const ARCSEC: f64 = std::f64::consts::PI / 180.0 / 3600.0;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().map(|list| list.iter().filter_map(Value::as_f64).collect()).unwrap_or_default()
}

fn point(value: &Value) -> Vector3<f64> {
    Vector3::from_column_slice(&numbers(value))
}

/// The session with everything true but the effects inserted.
fn true_session(folder: &Path, truth: &Value) -> Session {
    let case = truth["case"].as_str().unwrap();
    let mut session = load_session(&folder.join(case).join("session.yaml")).unwrap();
    let names: Vec<String> = session.machine.axes.iter().map(|axis| axis.name.clone()).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    for (name, value) in truth["pige"].as_object().unwrap() {
        let error = ErrorName::parse(name, &names).unwrap();
        let axis = session.machine.axis_index(&error.axis).unwrap();
        let unit = if error.component.is_angle() { ARCSEC } else { UM };
        session.machine.axes[axis].location_errors[error.component.index()] = value.as_f64().unwrap() * unit;
    }
    for test in &mut session.tests {
        let displaced = |ball: &mut Ball, list: &Value| {
            let own = list.as_array().unwrap().iter().find(|entry| (point(&entry["at"]) - ball.at).norm() < 1e-3);
            ball.at += point(&own.unwrap()["error_um"]) * UM;
        };
        displaced(&mut test.pivot, &truth["pivots"]);
        displaced(&mut test.spindle_ball, &truth["spindle_balls"]);
        let bars = truth["bars"].as_array().unwrap();
        let own =
            bars.iter().find(|bar| (bar["calibrated"].as_f64().unwrap() - test.bar_length_mm.unwrap()).abs() < 1e-6);
        test.bar_error_mm = own.unwrap()["reading_error_um"].as_f64().unwrap() * UM;
    }
    session
}

/// Rms of recording minus simulation over all readings, µm.
fn residual_um(session: &Session) -> f64 {
    let traces = simulate(session, Composition::Exact).unwrap();
    let squares: Vec<f64> = session
        .tests
        .iter()
        .zip(&traces)
        .flat_map(|(test, trace)| test.recording.as_ref().unwrap().length_mm.iter().zip(&trace.length_mm))
        .map(|(read, simulated)| (read - simulated).powi(2))
        .filter(|square| square.is_finite())
        .collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt() / UM
}

fn number(value: f64) -> ParameterValue {
    ParameterValue::Number(value)
}

/// The catalogue's effects for one of the truth's.
fn effects_of(session: &Session, truth: &Value) -> Vec<Effect> {
    let machine = &session.machine;
    let params = &truth["params"];
    let param = |name: &str| params[name].as_f64().unwrap();
    let size = truth["size"].as_f64().unwrap();
    let axis = truth["place"].as_str().and_then(|name| machine.axis_index(name));
    match truth["id"].as_str().unwrap() {
        "rotary-backlash" | "linear-backlash" => {
            let axis = axis.unwrap();
            let unit = if truth["unit"] == "arcsec" { ARCSEC } else { UM };
            let take_up = machine.axes[axis].kind.from_file_unit(param("take_up"));
            vec![
                Effect::new(truth["id"].as_str().unwrap(), Place::Axis(axis))
                    .size(Outlet::own(machine, axis), "", size * unit)
                    .with("take_up", number(take_up))
                    .with("windup_share", number(param("windup_share"))),
            ]
        }
        "rotary-error-motion" => {
            let axis = axis.unwrap();
            let mut effect = Effect::new("rotary-error-motion", Place::Axis(axis));
            let mut orders = Vec::new();
            for (letter, component) in [("X", Component::EX), ("Y", Component::EY)] {
                let table = params["harmonics"][letter].as_array().unwrap();
                let (order, amplitude, phase) = (numbers(&table[0]), numbers(&table[1]), numbers(&table[2]));
                for k in 0..order.len() {
                    let outlet = Outlet::Motion { axis, component };
                    let a = amplitude[k] * size * UM;
                    effect = effect.size(outlet, &format!("cos{}", order[k]), a * phase[k].cos()).size(
                        outlet,
                        &format!("sin{}", order[k]),
                        -a * phase[k].sin(),
                    );
                    if !orders.contains(&order[k]) {
                        orders.push(order[k]);
                    }
                }
            }
            vec![effect.with("orders", ParameterValue::List(orders))]
        }
        "worm-cyclic" => {
            let axis = axis.unwrap();
            // the worm's eccentricity turns tooth error up and down: sidebands; flanks are no pure sine: twice the teeth
            let teeth = param("teeth");
            let orders = vec![1.0, teeth - 1.0, teeth, teeth + 1.0, 2.0 * teeth];
            let effect = Effect::new("cyclic-error", Place::Axis(axis)).with("orders", ParameterValue::List(orders));
            vec![fitted(session, effect, &[Outlet::own(machine, axis)])]
        }
        "linear-reversal-spike" => {
            let axis = axis.unwrap();
            vec![
                Effect::new("reversal-spike", Place::Axis(axis))
                    .size(Outlet::own(machine, axis), "", size * UM)
                    .with("travel", number(param("presliding_mm")))
                    .with("servo_hz", number(param("servo_hz")))
                    .with("damping", number(param("servo_damping"))),
            ]
        }
        "gravity-sag" => {
            let axis = axis.unwrap();
            let outlets: Vec<Outlet> = [Component::EY, Component::EZ, Component::EA, Component::EB]
                .map(|component| Outlet::Motion { axis, component })
                .to_vec();
            vec![fitted(session, Effect::new("gravity-sag", Place::Axis(axis)), &outlets)]
        }
        "guideway-wear" => {
            let axis = axis.unwrap();
            vec![
                Effect::new("straightness", Place::Axis(axis))
                    .size(Outlet::Motion { axis, component: Component::EZ }, "bump", size * UM * param("sign"))
                    .with("centre", number(param("centre_mm")))
                    .with("width", number(param("width_mm")))
                    .with("skew", number(param("skew"))),
            ]
        }
        "pivot-slip" => {
            let time = numbers_or_null(&truth["range"]["time_s"])[0];
            let direction = numbers(&params["direction"]);
            let mut effect = Effect::new("pivot-slip", Place::Pivot)
                .with("time", number(time))
                .with("creep_share", number(param("creep_share")))
                .with("creep_time", number(CREEP_TIME_S));
            for (k, share) in direction.iter().enumerate() {
                effect = effect.size(Outlet::Pivot(k), "", size * UM * share);
            }
            vec![effect]
        }
        "squareness" => {
            let axis = axis.unwrap();
            let outlet = Outlet::Location { axis, component: Component::EC };
            vec![Effect::new("squareness", Place::Axis(axis)).size(outlet, "", size * ARCSEC * param("sign"))]
        }
        "thermal-growth" => {
            let axis = axis.unwrap();
            let outlets: Vec<Outlet> = [Component::EZ, Component::EA, Component::EY]
                .map(|component| Outlet::Motion { axis, component })
                .to_vec();
            let tau = ParameterValue::List(numbers(&params["tau_s"]));
            vec![fitted(session, Effect::new("thermal-growth", Place::Axis(axis)).with("tau", tau), &outlets)]
        }
        "unknown-clamp" => {
            let axis = axis.unwrap();
            let outlets: Vec<Outlet> =
                [Component::EZ, Component::EA].map(|component| Outlet::Motion { axis, component }).to_vec();
            let deg = |value: &Value| number(value.as_f64().unwrap().to_radians());
            let effect = Effect::new("clamp-lift", Place::Axis(axis))
                .with("from", deg(&truth["range"]["deg"][0]))
                .with("to", deg(&truth["range"]["deg"][1]))
                .with("hysteresis", deg(&params["hysteresis_deg"]))
                .with("rise", number(param("lift_time_s")));
            vec![fitted(session, effect, &outlets)]
        }
        other => panic!("no model for {other}"),
    }
}

/// Numbers of a list in which `null` stands for no number.
fn numbers_or_null(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|entry| entry.as_f64().unwrap_or(f64::NAN)).collect()
}

/// The effect with the sizes that fit the recordings best, by its linear columns.
fn fitted(session: &Session, effect: Effect, outlets: &[Outlet]) -> Effect {
    let chain = Chain::of(&session.machine);
    let context = Context::of(session, &chain).unwrap();
    let geometry = Geometry::new(&chain, &session.machine.location_errors(), Composition::Exact);
    let kind = kind(&effect.kind).unwrap();
    let profiles = kind.shape(&context, &effect).unwrap();
    let functions = (kind.functions)(&effect);
    let count = outlets.len() * functions.len();
    let (mut normal, mut right) = (DMatrix::zeros(count, count), DVector::zeros(count));
    for (index, test) in session.tests.iter().enumerate() {
        let (pivot, spindle) = test.links(&chain).unwrap();
        let motion = context.motion(index);
        let sensitivities: Vec<Sensitivity> = (0..motion.rows())
            .map(|row| {
                let mut at = Sensitivity::zeros(chain.axis_count());
                let balls = ((pivot, &test.pivot.at), (spindle, &test.spindle_ball.at));
                geometry.sensitivity(balls.0, balls.1, motion.row(row), None, &mut at);
                at
            })
            .collect();
        let columns: Vec<Vec<f64>> = outlets
            .iter()
            .flat_map(|outlet| profiles.iter().map(|profile| column(&context, index, &sensitivities, outlet, profile)))
            .collect();
        for (row, read) in test.recording.as_ref().unwrap().length_mm.iter().enumerate() {
            let left = read - sensitivities[row].length_mm - test.bar_error_mm;
            if left.is_finite() {
                let line = DVector::from_iterator(count, columns.iter().map(|column| column[row]));
                right += &line * left;
                normal += &line * line.transpose();
            }
        }
    }
    let scale = normal.diagonal().map(|value: f64| value.max(1e-30).sqrt().recip());
    let scaled = DMatrix::from_fn(count, count, |i, j| normal[(i, j)] * scale[i] * scale[j])
        + DMatrix::identity(count, count) * 1e-10;
    let solution = scaled.cholesky().unwrap().solve(&right.component_mul(&scale)).component_mul(&scale);
    let sizes = outlets.iter().flat_map(|outlet| functions.iter().map(move |function| (outlet, function)));
    sizes
        .zip(solution.iter())
        .fold(effect.clone(), |effect, ((outlet, function), value)| effect.size(*outlet, function, *value))
}

/// Time constant of the creep, which the truth does not tell: the best of 5, 10, 20, 40, 80, 200 s, s.
const CREEP_TIME_S: f64 = 40.0;

/// Residual over noise that is reached, a hundredth of slack included, with what stays open.
const REACHED: [(&str, f64, &str); 12] = [
    ("case-001", 1.02, ""),
    ("case-002", 1.01, ""),
    ("case-003", 1.02, "sizes fitted: phases are not told"),
    ("case-004", 1.02, ""),
    ("case-005", 1.03, "sizes fitted: products stand for a load exponent of 0.82"),
    ("case-006", 1.01, ""),
    ("case-007", 1.01, ""),
    ("case-008", 1.02, ""),
    ("case-009", 1.13, "a gravity bias of the backlash, an offset between up and down, is not modelled"),
    ("case-010", 1.01, ""),
    ("case-011", 1.04, "sizes fitted: the source's own history between tests is not told"),
    ("case-012", 2.30, "outside the catalogue: a curve of position alone, without the hysteresis in it"),
];

#[test]
fn true_effects_explain_recordings_of_an_independent_simulator() {
    let Some(folder) = shared_data::folder("recordings/practice") else { return };
    for (case, most, open) in REACHED {
        let text = std::fs::read_to_string(folder.join(format!("truth/{case}.json"))).unwrap();
        let truth: Value = serde_json::from_str(&text).unwrap();
        let mut session = true_session(&folder, &truth);
        let before = residual_um(&session);
        for effect in truth["effects"].as_array().unwrap() {
            session.machine.effects.extend(effects_of(&session, effect));
        }
        let after = residual_um(&session);
        let noise = truth["noise_rms_um"].as_f64().unwrap();
        let name = truth["effects"][0]["id"].as_str().unwrap_or("clean");
        println!("{case} {name:22} {before:.4} um without, {after:.4} um with, noise {noise:.4} um; {open}");
        assert!(after <= most * noise, "{case}: {after} um is more than {most} times the noise of {noise} um");
    }
}
