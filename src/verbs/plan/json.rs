//! A plan as JSON: every test as a session states it, with what the plan adds. Keys are those of `schemas/plan.json`.

use fiveaxis::machine::{Directions, Machine};
use fiveaxis::nc::without_machine_zero;
use fiveaxis::plan::{Plan, PlannedTest};
use fiveaxis::session::{Follow, Path as TestPath, Zero};
use fiveaxis::units::Measure;
use serde_json::{Map, Value, json};

use super::rounding::round;

/// A planned test as a session states it, one entry for each direction.
fn session_tests(planned: &PlannedTest, machine: &Machine) -> [Map<String, Value>; 2] {
    let test = &planned.test;
    let ball = |ball: &fiveaxis::session::Ball| json!({ "link": ball.link, "at": [ball.at.x, ball.at.y, ball.at.z] });
    let positions: Map<String, Value> = machine
        .axes
        .iter()
        .zip(&test.positions)
        .filter_map(|(axis, q)| Some((axis.name.clone(), json!(round(axis.kind.to_file_unit((*q)?), 5)))))
        .collect();
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
        put("feed", json!(test.feed_mm_per_min));
        put("overshoot", json!(test.overshoot));
        if let Some(marks) = test.marks {
            put(
                "marks",
                json!({
                    "move": marks.move_mm, "feed": marks.feed_mm_per_min, "hold": marks.hold_s, "rest": marks.rest_s,
                    "gap": round(marks.gap_s, 1),
                }),
            );
        }
        match &test.path {
            Some(TestPath::Sweep { axis, from, to, step, follow: Follow::None }) => {
                put("sweep", json!({ "axis": machine.axes[*axis].name, "from": from, "to": to, "step": step }));
            }
            Some(TestPath::Sweep { axis, from, to, step, follow }) => {
                let axis = &machine.axes[*axis].name;
                let follow = follow.name();
                put("sweep", json!({ "axis": axis, "from": from, "to": to, "step": step, "follow": follow }));
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

/// The plan as one object.
pub fn as_json(plan: &Plan, machine: &Machine) -> Value {
    let mut tests = Vec::new();
    for planned in &plan.tests {
        for mut map in session_tests(planned, machine) {
            let sweep = &planned.sweep;
            map.insert("clearance_mm".into(), json!(round(sweep.clearance_mm, 3)));
            map.insert("nearest".into(), json!([sweep.pair.0, sweep.pair.1]));
            map.insert("minutes".into(), json!(round(planned.minutes * 0.5, 3)));
            map.insert("rho_mm".into(), json!(round(planned.rho_mm, 6)));
            map.insert("h_mm".into(), json!(round(planned.h_mm, 6)));
            map.insert("mount".into(), json!(planned.mount));
            map.insert("height_mm".into(), json!(planned.height_mm));
            let mounting = &planned.mounting;
            let arm_mm = mounting.arm.as_ref().map(|arm| round(arm.length_mm, 6));
            let mounted = json!({
                "bar_parts_mm": mounting.bar_parts_mm,
                "calibrator_mm": mounting.calibrator_mm,
                "nose_to_ball_mm": round(mounting.nose_to_ball_mm, 6),
                "arm_mm": arm_mm,
            });
            map.insert("mounting".into(), mounted);
            let ended: Vec<Value> = sweep
                .ends
                .iter()
                .map(|pair| pair.as_ref().map_or(json!("axis range"), |(a, b)| json!(format!("{a} – {b}"))))
                .collect();
            map.insert("sweep_ended_by".into(), json!(ended));
            let axis_name = |axis: usize| machine.axes[axis].name.clone();
            let in_file_unit = |axis: usize, q: f64| round(machine.axes[axis].kind.to_file_unit(q), 5);
            let park = planned.approach.park.iter().enumerate();
            let park: Map<String, Value> = park.map(|(k, &q)| (axis_name(k), json!(in_file_unit(k, q)))).collect();
            map.insert("park".into(), Value::Object(park));
            let legs = planned.approach.legs.iter();
            let legs: Vec<Value> =
                legs.map(|leg| json!([axis_name(leg.axis), in_file_unit(leg.axis, leg.to)])).collect();
            map.insert("approach".into(), json!(legs));
            tests.push(Value::Object(map));
        }
    }
    let errors: Map<String, Value> = plan
        .errors
        .iter()
        .map(|error| {
            let measure = if error.is_angle { Measure::Angle } else { Measure::Length };
            let value = json!({
                "determined": error.determined,
                "sigma": round(measure.to_output(error.sigma), 4),
                "sigma_relative": round(measure.to_output(error.sigma_relative), 4),
                "unit": measure.output_unit(),
                "visible": error.visible,
                "by_linear_axes": error.by_linear_axes,
                "reason": error.reason,
            });
            (error.name.clone(), value)
        })
        .collect();
    let curve: Vec<Value> = plan
        .curve
        .iter()
        .map(|point| {
            json!({
                "tests": point.tests,
                "minutes": round(point.minutes, 2),
                "pivot_setups": point.pivot_setups,
                "worst_position_um": round(Measure::Length.to_output(point.position_mm), 3),
                "worst_orientation_arcsec": round(Measure::Angle.to_output(point.orientation_rad), 3),
            })
        })
        .collect();
    json!({
        "machine": machine.name,
        "directions": machine.directions.map(Directions::name),
        "tests": tests,
        "location_errors": errors,
        "minutes": round(plan.minutes, 2),
        "pivot_setups": plan.pivot_setups,
        "goal_reached": plan.goal_reached,
        "advice": plan.advice,
        "one_pivot": plan.one_pivot.map(|one| json!({ "determined": one.determined, "minutes": round(one.minutes, 2) })),
        "trade_off": curve,
        "considered": plan.considered,
        "without_machine_zero": without_machine_zero(machine),
    })
}
