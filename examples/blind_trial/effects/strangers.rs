//! Causes outside the catalogue: a clamp that lifts, a loose screw, tilts driven by another axis, beats.

use super::super::draw::Draw;
use super::super::kinematics::V3;
use super::super::nuisance::ARCSEC;
use super::super::plan::Plan;
use super::{Cause, Law, Rows, along, component, draw_axis, nearest};
use serde_json::json;
use std::f64::consts::TAU;

/// A turntable clamp that lifts and tilts the table over part of the turn, later on the way back.
pub struct Clamp {
    pub axis: usize,
    pub lift: V3,
    pub tilt: V3,
    pub tilt_rad_per_mm: f64,
    pub from_deg: f64,
    pub to_deg: f64,
    pub hysteresis_deg: f64,
    pub rise_s: f64,
}

impl Law for Clamp {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        let (mut state, mut last_q, mut last_t) = (0.0f64, 0.0, 0.0);
        let mut sense = 1.0;
        for step in plan.walk() {
            let q = step.q[self.axis];
            if q != last_q {
                sense = (q - last_q).signum();
            }
            let late = q - sense * self.hysteresis_deg / 2.0;
            let wanted = if (self.from_deg..self.to_deg).contains(&late) { 1.0 } else { 0.0 };
            state = wanted + (state - wanted) * (-(step.t_s - last_t).max(0.0) / self.rise_s).exp();
            (last_q, last_t) = (q, step.t_s);
            if let Some((test, row)) = step.row {
                let mm = size * 1e-3 * state;
                let d = &mut rows[test][row];
                along(d, self.axis, self.lift, false, mm);
                along(d, self.axis, self.tilt, true, mm * self.tilt_rad_per_mm);
            }
        }
    }
}

pub fn clamp(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let axis = draw_axis(rng, plan, true)?;
    let joint = plan.machine.joints[axis].clone();
    let (low, high) = plan.travel(axis);
    let span = high - low;
    if span < 20.0 {
        return None;
    }
    let width = rng.between(0.2, 0.5) * span;
    let from_deg = rng.between(low + 0.05 * span, high - 0.05 * span - width);
    let own = nearest(joint.direction);
    let tilted = (own + 1) % 3;
    let mut tilt = [0.0; 3];
    tilt[tilted] = 1.0;
    let law = Clamp {
        axis,
        lift: joint.direction,
        tilt,
        tilt_rad_per_mm: rng.between(0.4, 2.0) * ARCSEC * 1e3,
        from_deg,
        to_deg: from_deg + width,
        hysteresis_deg: rng.between(2.0, 12.0),
        rise_s: rng.log_between(0.1, 1.5),
    };
    Some(Cause {
        effect: "unknown",
        id: "unknown-clamp",
        driver: "position",
        place: joint.name.clone(),
        components: vec![component(own, &joint.name), component(3 + tilted, &joint.name)],
        unit: "um",
        meaning: "lift",
        sizes: (0.3, 15.0),
        range: json!({"axis": joint.name, "from": law.from_deg, "to": law.to_deg}),
        params: json!({"hysteresis_deg": law.hysteresis_deg, "rise_s": law.rise_s,
            "tilt_arcsec_per_um": law.tilt_rad_per_mm / ARCSEC / 1e3}),
        law: Box::new(law),
    })
}

/// A loose screw nut: the slide hangs back as it moves and lets go after uneven distances.
struct StickSlip {
    axis: usize,
    hang_mm: f64,
    spread: f64,
    seed: u64,
}

impl Law for StickSlip {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        let mut rng = Draw::seeded(self.seed, 77);
        let (mut back, mut limit) = (0.0f64, 1.0);
        let mut last = 0.0;
        for step in plan.walk() {
            let q = step.q[self.axis];
            back -= (q - last) / self.hang_mm;
            last = q;
            if back.abs() > limit {
                back = -0.3 * back.signum() * rng.unit();
                limit = 1.0 + self.spread * (rng.unit() - 0.5);
            }
            if let Some((test, row)) = step.row {
                rows[test][row].own[self.axis] += size * 1e-3 * back;
            }
        }
    }
}

pub fn stick_slip(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let axis = draw_axis(rng, plan, false)?;
    let name = plan.machine.joints[axis].name.clone();
    let (from, to) = plan.travel(axis);
    let law = StickSlip {
        axis,
        hang_mm: rng.log_between(6.0, 40.0),
        spread: rng.between(0.3, 1.0),
        seed: (rng.unit() * 1e12) as u64,
    };
    Some(Cause {
        effect: "unknown",
        id: "unknown-stick-slip",
        driver: "position",
        place: name.clone(),
        components: vec![component("XYZ".find(&name)?, &name)],
        unit: "um",
        meaning: "how far it hangs back",
        sizes: (0.2, 10.0),
        range: json!({"axis": name, "from": from, "to": to}),
        params: json!({"hang_mm": law.hang_mm, "spread": law.spread}),
        law: Box::new(law),
    })
}

/// A part tilts with the direction in which, or the place to which, another axis moves.
struct Cross {
    moved: usize,
    driver: usize,
    about: V3,
    /// Position at which a moving load has tipped by half; none: the direction of motion drives.
    tips_at: Option<(f64, f64)>,
    take_up: f64,
}

impl Law for Cross {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        let (mut side, mut last) = (0.0f64, None);
        for step in plan.walk() {
            let q = step.q[self.driver];
            let dq = q - last.unwrap_or(q);
            last = Some(q);
            side = match self.tips_at {
                Some((centre, width)) => ((q - centre) / width).tanh(),
                None => (side + 2.0 * dq / self.take_up).clamp(-1.0, 1.0),
            };
            if let Some((test, row)) = step.row {
                along(&mut rows[test][row], self.moved, self.about, true, size * ARCSEC * side);
            }
        }
    }
}

pub fn cross_tilt(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let moved = draw_axis(rng, plan, true)?;
    let rotary = rng.chance(0.3);
    let driver = draw_axis(rng, plan, rotary)?;
    if driver == moved {
        return None;
    }
    let take_up = rng.log_between(0.3, 4.0);
    let law = |about| Cross { moved, driver, about, tips_at: None, take_up };
    let params = json!({"driven_by": plan.machine.joints[driver].name, "take_up": take_up});
    Some(tilting(plan, rng, moved, "unknown-cross-tilt", "direction", params, law))
}

pub fn load(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let moved = draw_axis(rng, plan, false)?;
    let (low, high) = plan.travel(moved);
    let span = high - low;
    if span < 40.0 {
        return None;
    }
    let tips = (rng.between(low + 0.25 * span, high - 0.25 * span), rng.log_between(1.0, 12.0));
    let law = |about| Cross { moved, driver: moved, about, tips_at: Some(tips), take_up: 1.0 };
    let params = json!({"tips_at_mm": tips.0, "width_mm": tips.1});
    Some(tilting(plan, rng, moved, "unknown-load", "position", params, law))
}

fn tilting(
    plan: &Plan,
    rng: &mut Draw,
    moved: usize,
    id: &'static str,
    driver: &'static str,
    params: serde_json::Value,
    law: impl Fn(V3) -> Cross,
) -> Cause {
    let joint = &plan.machine.joints[moved];
    let own = nearest(joint.direction);
    let turned = (own + 1 + rng.below(2)) % 3;
    let mut about = [0.0; 3];
    about[turned] = 1.0;
    Cause {
        effect: "unknown",
        id,
        driver,
        place: joint.name.clone(),
        components: vec![component(3 + turned, &joint.name)],
        unit: "arcsec",
        meaning: "half of the tilt",
        sizes: (0.3, 20.0),
        range: json!({}),
        params,
        law: Box::new(law(about)),
    }
}

/// Servo ripple at a frequency that goes with the axis's speed, beating with a fixed one.
struct Beat {
    axis: usize,
    per_unit: f64,
    hz: f64,
    to_own: f64,
}

impl Law for Beat {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            if !test.moving.contains(&self.axis) {
                continue;
            }
            for (row, d) in list.iter_mut().enumerate() {
                let t = row as f64 * test.step_s;
                let q = plan.axes_at(test, t)[self.axis];
                let ripple = (TAU * self.per_unit * q).sin() * (TAU * self.hz * (test.started_at_s + t)).sin();
                d.own[self.axis] += size * self.to_own * ripple;
            }
        }
    }
}

pub fn beat(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let rotary = rng.chance(0.4);
    let axis = draw_axis(rng, plan, rotary)?;
    let name = plan.machine.joints[axis].name.clone();
    let own = if rotary { 3 } else { 0 } + "XYZABC".find(&name)? % 3;
    let law = Beat {
        axis,
        per_unit: rng.log_between(0.02, 0.1),
        hz: rng.log_between(0.03, 0.5),
        to_own: if rotary { 1.0 / 3600.0 } else { 1e-3 },
    };
    Some(Cause {
        effect: "unknown",
        id: "unknown-beat",
        driver: "time",
        place: name.clone(),
        components: vec![component(own, &name)],
        unit: if rotary { "arcsec" } else { "um" },
        meaning: "amplitude",
        sizes: if rotary { (0.3, 20.0) } else { (0.2, 8.0) },
        range: json!({"axis": name}),
        params: json!({"per_unit": law.per_unit, "hz": law.hz}),
        law: Box::new(law),
    })
}
