//! Joints that stand beside their command after a move, the more the faster they arrived. Static poses only; a sweep has the lag of `timing`.
//!
//! `E = −v (s + s_i ρ²)`. Axes that move together start and stop together, so each one's speed is in proportion to its way:
//! `v = (Δq/r) / max_j |Δq_j/r_j|`, from −1 to 1, r the top speeds. ρ is the distance (m) of the ball from the line of the
//! joint that moved: what is braked farther out pulls more. With `about` it is taken from the line of another axis: an arm
//! stretched out there makes the whole move slower or softer.

use super::candidates::{CandidateFamily, Observations, PLAUSIBLE_OF_ARMS, directions, motion, none, with_word};
use super::context::Profile;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, list, names_axis,
    of_any_axis, plain_measure, word,
};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::chain::Chain;
use crate::machine::{AxisKind, Effect, Machine, Outlet, Place};

/// Error left by the speed of arrival.
pub static ARRIVAL_LAG: Kind = Kind {
    name: "arrival-lag",
    driver: Driver::Speed,
    formula: "E = -v (s + s_i rho^2), v way of the last move over top speed, as a share of the axis that sets the pace",
    size_meaning: "largest error after an arrival of the session",
    cause: "readings taken before the joint had settled, following error not integrated out, drive or gear left wound up by braking",
    remedy: "wait longer before reading and approach slowly or always from the same side; then check position loop and drive stiffness",
    titles: &[("", "Arrival at speed leaves {place} off ({moving})")],
    measures: Some("at the fastest arrival"),
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::BothWays },
    unseen: Unseen::Listed,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: false,
    signature: Signature::Arrival,
    candidates: none,
    candidates_of_poses: arrivals,
    documented: Documented {
        place: "any axis",
        components: "all",
        functions: "`speed` −v, `inertia` −v·ρ²; v = (Δq/r) over the largest |Δq/r| of all axes",
        parameters: "`of`: axis that moves, `about`: axis from whose line ρ is taken, `rates`: r",
        unit: "um, arcsec (inertia: per m²)",
    },
    parameters: &[
        Parameter::word("of", &[], DefaultValue::Absent, "axis whose arrival drives; the place when not stated"),
        Parameter::word(
            "about",
            &[],
            DefaultValue::Absent,
            "axis from whose line rho is taken; the one that drives when not stated",
        ),
        Parameter::list(
            "rates",
            ParameterUnit::Plain,
            DefaultValue::Absent,
            (1e-6, 1e6),
            "top speeds of all axes in the order of the machine file, in any one unit; all equal when not stated",
        ),
    ],
    check,
    outlets: of_any_axis,
    measure: plain_measure,
    functions: |_| vec!["speed".into(), "inertia".into()],
    profiles,
};

fn check(machine: &Machine, effect: &Effect) -> Result<(), String> {
    ["of", "about"].into_iter().try_for_each(|key| names_axis(machine, effect, key))?;
    match (list(effect, "rates").len(), machine.axes.len()) {
        (count, axes) if count != 0 && count != axes => {
            Err(format!("'rates' has {count} numbers, one for each of the {axes} axes is needed"))
        }
        _ => Ok(()),
    }
}

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let machine = context.machine();
    let named = |key: &str| word(effect, key).and_then(|name| machine.axis_index(name));
    let Some(axis) = named("of").or(effect.place.axis()) else { return Ok(vec![context.profile(|_, _| 0.0); 2]) };
    let speed = arrival(context, axis, list(effect, "rates"));
    let square = context.squared_arm_m2(named("about").unwrap_or(axis));
    let inertia = context.profile(|test, row| speed[test][row] * square[test][row]);
    Ok(vec![speed, inertia])
}

/// Minus the speed at which an axis arrived at every row, as a share of the pace; 0 in sweeps and before any move.
fn arrival(context: &Context, axis: usize, rates: &[f64]) -> Profile {
    let machine = context.machine();
    let rate = |k: usize| rates.get(k).copied().unwrap_or(1.0);
    let sign = context.chain().joint(axis).sign;
    let way = |k: usize, from: &[f64], to: &[f64]| machine.axes[k].kind.to_file_unit(to[k] - from[k]) / rate(k);
    let share = |from: &[f64], to: &[f64]| -> f64 {
        let longest = (0..machine.axes.len()).map(|k| way(k, from, to).abs()).fold(0.0, f64::max);
        if longest > 0.0 { -sign * way(axis, from, to) / longest } else { 0.0 }
    };
    let mut profile: Profile = vec![Vec::new(); context.tests()];
    let mut before: Option<(f64, &[f64])> = None;
    for &test in context.order() {
        let motion = context.motion(test);
        if motion.time_s.is_some() {
            profile[test] = vec![0.0; motion.rows()];
        } else {
            let began = context.session().tests[test].started_at_s;
            // tests that began together were read at the same stops: none of them follows another
            let mut last = before.filter(|(other, _)| *other < began).map(|(_, row)| row);
            for row in 0..motion.rows() {
                let here = motion.row(row);
                profile[test].push(last.map_or(0.0, |last| share(last, here)));
                last = Some(here);
            }
        }
        if motion.rows() > 0 {
            before = Some((context.session().tests[test].started_at_s, motion.row(motion.rows() - 1)));
        }
    }
    profile
}

/// What the speed of arrival leaves: at the joint itself, and in the bearings of others that its braking bends.
fn arrivals(seen: &Observations) -> Vec<CandidateFamily> {
    let (machine, chain) = (seen.machine(), seen.context.chain());
    let moving: Vec<usize> = (0..machine.axes.len()).filter(|&axis| seen.context.travelled(axis).is_some()).collect();
    let mut list = Vec::new();
    for &axis in &moving {
        let place = Place::Axis(axis);
        let new = |outlets| CandidateFamily::new(ARRIVAL_LAG.name, place, outlets, PLAUSIBLE_OF_ARMS);
        let own = new(vec![Outlet::own(machine, axis)]);
        list.push(CandidateFamily { functions: &["speed"], ..own.clone() });
        list.push(own.clone());
        // an arm stretched out from another joint's line makes the whole move slower or softer
        for &about in moving.iter().filter(|&&about| about != axis && machine.axes[about].kind == AxisKind::Rotary) {
            let stretched = with_word(ARRIVAL_LAG.name, place, "about", &machine.axes[about].name);
            list.push(CandidateFamily { functions: &["inertia"], ..own.clone() }.over(vec![stretched]));
        }
        for &of in moving.iter().filter(|&&of| of != axis && chain.carries(of, chain.carried_by(axis))) {
            let braked = with_word(ARRIVAL_LAG.name, place, "of", &machine.axes[of].name);
            // a tilt about the line of the joint before is that joint's own error
            let mut tilts = motion(axis, &directions(machine, axis).tilts);
            tilts.retain(|outlet| !is_own_of(chain, of, axis, outlet));
            list.push(new(tilts).over(vec![braked]));
        }
    }
    list
}

/// Cosine of the angle between two lines from which they count as one direction.
const SAME_DIRECTION: f64 = 0.9;

/// Whether a tilt of an axis turns about the direction of another axis that carries it, at zero and nearly always.
fn is_own_of(chain: &Chain, of: usize, axis: usize, outlet: &Outlet) -> bool {
    let Outlet::Motion { component, .. } = outlet else { return false };
    let (before, after) = (chain.carried_by(of), chain.carried_by(axis));
    let follows = before.branch == after.branch && after.depth == before.depth + 1;
    follows && chain.joint(of).direction[component.direction_index()].abs() > SAME_DIRECTION
}
