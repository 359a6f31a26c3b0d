//! A plan as JSON: every test as a session states it, with what the plan adds. Keys are those of `schemas/plan.json`.

use crate::collision::Leg;
use crate::machine::{Directions, Machine};
use crate::nc::without_machine_zero;
use crate::plan::{ErrorForecast, Plan, PlannedTest, TradeOff};
use crate::session::{Follow, Path as TestPath, Zero};
use crate::units::{Measure, rounded};
use serde_json::{Map, Value, json};

/// A planned test as a session states it, one entry for each direction.
fn session_tests(planned: &PlannedTest, machine: &Machine) -> [Map<String, Value>; 2] {
    let test = &planned.test;
    let ball = |ball: &crate::session::Ball| json!({ "link": ball.link, "at": [ball.at.x, ball.at.y, ball.at.z] });
    let positions: Map<String, Value> = machine
        .axes
        .iter()
        .zip(&test.positions)
        .filter_map(|(axis, q)| Some((axis.name.clone(), json!(rounded(axis.kind.to_file_unit((*q)?), 5)))))
        .collect();
    let came = machine.axes.iter().zip(&test.approached);
    let approached: Map<String, Value> =
        came.filter_map(|(axis, sense)| Some((axis.name.clone(), json!((*sense)? as i64)))).collect();
    let mut spindle_ball = ball(&test.spindle_ball);
    if let Some(about) = test.spindle_ball.indexed_about {
        spindle_ball["indexed_about"] = json!(["x", "y", "z"][about]);
    }
    planned.both_ways().map(|test| {
        let mut map = Map::new();
        let mut put = |key: &str, value: Value| map.insert(key.into(), value);
        put("recording", json!(format!("{}.csv", test.name)));
        put("name", json!(test.name));
        put("bar_length", json!(test.bar_length_mm));
        if test.zero != Zero::default() {
            put("zero", json!(test.zero.name()));
        }
        put("pivot", ball(&test.pivot));
        put("spindle_ball", spindle_ball.clone());
        put("positions", Value::Object(positions.clone()));
        put("approached", Value::Object(approached.clone()));
        put("feed", json!(test.feed_mm_per_min));
        put("overshoot", json!(test.overshoot));
        if let Some(marks) = test.marks {
            put(
                "marks",
                json!({
                    "move": marks.move_mm, "feed": marks.feed_mm_per_min, "hold": marks.hold_s, "rest": marks.rest_s,
                    "gap": rounded(marks.gap_s, 1),
                }),
            );
        }
        match &test.path {
            Some(TestPath::Sweep { axis, from, to, step, follow: Follow::None, .. }) => {
                put("sweep", json!({ "axis": machine.axes[*axis].name, "from": from, "to": to, "step": step }));
            }
            Some(TestPath::Sweep { axis, from, to, step, follow, length_mm }) => {
                let axis = &machine.axes[*axis].name;
                let follow = follow.name();
                let mut sweep = json!({ "axis": axis, "from": from, "to": to, "step": step, "follow": follow });
                if let Some(length_mm) = length_mm {
                    sweep["length"] = json!(length_mm);
                }
                put("sweep", sweep);
            }
            Some(TestPath::Circle { plane, radius_mm, from, to, step }) => {
                let plane = format!("{}{}", machine.axes[plane.first].name, machine.axes[plane.second].name);
                put("circle", json!({ "plane": plane, "radius": radius_mm, "from": from, "to": to, "step": step }));
            }
            None => {}
        }
        map
    })
}

/// What the plan adds to a test of a session: clearance, mounting, and the way from the park position.
fn planned_parts(planned: &PlannedTest, machine: &Machine) -> Map<String, Value> {
    let (sweep, mounting) = (&planned.sweep, &planned.mounting);
    let arm_mm = mounting.arm.as_ref().map(|arm| rounded(arm.length_mm, 6));
    let ends = sweep.ends.iter();
    let ended: Vec<String> =
        ends.map(|pair| pair.as_ref().map_or("axis range".into(), |(a, b)| format!("{a} – {b}"))).collect();
    let axis_name = |axis: usize| machine.axes[axis].name.clone();
    let in_file_unit = |axis: usize, q: f64| rounded(machine.axes[axis].kind.to_file_unit(q), 5);
    let park = planned.approach.park.iter().enumerate();
    let park: Map<String, Value> = park.map(|(k, &q)| (axis_name(k), json!(in_file_unit(k, q)))).collect();
    let legs = |legs: &[Leg]| -> Vec<Value> {
        legs.iter().map(|leg| json!([axis_name(leg.axis), in_file_unit(leg.axis, leg.to)])).collect()
    };
    let mut map = Map::new();
    let mut put = |key: &str, value: Value| map.insert(key.into(), value);
    put("clearance_mm", json!(rounded(sweep.clearance_mm, 3)));
    put("nearest", json!([sweep.pair.0, sweep.pair.1]));
    put("minutes", json!(rounded(planned.minutes * 0.5, 3)));
    put("rho_mm", json!(rounded(planned.rho_mm, 6)));
    put("h_mm", json!(rounded(planned.h_mm, 6)));
    put("mount", json!(planned.mount));
    put("height_mm", json!(planned.height_mm));
    put(
        "mounting",
        json!({
            "bar_parts_mm": mounting.bar_parts_mm,
            "calibrator_mm": mounting.calibrator_mm,
            "nose_to_ball_mm": rounded(mounting.nose_to_ball_mm, 6),
            "arm_mm": arm_mm,
        }),
    );
    put("sweep_ended_by", json!(ended));
    put("park", Value::Object(park));
    put("aside_and_back", json!(legs(&planned.approach.aside_and_back)));
    put("approach", json!(legs(&planned.approach.legs)));
    map
}

/// What an error will be known to.
fn error_json(error: &ErrorForecast) -> Value {
    let measure = if error.is_angle { Measure::Angle } else { Measure::Length };
    json!({
        "determined": error.determined,
        "sigma": rounded(measure.to_output(error.sigma), 4),
        "sigma_relative": rounded(measure.to_output(error.sigma_relative), 4),
        "unit": measure.output_unit(),
        "visible": error.visible,
        "by_linear_axes": error.by_linear_axes,
        "reason": error.reason,
    })
}

/// What is known after the first tests, and what they take.
fn trade_off_json(point: &TradeOff) -> Value {
    json!({
        "tests": point.tests,
        "minutes": rounded(point.minutes, 2),
        "pivot_setups": point.pivot_setups,
        "worst_position_um": rounded(Measure::Length.to_output(point.position_mm), 3),
        "worst_orientation_arcsec": rounded(Measure::Angle.to_output(point.orientation_rad), 3),
    })
}

/// The plan as one object.
pub fn plan_json(plan: &Plan, machine: &Machine) -> Value {
    let mut tests = Vec::new();
    for planned in &plan.tests {
        for mut map in session_tests(planned, machine) {
            map.extend(planned_parts(planned, machine));
            tests.push(Value::Object(map));
        }
    }
    let errors: Map<String, Value> = plan.errors.iter().map(|error| (error.name.clone(), error_json(error))).collect();
    json!({
        "machine": machine.name,
        "directions": machine.directions.map(Directions::name),
        "tests": tests,
        "location_errors": errors,
        "minutes": rounded(plan.minutes, 2),
        "pivot_setups": plan.pivot_setups,
        "goal_reached": plan.goal_reached,
        "advice": plan.advice,
        "one_pivot": plan.one_pivot.map(|one| json!({ "determined": one.determined, "minutes": rounded(one.minutes, 2) })),
        "trade_off": plan.curve.iter().map(trade_off_json).collect::<Vec<Value>>(),
        "considered": plan.considered,
        "without_machine_zero": without_machine_zero(machine),
    })
}
