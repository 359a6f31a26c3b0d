//! A ball seat that moved once: step at a session time, with creep. Drift without an event is in `thermal`.
//!
//! `displacement = s [1 − c e^(−(t − t0)/τ)]` from t0 on, zero before: the share 1 − c at once, c creeping after it.

use super::candidates::{CandidateFamily, Observations, Refined, none, with_number};
use super::context::Profile;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, no_check,
    plain_measure, single_function,
};
use super::named_ball::{self, NamedBall, SAME_PLACE_MM, naming};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::machine::{Effect, Outlet, ParameterValue, Place};
use crate::session::{Ball, Test};

const LINK_AND_PLACE: [Parameter; 2] = named_ball::parameters(
    "link of the ball concerned",
    "place of the ball concerned, mm; without link and at: the ball of the test in or before which it slips",
);
const PARAMETERS: &[Parameter] = &[
    Parameter::number("time", ParameterUnit::Plain, DefaultValue::Required, (-1e9, 1e9), "session time of the slip, s"),
    Parameter::number(
        "creep_share",
        ParameterUnit::Plain,
        DefaultValue::Number(0.0),
        (0.0, 1.0),
        "share that follows by creep instead of at once",
    ),
    Parameter::number(
        "creep_time",
        ParameterUnit::Plain,
        DefaultValue::Number(30.0),
        (1e-3, 1e7),
        "time constant of the creep, s",
    ),
    LINK_AND_PLACE[0],
    LINK_AND_PLACE[1],
];

/// Slip of the pivot cup.
pub static PIVOT_SLIP: Kind = Kind {
    name: "pivot-slip",
    driver: Driver::Event,
    formula: "pivot = s [1 - c e^(-(t-t0)/tau)] from t0 on",
    size_meaning: "displacement",
    cause: "magnet or glue of the cup let go, a knock, the bar pulled at the end of its stroke, a work offset set anew",
    remedy: "mount the cup anew, repeat the tests after the slip or treat them as a setup of their own",
    titles: &[("", "The pivot cup moved")],
    measures: Some(""),
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::RepeatAtEnd },
    unseen: Unseen::ByMoment,
    unmoved: &[],
    form_error: 0.08,
    needs_runs: true,
    signature: Signature::Jump,
    candidates: pivot_slips,
    candidates_of_poses: none,
    documented: Documented {
        place: "`pivot`",
        components: "`x y z` on its link",
        functions: "`1 − c·e^(−(t−t0)/τ)` from t0 on",
        parameters: "`time`, `creep_share`, `creep_time`, `link`, `at`",
        unit: "um",
    },
    parameters: PARAMETERS,
    check: no_check,
    outlets: |_, place| {
        if place == Place::Pivot { (0..3).map(Outlet::Pivot).collect() } else { Vec::new() }
    },
    measure: plain_measure,
    functions: single_function,
    profiles: |context, effect| slip(&PIVOT_SLIP, context, effect, |test| &context.session().tests[test].pivot),
};

/// Slip of the ball in the spindle.
pub static BALL_SLIP: Kind = Kind {
    name: "ball-slip",
    driver: Driver::Event,
    formula: "spindle ball = s [1 - c e^(-(t-t0)/tau)] from t0 on",
    size_meaning: "displacement",
    cause: "ball stem or tool holder moved in the spindle, draw-bar not fully clamped, a knock, a work offset set anew",
    remedy: "clean and clamp the holder anew, repeat the tests after the slip or treat them as a setup of their own",
    titles: &[("", "The ball in the spindle moved")],
    measures: Some(""),
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::RepeatAtEnd },
    unseen: Unseen::ByMoment,
    unmoved: &[],
    form_error: 0.08,
    needs_runs: true,
    signature: Signature::Jump,
    candidates: ball_slips,
    candidates_of_poses: none,
    documented: Documented {
        place: "`spindle-ball`",
        components: "`x y z` on its link",
        functions: "`1 − c·e^(−(t−t0)/τ)` from t0 on",
        parameters: "`time`, `creep_share`, `creep_time`, `link`, `at`",
        unit: "um",
    },
    parameters: PARAMETERS,
    check: no_check,
    outlets: |_, place| {
        if place == Place::SpindleBall { (0..3).map(Outlet::SpindleBall).collect() } else { Vec::new() }
    },
    measure: plain_measure,
    functions: single_function,
    profiles: |context, effect| slip(&BALL_SLIP, context, effect, |test| &context.session().tests[test].spindle_ball),
};

fn slip<'a>(
    kind: &Kind,
    context: &Context,
    effect: &Effect,
    ball: impl Fn(usize) -> &'a Ball,
) -> Result<Vec<Profile>, EffectError> {
    let number = |name| kind.number(context, effect, name);
    let (time, creep_share, creep_time) = (number("time"), number("creep_share"), number("creep_time"));
    let named = NamedBall::of(effect);
    // the ball of that name that was mounted when it happened; what is mounted anew later has not slipped
    let from_then = context.order().iter().copied().filter(|&test| context.ends_at_s(test) >= time);
    let mounted = from_then.map(&ball).find(|ball| named.is(ball));
    let concerned = |ball: &Ball| mounted.is_some_and(|mounted| is_one(ball, mounted));
    let acts = |test: usize| context.ends_at_s(test) >= time && concerned(ball(test));
    Ok(vec![context.profile_in(acts, |test, row| {
        let since = context.session_time_s(test, row) - time;
        if since < 0.0 {
            return 0.0;
        }
        // most slips do not creep, and exponentials are dear
        if creep_share == 0.0 { 1.0 } else { 1.0 - creep_share * (-since / creep_time).exp() }
    })])
}

fn is_one(one: &Ball, other: &Ball) -> bool {
    one.link == other.link && one.setup == other.setup && (one.at - other.at).norm() < SAME_PLACE_MM
}

/// Moments of a test that are tried, as shares of it; in all but the first of a setup also just before it.
const MOMENTS: [f64; 4] = [0.2, 0.4, 0.6, 0.8];
const JUST_BEFORE: f64 = -1e-6;
/// Creep that is tried where the residual jumps: from none the refinement finds no long one.
const CREEP_SHARE: f64 = 0.4;
const CREEP_S: f64 = 100.0;

fn pivot_slips(seen: &Observations) -> Vec<CandidateFamily> {
    let setups = seen.setups;
    let outlets = || (0..3).map(Outlet::Pivot).collect();
    let of_setup = |setup| slips(seen, &PIVOT_SLIP, (&setups.pivot_of, setup), |test| &test.pivot, outlets());
    (0..setups.pivots.len()).filter_map(of_setup).collect()
}

fn ball_slips(seen: &Observations) -> Vec<CandidateFamily> {
    let setups = seen.setups;
    let outlets = || (0..3).map(Outlet::SpindleBall).collect();
    let of_setup =
        |setup| slips(seen, &BALL_SLIP, (&setups.spindle_ball_of, setup), |test| &test.spindle_ball, outlets());
    (0..setups.spindle_balls.len()).filter_map(of_setup).collect()
}

/// Slips of the ball of one setup, at moments of each of its tests and where the residual jumps; `None` where no test has it.
fn slips(
    seen: &Observations,
    kind: &'static Kind,
    (setup_of, setup): (&[usize], usize),
    ball: fn(&Test) -> &Ball,
    outlets: Vec<Outlet>,
) -> Option<CandidateFamily> {
    let place = if kind.name == PIVOT_SLIP.name { Place::Pivot } else { Place::SpindleBall };
    let tests = seen.context.order().iter().filter(|&&test| setup_of[test] == setup);
    let mut grid = Vec::new();
    for (index, &test) in tests.enumerate() {
        let own = &seen.context.session().tests[test];
        let (from, to) = (own.started_at_s, seen.context.ends_at_s(test));
        let before = (index > 0).then_some(JUST_BEFORE);
        let moments = before.into_iter().chain(MOMENTS).map(|share| from + share * (to - from));
        let ball = ball(own);
        let at_once = |time| naming(with_number(kind.name, place, "time", time), ball);
        let creeping = |time| {
            let parameter = |effect: Effect, name, value| effect.with(name, ParameterValue::Number(value));
            parameter(parameter(at_once(time), "creep_share", CREEP_SHARE), "creep_time", CREEP_S)
        };
        let jumps = || seen.jumps_s[test].iter().copied();
        grid.extend(moments.chain(jumps()).map(at_once));
        grid.extend(jumps().map(creeping));
    }
    let shape = vec![
        Refined::number("time", (0.0, seen.latest_s()), 3.0),
        Refined::number("creep_share", (0.0, 1.0), 0.3),
        Refined::number("creep_time", (0.5, 2000.0), 10.0),
    ];
    let family = CandidateFamily::new(kind.name, place, outlets, 30.0).fast().refine(shape);
    (!grid.is_empty()).then(|| family.over(grid))
}
