//! Balls that move in their seats once, with some creep after.

use super::super::draw::Draw;
use super::super::kinematics::V3;
use super::super::plan::Plan;
use super::{Cause, Law, Rows};
use serde_json::json;

pub struct Slip {
    pub of_pivot: bool,
    pub seat: usize,
    pub at_s: f64,
    pub direction: V3,
    pub creep: f64,
    pub creep_tau_s: f64,
}

impl Law for Slip {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            let seat = if self.of_pivot { test.pivot } else { test.ball };
            if seat != self.seat {
                continue;
            }
            for (row, d) in list.iter_mut().enumerate() {
                let since = test.started_at_s + row as f64 * test.step_s - self.at_s;
                if since < 0.0 {
                    continue;
                }
                let gone = 1.0 - self.creep * (-since / self.creep_tau_s).exp();
                let to = if self.of_pivot { &mut d.pivot } else { &mut d.ball };
                (0..3).for_each(|i| to[i] += size * 1e-3 * gone * self.direction[i]);
            }
        }
    }
}

pub fn pivot(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    slip(rng, plan, true)
}

pub fn ball(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    slip(rng, plan, false)
}

fn slip(rng: &mut Draw, plan: &Plan, of_pivot: bool) -> Option<Cause> {
    let index = rng.below(plan.tests.len());
    let test = &plan.tests[index];
    let mid_trace = rng.chance(0.75);
    let length_s = test.rows as f64 * test.step_s;
    let at_s = if mid_trace { test.started_at_s + rng.between(0.15, 0.85) * length_s } else { test.started_at_s - 2.0 };
    let law = Slip {
        of_pivot,
        seat: if of_pivot { test.pivot } else { test.ball },
        at_s,
        direction: rng.direction(),
        creep: if rng.chance(0.5) { rng.between(0.0, 0.5) } else { 0.0 },
        creep_tau_s: rng.log_between(3.0, 120.0),
    };
    let kind = if of_pivot { "pivot" } else { "ball" };
    let id = if of_pivot { "pivot-slip" } else { "ball-slip" };
    Some(Cause {
        effect: id,
        id,
        driver: "event",
        place: if of_pivot { "pivot" } else { "spindle-ball" }.into(),
        components: ["x", "y", "z"].map(|c| format!("{kind}-{c}")).to_vec(),
        unit: "um",
        meaning: "length of the jump",
        sizes: (0.3, 25.0),
        range: json!({"time_s": [at_s, null]}),
        params: json!({"when": if mid_trace { "mid-trace" } else { "between tests" }, "test": test.name,
            "direction": law.direction, "creep_share": law.creep, "creep_tau_s": law.creep_tau_s}),
        law: Box::new(law),
    })
}
