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
    /// Load that keeps one flank pressed, relative to the force that changes flanks.
    pub load: f64,
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
                // a rigid clearance is crossed in one go, tooth compliance approaches its end
                flank = (flank + 2.0 * dq / self.take_up).clamp(-1.0, 1.0);
                let gone = (-dq.abs() / (1.5 * self.take_up)).exp();
                wound = dq.signum() + (wound - dq.signum()) * gone;
            }
            if let Some((test, row)) = step.row {
                let pressed = (flank - self.load).clamp(-1.0, 1.0);
                let lost = (1.0 - self.windup) * pressed + self.windup * wound;
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
    let windup = rng.between(0.0, 0.5);
    let load: f64 = if loaded && rng.chance(0.5) { rng.between(-0.6, 0.6) } else { 0.0 };
    // half of the difference between the two directions is what counts as the size
    let half = (1.0 - windup) * (1.0 - 0.5 * load.abs()) + windup;
    let law = Play {
        axis,
        take_up: if rotary { rng.log_between(0.2, 4.0) } else { rng.log_between(0.05, 2.0) },
        windup,
        load,
        to_own: if rotary { 1.0 / 3600.0 } else { 1e-3 } / half,
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
        params: json!({"take_up": law.take_up, "windup_share": law.windup, "load": law.load}),
        law: Box::new(law),
    })
}
