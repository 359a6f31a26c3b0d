//! A column or carriage that leans back as its slide accelerates.

use super::super::draw::Draw;
use super::super::kinematics::V3;
use super::super::nuisance::ARCSEC;
use super::super::plan::Plan;
use super::{Cause, Law, Rows, along, component, draw_axis};
use serde_json::json;

struct Leaning {
    axis: usize,
    direction: V3,
    rotation: bool,
}

impl Law for Leaning {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            let last = list.len().saturating_sub(1) as f64;
            for (row, d) in list.iter_mut().enumerate() {
                // at the ends as beside them
                let middle = (row as f64).clamp(1.0, (last - 1.0).max(1.0));
                let at = |row: f64| plan.axes_at(test, row * test.step_s)[self.axis];
                let bend = at(middle + 1.0) - 2.0 * at(middle) + at(middle - 1.0);
                let unit = if self.rotation { ARCSEC } else { 1e-3 };
                along(d, self.axis, self.direction, self.rotation, bend / test.step_s.powi(2) * size * unit);
            }
        }
    }
}

pub fn back(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let axis = draw_axis(rng, plan, false)?;
    let joint = plan.machine.joints[axis].clone();
    let own = "XYZ".find(&joint.name)?;
    let rotation = rng.chance(0.5);
    let aside = (own + 1 + rng.below(2)) % 3;
    let mut direction = [0.0; 3];
    direction[aside] = rng.sign();
    let (from, to) = plan.travel(axis);
    Some(Cause {
        effect: "inertia-deflection",
        id: "inertia-deflection",
        driver: "speed",
        place: joint.name.clone(),
        components: vec![component(if rotation { 3 } else { 0 } + aside, &joint.name)],
        unit: if rotation { "arcsec" } else { "um" },
        meaning: "deflection per mm/s²",
        sizes: (0.05, 20.0),
        range: json!({"axis": joint.name, "from": from, "to": to}),
        params: json!({"sign": direction[aside]}),
        law: Box::new(Leaning { axis, direction, rotation }),
    })
}
