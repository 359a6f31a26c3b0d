//! The concealed causes: each a law in the time domain that moves balls, axes or readings; no identification.

pub mod backlash;
pub mod dirt;
mod drifting;
mod gauges;
mod leaning;
mod not_returning;
pub mod periodic;
mod seats;
pub mod shapes;
pub mod slips;
pub mod spikes;
pub mod strangers;
mod timing;

use super::draw::Draw;
use super::kinematics::Disturbance;
use super::plan::Plan;
use serde_json::Value;

/// Disturbances per test and row.
pub type Rows = Vec<Vec<Disturbance>>;

/// Turns a size in the cause's unit into disturbances of every row.
pub trait Law: Send + Sync {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows);
}

/// A cause with its place in the words of the answer contract.
pub struct Cause {
    /// Name in the answer contract; causes outside the catalogue are `unknown`.
    pub effect: &'static str,
    /// Name in this trial, which tells strangers apart.
    pub id: &'static str,
    pub driver: &'static str,
    pub place: String,
    pub components: Vec<String>,
    pub unit: &'static str,
    pub meaning: &'static str,
    /// Plausible sizes.
    pub sizes: (f64, f64),
    pub range: Value,
    pub params: Value,
    pub law: Box<dyn Law>,
}

/// Draws a cause of one kind for a session, or none where the machine has no place for it.
type Drawer = fn(&mut Draw, &mut Plan) -> Option<Cause>;

/// Every kind, how often it is drawn, and whether it stands in the catalogue.
pub const KINDS: &[(&str, f64, bool, Drawer)] = &[
    ("rotary-backlash", 1.3, true, backlash::rotary),
    ("linear-backlash", 1.0, true, backlash::linear),
    ("reversal-spike", 1.0, true, spikes::reversal),
    ("rotary-error-motion", 1.6, true, periodic::error_motion),
    ("cyclic-error", 1.4, true, periodic::cyclic),
    ("gravity-sag", 1.0, true, drifting::sag),
    ("thermal-growth", 1.3, true, drifting::growth),
    ("straightness", 1.2, true, shapes::wear),
    ("squareness", 0.8, true, shapes::squareness),
    ("linear-scale", 0.8, true, shapes::scale),
    ("servo-lag", 0.8, true, timing::lag),
    ("trigger-latency", 0.8, true, timing::latency),
    ("pivot-slip", 0.8, true, slips::pivot),
    ("ball-slip", 0.7, true, slips::ball),
    ("bar-length", 0.6, true, drifting::bar),
    ("vibration", 0.9, true, periodic::vibration),
    ("unknown-clamp", 1.0, false, strangers::clamp),
    ("unknown-stick-slip", 1.0, false, strangers::stick_slip),
    ("unknown-cross-tilt", 1.0, false, strangers::cross_tilt),
    ("unknown-beat", 1.0, false, strangers::beat),
    ("unknown-load", 1.0, false, strangers::load),
    // by --only: sessions of a seed stay what they were
    ("ball-form", 0.0, true, seats::lobes),
    ("cup-stiction", 0.0, true, seats::sticks),
    ("unknown-hose", 0.0, false, seats::hose),
    ("bar-sag", 0.0, true, gauges::bending),
    ("control-centre", 0.0, true, gauges::wrong_centre),
    ("asynchronous-error-motion", 0.0, true, not_returning::cage),
    ("repeatability", 0.0, true, not_returning::returns_elsewhere),
    ("axis-shift", 0.0, true, not_returning::gives_way),
    ("local-positioning-error", 0.0, true, dirt::on_a_scale),
    ("inertia-deflection", 0.0, true, leaning::back),
];

/// Undisturbed rows of a session.
pub fn still(plan: &Plan) -> Rows {
    plan.tests.iter().map(|t| vec![Disturbance::default(); t.rows]).collect()
}

/// A rotary or linear axis drawn at random, preferring those that move somewhere in the session.
fn draw_axis(rng: &mut Draw, plan: &Plan, rotary: bool) -> Option<usize> {
    let all: Vec<usize> = (0..plan.machine.joints.len()).filter(|&j| plan.machine.joints[j].rotary == rotary).collect();
    let busy: Vec<usize> = all.iter().copied().filter(|j| plan.tests.iter().any(|t| t.moving.contains(j))).collect();
    let from = if !busy.is_empty() && rng.chance(0.9) { busy } else { all };
    if from.is_empty() { None } else { Some(*rng.pick(&from)) }
}

/// The letter of rotation about a coordinate direction, or of the nearest one.
fn nearest(direction: [f64; 3]) -> usize {
    (0..3).max_by(|&a, &b| direction[a].abs().total_cmp(&direction[b].abs())).unwrap_or(0)
}

/// Name of a component error: `EZ` and axis `C` give `EZC`.
fn component(kind: usize, axis: &str) -> String {
    format!("{}{axis}", super::nuisance::COMPONENTS[kind])
}

/// A component's motion of an axis by `amount` along or about its direction, whatever that is.
fn along(d: &mut Disturbance, axis: usize, direction: [f64; 3], rotation: bool, amount: f64) {
    let shift = if rotation { 3 } else { 0 };
    for (m, u) in d.motion[axis][shift..].iter_mut().zip(direction) {
        *m += amount * u;
    }
}
