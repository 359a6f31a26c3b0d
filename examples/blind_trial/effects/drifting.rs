//! Heat and weight: growth with two time constants, sag that turns with gravity, a bar that expands.

use super::super::draw::Draw;
use super::super::kinematics::{V3, cross, dot, unit};
use super::super::nuisance::ARCSEC;
use super::super::plan::{Plan, Temperature, Test};
use super::{Cause, Law, Rows, along, component, nearest};
use serde_json::{Value, json};

/// Growth of the part behind an axis along a direction, with tilts that go with it.
pub struct Growth {
    pub axis: usize,
    pub direction: V3,
    pub tilt_about: V3,
    pub tilt_rad_per_mm: f64,
    pub tau_s: [f64; 2],
    /// Share of the second node, which may pull the other way.
    pub second: f64,
    pub warm: f64,
    pub by_temperature: bool,
}

impl Growth {
    fn raw(&self, plan: &Plan, t_s: f64) -> f64 {
        if self.by_temperature {
            // the part follows the air through its own time constant
            let mut felt = 0.0;
            for k in 0..24 {
                let age = self.tau_s[0] / 3.0 * (f64::from(k) + 0.5) / 6.0;
                let weight = (-age * 3.0 / self.tau_s[0]).exp();
                felt += weight * plan.temperature.as_ref().map_or(0.0, |w| w.at((t_s - age).max(0.0)));
            }
            return felt / 6.0;
        }
        let rise = |tau: f64| self.warm.powf(self.tau_s[0] / tau) * (1.0 - (-t_s / tau).exp());
        rise(self.tau_s[0]) + self.second * rise(self.tau_s[1])
    }
}

impl Law for Growth {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        // the air before the first reading is known to nobody
        let from_s = if self.by_temperature { first_reading_s(plan) } else { 0.0 };
        let span_s = plan.end_s() - from_s;
        let course: Vec<f64> = (0..=400).map(|k| self.raw(plan, from_s + span_s * f64::from(k) / 400.0)).collect();
        let low = course.iter().copied().fold(f64::INFINITY, f64::min);
        let high = course.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let start = course[0];
        if high - low <= 0.0 {
            return;
        }
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            for (row, d) in list.iter_mut().enumerate() {
                let t = test.started_at_s + row as f64 * test.step_s;
                let grown_mm = size * 1e-3 * (self.raw(plan, t) - start) / (high - low);
                along(d, self.axis, self.direction, false, grown_mm);
                along(d, self.axis, self.tilt_about, true, grown_mm * self.tilt_rad_per_mm);
            }
        }
    }
}

/// A part that bearings and screws heat as axes move: a light mass takes the heat and passes it on to a heavy one.
///
/// Stepped through the session in time; between tests the axes stand and both masses cool.
pub struct Warmed {
    pub axis: usize,
    pub direction: V3,
    pub tilt_about: V3,
    pub tilt_rad_per_mm: f64,
    /// Cooling times of the light and the heavy mass, s.
    pub tau_s: [f64; 2],
    /// Share of the growth that the heavy mass has.
    pub heavy: f64,
    /// Warmth of both masses as the session begins.
    pub warm: f64,
    pub rotary: bool,
}

/// Steps through a session, s.
const HEAT_STEP_S: f64 = 0.5;
/// Travel of an axis, per second, that gives one unit of heat: mm or degrees.
const HEAT_SPEED: [f64; 2] = [15.0, 6.0];

impl Warmed {
    /// Growth and bend at every step.
    fn course(&self, plan: &Plan) -> Vec<(f64, f64)> {
        let heat = |t_s: f64| -> f64 {
            let in_time = |test: &&Test| {
                let passed = t_s - test.started_at_s;
                passed >= HEAT_STEP_S && passed <= test.rows as f64 * test.step_s
            };
            let Some(test) = plan.tests.iter().find(in_time) else { return 0.0 };
            let t = t_s - test.started_at_s;
            let (before, now) = (plan.axes_at(test, t - HEAT_STEP_S), plan.axes_at(test, t));
            (0..now.len())
                .filter(|&j| plan.machine.joints[j].rotary == self.rotary)
                .map(|j| (now[j] - before[j]).abs() / HEAT_STEP_S / HEAT_SPEED[usize::from(self.rotary)])
                .sum()
        };
        let (mut light, mut heavy) = (self.warm, self.warm);
        let steps = (plan.end_s() / HEAT_STEP_S) as usize + 2;
        (0..steps)
            .map(|step| {
                let here = (self.heavy * heavy + (1.0 - self.heavy) * light, light - 0.5 * heavy);
                let passed_on = (light - heavy) / self.tau_s[1];
                light += HEAT_STEP_S * ((heat(step as f64 * HEAT_STEP_S) - light) / self.tau_s[0] - 0.3 * passed_on);
                heavy += HEAT_STEP_S * passed_on;
                here
            })
            .collect()
    }
}

impl Law for Warmed {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        let course = self.course(plan);
        let at = |t: f64| {
            let place = (t / HEAT_STEP_S).max(0.0);
            let k = (place as usize).min(course.len() - 2);
            let share = place - k as f64;
            let mix = |a: f64, b: f64| a + share * (b - a);
            (mix(course[k].0, course[k + 1].0), mix(course[k].1, course[k + 1].1))
        };
        let first = at(first_reading_s(plan));
        let seen = plan
            .tests
            .iter()
            .flat_map(|test| (0..test.rows).map(|row| at(test.started_at_s + row as f64 * test.step_s).0));
        let (low, high) = seen.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
        if high - low <= 0.0 {
            return;
        }
        let mm = size * 1e-3 / (high - low);
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            for (row, d) in list.iter_mut().enumerate() {
                let (grown, bent) = at(test.started_at_s + row as f64 * test.step_s);
                along(d, self.axis, self.direction, false, mm * (grown - first.0));
                along(d, self.axis, self.tilt_about, true, mm * (bent - first.1) * self.tilt_rad_per_mm);
            }
        }
    }
}

fn first_reading_s(plan: &Plan) -> f64 {
    plan.tests.iter().map(|test| test.started_at_s).fold(f64::INFINITY, f64::min)
}

fn weather(rng: &mut Draw) -> Temperature {
    Temperature {
        start_degc: rng.between(19.0, 23.0),
        rise_k: rng.sign() * rng.between(1.5, 5.0),
        tau_s: rng.log_between(600.0, 4000.0),
        wobble_k: rng.between(0.1, 0.8),
        period_s: rng.between(500.0, 2000.0),
    }
}

pub fn growth(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let machine = plan.machine.clone();
    let spindle_slide = machine.tool.iter().rev().find(|&&j| !machine.joints[j].rotary).copied();
    let table = machine.work.iter().rev().find(|&&j| machine.joints[j].rotary).copied();
    let axis = match table {
        Some(j) if rng.chance(0.3) => j,
        _ => spindle_slide?,
    };
    let joint = machine.joints[axis].clone();
    // a spindle grows along Z, a table along its axis
    let direction: V3 = if joint.rotary { joint.direction } else { [0.0, 0.0, 1.0] };
    let mut tilt_about: V3 = [0.0; 3];
    let tilted = nearest([rng.normal(), if joint.rotary { rng.normal() } else { 0.0 }, 0.0]);
    tilt_about[tilted] = 1.0;
    let tilts = rng.chance(0.7);
    let tilt_rad_per_mm = if tilts { rng.sign() * rng.between(0.3, 1.5) * ARCSEC * 1e3 } else { 0.0 };
    let mut components = vec![component(nearest(direction), &joint.name)];
    if tilts {
        components.push(component(3 + tilted, &joint.name));
    }
    let drives = |test: &Test| test.moving.iter().any(|&j| machine.joints[j].rotary == joint.rotary);
    if plan.tests.iter().any(drives) && rng.chance(0.45) {
        let light = rng.log_between(90.0, 500.0);
        let law = Warmed {
            axis,
            direction,
            tilt_about,
            tilt_rad_per_mm,
            tau_s: [light, light * rng.between(3.0, 12.0)],
            heavy: rng.between(0.2, 0.8),
            warm: if rng.chance(0.5) { 0.0 } else { rng.between(0.0, 1.0) },
            rotary: joint.rotary,
        };
        let params = json!({"heated_by": if joint.rotary { "rotary axes" } else { "slides" }, "tau_s": law.tau_s,
            "heavy": law.heavy, "warm_start": law.warm, "tilt_arcsec_per_um": tilt_rad_per_mm / ARCSEC / 1e3});
        return Some(grown(plan, joint.name, components, "time", params, Box::new(law)));
    }
    let by_temperature = rng.chance(0.4);
    if by_temperature && plan.temperature.is_none() {
        plan.temperature = Some(weather(rng));
    }
    let tau = rng.log_between(250.0, 2500.0);
    let law = Growth {
        axis,
        direction,
        tilt_about,
        tilt_rad_per_mm,
        tau_s: [tau, tau * rng.between(1.8, 4.0)],
        second: rng.between(-0.3, 0.8),
        warm: rng.between(0.6, 1.0),
        by_temperature,
    };
    let driver = if by_temperature { "temperature" } else { "time" };
    let params = json!({"tau_s": law.tau_s, "second_node": law.second, "warm_start": law.warm,
        "tilt_arcsec_per_um": law.tilt_rad_per_mm / ARCSEC / 1e3});
    Some(grown(plan, joint.name, components, driver, params, Box::new(law)))
}

fn grown(
    plan: &Plan,
    place: String,
    components: Vec<String>,
    driver: &'static str,
    params: Value,
    law: Box<dyn Law>,
) -> Cause {
    Cause {
        effect: "thermal-growth",
        id: "thermal-growth",
        driver,
        place,
        components,
        unit: "um",
        meaning: "peak to peak over the session",
        sizes: (0.5, 40.0),
        range: json!({"time_s": [0.0, plan.end_s()]}),
        params,
        law,
    }
}

/// Weight of the body behind a tilting joint: it bends, winds up its drive and rides on its mesh.
pub struct Sag {
    pub axis: usize,
    /// Deflection per g along the body's three directions, relative to the largest.
    pub compliance: V3,
    pub centre_of_gravity: V3,
    pub windup_arcsec_per_um: f64,
    pub mesh: V3,
    pub exponent: f64,
}

impl Law for Sag {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        let joint = &plan.machine.joints[self.axis];
        let at = |q: &[f64; 5]| {
            let body = plan.gravity_in(self.axis, q, true);
            let g = plan.gravity_in(self.axis, q, false);
            let bent = [0, 1, 2].map(|i| self.compliance[i] * body[i].signum() * body[i].abs().powf(self.exponent));
            // back into the carrier's directions
            let turn = if joint.reversed { -q[self.axis] } else { q[self.axis] }.to_radians();
            let frame = super::super::kinematics::Quaternion::about(joint.direction, turn);
            let arm = frame.turn(self.centre_of_gravity);
            let torque = dot(joint.direction, cross(arm, g));
            let moved = frame.turn(bent);
            (moved, torque.signum() * torque.abs().powf(self.exponent))
        };
        let (bent0, torque0) = at(&[0.0; 5]);
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            for (row, d) in list.iter_mut().enumerate() {
                let (bent, torque) = at(&plan.axes_at(test, row as f64 * test.step_s));
                let turned = torque - torque0;
                for i in 0..3 {
                    d.motion[self.axis][i] += size * 1e-3 * (bent[i] - bent0[i] + turned * self.mesh[i]);
                }
                let wind = size * self.windup_arcsec_per_um * ARCSEC * turned;
                along(d, self.axis, joint.direction, true, wind);
            }
        }
    }
}

pub fn sag(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let axis = (0..plan.machine.joints.len()).find(|&j| {
        let joint = &plan.machine.joints[j];
        joint.rotary && joint.direction[2].abs() < 0.9
    })?;
    let joint = plan.machine.joints[axis].clone();
    let own = nearest(joint.direction);
    let mut compliance = [0; 3].map(|_| rng.between(0.2, 1.0));
    compliance[rng.below(3)] = 1.0;
    compliance[own] *= 0.3;
    let largest = compliance.iter().copied().fold(0.0, f64::max);
    compliance.iter_mut().for_each(|c| *c /= largest);
    let mut arm = rng.direction();
    arm[own] = 0.0;
    let mut mesh = [0; 3].map(|_| rng.between(-0.6, 0.6));
    mesh[own] = 0.0;
    let law = Sag {
        axis,
        compliance,
        centre_of_gravity: unit(arm),
        windup_arcsec_per_um: rng.between(0.0, 1.8),
        mesh,
        exponent: rng.between(0.8, 1.15),
    };
    let mut components: Vec<String> = (0..3).filter(|&i| i != own).map(|i| component(i, &joint.name)).collect();
    components.push(component(3 + own, &joint.name));
    let (from, to) = plan.travel(axis);
    Some(Cause {
        effect: "gravity-sag",
        id: "gravity-sag",
        driver: "gravity",
        place: joint.name.clone(),
        components,
        unit: "um",
        meaning: "largest body deflection per g",
        sizes: (0.3, 30.0),
        range: json!({"axis": joint.name, "from": from, "to": to}),
        params: json!({"compliance": compliance, "centre_of_gravity": law.centre_of_gravity,
            "windup_arcsec_per_um": law.windup_arcsec_per_um, "mesh": mesh, "load_exponent": law.exponent}),
        law: Box::new(law),
    })
}

/// A bar wrong by a constant (one of them), or all of them expanding.
struct BarLaw {
    one: Option<usize>,
    by_temperature: bool,
    tau_s: f64,
}

impl Law for BarLaw {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        let longest = plan.bars.iter().map(|b| b.nominal_mm).fold(1.0, f64::max);
        let first_s = first_reading_s(plan);
        let (from_s, end_s) = (if self.by_temperature { first_s } else { 0.0 }, plan.end_s());
        let course = |t: f64| match (&plan.temperature, self.by_temperature) {
            (Some(w), true) => w.at(t) - w.at(first_s),
            _ => 1.0 - (-t / self.tau_s).exp(),
        };
        let courses = (0..=200).map(|k| course(from_s + (end_s - from_s) * f64::from(k) / 200.0));
        let (low, high) = courses.fold((0.0f64, 0.0f64), |(low, high), now| (low.min(now), high.max(now)));
        let range = (high - low).max(1e-9);
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            for (row, d) in list.iter_mut().enumerate() {
                let t = test.started_at_s + row as f64 * test.step_s;
                // a bar that grew reads less than the distance it spans
                d.length -= 1e-3
                    * size
                    * match self.one {
                        Some(bar) if bar == test.bar => 1.0,
                        Some(_) => 0.0,
                        None => course(t) / range * plan.bars[test.bar].nominal_mm / longest,
                    };
            }
        }
    }
}

pub fn bar(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let driver = *rng.pick(&["constant", "time", "temperature"]);
    if driver == "temperature" && plan.temperature.is_none() {
        plan.temperature = Some(weather(rng));
    }
    let one = (driver == "constant").then(|| rng.below(plan.bars.len()));
    let law = BarLaw { one, by_temperature: driver == "temperature", tau_s: rng.log_between(300.0, 2500.0) };
    Some(Cause {
        effect: "bar-length",
        id: "bar-length",
        driver,
        place: "bar".into(),
        components: vec!["length".into()],
        unit: "um",
        meaning: if one.is_some() {
            "error of the bar"
        } else {
            "growth of the longest bar, peak to peak over the session"
        },
        sizes: (0.5, 15.0),
        range: json!({"bar_mm": one.map(|i| plan.bars[i].nominal_mm)}),
        params: json!({"tau_s": law.tau_s}),
        law: Box::new(law),
    })
}
