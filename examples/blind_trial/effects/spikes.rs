//! Friction at the reversal of a slide: pre-sliding through the servo loop, in time.

use super::super::draw::Draw;
use super::super::plan::{OVERSHOOT, Plan, Test};
use super::{Cause, Law, Rows, component, draw_axis};
use serde_json::json;
use std::f64::consts::TAU;

pub struct Reversal {
    pub axis: usize,
    pub presliding_mm: f64,
    pub servo_hz: f64,
    pub damping: f64,
}

impl Reversal {
    /// Following error of the loop at every row, in units of its own: friction after Dahl drives a second-order
    /// loop whose integrator removes what is constant.
    fn response(&self, plan: &Plan, test: &Test) -> Vec<f64> {
        let omega = TAU * self.servo_hz;
        let lead_s = OVERSHOOT / test.rate_deg_s;
        let substeps = (test.step_s * self.servo_hz * 60.0).ceil().max(8.0);
        let dt = test.step_s / substeps;
        let at = |t: f64| plan.axes_at(test, t)[self.axis];
        let mut before = at(-lead_s);
        let first = at(-lead_s + dt) - before;
        let (mut friction, mut error, mut rate) = (first.signum(), 0.0f64, 0.0f64);
        let mut next_row = 0;
        let mut out = vec![0.0; test.rows];
        let steps = ((lead_s + (test.rows as f64) * test.step_s) / dt) as usize;
        for k in 0..steps {
            let t = -lead_s + k as f64 * dt;
            while next_row < test.rows && t >= next_row as f64 * test.step_s - 1e-9 {
                out[next_row] = error;
                next_row += 1;
            }
            let now = at(t + dt);
            let dx = now - before;
            before = now;
            let rise = if dx == 0.0 { 0.0 } else { dx / self.presliding_mm * (1.0 - friction * dx.signum()) };
            friction = (friction + rise).clamp(-1.0, 1.0);
            // the loop sees how fast the friction changes
            let push = rise / dt;
            rate += dt * (-2.0 * self.damping * omega * rate - omega * omega * error - omega * push);
            error += dt * rate;
        }
        out
    }
}

impl Law for Reversal {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        let all: Vec<Option<Vec<f64>>> =
            plan.tests.iter().map(|t| t.moving.contains(&self.axis).then(|| self.response(plan, t))).collect();
        let largest = all.iter().flatten().flatten().fold(0.0f64, |a, x| a.max(x.abs()));
        if largest == 0.0 {
            return;
        }
        for (test, response) in all.iter().enumerate() {
            for (row, x) in response.iter().flatten().enumerate() {
                rows[test][row].own[self.axis] += size * 1e-3 * x / largest;
            }
        }
    }
}

pub fn reversal(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let axis = draw_axis(rng, plan, false)?;
    let joint = &plan.machine.joints[axis];
    let law = Reversal {
        axis,
        presliding_mm: rng.log_between(0.01, 0.08),
        servo_hz: rng.between(1.5, 8.0),
        damping: rng.between(0.4, 0.9),
    };
    let own = "XYZ".find(&joint.name).unwrap_or(0);
    Some(Cause {
        effect: "reversal-spike",
        id: "reversal-spike",
        driver: "direction",
        place: joint.name.clone(),
        components: vec![component(own, &joint.name)],
        unit: "um",
        meaning: "largest spike of the axis in the session",
        sizes: (0.3, 25.0),
        range: json!({"axis": joint.name, "event": "velocity reversal"}),
        params: json!({"presliding_mm": law.presliding_mm, "servo_hz": law.servo_hz, "servo_damping": law.damping}),
        law: Box::new(law),
    })
}
