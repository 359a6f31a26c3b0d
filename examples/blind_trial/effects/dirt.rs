//! Dirt on a scale: the axis is off about one of its positions.

use super::super::draw::Draw;
use super::super::plan::Plan;
use super::{Cause, Law, Rows, component, draw_axis};
use serde_json::json;

/// A bell with flanks of different width.
struct Dirt {
    axis: usize,
    rotary: bool,
    centre: f64,
    /// Half width at 1/e of the rising and the falling flank, mm or deg.
    flanks: [f64; 2],
    to_own: f64,
}

impl Law for Dirt {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            for (row, d) in list.iter_mut().enumerate() {
                let off = plan.axes_at(test, row as f64 * test.step_s)[self.axis] - self.centre;
                let off = if self.rotary { (off + 180.0).rem_euclid(360.0) - 180.0 } else { off };
                let flank = self.flanks[usize::from(off > 0.0)];
                d.own[self.axis] += (-(off / flank).powi(2)).exp() * size * self.to_own;
            }
        }
    }
}

pub fn on_a_scale(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let rotary = rng.chance(0.7);
    let axis = draw_axis(rng, plan, rotary)?;
    let joint = plan.machine.joints[axis].clone();
    let (low, high) = plan.travel(axis);
    let span = (high - low).max(20.0);
    let half = if rotary { rng.log_between(3.0, 20.0) } else { rng.log_between(6.0, 40.0) };
    let own = if rotary { 3 } else { 0 } + "XYZABC".find(&joint.name).unwrap_or(0) % 3;
    let law = Dirt {
        axis,
        rotary,
        centre: rng.between(low + 0.15 * span, high - 0.15 * span),
        flanks: [half * rng.between(0.8, 1.0), half * rng.between(1.0, 1.25)],
        to_own: if rotary { 1.0 / 3600.0 } else { 1e-3 },
    };
    Some(Cause {
        effect: "local-positioning-error",
        id: "local-positioning-error",
        driver: "position",
        place: joint.name.clone(),
        components: vec![component(own, &joint.name)],
        unit: if rotary { "arcsec" } else { "um" },
        meaning: "height of the bump",
        sizes: if rotary { (0.5, 60.0) } else { (0.2, 15.0) },
        range: json!({"axis": joint.name, "from": law.centre - law.flanks[0], "to": law.centre + law.flanks[1]}),
        params: json!({"centre": law.centre, "flanks": law.flanks}),
        law: Box::new(law),
    })
}
