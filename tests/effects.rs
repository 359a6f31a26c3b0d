//! Every effect of the catalogue on several topologies: a new kind is tested by being registered. Laws of single kinds follow.

use std::path::Path;

use fiveaxis::chain::{Chain, Composition, Geometry, Sensitivity};
use fiveaxis::disturbances::{Disturbances, column};
use fiveaxis::effects::{self, Context, DefaultValue, Kind, Parameter, ParameterUnit};
use fiveaxis::load::{load_machine, machine_from_yaml};
use fiveaxis::machine::{AxisKind, Component, Directions, Effect, Machine, Outlet, ParameterValue, Place};
use fiveaxis::report::machine_yaml;
use fiveaxis::session::{Ball, CirclePlane, Clock, Follow, Recording, Session, Spread, Test};
use fiveaxis::simulate::simulate;
use fiveaxis::units::Measure;
use nalgebra::Vector3;

/// One of each class: table-table, table-head, head-head, inclined axes, a chain with names of its own.
const TOPOLOGIES: [&str; 4] = [
    "hermle-c600u.yaml",
    "table-head-cb-moving-table-y.yaml",
    "head-head-ca-moving-table.yaml",
    "nutating-table-45.yaml",
];

const ARM: &str = "name: arm\nchain: [w, b, J1, J2, J3, t]\naxes:\n  J1: {type: rotary, direction: [0, 0, 1]}\n  J2: \
                   {type: rotary, direction: [0, 1, 0], origin: [0, 0, 290], reversed: true}\n  J3: {type: rotary, \
                   direction: [0, 0.6, 0.8], origin: [0, 0, 560]}\n";

fn machines() -> Vec<Machine> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines");
    let mut all: Vec<Machine> = TOPOLOGIES.iter().map(|name| load_machine(&folder.join(name)).unwrap()).collect();
    // the laws below state signs of the carried part; the other machines keep the senses of ISO 841
    all[0].directions = Some(Directions::Carried);
    all.push(machine_from_yaml(Path::new("arm.yaml"), ARM.into()).unwrap());
    all
}

fn ball(link: &str, at: [f64; 3]) -> Ball {
    Ball { link: link.into(), at: Vector3::from(at), setup: None, spread_mm: None, indexed_about: None }
}

/// A recording of the given rows (all axes, mm or rad) at 0.1 s steps with a rising temperature.
fn recording(rows: &[Vec<f64>]) -> Recording {
    let axes = rows[0].len();
    Recording {
        clock: Clock::TimeS((0..rows.len()).map(|row| row as f64 * 0.1).collect()),
        axes: (0..axes).collect(),
        positions: (0..axes).map(|axis| rows.iter().map(|row| row[axis]).collect()).collect(),
        length_mm: vec![f64::NAN; rows.len()],
        channels: vec![("temperature_degC".into(), (0..rows.len()).map(|row| 20.0 + 0.01 * row as f64).collect())],
        leading_texts: std::sync::Arc::default(),
        leading_header: String::new(),
        column: fiveaxis::session::LengthColumn::LengthMm,
        scatter: None,
    }
}

fn test(name: &str, started_at_s: f64, rows: &[Vec<f64>]) -> Test {
    Test {
        name: name.into(),
        recording_file: None,
        recording: Some(recording(rows)),
        path: None,
        started_at_s,
        bar_length_mm: Some(100.0),
        bar_setup: None,
        zero: fiveaxis::session::Zero::Calibrated,
        bar_error_mm: 0.0,
        pivot: ball("w", [70.0, 40.0, 20.0]),
        spindle_ball: ball("t", [-35.0, 10.0, 110.0]),
        positions: vec![None; rows[0].len()],
        feed_mm_per_min: None,
        overshoot: None,
        marks: None,
        approached: Vec::new(),
        reading: fiveaxis::readings::Reading::Length,
    }
}

fn session(machine: Machine, tests: Vec<Test>) -> Session {
    Session { name: "walk".into(), machine_file: "machine.yaml".into(), machine, spread: Spread::default(), tests }
}

/// Two tests in which every axis moves to and fro, each at a rhythm of its own.
fn walk(machine: Machine) -> Session {
    let row = |k: usize, turn: f64| -> Vec<f64> {
        let phase = |axis: usize| 0.04 * turn * k as f64 * (1.0 + 0.17 * axis as f64);
        let reach = |axis: usize| if machine.axes[axis].kind == AxisKind::Linear { 60.0 } else { 0.7 };
        (0..machine.axes.len()).map(|axis| reach(axis) * phase(axis).sin()).collect()
    };
    let rows = |turn: f64| (0..160).map(|k| row(k, turn)).collect::<Vec<_>>();
    let tests = vec![test("there", 60.0, &rows(1.0)), test("back", 200.0, &rows(-1.0))];
    session(machine, tests)
}

/// The same rows as stops without times.
fn as_poses(session: &mut Session) {
    for recording in session.tests.iter_mut().filter_map(|test| test.recording.as_mut()) {
        recording.clock = Clock::Pose((0..recording.length_mm.len()).map(|row| row as f64).collect());
    }
}

#[test]
fn arrival_follows_the_share_of_the_slowest_axis() {
    let arm = machine_from_yaml(Path::new("arm.yaml"), ARM.into()).unwrap();
    let degrees = [[0.0, 0.0, 0.0], [10.0, 5.0, 0.0], [10.0, -15.0, 10.0], [10.0, -15.0, 10.0], [-20.0, -15.0, 40.0]];
    let rows: Vec<Vec<f64>> = degrees.iter().map(|row| row.iter().map(|q: &f64| q.to_radians()).collect()).collect();
    let mut session = session(arm, vec![test("poses", 0.0, &rows)]);
    as_poses(&mut session);
    // top speeds as 1 : 1 : 2; J2 counts its angle backwards, so that it stops short on the other side
    let effect = |place: &str| {
        let axis = session.machine.axis_index(place).unwrap();
        let rates = ParameterValue::List(vec![1.0, 1.0, 2.0]);
        Effect::new("arrival-lag", Place::Axis(axis)).with("rates", rates)
    };
    for (place, expected) in
        [("J1", [0.0, -1.0, 0.0, 0.0, 1.0]), ("J2", [0.0, 0.5, -1.0, 0.0, 0.0]), ("J3", [0.0, 0.0, -0.25, 0.0, -0.5])]
    {
        let chain = Chain::of(&session.machine);
        let context = Context::of(&session, &chain).unwrap();
        let effect = effect(place);
        let profiles = effects::kind("arrival-lag").unwrap().shape(&context, &effect).unwrap();
        for (found, expected) in profiles[0][0].iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{place}: {:?}", profiles[0][0]);
        }
        if place == "J1" {
            // the ball at t, mm, and its distance from the upright line of J1, in m²
            let chain = Chain::of(&session.machine);
            let at = Geometry::nominal(&chain)
                .pose(chain.link("t").unwrap(), &rows[1], None)
                .point(&session.tests[0].spindle_ball.at);
            let squared = (at.x * at.x + at.y * at.y) * 1e-6;
            assert!((profiles[1][0][1] + squared).abs() < 1e-12, "{} for {squared}", profiles[1][0][1]);
        }
    }
    // in sweeps it is silent
    let timed = walk(session.machine.clone());
    let profiles = profile(&timed, &effect("J1"));
    assert!(profiles.iter().flatten().all(|value| *value == 0.0));
}

/// A parameter's default, or a value that its bounds and the rhythm of [`walk`] allow.
fn example(machine: &Machine, place: Place, parameter: &Parameter) -> Option<ParameterValue> {
    let (from, to) = parameter.bounds;
    let axis_kind = place.axis().map(|axis| machine.axes[axis].kind);
    let inside = |value: f64| match (parameter.unit, axis_kind) {
        (ParameterUnit::Position, Some(kind)) => kind.from_file_unit(value.clamp(from, to)),
        _ => value.clamp(from, to),
    };
    Some(match (parameter.name, parameter.unit, parameter.count) {
        ("orders" | "order", ..) if axis_kind == Some(AxisKind::Linear) => return None,
        ("periods" | "period", ..) if axis_kind == Some(AxisKind::Rotary) => return None,
        ("link", ..) => ParameterValue::Word(if place == Place::Pivot { "w" } else { "t" }.into()),
        ("at", ..) if place == Place::Pivot => ParameterValue::List(vec![70.0, 40.0, 20.0]),
        ("at", ..) => ParameterValue::List(vec![-35.0, 10.0, 110.0]),
        ("bar", ..) => ParameterValue::Number(100.0),
        ("time", ..) => ParameterValue::Number(65.0),
        ("from", ..) => ParameterValue::Number(-70.0),
        ("to", ..) => ParameterValue::Number(70.0),
        ("channel", ..) => ParameterValue::Word("temperature_degC".into()),
        ("load", ..) => {
            let on_table = machine.code.workpiece_side.iter().any(|name| name == place.name(machine));
            ParameterValue::Word(if on_table { "w" } else { "t" }.into())
        }
        // knots of a vibration
        ("wander", ..) => ParameterValue::Number(5.0),
        // as many as joints beyond, and a reference of slides alone
        ("masses", ..) => return None,
        ("middle", ..) if axis_kind == Some(AxisKind::Rotary) => return None,
        // goes with friction alone
        ("warmth", ..) => return None,
        ("rates", ..) => ParameterValue::List((1..=machine.axes.len()).map(|k| k as f64).collect()),
        ("of" | "about", ..) => ParameterValue::Word(machine.axes[0].name.clone()),
        (_, ParameterUnit::Word(words), _) => ParameterValue::Word((*words.first()?).into()),
        (_, _, 1) => match parameter.default {
            DefaultValue::Number(value) => ParameterValue::Number(inside(value)),
            _ => ParameterValue::Number(inside(1.0)),
        },
        _ => ParameterValue::List(vec![inside(2.0), inside(5.0)]),
    })
}

/// An effect of a kind at a place with every parameter stated and every size set.
fn full(machine: &Machine, kind: &Kind, place: Place) -> Effect {
    let mut effect = Effect::new(kind.name, place);
    // a pose stands in place of a time
    for parameter in kind.parameters.iter().filter(|parameter| parameter.name != "pose") {
        if let Some(value) = example(machine, place, parameter) {
            effect.set(parameter.name, value);
        }
    }
    let functions = (kind.functions)(&effect);
    for (index, outlet) in (kind.outlets)(machine, place).into_iter().enumerate() {
        for (k, function) in functions.iter().enumerate() {
            let typical = match (kind.measure)(machine, &outlet, function) {
                Measure::Length | Measure::LengthPerKelvin | Measure::LengthPerLoad => 8e-3,
                Measure::Angle | Measure::AnglePerKelvin | Measure::AnglePerLoad => 3e-5,
                Measure::Strain => 5e-5,
                Measure::Time => 1e-3,
                Measure::TimeSquared => 1e-4,
            };
            let sign = if (index + k) % 2 == 0 { 1.0 } else { -1.0 };
            effect = effect.size(outlet, function, typical * sign / (1.0 + index as f64));
        }
    }
    effect
}

/// Runs `check` for every kind at every place of every topology.
fn each(mut check: impl FnMut(&Machine, &Kind, Effect)) {
    let machines = machines();
    for kind in effects::KINDS {
        let mut places = 0;
        for machine in &machines {
            for place in kind.places(machine) {
                places += 1;
                check(machine, kind, full(machine, kind, place));
            }
        }
        assert!(places >= machines.len() - 1, "{} fits {places} places only", kind.name);
    }
}

fn lengths(session: &Session) -> Vec<Vec<f64>> {
    simulate(session, Composition::Exact).unwrap().into_iter().map(|trace| trace.length_mm).collect()
}

fn with_effects(session: &Session, effects: Vec<Effect>) -> Session {
    let mut session = session.clone();
    session.machine.effects = effects;
    session
}

#[test]
fn every_effect_reads_back_as_written() {
    each(|machine, kind, effect| {
        let mut machine = machine.clone();
        machine.effects = vec![effect.clone(), Effect { tests: Some(vec!["there".into()]), ..effect }];
        let text = machine_yaml(&machine);
        let read = machine_from_yaml(Path::new("machine.yaml"), text.clone())
            .unwrap_or_else(|why| panic!("{}: {why}\n{text}", kind.name));
        assert_eq!(read.effects, machine.effects, "{}\n{text}", kind.name);
    });
}

#[test]
fn no_size_no_effect_and_columns_are_the_slope() {
    let mut worst = (0.0f64, String::new());
    let mut moved = std::collections::BTreeSet::new();
    each(|machine, kind, effect| {
        let label = format!("{} at {} of {}", kind.name, effect.place.name(machine), machine.name);
        let mut session = walk(machine.clone());
        // the walk goes to and fro within a turn: slow for what grows with the square of the speed over a turn
        let effect = if kind.name == "imbalance" { effect.scaled(1e4) } else { effect };
        if kind.name == "arrival-lag" {
            as_poses(&mut session);
        }
        let base = lengths(&session);
        assert_eq!(lengths(&with_effects(&session, vec![effect.scaled(0.0)])), base, "{label}");

        let whole = lengths(&with_effects(&session, vec![effect.clone()]));
        let half = lengths(&with_effects(&session, vec![effect.scaled(0.5)]));
        let linear = linear_change(&session, &effect);
        let (mut largest, mut off, mut off_half) = (0.0f64, 0.0f64, 0.0f64);
        for test in 0..base.len() {
            for row in 0..base[test].len() {
                let change = whole[test][row] - base[test][row];
                largest = largest.max(change.abs());
                off = off.max((change - linear[test][row]).abs());
                off_half = off_half.max((half[test][row] - base[test][row] - linear[test][row] / 2.0).abs());
            }
        }
        if largest == 0.0 && ["gravity-sag", "weight-compliance"].contains(&kind.name) {
            // an upright axis does not turn gravity in the frame it carries, nor the moment of what stands on it
            return;
        }
        if ["surface-form", "sensor-gain"].contains(&kind.name) {
            // bars see no surface and are no sensors: their laws stand in `loads`
            assert_eq!(largest, 0.0, "{label}");
            moved.insert(kind.name);
            return;
        }
        assert!(largest > 1e-5, "{label} moves nothing: {largest:e} mm");
        moved.insert(kind.name);
        // second order: a quarter at half the size; lengths of some 300 mm carry rounding of 1e-13
        assert!(off < 0.02 * largest, "{label}: {off:e} of {largest:e} mm");
        assert!(off_half < 0.3 * off + 1e-11, "{label}: {off_half:e} at half the size, {off:e} at the whole");
        if off / largest > worst.0 {
            worst = (off / largest, label);
        }
    });
    assert_eq!(moved.len(), effects::KINDS.len());
    println!("largest share that is not linear: {:.2e}, {}", worst.0, worst.1);
}

/// Change of all readings by the effect's linear columns, mm.
fn linear_change(session: &Session, effect: &Effect) -> Vec<Vec<f64>> {
    let chain = Chain::of(&session.machine);
    let context = Context::of(session, &chain).unwrap();
    let geometry = Geometry::new(&chain, &session.machine.location_errors(), Composition::Exact);
    let kind = effects::kind(&effect.kind).unwrap();
    let profiles = kind.shape(&context, effect).unwrap();
    let functions = (kind.functions)(effect);
    assert_eq!(profiles.len(), functions.len(), "{}", kind.name);
    (0..session.tests.len())
        .map(|index| {
            let test = &session.tests[index];
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
            let mut sum = vec![0.0; motion.rows()];
            for size in &effect.sizes {
                let function = functions.iter().position(|name| *name == size.function).unwrap();
                let column = column(&context, index, &sensitivities, &size.outlet, &profiles[function]);
                sum.iter_mut().zip(column).for_each(|(sum, value)| *sum += size.value * value);
            }
            sum
        })
        .collect()
}

#[test]
fn words_of_the_trade_are_there() {
    let mut names = Vec::new();
    for kind in effects::KINDS {
        for words in [kind.formula, kind.size_meaning, kind.cause, kind.remedy] {
            assert!(words.len() > 3, "{}", kind.name);
        }
        assert!(!names.contains(&kind.name), "{} is registered twice", kind.name);
        names.push(kind.name);
    }
    let documentation = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/effects.md")).unwrap();
    for name in names {
        assert!(documentation.contains(&format!("`{name}`")), "{name} is missing in docs/effects.md");
    }
}

/// A C600U on which C sweeps with the bar along its turning, out and back with the given numbers of rows.
fn sweeps(rows: [usize; 2]) -> Session {
    let machine = machines().remove(0);
    let c = machine.axis_index("C").unwrap();
    let arc = |from: f64, to: f64, rows: usize| -> Vec<Vec<f64>> {
        (0..rows)
            .map(|k| {
                let mut q = vec![0.0; machine.axes.len()];
                q[c] = (from + (to - from) * k as f64 / (rows - 1) as f64).to_radians();
                q
            })
            .collect()
    };
    let mut tests = vec![test("out", 0.0, &arc(-20.0, 40.0, rows[0])), test("back", 100.0, &arc(40.0, -20.0, rows[1]))];
    for test in &mut tests {
        test.pivot = ball("C", [100.0, 0.0, 0.0]);
        // along the turning: backlash shows whole
        test.spindle_ball = ball("Z", [100.0, -300.0, 0.0]);
    }
    session(machine, tests)
}

fn backlash(session: &Session, half_width_rad: f64) -> Effect {
    let c = session.machine.axis_index("C").unwrap();
    Effect::new("rotary-backlash", Place::Axis(c))
        .size(Outlet::own(&session.machine, c), "", half_width_rad)
        .with("take_up", ParameterValue::Number(0.5f64.to_radians()))
        .with("windup_share", ParameterValue::Number(0.4))
}

fn profile(session: &Session, effect: &Effect) -> Vec<Vec<f64>> {
    let chain = Chain::of(&session.machine);
    let context = Context::of(session, &chain).unwrap();
    effects::kind(&effect.kind).unwrap().shape(&context, effect).unwrap().remove(0)
}

#[test]
fn backlash_is_its_half_width_behind_after_the_approach() {
    let session = sweeps([121, 121]);
    let half_width = 5e-5;
    let found = profile(&session, &backlash(&session, half_width));
    // 4 deg of approach are eight take-ups from rest: e^-8 of the wind-up is missing
    let missing = 0.4 * (-8.0f64).exp() * 1.01;
    assert!(found[0].iter().all(|value| (value + 1.0).abs() <= missing), "out: {:?}", found[0][0]);
    assert!(found[1].iter().all(|value| (value - 1.0).abs() <= 2.0 * missing), "back: {:?}", found[1][0]);
    let base = lengths(&session);
    let moved = lengths(&with_effects(&session, vec![backlash(&session, half_width)]));
    // at C = 0 the bar stands along the turning at 100 mm: length changes by -100 mm times the angle, rows 40 and 80
    let change = |test: usize, row: usize| moved[test][row] - base[test][row];
    let expected = 100.0 * half_width;
    assert!((change(1, 80) - change(0, 40) - 2.0 * expected).abs() < 1e-3 * expected, "{}", change(1, 80));
    assert!(
        change(1, 80) > 0.0,
        "the table trails: turning back it stands too far forward, away from the spindle ball"
    );
}

#[test]
fn backlash_does_not_depend_on_speed_or_sampling() {
    let half_width = 5e-5;
    let sparse = sweeps([31, 31]);
    let mut dense = sweeps([121, 121]);
    for test in &mut dense.tests {
        if let Some(Recording { clock: Clock::TimeS(time), .. }) = &mut test.recording {
            time.iter_mut().for_each(|time| *time *= 0.01);
        }
    }
    let (few, many) =
        (profile(&sparse, &backlash(&sparse, half_width)), profile(&dense, &backlash(&dense, half_width)));
    for test in 0..2 {
        for (row, value) in few[test].iter().enumerate() {
            // approaches start at row distances that differ: the same but for e^-8
            assert!((value - many[test][4 * row]).abs() < 1e-3, "{value} {}", many[test][4 * row]);
        }
    }
}

#[test]
fn play_closes_its_loops() {
    let mut session = sweeps([121, 121]);
    let c = session.machine.axis_index("C").unwrap();
    // to and fro by 0.4 deg, less than the gap and the take-up: a minor loop
    let turns: Vec<Vec<f64>> = (0..400)
        .map(|k| {
            let mut q = vec![0.0; session.machine.axes.len()];
            q[c] = (0.2 * (k as f64 * std::f64::consts::TAU / 40.0).sin()).to_radians();
            q
        })
        .collect();
    session.tests.truncate(1);
    session.tests[0].recording = Some(recording(&turns));
    session.tests[0].overshoot = Some(0.0);
    let effect = backlash(&session, 5e-5).with("gap", ParameterValue::Number(1.0f64.to_radians()));
    let found = &profile(&session, &effect)[0];
    for k in 0..40 {
        let (this, next) = (found[320 + k], found[360 + k]);
        assert!((this - next).abs() < 1e-6, "row {k} of the loop: {this} then {next}");
    }
    let (low, high) = found[320..].iter().fold((1.0f64, -1.0f64), |(l, h), v| (l.min(*v), h.max(*v)));
    assert!(high - low > 0.1 && low > -1.0 && high < 1.0, "a minor loop inside the major one: {low} … {high}");
}

#[test]
fn results_do_not_depend_on_the_order_of_the_file() {
    each(|machine, kind, effect| {
        let session = walk(machine.clone());
        let forward = lengths(&with_effects(&session, vec![effect.clone()]));
        let mut turned = with_effects(&session, vec![effect]);
        turned.tests.reverse();
        let mut backward = lengths(&turned);
        backward.reverse();
        assert_eq!(forward, backward, "{}", kind.name);
    });
}

#[test]
fn an_effect_acts_only_in_its_tests() {
    let session = walk(machines().remove(0));
    let base = lengths(&session);
    let effect = Effect { tests: Some(vec!["back".into()]), ..backlash(&session, 5e-5) };
    let found = lengths(&with_effects(&session, vec![effect]));
    assert_eq!(found[0], base[0]);
    assert_ne!(found[1], base[1]);
}

#[test]
fn growth_ends_in_its_steady_state() {
    let mut session = sweeps([31, 31]);
    session.tests[1].started_at_s = 1e5;
    let z = session.machine.axis_index("Z").unwrap();
    let outlet = Outlet::Motion { axis: z, component: Component::EZ };
    let effect = Effect::new("thermal-growth", Place::Axis(z))
        .with("tau", ParameterValue::List(vec![60.0, 900.0]))
        .size(outlet, "growth1", 5e-3)
        .size(outlet, "growth2", 7e-3);
    let chain = Chain::of(&session.machine);
    let context = Context::of(&session, &chain).unwrap();
    let disturbances = Disturbances::of(&context, &[effect]).unwrap();
    let at = |test: usize, row: usize| disturbances.by_test[test][row].motion[z][2];
    assert_eq!(at(0, 0), 0.0);
    assert!((at(1, 30) - 12e-3).abs() < 1e-15);
    let t: f64 = 3.0;
    let expected = 5e-3 * (1.0 - (-t / 60.0).exp()) + 7e-3 * (1.0 - (-t / 900.0).exp());
    assert!((at(0, 30) - expected).abs() < 1e-15);
}

#[test]
fn a_part_follows_the_temperature_with_its_lag() {
    let mut session = sweeps([31, 31]);
    session.tests[1].started_at_s = 9.0;
    let z = session.machine.axis_index("Z").unwrap();
    let lag_s = 7.0;
    let followed = |lag_s: f64| {
        let effect = Effect::new("thermal-growth", Place::Axis(z))
            .with("channel", ParameterValue::Word("temperature_degC".into()))
            .with("lag", ParameterValue::Number(lag_s));
        profile(&session, &effect)
    };
    // both recordings rise by 0.1 K a second from 20 degrees on; in between the air leaves and arrives on the same slope
    let air = |t: f64| match t {
        t if t <= 3.0 => 0.1 * t,
        t if t <= 9.0 => {
            let x = (t - 3.0) / 6.0;
            let (x2, x3) = (x * x, x * x * x);
            0.3 * (2.0 * x3 - 3.0 * x2 + 1.0) + 0.6 * (x3 - 2.0 * x2 + x) + 0.6 * (x3 - x2)
        }
        t => 0.1 * (t - 9.0),
    };
    // the same by small steps in time
    let step_s = 1e-4;
    let (mut felt, mut by_steps) = (0.0, Vec::new());
    for k in 0..=120_000 {
        if k % 1000 == 0 {
            by_steps.push(felt);
        }
        felt += step_s * (air((k as f64 + 0.5) * step_s) - felt) / lag_s;
    }
    let found = followed(lag_s);
    for row in 0..31 {
        assert!((found[0][row] - by_steps[row]).abs() < 1e-6, "{row}: {} for {}", found[0][row], by_steps[row]);
        // sixteen straight pieces stand for the bridge
        assert!(
            (found[1][row] - by_steps[90 + row]).abs() < 1e-3,
            "{row}: {} for {}",
            found[1][row],
            by_steps[90 + row]
        );
    }
    assert!((followed(0.0)[0][30] - 0.3).abs() < 1e-12);
    // a gap long against the tests is bridged straight: their slopes say nothing of an hour
    session.tests[1].started_at_s = 3603.0;
    let effect = Effect::new("thermal-growth", Place::Axis(z))
        .with("channel", ParameterValue::Word("temperature_degC".into()))
        .with("lag", ParameterValue::Number(600.0));
    let long = profile(&session, &effect)[1][0];
    let (mut felt, step_s) = (0.3 * 1.5 / 600.0, 1e-2);
    for k in 0..360_000 {
        felt += step_s * (0.3 * (1.0 - (k as f64 + 0.5) * step_s / 3600.0) - felt) / 600.0;
    }
    assert!((long - felt).abs() < 0.002, "{long} for {felt}");
}

#[test]
fn missing_temperatures_lie_between_their_neighbours() {
    let mut session = sweeps([31, 31]);
    session.tests[1].started_at_s = 9.0;
    let z = session.machine.axis_index("Z").unwrap();
    let felt = |session: &Session, lag_s: f64| {
        let effect = Effect::new("thermal-growth", Place::Axis(z))
            .with("channel", ParameterValue::Word("temperature_degC".into()))
            .with("lag", ParameterValue::Number(lag_s));
        profile(session, &effect)
    };
    let whole = felt(&session, 7.0);
    let mut gappy = session.clone();
    for test in &mut gappy.tests {
        let (_, read) = &mut test.recording.as_mut().unwrap().channels[0];
        // it rises evenly: nothing is lost between a first and a last reading
        (1..30).filter(|row| row % 4 != 0).for_each(|row| read[row] = f64::NAN);
    }
    let found = felt(&gappy, 7.0);
    for (found, whole) in found.iter().flatten().zip(whole.iter().flatten()) {
        assert!((found - whole).abs() < 1e-9, "{found} for {whole}");
    }
    // a test that no thermometer read lies on the bridge, and the clock does not turn back behind it
    let mut unread = session.clone();
    for (name, started_at_s) in [("third", 21.0), ("fourth", 33.0)] {
        let mut test = session.tests[1].clone();
        (test.name, test.started_at_s) = (name.into(), started_at_s);
        unread.tests.push(test);
    }
    let mut steady = unread.clone();
    for session in [&mut unread, &mut steady] {
        for (test, degrees) in session.tests.iter_mut().zip([20.0, 21.0, 21.0, 21.0]) {
            test.recording.as_mut().unwrap().channels[0].1.iter_mut().for_each(|read| *read = degrees);
        }
    }
    // from the second one on the air stands still, whether it is read or not
    unread.tests[1].recording.as_mut().unwrap().channels[0].1[1..30].iter_mut().for_each(|read| *read = f64::NAN);
    unread.tests[2].recording.as_mut().unwrap().channels[0].1.iter_mut().for_each(|read| *read = f64::NAN);
    for (found, whole) in felt(&unread, 7.0).iter().flatten().zip(felt(&steady, 7.0).iter().flatten()) {
        assert!((found - whole).abs() < 1e-9, "{found} for {whole}");
    }
    // poses have no times: every reading stays in its row
    let mut poses = sweeps([31, 31]);
    as_poses(&mut poses);
    poses.tests[0].recording.as_mut().unwrap().channels[0].1[1] = f64::NAN;
    let found = felt(&poses, 0.0);
    assert_eq!(found[0][1], found[0][0]);
    assert!((found[0][30] - 0.3).abs() < 1e-12, "{}", found[0][30]);
}

#[test]
fn a_part_out_of_balance_settles_from_the_first_reading_on() {
    let mut session = sweeps([31, 31]);
    session.tests.iter_mut().for_each(|test| test.started_at_s += 500.0);
    let z = session.machine.axis_index("Z").unwrap();
    let effect = Effect::new("thermal-growth", Place::Axis(z))
        .with("channel", ParameterValue::Word("temperature_degC".into()))
        .with("lag", ParameterValue::Number(7.0))
        .with("begins", ParameterValue::Word("warm".into()));
    let chain = Chain::of(&session.machine);
    let context = Context::of(&session, &chain).unwrap();
    let shapes = effects::kind("thermal-growth").unwrap().shape(&context, &effect).unwrap();
    assert_eq!(shapes.len(), 2);
    assert_eq!(shapes[1][0][0], 0.0);
    assert!((shapes[1][0][30] - (1.0 - (-3.0f64 / 7.0).exp())).abs() < 1e-12);
}

#[test]
fn friction_heats_while_an_axis_moves() {
    let mut session = sweeps([31, 31]);
    session.tests[1].started_at_s = 40.0;
    let axis = |name: &str| session.machine.axis_index(name).unwrap();
    let grown = |heat: &str, place: usize| {
        let effect = Effect::new("thermal-growth", Place::Axis(place))
            .with("tau", ParameterValue::List(vec![7.0]))
            .with("heat", ParameterValue::Word(heat.into()));
        profile(&session, &effect)
    };
    let found = grown("own", axis("C"));
    // 60 degrees in 3 s are 10/3 rpm, from 0 s and from 40 s on; by small steps in time
    let step_s = 1e-4;
    let (mut warmth, mut by_steps) = (0.0, Vec::new());
    for k in 0..=430_000 {
        if k % 1000 == 0 {
            by_steps.push(warmth);
        }
        let t = (k as f64 + 0.5) * step_s;
        let heat = if (3.0..40.0).contains(&t) { 0.0 } else { 10.0 / 3.0 };
        warmth += step_s * (heat - warmth) / 7.0;
    }
    for row in 0..31 {
        assert!((found[0][row] - by_steps[row]).abs() < 2e-5, "{row}: {} for {}", found[0][row], by_steps[row]);
        assert!((found[1][row] - by_steps[400 + row]).abs() < 2e-5, "{row}: {}", found[1][row]);
    }
    // C is the only rotary axis that moves, and no slide does
    assert_eq!(grown("rotary", axis("A")), found);
    assert!(grown("slides", axis("Z")).iter().flatten().all(|value| *value == 0.0));
    // tests without times of day: each heats by its own clock, whatever the first one's clock says
    let mut untimed = session.clone();
    untimed.tests.iter_mut().for_each(|test| test.started_at_s = -50.0);
    let effect = Effect::new("thermal-growth", Place::Axis(axis("C")))
        .with("tau", ParameterValue::List(vec![7.0]))
        .with("heat", ParameterValue::Word("own".into()));
    let rises = profile(&untimed, &effect);
    assert!((rises[0][30] - found[0][30]).abs() < 1e-12 && rises[1][30] > rises[0][30]);
    // of a warmth it cools to the warmth of its work; growth counts from the beginning
    let warm = profile(&session, &effect.clone().with("warmth", ParameterValue::Number(0.6)));
    let mut warmth = 0.6;
    for k in 0..=30_000 {
        if k % 1000 == 0 {
            let grown = warm[0][k / 1000];
            assert!((grown - (warmth - 0.6)).abs() < 2e-5, "{k}: {grown} for {}", warmth - 0.6);
        }
        warmth += step_s * (10.0 / 3.0 - warmth) / 7.0;
    }
    // a warm part settles as one that a steady source heats
    let warm = Effect::new("thermal-growth", Place::Axis(axis("C")))
        .with("tau", ParameterValue::List(vec![7.0]))
        .with("heat", ParameterValue::Word("own".into()))
        .with("begins", ParameterValue::Word("warm".into()));
    let chain = Chain::of(&session.machine);
    let context = Context::of(&session, &chain).unwrap();
    let shapes = effects::kind("thermal-growth").unwrap().shape(&context, &warm).unwrap();
    assert_eq!(shapes.len(), 2);
    assert!((shapes[1][0][30] - (1.0 - (-3.0f64 / 7.0).exp())).abs() < 1e-12);
}

#[test]
fn a_lag_that_all_slides_have_takes_from_the_radius() {
    let machine = machines().remove(0);
    let (x, y) = (machine.axis_index("X").unwrap(), machine.axis_index("Y").unwrap());
    let (radius, omega): (f64, f64) = (100.0, 0.5);
    let rows: Vec<Vec<f64>> = (0..126)
        .map(|k| {
            let mut q = vec![0.0; machine.axes.len()];
            let turn = omega * 0.1 * k as f64;
            (q[x], q[y]) = (radius * turn.cos(), radius * turn.sin());
            q
        })
        .collect();
    let session = session(machine, vec![test("circle", 0.0, &rows)]);
    let loss_s2 = 2e-4;
    let effect = Effect::new("servo-lag", Place::Axis(x)).size(Outlet::SlidesAcceleration { axis: x }, "", loss_s2);
    let chain = Chain::of(&session.machine);
    let context = Context::of(&session, &chain).unwrap();
    let moved = Disturbances::of(&context, &[effect]).unwrap();
    // the radius falls by s v²/R; second differences see the fourth derivative, (0.1 ω)²/12 of it
    for (row, q) in rows.iter().enumerate().skip(1).take(124) {
        let at = &moved.by_test[0][row].position;
        let along = (at[x] * q[x] + at[y] * q[y]) / radius;
        let expected = -loss_s2 * omega * omega * radius;
        assert!((along - expected).abs() < 3e-4 * expected.abs(), "{row}: {along} for {expected}");
    }
}

#[test]
fn a_joint_tips_with_the_axis_that_drives() {
    let session = sweeps([121, 121]);
    let (c, a) = (session.machine.axis_index("C").unwrap(), session.machine.axis_index("A").unwrap());
    let play = |place: usize| {
        Effect::new("lateral-play", Place::Axis(place))
            .with("gap", ParameterValue::Number(0.0))
            .with("of", ParameterValue::Word("C".into()))
    };
    assert_eq!(profile(&session, &play(a)), profile(&session, &play(c)), "C drives wherever it acts");
    assert!(profile(&session, &play(a))[1].iter().skip(1).all(|value| *value == 1.0));
    // A stands still: by itself it would not tip
    let own = Effect::new("lateral-play", Place::Axis(a)).with("gap", ParameterValue::Number(0.0));
    assert!(profile(&session, &own).iter().flatten().all(|value| *value == 0.0));
    // travels of a slide that is driven by a rotary axis are degrees of that axis
    let z = session.machine.axis_index("Z").unwrap();
    let taken_up = |place: usize, value: f64| {
        play(place).with("take_up", ParameterValue::Number(value)).with("windup_share", ParameterValue::Number(1.0))
    };
    assert_eq!(profile(&session, &taken_up(z, 5.0)), profile(&session, &taken_up(c, 5f64.to_radians())));
}

#[test]
fn squareness_is_the_location_error() {
    let session = walk(machines().remove(0));
    let y = session.machine.axis_index("Y").unwrap();
    let value = 6e-5;
    let effect = Effect::new("squareness", Place::Axis(y)).size(
        Outlet::Location { axis: y, component: Component::EC },
        "",
        value,
    );
    let mut located = session.clone();
    located.machine.axes[y].location_errors[Component::EC.index()] = value;
    assert_eq!(lengths(&with_effects(&session, vec![effect])), lengths(&located));
}

#[test]
fn delay_is_a_shift_in_time() {
    let mut session = sweeps([121, 121]);
    session.tests.truncate(1);
    let effect = Effect::new("trigger-latency", Place::Recorder).size(Outlet::Delay, "", 0.2);
    let base = &lengths(&session)[0];
    let late = &lengths(&with_effects(&session, vec![effect]))[0];
    // rows are 0.1 s apart at constant speed: the readings belong to positions two rows later
    for row in 0..119 {
        assert!((late[row] - base[row + 2]).abs() < 1e-9, "{row}: {} {}", late[row], base[row + 2]);
    }
}

#[test]
fn a_pivot_slips_with_its_own_tests_only() {
    let mut session = sweeps([31, 31]);
    let mut other = session.tests[1].clone();
    other.name = "elsewhere".into();
    other.started_at_s = 300.0;
    other.pivot = ball("C", [-100.0, 0.0, 0.0]);
    session.tests.push(other);
    let base = lengths(&session);
    let effect = Effect::new("pivot-slip", Place::Pivot)
        .with("time", ParameterValue::Number(101.5))
        .size(Outlet::Pivot(0), "", 3e-3)
        .size(Outlet::Pivot(1), "", 4e-3);
    let found = lengths(&with_effects(&session, vec![effect]));
    assert_eq!(found[0], base[0]);
    assert_eq!(found[1][..15], base[1][..15]);
    assert!((15..31).all(|row| (found[1][row] - base[1][row]).abs() > 1e-4));
    assert_eq!(found[2], base[2]);
}

#[test]
fn a_spike_follows_a_reversal_and_dies_away() {
    let machine = machines().remove(0);
    let (x, y) = (machine.axis_index("X").unwrap(), machine.axis_index("Y").unwrap());
    let mut circle = test("circle", 0.0, &[vec![0.0; machine.axes.len()]]);
    circle.recording = None;
    circle.path = Some(fiveaxis::session::Path::Circle {
        plane: CirclePlane { first: x, second: y },
        radius_mm: 100.0,
        from: -90.0,
        to: 90.0,
        step: 0.2,
    });
    circle.positions = vec![Some(0.0); machine.axes.len()];
    circle.feed_mm_per_min = Some(500.0);
    let session = session(machine, vec![circle]);
    for servo_hz in [0.0, 3.0] {
        let effect = Effect::new("reversal-spike", Place::Axis(x))
            .with("servo_hz", ParameterValue::Number(servo_hz))
            .size(Outlet::own(&session.machine, x), "", 5e-3);
        let found = &profile(&session, &effect)[0];
        let largest = (0..found.len()).max_by(|&a, &b| found[a].abs().total_cmp(&found[b].abs())).unwrap();
        // X turns round at row 450 of 900 (0 deg); the axis trails, so going back it stands too far out
        assert!((450..462).contains(&largest), "largest at row {largest}");
        assert!(found[largest] > 0.9, "{}", found[largest]);
        assert!(found[900].abs() < 1e-6 && found[440].abs() < 1e-6, "{} {}", found[440], found[900]);
    }
}

#[test]
fn a_spike_between_few_rows_is_the_spike_between_many() {
    let machine = machines().remove(0);
    let (x, y) = (machine.axis_index("X").unwrap(), machine.axis_index("Y").unwrap());
    let spike = |step: f64| {
        let mut circle = test("circle", 0.0, &[vec![0.0; machine.axes.len()]]);
        circle.recording = None;
        let plane = CirclePlane { first: x, second: y };
        // X turns round at 0 deg, between two rows
        circle.path = Some(fiveaxis::session::Path::Circle { plane, radius_mm: 100.0, from: -24.4, to: 23.6, step });
        circle.positions = vec![Some(0.0); machine.axes.len()];
        circle.feed_mm_per_min = Some(2000.0);
        let session = session(machine.clone(), vec![circle]);
        let effect = Effect::new("reversal-spike", Place::Axis(x))
            .with("servo_hz", ParameterValue::Number(7.0))
            .with("damping", ParameterValue::Number(0.6))
            .with("travel", ParameterValue::Number(0.07))
            .size(Outlet::own(&session.machine, x), "", 5e-3);
        profile(&session, &effect).remove(0)
    };
    let (many, few) = (spike(0.01), spike(0.8));
    let shared: Vec<f64> = many.iter().step_by(80).copied().collect();
    // each is scaled to its own largest value
    let largest = shared.iter().fold(0.0f64, |most, value| most.max(value.abs()));
    for (row, (shared, few)) in shared.iter().zip(&few).enumerate() {
        assert!((shared / largest - few).abs() < 0.03, "row {row}: {} and {few}", shared / largest);
    }
}

#[test]
fn a_stop_is_no_reversal() {
    let machine = machines().remove(0);
    let (x, axes) = (machine.axis_index("X").unwrap(), machine.axes.len());
    // X goes on, stops short, stands and goes on: no row leads back
    let rows: Vec<Vec<f64>> = (0..60)
        .map(|row| {
            let way = [row.min(20) as f64, (row as f64 - 40.0).max(0.0)].iter().sum::<f64>();
            (0..axes).map(|axis| if axis == x { way } else { 0.0 }).collect()
        })
        .collect();
    let session = session(machine, vec![test("stop", 0.0, &rows)]);
    let effect = Effect::new("reversal-spike", Place::Axis(x)).with("servo_hz", ParameterValue::Number(7.0)).size(
        Outlet::own(&session.machine, x),
        "",
        5e-3,
    );
    let found = &profile(&session, &effect)[0];
    assert!(found.iter().all(|value| *value == 0.0), "{found:?}");
}

#[test]
fn sweeps_of_poses_have_no_approach_and_no_speed() {
    let mut session = sweeps([31, 31]);
    as_poses(&mut session);
    let found = profile(&session, &backlash(&session, 5e-5));
    assert_eq!(found[0][0], 0.0, "nothing is known before the first pose");
    assert!(found[0][30] < -0.9 && found[1][30] > 0.9);
    let effect = Effect::new("trigger-latency", Place::Recorder).size(Outlet::Delay, "", 0.2);
    assert_eq!(lengths(&with_effects(&session, vec![effect])), lengths(&session));
}

#[test]
fn planned_tests_carry_effects() {
    let mut session = sweeps([31, 31]);
    let c = session.machine.axis_index("C").unwrap();
    for (test, (from, to)) in session.tests.iter_mut().zip([(-20.0, 40.0), (40.0, -20.0)]) {
        test.recording = None;
        test.path = Some(fiveaxis::session::Path::Sweep {
            axis: c,
            from,
            to,
            step: 0.5,
            follow: Follow::None,
            length_mm: None,
        });
        test.positions = vec![Some(0.0); session.machine.axes.len()];
    }
    let found = profile(&session, &backlash(&session, 5e-5));
    assert!(found[0].iter().all(|value| *value < -0.99) && found[1].iter().all(|value| *value > 0.99));
}

#[test]
fn wrong_entries_get_one_clear_message() {
    let refusal = |entry: &str| {
        let text = format!("name: m\ncode: \"[wCAbYXZt]\"\naxes: {{}}\neffects:\n{entry}");
        machine_from_yaml(Path::new("m.yaml"), text).unwrap_err().to_string()
    };
    for (entry, line, says) in [
        ("  - effect: rotary-backlsh\n    place: C\n", 5, "did you mean 'rotary-backlash'?"),
        ("  - effect: rotary-backlash\n    place: X\n", 6, "cannot sit at 'X'"),
        ("  - effect: rotary-backlash\n    place: C\n    sizes: {ECC: 10}\n", 7, "'10' has no unit"),
        ("  - effect: rotary-backlash\n    place: C\n    sizes: {ECC: 10 um}\n", 7, "does not fit here"),
        ("  - effect: rotary-backlash\n    place: C\n    sizes: {EAC: 10 arcsec}\n", 7, "did you mean 'ECC'?"),
        ("  - effect: rotary-backlash\n    place: C\n    take_upp: 1\n    sizes: {}\n", 7, "did you mean 'take_up'?"),
        ("  - effect: rotary-backlash\n    place: C\n    take_up: -1\n    sizes: {}\n", 7, "outside 0 … 10000"),
        ("  - effect: rotary-backlash\n    place: C\n    take_up: .nan\n    sizes: {}\n", 7, "not a finite number"),
        ("  - effect: rotary-backlash\n    place: C\n", 5, "an effect needs its sizes, e.g. sizes: {ECC: 1.5 arcsec}"),
        ("  - effect: cyclic-error\n    place: C\n    sizes: {}\n", 5, "a rotary axis has orders"),
        (
            "  - effect: cyclic-error\n    place: C\n    orders: [90]\n    sizes: {ECC: {cos9: 1 arcsec}}\n",
            8,
            "did you mean 'cos90'?",
        ),
        ("  - effect: pivot-slip\n    place: pivot\n    sizes: {x: 1 um}\n", 5, "needs the key 'time'"),
        ("  - effect: servo-lag\n    place: X\n    sizes: {lag: 3 um}\n", 7, "allowed: ms, s, us"),
        ("  - effect: unknown\n    place: C\n    from: 5\n    to: 5\n    sizes: {}\n", 5, "'from' is below 'to'"),
        ("  - effect: clamp-lift\n    place: C\n    from: 40\n    to: -10\n    sizes: {}\n", 5, "'from' is below 'to'"),
        ("  - effect: clamp-lift\n    place: C\n    from: 40\n    sizes: {}\n", 5, "needs the key 'to'"),
        ("  - effect: ball-form\n    place: pivot\n    degree: 2.5\n    sizes: {}\n", 5, "2, 3 or 4"),
        ("  - effect: beat\n    place: X\n    order: 3\n    frequency: 1\n    sizes: {}\n", 5, "has a period in mm"),
        ("  - 5\n", 5, ""),
    ] {
        let message = refusal(entry);
        assert!(message.starts_with(&format!("m.yaml:{line}:")) && message.contains(says), "{entry}: {message}");
    }
}

#[test]
fn a_clamp_lifts_over_its_stretch_later_on_the_way_back_and_in_its_time() {
    let session = sweeps([241, 181]);
    let c = session.machine.axis_index("C").unwrap();
    let deg = |value: f64| ParameterValue::Number(value.to_radians());
    let (from, to, late, rise_s) = (-3.3, 21.7, 2.6, 1.7);
    let lift = Effect::new("clamp-lift", Place::Axis(c)).with("from", deg(from)).with("to", deg(to));
    let lift = lift.with("hysteresis", deg(late)).with("rise", ParameterValue::Number(rise_s));
    let found = profile(&session, &lift);
    for (test, found) in found.iter().enumerate() {
        // in small steps of time; a sweep passes both edges in one sense, half of the hysteresis late
        let recording = session.tests[test].recording.as_ref().unwrap();
        let time = recording.time_s().unwrap();
        let at = |row: usize| recording.positions[c][row].to_degrees();
        let sense = (at(found.len() - 1) - at(0)).signum();
        let wanted = |q: f64| f64::from(u8::from((from..to).contains(&(q - sense * late / 2.0))));
        let mut lifted = wanted(at(0));
        assert_eq!(found[0], lifted);
        let steps = 2000;
        for row in 1..found.len() {
            let dt = (time[row] - time[row - 1]) / f64::from(steps);
            for step in 0..steps {
                let share = (f64::from(step) + 0.5) / f64::from(steps);
                lifted += dt / rise_s * (wanted(at(row - 1) + share * (at(row) - at(row - 1))) - lifted);
            }
            assert!((found[row] - lifted).abs() < 1e-3, "test {test} row {row}: {} for {lifted}", found[row]);
        }
        let (low, high) = found.iter().fold((1.0f64, 0.0f64), |(low, high), value| (low.min(*value), high.max(*value)));
        assert!(low < 0.05 && high > 0.95, "{low} … {high}");
    }
}

/// Unit vectors from a test's pivot to its spindle ball, in the frame of the pivot.
fn bar_directions(session: &Session, test: usize) -> Vec<nalgebra::Vector3<f64>> {
    let chain = Chain::of(&session.machine);
    let context = Context::of(session, &chain).unwrap();
    let geometry = Geometry::nominal(&chain);
    let (pivot, spindle) = session.tests[test].links(&chain).unwrap();
    let motion = context.motion(test);
    let row = |row: usize| {
        let cup = geometry.pose(pivot, motion.row(row), None);
        let ball = geometry.pose(spindle, motion.row(row), None).point(&session.tests[test].spindle_ball.at);
        (cup.rotation.transpose() * (ball - cup.point(&session.tests[test].pivot.at))).normalize()
    };
    (0..motion.rows()).map(row).collect()
}

#[test]
fn the_form_of_a_ball_is_what_spherical_harmonics_make_of_the_bars_direction() {
    let session = walk(machines().remove(0));
    let form = Effect::new("ball-form", Place::Pivot).with("degree", ParameterValue::Number(4.0));
    let chain = Chain::of(&session.machine);
    let context = Context::of(&session, &chain).unwrap();
    let kind = effects::kind("ball-form").unwrap();
    let (names, profiles) = ((kind.functions)(&form), kind.shape(&context, &form).unwrap());
    assert_eq!((names.len(), profiles.len()), (21, 21));
    // in Cartesian form, to a factor: https://en.wikipedia.org/wiki/Table_of_spherical_harmonics#Real_spherical_harmonics
    let known = |name: &str, x: f64, y: f64, z: f64| match name {
        "y2-2" => x * y,
        "y2-1" => y * z,
        "y2+0" => 3.0 * z * z - 1.0,
        "y2+1" => x * z,
        "y2+2" => x * x - y * y,
        "y3-3" => y * (3.0 * x * x - y * y),
        "y3-2" => x * y * z,
        "y3-1" => y * (5.0 * z * z - 1.0),
        "y3+0" => 5.0 * z.powi(3) - 3.0 * z,
        "y3+1" => x * (5.0 * z * z - 1.0),
        "y3+2" => (x * x - y * y) * z,
        "y3+3" => x * (x * x - 3.0 * y * y),
        "y4-4" => x * y * (x * x - y * y),
        "y4-3" => y * (3.0 * x * x - y * y) * z,
        "y4-2" => x * y * (7.0 * z * z - 1.0),
        "y4-1" => y * (7.0 * z.powi(3) - 3.0 * z),
        "y4+0" => 35.0 * z.powi(4) - 30.0 * z * z + 3.0,
        "y4+1" => x * (7.0 * z.powi(3) - 3.0 * z),
        "y4+2" => (x * x - y * y) * (7.0 * z * z - 1.0),
        "y4+3" => x * (x * x - 3.0 * y * y) * z,
        "y4+4" => x * x * (x * x - 3.0 * y * y) - y * y * (3.0 * x * x - y * y),
        other => panic!("{other}"),
    };
    // largest over the sphere, by a grid
    let sphere = (0..=400).flat_map(|i| (0..800).map(move |j| (f64::from(i) / 200.0 - 1.0, f64::from(j) * 0.008)));
    let sphere: Vec<[f64; 3]> = sphere
        .map(|(z, turn)| {
            let across = (1.0 - z * z).max(0.0).sqrt();
            [across * turn.cos(), across * turn.sin(), z]
        })
        .collect();
    for (name, profile) in names.iter().zip(&profiles) {
        let largest = sphere.iter().map(|[x, y, z]| known(name, *x, *y, *z).abs()).fold(0.0, f64::max);
        for (test, rows) in profile.iter().enumerate() {
            for (value, u) in rows.iter().zip(bar_directions(&session, test)) {
                let expected = known(name, u.x, u.y, u.z) / largest;
                assert!((value - expected).abs() < 2e-3, "{name}: {value} for {expected}");
            }
        }
    }
}

#[test]
fn a_cup_sticks_until_the_bar_has_turned_in_it() {
    let session = sweeps([121, 121]);
    let sticks = Effect::new("cup-stiction", Place::SpindleBall).with("turned", ParameterValue::Number(4.0));
    let chain = Chain::of(&session.machine);
    let context = Context::of(&session, &chain).unwrap();
    let found = effects::kind("cup-stiction").unwrap().shape(&context, &sticks).unwrap().remove(0);
    for (test, found) in found.iter().enumerate() {
        // the spindle does not turn: the bar's angle at its ball is that seen from the machine
        let seen = bar_directions(&session, test);
        let positions = context.motion(test);
        let c = session.machine.axis_index("C").unwrap();
        let from_machine = |row: usize| {
            let turn = nalgebra::Rotation3::from_axis_angle(&nalgebra::Vector3::z_axis(), positions.row(row)[c]);
            turn * seen[row]
        };
        let mut turned = 0.0f64;
        for (row, sticks) in found.iter().enumerate() {
            if row > 0 {
                turned += from_machine(row).dot(&from_machine(row - 1)).min(1.0).acos().to_degrees();
            }
            assert!((sticks - (-turned / 4.0).exp()).abs() < 1e-6, "{sticks} at {turned} deg");
        }
        assert!(found[0] == 1.0 && found[found.len() - 1] < 0.5, "{found:?}");
    }
}
