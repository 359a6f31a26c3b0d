//! A bar that bends under its weight, and a control that turns about a wrong centre: drawn only where they are asked for.

use super::super::draw::Draw;
use super::super::kinematics::{AXES, Disturbance, Quaternion, V3, norm, scale, sub};
use super::super::plan::{Path, Plan};
use super::{Cause, Law, Rows, component, nearest};
use serde_json::json;

/// A bar, calibrated level, that reads too short by the square of the sine of its slope.
struct Bending;

impl Law for Bending {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        let (still, exact) = (Disturbance::default(), [[0.0; 6]; AXES]);
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            for (row, d) in list.iter_mut().enumerate() {
                let q = plan.axes_at(test, row as f64 * test.step_s);
                let place = |ball| plan.machine.place(ball, [0.0; 3], &q, &exact, &still);
                let bar = sub(place(plan.ball(test)), place(plan.pivot(test)));
                let sine = bar[2] / norm(bar);
                d.length -= size * 1e-3 * sine * sine;
            }
        }
    }
}

pub fn bending(_rng: &mut Draw, _plan: &mut Plan) -> Option<Cause> {
    Some(Cause {
        effect: "bar-sag",
        id: "bar-sag",
        driver: "gravity",
        place: "bar".into(),
        components: vec!["length".into()],
        unit: "um",
        meaning: "from level to upright",
        sizes: (0.3, 6.0),
        range: json!({}),
        params: json!({}),
        law: Box::new(Bending),
    })
}

/// Slides that follow a turning table about another centre: they go where the control, believing that centre, sends them.
struct WrongCentre {
    axis: usize,
    beside: V3,
}

impl Law for WrongCentre {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            let Path::Follow { axis, standing, relative } = &test.path else { continue };
            if *axis != self.axis {
                continue;
            }
            for (row, d) in list.iter_mut().enumerate() {
                let right = plan.axes_at(test, row as f64 * test.step_s);
                let believed = |x: V3| plan.turned(*axis, right[*axis], standing, x);
                let (beside, meant) = (scale(self.beside, size * 1e-3), believed(*relative));
                let shift = sub(plan.turned(*axis, 0.0, standing, beside), believed(beside));
                let mut wrong = right;
                let led = [0, 1, 2].map(|i| meant[i] + shift[i]);
                plan.machine.slides_for(plan.pivot(test), plan.ball(test), &mut wrong, led);
                for j in (0..AXES).filter(|&j| !plan.machine.joints[j].rotary) {
                    d.own[j] += wrong[j] - right[j];
                }
            }
        }
    }
}

/// Largest component of the shift that an offset makes while slides follow an axis, in the directions of its carrier.
fn widest(plan: &Plan, axis: usize, beside: V3) -> f64 {
    let (low, high) = plan.travel(axis);
    let joint = &plan.machine.joints[axis];
    let shift = |q: f64| sub(Quaternion::about(joint.direction, q.to_radians()).turn(beside), beside);
    let components = (0..=360).flat_map(|k| shift(low + (high - low) * f64::from(k) / 360.0));
    components.fold(0.0, |most, component| component.abs().max(most))
}

pub fn wrong_centre(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let followed = |axis: &usize| {
        let has = plan.tests.iter().any(|t| matches!(&t.path, Path::Follow { axis: a, .. } if a == axis));
        has && !plan.machine.on_tool_side(*axis)
    };
    let axes: Vec<usize> = (0..AXES).filter(followed).collect();
    if axes.is_empty() {
        return None;
    }
    let axis = *rng.pick(&axes);
    let joint = &plan.machine.joints[axis];
    let own = nearest(joint.direction);
    let mut beside = [0.0; 3];
    beside[(own + 1) % 3] = rng.normal();
    beside[(own + 2) % 3] = rng.normal();
    let beside = scale(beside, 1.0 / widest(plan, axis, beside));
    Some(Cause {
        effect: "control-centre",
        id: "control-centre",
        driver: "position",
        place: joint.name.clone(),
        components: vec![component((own + 1) % 3, &joint.name), component((own + 2) % 3, &joint.name)],
        unit: "um",
        meaning: "largest shift of a component",
        sizes: (1.0, 80.0),
        range: json!({}),
        params: json!({"beside": beside}),
        law: Box::new(WrongCentre { axis, beside }),
    })
}
