//! Joints that stand beside their command after a move, the more the faster they arrived. Static poses only; a sweep has `servo_lag`.
//!
//! `E = −v (s + s_i ρ²)`. Axes that move together start and stop together, so each one's speed is in proportion to its way:
//! `v = (Δq/r) / max_j |Δq_j/r_j|`, from −1 to 1, r the top speeds. ρ is the distance (m) of the ball from the line of the
//! joint that moved: what is braked farther out pulls more.

use super::kind::{
    Default, Driver, Kind, Parameter, ParameterUnit, Profile, every_component, list, plain_measure, word,
};
use super::{Context, EffectError};
use crate::chain::Geometry;
use crate::machine::{AxisKind, Effect, Machine, Place};

/// mm in a metre.
const MM_PER_M: f64 = 1e3;

/// Error left by the speed of arrival.
pub static ARRIVAL_LAG: Kind = Kind {
    name: "arrival-lag",
    driver: Driver::Speed,
    formula: "E = -v (s + s_i rho^2), v way of the last move over top speed, as a share of the axis that sets the pace",
    size_meaning: "short of the command after arriving at full speed",
    cause: "readings taken before the joint had settled, following error not integrated out, drive or gear left wound up by braking",
    remedy: "wait longer before reading and approach slowly or always from the same side; then check position loop and drive stiffness",
    parameters: &[
        Parameter::word("of", &[], Default::Absent, "axis whose arrival drives; the place when not stated"),
        Parameter::list(
            "rates",
            ParameterUnit::Plain,
            Default::Absent,
            (1e-6, 1e6),
            "top speeds of all axes in the order of the machine file, in any one unit; all equal when not stated",
        ),
    ],
    check,
    outlets: |machine, place| match place {
        Place::Axis(axis) => every_component(machine, axis),
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions: |_| vec!["speed".into(), "inertia".into()],
    profiles,
};

fn check(machine: &Machine, effect: &Effect) -> Result<(), String> {
    let count = list(effect, "rates").len();
    let of = word(effect, "of");
    match (count, machine.axes.len(), of) {
        (_, _, Some(name)) if machine.axis_index(name).is_none() => {
            Err(format!("'of: {name}' names no axis; axes are {}", machine.axis_names().join(" ")))
        }
        (count, axes, _) if count != 0 && count != axes => {
            Err(format!("'rates' has {count} numbers, one for each of the {axes} axes is needed"))
        }
        _ => Ok(()),
    }
}

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let machine = context.machine();
    let axis = word(effect, "of").and_then(|name| machine.axis_index(name)).or(effect.place.axis());
    let Some(axis) = axis else { return Ok(vec![context.profile(|_, _| 0.0); 2]) };
    let speed = arrival(context, axis, list(effect, "rates"));
    let square = squared_distance_m2(context, axis);
    let inertia = context.profile(|test, row| speed[test][row] * square(test, row));
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

/// Squared distance of the ball that an axis carries from the line of that axis, m²; 0 for a slide.
fn squared_distance_m2<'c>(context: &'c Context, axis: usize) -> impl Fn(usize, usize) -> f64 + 'c {
    let chain = context.chain();
    let geometry = Geometry::nominal(chain);
    move |test, row| {
        if context.machine().axes[axis].kind == AxisKind::Linear {
            return 0.0;
        }
        let test_of = &context.session().tests[test];
        let link = |name: &str| chain.link(name).unwrap_or(chain.carried_by(axis));
        let carried =
            if chain.carries(axis, link(&test_of.spindle_ball.link)) { &test_of.spindle_ball } else { &test_of.pivot };
        let positions = context.motion(test).row(row).to_vec();
        let joint = geometry.pose(chain.carried_by(axis), &positions, None);
        let ball = geometry.pose(link(&carried.link), &positions, None).point(&carried.at);
        let direction = joint.rotation * chain.joint(axis).direction;
        let arm = ball - joint.point(&chain.joint(axis).origin);
        (arm - direction * arm.dot(&direction)).norm_squared() / (MM_PER_M * MM_PER_M)
    }
}
