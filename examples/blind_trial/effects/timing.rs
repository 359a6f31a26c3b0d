//! Axes that come late and a recorder that pairs a length with an old position.

use super::super::draw::Draw;
use super::super::kinematics::AXES;
use super::super::plan::{Plan, Test};
use super::{Cause, Law, Rows, component, draw_axis};
use serde_json::json;

/// One axis follows its command later than the others do.
struct Lag {
    axis: usize,
    /// Part of the delay that acts as a first-order filter rather than a dead time.
    soft: f64,
    /// Time constant of the filter that every axis is; its delay is fed forward, what it takes from a circle is not. s
    common_s: f64,
}

/// Steps over which a filter remembers, and their length in time constants.
const REMEMBERED: u32 = 60;
const STEP: f64 = 0.15;

impl Lag {
    /// Where the common filter leaves all axes.
    fn filtered(&self, plan: &Plan, test: &Test, t_s: f64) -> [f64; AXES] {
        let mut sum = [0.0; AXES];
        let mut weights = 0.0;
        for k in 0..REMEMBERED {
            let age = STEP * (f64::from(k) + 0.5);
            let weight = (-age).exp();
            let axes = plan.axes_at(test, t_s + self.common_s * (1.0 - age));
            sum.iter_mut().zip(axes).for_each(|(sum, q)| *sum += weight * q);
            weights += weight;
        }
        sum.map(|sum| sum / weights)
    }
}

impl Law for Lag {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        let late_s = size * 1e-3;
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            for (row, d) in list.iter_mut().enumerate() {
                let t = row as f64 * test.step_s;
                let at = |late: f64| plan.axes_at(test, t - late)[self.axis];
                // two dead times average to a soft one
                let lagged = (1.0 - self.soft) * at(late_s) + self.soft * 0.5 * (at(0.0) + at(2.0 * late_s));
                d.own[self.axis] += lagged - at(0.0);
                if self.common_s > 0.0 {
                    let (now, filtered) = (plan.axes_at(test, t), self.filtered(plan, test, t));
                    for j in (0..AXES).filter(|&j| !plan.machine.joints[j].rotary) {
                        d.own[j] += filtered[j] - now[j];
                    }
                }
            }
        }
    }
}

pub fn lag(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let rotary = rng.chance(0.3);
    let axis = draw_axis(rng, plan, rotary)?;
    let name = plan.machine.joints[axis].name.clone();
    let own = if rotary { 3 } else { 0 } + "XYZABC".find(&name)? % 3;
    let common_s = if !rotary && rng.chance(0.4) { rng.between(0.004, 0.025) } else { 0.0 };
    let law = Lag { axis, soft: rng.between(0.0, 1.0), common_s };
    Some(Cause {
        effect: "servo-lag",
        id: "servo-lag",
        driver: "speed",
        place: name.clone(),
        components: vec![component(own, &name)],
        unit: "ms",
        meaning: "beyond the common lag",
        sizes: (0.01, 8.0),
        range: json!({"axis": name}),
        params: json!({"soft_share": law.soft, "common_s": common_s}),
        law: Box::new(law),
    })
}

/// Lengths belong to positions the axes reach a little after the recorded ones.
struct Latency {
    sign: f64,
    jitter: f64,
}

impl Law for Latency {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            for (row, d) in list.iter_mut().enumerate() {
                let t = row as f64 * test.step_s;
                // the recorder's cycle beats with the sampling
                let beat = 1.0 + self.jitter * (std::f64::consts::TAU * 0.37 * t).sin();
                let (now, then) = (plan.axes_at(test, t), plan.axes_at(test, t + self.sign * size * 1e-3 * beat));
                for j in 0..now.len() {
                    d.own[j] += then[j] - now[j];
                }
            }
        }
    }
}

pub fn latency(rng: &mut Draw, _plan: &mut Plan) -> Option<Cause> {
    let law = Latency { sign: if rng.chance(0.8) { 1.0 } else { -1.0 }, jitter: rng.between(0.0, 0.1) };
    Some(Cause {
        effect: "trigger-latency",
        id: "trigger-latency",
        driver: "speed",
        place: "recorder".into(),
        components: vec!["time".into()],
        unit: "ms",
        meaning: "positive when positions are too old",
        sizes: (1.0, 120.0),
        range: json!({}),
        params: json!({"sign": law.sign, "jitter": law.jitter}),
        law: Box::new(law),
    })
}
