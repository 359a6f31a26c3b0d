//! Friction at reversal: the axis sticks, falls behind and is caught up by the servo. Lost motion that stays is in `backlash`.
//!
//! Friction turns round over the pre-sliding travel d: `w' = (sgn v − w) |v| / d`. Without servo dynamics the axis is
//! behind by `w − sgn v` halves, that is `−sgn(v) e^(−travel/d)` after a full reversal. After a short way it is less: friction
//! had not turned round. A pulse with which the control wrongly meets friction comes `in_full` at every reversal. The part stands while
//! its command goes on, so a spike comes in over a way as long as itself (`onset`). With them the position error y is
//! the response of a loop with integral action to the change of friction, `y″ + 2ζω y' + ω² y = −w'`, scaled so
//! that its largest value in the session is one.

use super::candidates::{CandidateFamily, Observations, Refined, none, with_number};
use super::context::Profile;
use super::context::Travel;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, no_check,
    plain_measure, single_function,
};
use super::memory::{MemoryLaw, Past};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::machine::{AxisKind, Effect, Machine, Outlet, ParameterValue, Place};
use std::f64::consts::TAU;

/// Spike after the reversal of an axis.
pub static REVERSAL_SPIKE: Kind = Kind {
    name: "reversal-spike",
    driver: Driver::Direction,
    formula: "own = -h sgn(v) e^(-travel/d), or y'' + 2 z w y' + w^2 y = -friction'",
    size_meaning: "largest spike of the axis in the session",
    cause: "friction of guideway or bearing that the servo catches up late; missing or wrong friction compensation",
    remedy: "check lubrication and preload, then tune the control's friction compensation",
    titles: &[("", "Reversal spikes of {place}")],
    measures: Some("at the largest"),
    notable: Notable { length: 1.5, angle: 2.0 },
    shown_by: ShownBy {
        arm: Some(ShowingTest::TwoSpeeds),
        rotary: Some(ShowingTest::Tangential),
        other: ShowingTest::Circles,
    },
    unseen: Unseen::Listed,
    unmoved: &[AxisKind::Linear],
    form_error: 0.035,
    needs_runs: true,
    signature: Signature::Spike,
    candidates: spikes,
    candidates_of_poses: none,
    documented: Documented {
        place: "any axis",
        components: "own",
        functions: "`−sgn v·e^(−travel/d)`, after a short way less the more of it was left unless `in_full`; with `servo_hz` f: `y″ + 2ζω y' + ω² y = −w'`, w the friction, largest value 1",
        parameters: "`travel` d, `in_full` (0 to 1), `onset`: way over which it comes in, `servo_hz`, `damping` ζ",
        unit: "um, arcsec, largest of the session",
    },
    parameters: &[
        Parameter::number(
            "travel",
            ParameterUnit::Position,
            DefaultValue::Number(0.05),
            (1e-6, 1e3),
            "pre-sliding travel over which friction turns round (1/e), mm or deg",
        ),
        Parameter::number(
            "in_full",
            ParameterUnit::Plain,
            DefaultValue::Number(0.0),
            (0.0, 1.0),
            "1: in full at every reversal, however short the way before; 0: as far as friction had turned round; not with servo_hz",
        ),
        Parameter::number(
            "onset",
            ParameterUnit::Position,
            DefaultValue::Number(0.0),
            (0.0, 1.0),
            "way over which the spike comes in, mm or deg: as long as the spike where the part stands meanwhile; 0: at once; not with servo_hz",
        ),
        Parameter::number(
            "servo_hz",
            ParameterUnit::Plain,
            DefaultValue::Number(0.0),
            (0.0, 1e3),
            "natural frequency at which the servo catches up, Hz; 0: by travel alone",
        ),
        Parameter::number(
            "damping",
            ParameterUnit::Plain,
            DefaultValue::Number(0.7),
            (1e-3, 10.0),
            "damping ratio of the servo; below 1 the spike rings",
        ),
    ],
    check: no_check,
    outlets: |machine, place| match place {
        Place::Axis(axis) => vec![Outlet::own(machine, axis)],
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions: single_function,
    profiles,
};

/// Friction and the servo's position error with its rate.
#[derive(Clone, Copy, Default)]
struct Friction {
    past: Past,
    error: f64,
    rate: f64,
    /// Way of the row before and the time it took; `None` before the second row of a test.
    before: Option<(f64, f64)>,
}

/// What is left of friction that turned round, and of the servo's error, below which nothing more comes of it; of about one.
const LEAST_LEFT: f64 = 1e-10;

impl Friction {
    /// Whether a row goes on in the direction in which friction and servo have settled.
    fn is_settled(&mut self, travel: &Travel) -> bool {
        let goes_on = travel.distance * self.past.direction >= 0.0 && travel.next * self.past.direction >= 0.0;
        let rest = (self.past.windup - self.past.direction).abs().max(self.error.abs()).max(self.rate.abs());
        let is_settled = goes_on && rest < LEAST_LEFT;
        if is_settled {
            (self.past.windup, self.error, self.rate) = (self.past.direction, 0.0, 0.0);
        }
        is_settled
    }
}

/// Steps of the integration per radian of the servo's phase.
const STEPS_PER_RADIAN: f64 = 16.0;
/// Largest error of a session with a reversal, times the servo's frequency: friction that turns round makes one of about one.
const LEAST_SPIKE: f64 = 1e-3;
/// Longest phase integrated within a row, rad: beyond it the servo has settled.
const MOST_PHASE: f64 = 64.0;

/// How the way of a row is spread over it: at the share s of the row it is travelled at the rate `way + turn (2 s - 1)`, by
/// the parabola through the position a row before, at its beginning and at its end. `before` and `row` are ways with the
/// seconds they took, `next` is the way after. A slide turns round between rows only where it goes on the other way.
fn turn((way_before, seconds_before): (f64, f64), (way, seconds): (f64, f64), next: f64) -> f64 {
    let turn = (way / seconds - way_before / seconds_before) * seconds * seconds / (seconds + seconds_before);
    match way_before * next < 0.0 {
        true => turn,
        false => turn.clamp(-way.abs(), way.abs()),
    }
}

/// The law of a spike by travel alone; `None` for other kinds, and where a servo catches up in time.
pub(super) fn law(machine: &Machine, effect: &Effect, axis: usize) -> Option<MemoryLaw> {
    let is_own = effect.sizes.iter().all(|size| size.outlet == Outlet::own(machine, axis));
    let number = |name| REVERSAL_SPIKE.number_of(machine, effect, name);
    let is_by_travel = effect.kind == REVERSAL_SPIKE.name && is_own && number("servo_hz") <= 0.0;
    is_by_travel.then(|| spike(number))
}

fn spike(number: impl Fn(&'static str) -> f64) -> MemoryLaw {
    MemoryLaw::Spike { travel: number("travel"), in_full: number("in_full"), onset: number("onset") }
}

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let Place::Axis(axis) = effect.place else { return Ok(Vec::new()) };
    let number = |name| REVERSAL_SPIKE.number(context, effect, name);
    let (omega, damping) = (TAU * number("servo_hz"), number("damping"));
    let law = spike(number);
    if omega <= 0.0 {
        let advance = |past: &mut Past, travel: Travel| law.advance(past, travel.distance);
        return Ok(vec![context.along(axis, Past::default(), advance, |past| law.value(past))]);
    }
    let advance = |state: &mut Friction, travel: Travel| {
        let Some(seconds) = travel.seconds.filter(|seconds| *seconds > 0.0) else {
            law.advance(&mut state.past, travel.distance);
            (state.error, state.rate, state.before) = (0.0, 0.0, None);
            return;
        };
        if state.is_settled(&travel) {
            state.before = Some((travel.distance, seconds));
            return;
        }
        let phase = (omega * seconds).min(MOST_PHASE);
        let steps = (phase * STEPS_PER_RADIAN).ceil().max(1.0);
        let (share, dt) = (1.0 / steps, phase / omega / steps);
        let turn = state.before.map_or(0.0, |before| turn(before, (travel.distance, seconds), travel.next));
        for step in 0..steps as usize {
            let middle = (step as f64 + 0.5) * share;
            let before = state.past.windup;
            law.advance(&mut state.past, share * (travel.distance + turn * (2.0 * middle - 1.0)));
            let push = -(state.past.windup - before) / dt;
            // semi-implicit: stable for every damping
            state.rate = (state.rate + dt * (push - omega * omega * state.error)) / (1.0 + 2.0 * damping * omega * dt);
            state.error += dt * state.rate;
        }
        state.before = Some((travel.distance, seconds));
    };
    let mut profile = context.along(axis, Friction::default(), advance, |state| state.error);
    let largest = profile.iter().flatten().fold(0.0f64, |most, value| most.max(value.abs()));
    // without a reversal there is rounding alone
    if largest * omega < LEAST_SPIKE {
        profile.iter_mut().flatten().for_each(|value| *value = 0.0);
    } else {
        profile.iter_mut().flatten().for_each(|value| *value /= largest);
    }
    Ok(vec![profile])
}

/// Pre-sliding travels that are tried of a rotary axis, deg, and of a slide, mm; frequencies of the servo, Hz.
const TRAVELS_DEG: [f64; 3] = [0.3, 1.0, 3.0];
const TRAVELS_MM: [f64; 4] = [0.02, 0.1, 0.5, 2.0];
const TRAVELS_IN_FULL_MM: [f64; 2] = [0.5, 2.0];
/// Way over which these come in: as long as spikes are, some micrometres, which readings hardly tell; `compensate` takes the size.
const ONSET_MM: f64 = 5e-3;
const SERVOS_HZ: [f64; 3] = [1.0, 3.0, 8.0];

fn spikes(seen: &Observations) -> Vec<CandidateFamily> {
    let own = |axis: usize| vec![Outlet::own(seen.machine(), axis)];
    let rotary = seen.moving(AxisKind::Rotary).map(|(axis, _)| {
        let place = Place::Axis(axis);
        let by_travel = TRAVELS_DEG.map(|d| with_number(REVERSAL_SPIKE.name, place, "travel", d.to_radians()));
        let travel = Refined::number("travel", (0.01f64.to_radians(), 20f64.to_radians()), 0.5);
        let family = CandidateFamily::new(REVERSAL_SPIKE.name, place, own(axis), 60.0);
        family.over(by_travel.to_vec()).refine(vec![travel]).fast()
    });
    let slides = seen.moving(AxisKind::Linear).map(|(axis, _)| {
        let place = Place::Axis(axis);
        let by_travel = TRAVELS_MM.map(|d| with_number(REVERSAL_SPIKE.name, place, "travel", d));
        // only after marks of a program and other short ways is one unlike the other
        let in_full = TRAVELS_IN_FULL_MM.map(|d| {
            with_number(REVERSAL_SPIKE.name, place, "travel", d)
                .with("in_full", ParameterValue::Number(1.0))
                .with("onset", ParameterValue::Number(ONSET_MM))
        });
        let ringing = SERVOS_HZ.map(|hz| {
            let servo = with_number(REVERSAL_SPIKE.name, place, "servo_hz", hz);
            let damped = servo.with("damping", ParameterValue::Number(0.5));
            damped.with("travel", ParameterValue::Number(0.05))
        });
        let shape = vec![
            Refined::number("travel", (0.02, 20.0), 0.7),
            Refined::number("servo_hz", (0.2, 60.0), 0.4),
            Refined::number("damping", (0.05, 3.0), 0.15),
        ];
        let family = CandidateFamily::new(REVERSAL_SPIKE.name, place, own(axis), 30.0);
        family.over(by_travel.into_iter().chain(in_full).chain(ringing).collect()).refine(shape).fast()
    });
    rotary.chain(slides).collect()
}
