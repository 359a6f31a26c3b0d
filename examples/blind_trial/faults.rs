//! Mistakes of whoever wrote the files: signs, names, units, order, time; no physics.

use super::draw::Draw;
use super::kinematics::{AXES, Disturbance};
use super::plan::Plan;
use super::recordings::Recording;

/// A mistake and whom it strikes.
pub struct Fault {
    pub effect: &'static str,
    pub says: String,
    spoil: Spoil,
}

enum Spoil {
    Sign(usize),
    Swap(usize, usize),
    PositionUnit(usize, f64),
    LengthUnit(f64),
    Reverse(usize, Vec<usize>),
    Shift(f64, Vec<usize>),
}

pub const FAULTS: &[&str] = &["axis-sign", "axis-swap", "unit", "angle-reversed", "time-shift"];

/// Draws a fault of a kind that changes something in this session.
pub fn draw(kind: &str, rng: &mut Draw, plan: &Plan) -> Option<Fault> {
    let busy = |rotary: bool| -> Vec<usize> {
        (0..AXES)
            .filter(|&j| plan.machine.joints[j].rotary == rotary && plan.tests.iter().any(|t| t.moving.contains(&j)))
            .collect()
    };
    let (slides, joints) = (busy(false), busy(true));
    let name = |j: usize| &plan.machine.joints[j].name;
    let all: Vec<usize> = slides.iter().chain(&joints).copied().collect();
    match kind {
        "axis-sign" => {
            let j = *rng.pick(&all);
            Some(Fault { effect: "axis-sign", says: format!("{} counted backwards", name(j)), spoil: Spoil::Sign(j) })
        }
        "axis-swap" if slides.len() > 1 => {
            let (a, b) = (slides[rng.below(2)], slides[slides.len() - 1]);
            let (a, b) = if a == b { (slides[0], b) } else { (a, b) };
            let says = format!("columns of {} and {} exchanged", name(a), name(b));
            Some(Fault { effect: "axis-swap", says, spoil: Spoil::Swap(a, b) })
        }
        "unit" => {
            let (says, spoil) = match rng.below(3) {
                0 if !slides.is_empty() => {
                    let j = *rng.pick(&slides);
                    (format!("{} in inches", name(j)), Spoil::PositionUnit(j, 1.0 / 25.4))
                }
                1 if !joints.is_empty() => {
                    let j = *rng.pick(&joints);
                    (format!("{} in radians", name(j)), Spoil::PositionUnit(j, std::f64::consts::PI / 180.0))
                }
                2 => ("lengths in metres".to_string(), Spoil::LengthUnit(1e-3)),
                _ => ("lengths in inches".to_string(), Spoil::LengthUnit(1.0 / 25.4)),
            };
            Some(Fault { effect: "unit", says, spoil })
        }
        "angle-reversed" if !joints.is_empty() => {
            let j = *rng.pick(&joints);
            let way = if rng.chance(0.5) { "ccw" } else { "cw" };
            let struck: Vec<usize> = (0..plan.tests.len())
                .filter(|&i| {
                    let test = &plan.tests[i];
                    test.moving == [j] && (test.to_deg > test.from_deg) == (way == "ccw")
                })
                .collect();
            let says = format!("{} of the {way} recordings written from the wrong end", name(j));
            (!struck.is_empty()).then_some(Fault { effect: "angle-reversed", says, spoil: Spoil::Reverse(j, struck) })
        }
        "time-shift" => {
            let late_s = rng.sign() * rng.log_between(0.4, 3.0);
            let one = rng.below(plan.tests.len());
            let struck = if rng.chance(0.5) { (0..plan.tests.len()).collect() } else { vec![one] };
            let says = format!("lengths {late_s:.2} s beside the positions in {} tests", struck.len());
            Some(Fault { effect: "time-shift", says, spoil: Spoil::Shift(late_s, struck) })
        }
        _ => None,
    }
}

impl Fault {
    /// Whether one look at a length says so, whatever a fit could absorb.
    pub fn is_gross(&self) -> bool {
        matches!(self.spoil, Spoil::LengthUnit(_))
    }

    /// Faults of pairing move the axes under the recorded positions.
    pub fn disturb(&self, plan: &Plan, rows: &mut [Vec<Disturbance>]) {
        let Spoil::Shift(late_s, struck) = &self.spoil else {
            return;
        };
        for &i in struck {
            let test = &plan.tests[i];
            for (row, d) in rows[i].iter_mut().enumerate() {
                let t = row as f64 * test.step_s;
                let (now, then) = (plan.axes_at(test, t), plan.axes_at(test, t + late_s));
                (0..AXES).for_each(|j| d.own[j] += then[j] - now[j]);
            }
        }
    }

    /// The others spoil what is written.
    pub fn spoil(&self, recordings: &mut [Recording]) {
        for (i, recording) in recordings.iter_mut().enumerate() {
            match &self.spoil {
                Spoil::Sign(j) => scale_positions(recording, *j, -1.0),
                Spoil::PositionUnit(j, k) => scale_positions(recording, *j, *k),
                Spoil::LengthUnit(k) => recording.lengths_mm.iter_mut().flatten().for_each(|x| *x *= k),
                Spoil::Swap(a, b) => swap(recording, *a, *b),
                Spoil::Reverse(j, struck) if struck.contains(&i) => {
                    recording.columns.iter_mut().filter(|c| c.0 == *j).for_each(|c| c.1.reverse());
                }
                _ => {}
            }
        }
    }
}

fn scale_positions(recording: &mut Recording, axis: usize, k: f64) {
    recording.columns.iter_mut().filter(|c| c.0 == axis).flat_map(|c| &mut c.1).for_each(|x| *x *= k);
    recording.standing.iter_mut().filter(|s| s.0 == axis).for_each(|s| s.1 *= k);
}

fn swap(recording: &mut Recording, a: usize, b: usize) {
    let other = |j: usize| {
        if j == a {
            b
        } else if j == b {
            a
        } else {
            j
        }
    };
    recording.columns.iter_mut().for_each(|c| c.0 = other(c.0));
    recording.standing.iter_mut().for_each(|s| s.0 = other(s.0));
}
