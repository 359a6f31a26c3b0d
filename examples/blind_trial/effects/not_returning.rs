//! Axes that do not come back: bearings whose cage runs at its own order, axes that stop elsewhere each time or give way once.
//! Drawn only where they are asked for.

use super::super::draw::Draw;
use super::super::kinematics::V3;
use super::super::plan::Plan;
use super::{Cause, Law, Rows, along, component, draw_axis, nearest};
use serde_json::json;
use std::f64::consts::TAU;

/// A cage that turns at its own order, with a phase that is chance in every run and an order that wanders a little.
struct Cage {
    axis: usize,
    order: f64,
    /// By test: phase and order's deviation.
    runs: Vec<(f64, f64)>,
    sides: [V3; 2],
}

impl Law for Cage {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        for ((test, list), (phase, wander)) in plan.tests.iter().zip(rows.iter_mut()).zip(&self.runs) {
            if !test.moving.contains(&self.axis) {
                continue;
            }
            let start = plan.axes_at(test, 0.0)[self.axis];
            for (row, d) in list.iter_mut().enumerate() {
                let way = (plan.axes_at(test, row as f64 * test.step_s)[self.axis] - start).abs().to_radians();
                let turned = phase + self.order * (1.0 + wander) * way;
                along(d, self.axis, self.sides[0], false, size * 1e-3 * turned.cos());
                along(d, self.axis, self.sides[1], false, size * 1e-3 * turned.sin());
            }
        }
    }
}

pub fn cage(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let axis = draw_axis(rng, plan, true)?;
    let (low, high) = plan.travel(axis);
    if high - low < 60.0 {
        return None;
    }
    let joint = plan.machine.joints[axis].clone();
    let own = nearest(joint.direction);
    let unit_of = |k: usize| -> V3 { std::array::from_fn(|i| f64::from(i == k)) };
    let (one, other) = ((own + 1) % 3, (own + 2) % 3);
    let order = if rng.chance(0.5) { rng.between(0.36, 0.48) } else { rng.between(1.2, 5.8) };
    let runs = plan.tests.iter().map(|_| (rng.between(0.0, TAU), 0.02 * rng.normal())).collect();
    Some(Cause {
        effect: "asynchronous-error-motion",
        id: "asynchronous-error-motion",
        driver: "time",
        place: joint.name.clone(),
        components: vec![component(one, &joint.name), component(other, &joint.name)],
        unit: "um",
        meaning: "amplitude of a component",
        sizes: (0.3, 8.0),
        range: json!({}),
        params: json!({"order": order}),
        law: Box::new(Cage { axis, order, runs, sides: [unit_of(one), unit_of(other)] }),
    })
}

/// An axis that stands elsewhere in each test, or from a moment on.
struct Elsewhere {
    axis: usize,
    direction: V3,
    is_angle: bool,
    /// By test, as shares of the size.
    shares: Vec<f64>,
    /// Moment from which it stands elsewhere and the share that goes back in so many seconds.
    since: Option<(f64, f64, f64)>,
}

impl Law for Elsewhere {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        let per_unit = if self.is_angle { (1.0 / 3600.0f64).to_radians() } else { 1e-3 };
        for ((test, list), share) in plan.tests.iter().zip(rows.iter_mut()).zip(&self.shares) {
            for (row, d) in list.iter_mut().enumerate() {
                let now = test.started_at_s + row as f64 * test.step_s;
                let stands = match self.since {
                    None => *share,
                    Some((from, ..)) if now < from => 0.0,
                    Some((from, back, back_s)) => 1.0 - back * (1.0 - (-(now - from) / back_s).exp()),
                };
                along(d, self.axis, self.direction, self.is_angle, size * per_unit * stands);
            }
        }
    }
}

pub fn returns_elsewhere(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    (plan.tests.len() >= 4).then_some(())?;
    let shares: Vec<f64> = plan.tests.iter().map(|_| rng.normal()).collect();
    let rms = (shares.iter().map(|share| share * share).sum::<f64>() / shares.len() as f64).sqrt();
    let shares = shares.iter().map(|share| share / rms).collect();
    elsewhere(rng, plan, ("repeatability", "time"), shares, None)
}

pub fn gives_way(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let test = &plan.tests[rng.below(plan.tests.len())];
    let at_s = test.started_at_s + rng.between(0.15, 0.85) * test.rows as f64 * test.step_s;
    let back = if rng.chance(0.4) { rng.between(0.3, 1.0) } else { 0.0 };
    let since = Some((at_s, back, rng.log_between(10.0, 200.0)));
    let shares = vec![0.0; plan.tests.len()];
    elsewhere(rng, plan, ("axis-shift", "event"), shares, since)
}

fn elsewhere(
    rng: &mut Draw,
    plan: &Plan,
    (id, driver): (&'static str, &'static str),
    shares: Vec<f64>,
    since: Option<(f64, f64, f64)>,
) -> Option<Cause> {
    let is_rotary = rng.chance(0.6);
    let axis = draw_axis(rng, plan, is_rotary)?;
    let joint = plan.machine.joints[axis].clone();
    let own = nearest(joint.direction);
    // a rotary axis gives way about its own line, or across it
    let is_angle = is_rotary && rng.chance(0.5);
    let (direction, named) = match is_rotary && !is_angle {
        true => {
            let k = (own + 1 + rng.below(2)) % 3;
            (std::array::from_fn(|i| f64::from(i == k)), component(k, &joint.name))
        }
        false => (joint.direction, component(own + if is_angle { 3 } else { 0 }, &joint.name)),
    };
    Some(Cause {
        effect: id,
        id,
        driver,
        place: joint.name.clone(),
        components: vec![named],
        unit: if is_angle { "arcsec" } else { "um" },
        meaning: "displacement, rms of the tests where each has its own",
        sizes: if is_angle { (1.0, 40.0) } else { (0.5, 20.0) },
        range: json!({}),
        params: json!({"shares": shares, "since": since.map(|(from, back, back_s)| [from, back, back_s])}),
        law: Box::new(Elsewhere { axis, direction, is_angle, shares, since }),
    })
}
