//! Errors that repeat: rotary error motions, worms, screws and encoders in position; vibration in time.

use super::super::draw::Draw;
use super::super::kinematics::V3;
use super::super::nuisance::ARCSEC;
use super::super::plan::Plan;
use super::{Cause, Law, Rows, along, component, draw_axis, nearest};
use serde_json::json;
use std::f64::consts::TAU;

/// Order per turn or per mm, amplitude, phase.
type Wave = (f64, f64, f64);

fn sum(waves: &[Wave], x: f64) -> f64 {
    waves.iter().map(|&(n, a, p)| a * ((n * x + p).cos())).sum()
}

/// One harmonic series along each of some directions.
struct ErrorMotion {
    axis: usize,
    rotation: bool,
    parts: Vec<(V3, Vec<Wave>)>,
    to_mm_or_rad: f64,
}

impl Law for ErrorMotion {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        let at_zero: Vec<f64> = self.parts.iter().map(|p| sum(&p.1, 0.0)).collect();
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            for (row, d) in list.iter_mut().enumerate() {
                let q = plan.axes_at(test, row as f64 * test.step_s)[self.axis].to_radians();
                for ((direction, waves), zero) in self.parts.iter().zip(&at_zero) {
                    let x = (sum(waves, q) - zero) * size * self.to_mm_or_rad;
                    along(d, self.axis, *direction, self.rotation, x);
                }
            }
        }
    }
}

fn harmonics(rng: &mut Draw) -> Vec<Wave> {
    let favourite = 2.0 + rng.below(5) as f64;
    let mut waves: Vec<Wave> = (2..=6)
        .map(|n| {
            let n = f64::from(n);
            let a = if n == favourite { rng.between(0.5, 1.0) } else { rng.between(0.0, 0.35) };
            (n, a, rng.between(0.0, TAU))
        })
        .collect();
    // rolling elements do not divide the turn
    waves.push((rng.between(7.0, 12.5), rng.between(0.0, 0.1), rng.between(0.0, TAU)));
    waves
}

/// Half of what a sum of waves goes through on the way from `from` to `to`, degrees.
fn half_range(waves: &[Wave], from: f64, to: f64) -> f64 {
    let course = (0..=720).map(|k| sum(waves, (from + (to - from) * f64::from(k) / 720.0).to_radians()));
    let (low, high) = course.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
    (high - low) / 2.0
}

pub fn error_motion(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let axis = draw_axis(rng, plan, true)?;
    let joint = &plan.machine.joints[axis];
    let own = nearest(joint.direction);
    let across: Vec<usize> = (0..3).filter(|&i| i != own).collect();
    let mode = *rng.pick(&["radial", "radial", "axial", "tilt"]);
    let (kinds, rotation) = match mode {
        "radial" => (across, false),
        "axial" => (vec![own], false),
        _ => (across, true),
    };
    let mut parts: Vec<(V3, Vec<Wave>)> = kinds
        .iter()
        .map(|&k| {
            let mut e = [0.0; 3];
            e[k] = 1.0;
            (e, harmonics(rng))
        })
        .collect();
    // the size is the largest of a component over a turn
    let largest = (0..720)
        .map(|k| f64::from(k).to_radians() / 2.0)
        .flat_map(|q| parts.iter().map(move |p| sum(&p.1, q).abs()).collect::<Vec<_>>())
        .fold(0.0, f64::max);
    parts.iter_mut().flat_map(|p| &mut p.1).for_each(|w| w.1 /= largest);
    let (from, to) = plan.travel(axis);
    let half_range = parts.iter().map(|p| half_range(&p.1, from, to)).fold(0.0, f64::max);
    let components = kinds.iter().map(|&k| component(k + if rotation { 3 } else { 0 }, &joint.name)).collect();
    Some(Cause {
        effect: "rotary-error-motion",
        id: "rotary-error-motion",
        driver: "position",
        place: joint.name.clone(),
        components,
        unit: if rotation { "arcsec" } else { "um" },
        meaning: "largest of a component",
        sizes: if rotation { (0.3, 25.0) } else { (0.2, 15.0) },
        range: json!({"axis": joint.name, "from": from, "to": to}),
        params: json!({"mode": mode, "harmonics": parts.iter().map(|p| &p.1).collect::<Vec<_>>(), "half_range_over_travel": half_range}),
        law: Box::new(ErrorMotion { axis, rotation, parts, to_mm_or_rad: if rotation { ARCSEC } else { 1e-3 } }),
    })
}

/// Waves of an axis's own position.
struct Cyclic {
    axis: usize,
    waves: Vec<Wave>,
    to_own: f64,
    rotary: bool,
}

impl Law for Cyclic {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        let zero = sum(&self.waves, 0.0);
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            for (row, d) in list.iter_mut().enumerate() {
                let q = plan.axes_at(test, row as f64 * test.step_s)[self.axis];
                let x = if self.rotary { q.to_radians() } else { q };
                d.own[self.axis] += (sum(&self.waves, x) - zero) * size * self.to_own;
            }
        }
    }
}

pub fn cyclic(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let rotary = rng.chance(0.6);
    let axis = draw_axis(rng, plan, rotary)?;
    let joint = &plan.machine.joints[axis];
    let phase = |rng: &mut Draw| rng.between(0.0, TAU);
    let mut waves = vec![];
    let params = if rotary {
        let teeth = *rng.pick(&[36.0, 48.0, 60.0, 72.0, 80.0, 90.0, 96.0, 120.0]);
        let eccentricity = if rng.chance(0.5) { rng.between(0.0, 0.8) } else { 0.0 };
        let flank = rng.between(0.0, 0.3);
        waves.push((teeth, 1.0, phase(rng)));
        waves.push((2.0 * teeth, flank, phase(rng)));
        waves.push((1.0, eccentricity, phase(rng)));
        json!({"per_turn": teeth, "eccentricity_ratio": eccentricity, "second": flank})
    } else {
        let pitch = *rng.pick(&[5.0, 8.0, 10.0, 12.0, 16.0, 20.0]);
        let second = rng.between(0.0, 0.35);
        let swell = rng.between(0.0, 0.3);
        waves.push((TAU / pitch, 1.0, phase(rng)));
        waves.push((2.0 * TAU / pitch, second, phase(rng)));
        // a bent screw modulates along its length
        waves.push((TAU / pitch + TAU / rng.between(150.0, 500.0), swell, phase(rng)));
        json!({"pitch_mm": pitch, "second": second, "swell": swell})
    };
    let own = if rotary { 3 } else { 0 } + "XYZABC".find(&joint.name).unwrap_or(0) % 3;
    let (from, to) = plan.travel(axis);
    Some(Cause {
        effect: "cyclic-error",
        id: "cyclic-error",
        driver: "position",
        place: joint.name.clone(),
        components: vec![component(own, &joint.name)],
        unit: if rotary { "arcsec" } else { "um" },
        meaning: "amplitude at its period",
        sizes: if rotary { (0.2, 20.0) } else { (0.1, 6.0) },
        range: json!({"axis": joint.name, "from": from, "to": to}),
        params,
        law: Box::new(Cyclic { axis, waves, to_own: if rotary { 1.0 / 3600.0 } else { 1e-3 }, rotary }),
    })
}

/// A fixed frequency that breathes and wanders in phase, on an axis or at the spindle ball.
struct Vibration {
    axis: Option<usize>,
    direction: V3,
    hz: f64,
    breath_hz: f64,
    depth: f64,
    wander: f64,
    phase: f64,
}

impl Law for Vibration {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            for (row, d) in list.iter_mut().enumerate() {
                let t = test.started_at_s + row as f64 * test.step_s;
                let loud = 1.0 + self.depth * (TAU * self.breath_hz * t).sin();
                let wander = self.wander * (TAU * t / 47.0).sin();
                let x = size * 1e-3 * loud * (TAU * self.hz * t + wander + self.phase).sin();
                match self.axis {
                    Some(j) => d.own[j] += x,
                    None => (0..3).for_each(|i| d.ball[i] += x * self.direction[i]),
                }
            }
        }
    }
}

pub fn vibration(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let axis = if rng.chance(0.6) { draw_axis(rng, plan, false) } else { None };
    let law = Vibration {
        axis,
        direction: rng.direction(),
        hz: rng.log_between(0.6, 14.0),
        breath_hz: rng.between(0.01, 0.1),
        depth: rng.between(0.0, 0.3),
        wander: rng.between(0.0, 0.6),
        phase: rng.between(0.0, TAU),
    };
    let (place, components) = match axis {
        Some(j) => {
            let name = &plan.machine.joints[j].name;
            (name.clone(), vec![component("XYZ".find(name).unwrap_or(0), name)])
        }
        None => ("spindle-ball".into(), ["ball-x", "ball-y", "ball-z"].map(String::from).to_vec()),
    };
    Some(Cause {
        effect: "vibration",
        id: "vibration",
        driver: "time",
        place,
        components,
        unit: "um",
        meaning: "amplitude",
        sizes: (0.05, 5.0),
        range: json!({"time_s": [0.0, plan.end_s()]}),
        params: json!({"hz": law.hz, "depth": law.depth, "breath_hz": law.breath_hz, "wander_rad": law.wander}),
        law: Box::new(law),
    })
}
