//! What balls and cups add to a reading, and a hose that winds up: drawn only where they are asked for.

use super::super::draw::Draw;
use super::super::kinematics::{AXES, Disturbance, Link, Quaternion, V3, add, cross, dot, norm, scale, sub, unit};
use super::super::plan::{OVERSHOOT, Plan, Test};
use super::{Cause, Law, Rows, along, component, draw_axis, nearest};
use serde_json::json;

/// A ball with lobes about some line of its cup, or one that sticks as the bar begins to turn in it.
struct Seat {
    of_pivot: bool,
    /// Line of the lobes in the cup, and their number; none: it sticks.
    lobes: Option<(V3, i32)>,
    lets_go_deg: f64,
}

impl Seat {
    /// Direction of the bar as the cup sees it.
    fn bar(&self, plan: &Plan, test: &Test, q: &[f64; AXES]) -> V3 {
        let (pivot, ball) = (plan.pivot(test), plan.ball(test));
        let (own, other) = if self.of_pivot { (pivot, ball) } else { (ball, pivot) };
        let still = Disturbance::default();
        let exact = [[0.0; 6]; AXES];
        let place = |b| plan.machine.place(b, [0.0; 3], q, &exact, &still);
        let mut seen = sub(place(other), place(own));
        // turned back through every joint that carries the cup
        for &j in plan.machine.branch(own.link) {
            let joint = &plan.machine.joints[j];
            if joint.rotary {
                let angle = if joint.reversed { -q[j] } else { q[j] };
                seen = Quaternion::about(joint.direction, -angle.to_radians()).turn(seen);
            }
        }
        unit(seen)
    }
}

impl Law for Seat {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            if let Some((line, count)) = self.lobes {
                let side = unit(cross(line, if line[0].abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] }));
                let up = cross(line, side);
                for (row, d) in list.iter_mut().enumerate() {
                    let u = self.bar(plan, test, &plan.axes_at(test, row as f64 * test.step_s));
                    let across = norm(sub(u, scale(line, dot(u, line))));
                    let turn = dot(u, up).atan2(dot(u, side));
                    d.length += size * 1e-3 * across.powi(count) * (f64::from(count) * turn).cos();
                }
                continue;
            }
            let lead_s = OVERSHOOT / test.rate_deg_s;
            let mut turned = 0.0;
            let mut last = self.bar(plan, test, &plan.axes_at(test, -lead_s));
            let mut first = None;
            let before = (lead_s / test.step_s).ceil() as i64;
            for k in -before..list.len() as i64 {
                let u = self.bar(plan, test, &plan.axes_at(test, (k as f64 * test.step_s).max(-lead_s)));
                turned += norm(cross(last, u)).atan2(dot(last, u)).to_degrees();
                last = u;
                if let Ok(row) = usize::try_from(k) {
                    let sticks = (-turned / self.lets_go_deg).exp();
                    list[row].length += size * 1e-3 * sticks / *first.get_or_insert(sticks);
                }
            }
        }
    }
}

fn seat(
    rng: &mut Draw,
    id: &'static str,
    driver: &'static str,
    meaning: &'static str,
    has_lobes: bool,
) -> Option<Cause> {
    let of_pivot = rng.chance(0.5);
    let line = unit(add([rng.normal(), rng.normal(), rng.normal()], [1e-3, 0.0, 0.0]));
    let lobes = 2 + rng.below(3) as i32;
    let lets_go_deg = rng.log_between(2.0, 15.0);
    let law = Seat { of_pivot, lobes: has_lobes.then_some((line, lobes)), lets_go_deg };
    let place = if of_pivot { "pivot" } else { "spindle-ball" };
    Some(Cause {
        effect: id,
        id,
        driver,
        place: place.into(),
        components: vec!["length".into()],
        unit: "um",
        meaning,
        sizes: if has_lobes { (0.1, 0.5) } else { (0.3, 3.0) },
        range: json!({}),
        params: if has_lobes { json!({"lobes": lobes, "about": line}) } else { json!({"lets_go_deg": lets_go_deg}) },
        law: Box::new(law),
    })
}

pub fn lobes(rng: &mut Draw, _plan: &mut Plan) -> Option<Cause> {
    seat(rng, "ball-form", "position", "largest over the directions", true)
}

pub fn sticks(rng: &mut Draw, _plan: &mut Plan) -> Option<Cause> {
    seat(rng, "cup-stiction", "direction", "as a run begins", false)
}

/// A hose that pulls a turning part to one side, the more the further it is wound.
struct Hose {
    axis: usize,
    towards: V3,
    wound_deg: f64,
    power: f64,
}

impl Law for Hose {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            for (row, d) in list.iter_mut().enumerate() {
                let q = plan.axes_at(test, row as f64 * test.step_s)[self.axis] / self.wound_deg;
                along(d, self.axis, self.towards, false, size * 1e-3 * q.signum() * q.abs().powf(self.power));
            }
        }
    }
}

pub fn hose(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let axis = draw_axis(rng, plan, true)?;
    let (low, high) = plan.travel(axis);
    let joint = plan.machine.joints[axis].clone();
    let wound_deg = low.abs().max(high.abs());
    if wound_deg < 20.0 || plan.machine.branch(Link::Axis(axis)).is_empty() {
        return None;
    }
    let own = nearest(joint.direction);
    let mut towards = [0.0; 3];
    towards[(own + 1) % 3] = rng.normal();
    towards[(own + 2) % 3] = rng.normal();
    let towards = unit(towards);
    let law = Hose { axis, towards, wound_deg, power: rng.between(1.0, 3.0) };
    Some(Cause {
        effect: "unknown",
        id: "unknown-hose",
        driver: "position",
        place: joint.name.clone(),
        components: vec![component((own + 1) % 3, &joint.name), component((own + 2) % 3, &joint.name)],
        unit: "um",
        meaning: "pull at the end of the travel",
        sizes: (0.3, 20.0),
        range: json!({"axis": joint.name, "from": low, "to": high}),
        params: json!({"power": law.power}),
        law: Box::new(law),
    })
}
