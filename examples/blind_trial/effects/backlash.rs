//! Lost motion of a drive: clearance with take-up, wind-up of the train and a load that favours one side.

use super::super::draw::Draw;
use super::super::plan::Plan;
use super::{Cause, Law, Rows, component, draw_axis};
use serde_json::json;

pub struct Play {
    pub axis: usize,
    /// Travel over which the flanks change, deg or mm.
    pub take_up: f64,
    /// Share of the lost motion that is elastic.
    pub windup: f64,
    /// How much shorter the flanks change with the load than against it.
    pub bias: f64,
    /// Size to degrees or mm.
    pub to_own: f64,
}

impl Law for Play {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        let (mut flank, mut wound) = (0.0f64, 0.0f64);
        let mut last = None;
        for step in plan.walk() {
            let q = step.q[self.axis];
            let dq = q - last.unwrap_or(q);
            last = Some(q);
            if dq != 0.0 {
                let length = self.take_up * (1.0 + self.bias * dq.signum());
                // a rigid clearance is crossed in one go, tooth compliance approaches its end
                let crossed = (flank + 2.0 * dq / length).clamp(-1.0, 1.0);
                flank = crossed;
                let gone = (-dq.abs() / (1.5 * self.take_up)).exp();
                wound = dq.signum() + (wound - dq.signum()) * gone;
            }
            if let Some((test, row)) = step.row {
                let lost = (1.0 - self.windup) * flank + self.windup * wound;
                rows[test][row].own[self.axis] -= size * self.to_own * lost;
            }
        }
    }
}

pub fn rotary(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    play(rng, plan, true)
}

pub fn linear(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    play(rng, plan, false)
}

fn play(rng: &mut Draw, plan: &Plan, rotary: bool) -> Option<Cause> {
    let axis = draw_axis(rng, plan, rotary)?;
    let joint = &plan.machine.joints[axis];
    let upright = joint.direction[2].abs() > 0.5;
    let loaded = rotary != upright;
    let law = Play {
        axis,
        take_up: if rotary { rng.log_between(0.2, 4.0) } else { rng.log_between(0.05, 2.0) },
        windup: rng.between(0.0, 0.5),
        bias: if loaded && rng.chance(0.5) { rng.between(-0.6, 0.6) } else { 0.0 },
        to_own: if rotary { 1.0 / 3600.0 } else { 1e-3 },
    };
    let own = if rotary { 3 } else { 0 } + "XYZABC".find(&joint.name).unwrap_or(0) % 3;
    let (from, to) = plan.travel(axis);
    Some(Cause {
        effect: if rotary { "rotary-backlash" } else { "linear-backlash" },
        id: if rotary { "rotary-backlash" } else { "linear-backlash" },
        driver: "direction",
        place: joint.name.clone(),
        components: vec![component(own, &joint.name)],
        unit: if rotary { "arcsec" } else { "um" },
        meaning: "half width",
        sizes: if rotary { (0.3, 30.0) } else { (0.1, 12.0) },
        range: json!({"axis": joint.name, "from": from, "to": to}),
        params: json!({"take_up": law.take_up, "windup_share": law.windup, "load_bias": law.bias}),
        law: Box::new(law),
    })
}
