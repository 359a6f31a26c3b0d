//! A part that sits in two ways: lifted or tipped over a stretch of its travel, later on the way back. Smooth errors over a
//! position are in `straightness` and `harmonics`.
//!
//! The part is followed through a play of width h, `p ← p clamped to q ± h/2`; over `from … to` of p it is lifted, and
//! it settles in the time s: `E′ = (1 − E)/s` within, `E′ = −E/s` outside. Between tests it comes to rest.

use super::backlash::across;
use super::candidates::{CandidateFamily, Observations, Refined, directions, motion, none};
use super::context::Profile;
use super::context::Travel;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, plain_measure,
    single_function,
};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::machine::{AxisKind, Effect, Machine, ParameterValue, Place};

/// Lift of a part over a stretch of its travel.
pub static CLAMP_LIFT: Kind = Kind {
    name: "clamp-lift",
    driver: Driver::Position,
    formula: "s E' = 1 - E for from <= p < to, s E' = -E elsewhere; p follows q with play h",
    size_meaning: "lift, largest direction",
    cause: "clamp, brake or seal that rubs, a hose or cable that pulls, a chip or dent under a seat: it lifts the part over a stretch of its travel",
    remedy: "open the clamp and repeat; look at what touches the part between the two places; clean and re-seat",
    titles: &[("", "{place} lifts over part of its travel ({moving})")],
    measures: Some("from one seat to the other"),
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::BothWays },
    unseen: Unseen::Never,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: true,
    signature: Signature::Lift,
    candidates: lifts,
    candidates_of_poses: none,
    documented: Documented {
        place: "any axis",
        components: "all but own",
        functions: "`s E' = 1 − E` for from ≤ p < to, `s E' = −E` elsewhere; p follows q through a play of `hysteresis`",
        parameters: "`from`, `to`, `hysteresis`, `rise` s (s)",
        unit: "um, arcsec",
    },
    parameters: &[
        Parameter::number(
            "from",
            ParameterUnit::Position,
            DefaultValue::Required,
            (-1e5, 1e5),
            "where the lift begins, mm or deg",
        ),
        Parameter::number(
            "to",
            ParameterUnit::Position,
            DefaultValue::Required,
            (-1e5, 1e5),
            "where it ends, mm or deg",
        ),
        Parameter::number(
            "hysteresis",
            ParameterUnit::Position,
            DefaultValue::Number(0.0),
            (0.0, 1e4),
            "how much later it comes and goes on the way back, mm or deg",
        ),
        Parameter::number(
            "rise",
            ParameterUnit::Plain,
            DefaultValue::Number(0.0),
            (0.0, 1e4),
            "time in which it settles (1/e), s",
        ),
    ],
    check: begins_before_it_ends,
    outlets: |machine, place| across(machine, place),
    measure: plain_measure,
    functions: single_function,
    profiles,
};

fn begins_before_it_ends(_machine: &Machine, effect: &Effect) -> Result<(), String> {
    match (effect.number("from"), effect.number("to")) {
        (Some(from), Some(to)) if from < to => Ok(()),
        _ => Err("'from' is below 'to': a stretch that is left out is the same lift with the other sign".into()),
    }
}

/// What the part does: its place after the play, mm or rad, and how far it is lifted, 0 … 1.
#[derive(Clone, Copy, Default)]
struct Seat {
    follows: Option<f64>,
    lifted: f64,
}

/// The stretch over which the part is lifted, and how it comes and goes.
struct Stretch {
    from: f64,
    to: f64,
    half_play: f64,
    rise_s: f64,
}

impl Stretch {
    fn holds(&self, place: f64) -> f64 {
        f64::from(u8::from((self.from..self.to).contains(&place)))
    }

    /// Goes on to the position `at`.
    fn advance(&self, seat: &mut Seat, at: f64, seconds: Option<f64>) {
        let before = seat.follows.unwrap_or(at);
        let after = before.clamp(at - self.half_play, at + self.half_play);
        seat.follows = Some(after);
        let Some(seconds) = seconds else {
            seat.lifted = self.holds(after);
            return;
        };
        // shares of the way at which it comes and goes
        let mut shares = match after == before {
            true => [0.0, 0.0],
            false => [self.from, self.to].map(|edge| ((edge - before) / (after - before)).clamp(0.0, 1.0)),
        };
        shares.sort_by(f64::total_cmp);
        let mut begins = 0.0;
        for ends in [shares[0], shares[1], 1.0] {
            let wanted = self.holds(before + (begins + ends) / 2.0 * (after - before));
            let left = (-(ends - begins) * seconds / self.rise_s.max(f64::MIN_POSITIVE)).exp();
            if ends > begins {
                seat.lifted = wanted + (seat.lifted - wanted) * left;
            }
            begins = ends;
        }
    }
}

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let Place::Axis(axis) = effect.place else { return Ok(Vec::new()) };
    let number = |name| CLAMP_LIFT.number(context, effect, name);
    let stretch = Stretch {
        from: number("from"),
        to: number("to"),
        half_play: number("hysteresis") / 2.0,
        rise_s: number("rise"),
    };
    let advance = |seat: &mut Seat, travel: Travel| stretch.advance(seat, travel.at, travel.seconds);
    Ok(vec![context.along(axis, Seat::default(), advance, |seat| seat.lifted)])
}

/// Places at which a stretch may begin or end, the ends of the travel among them.
const EDGES: usize = 13;

/// First steps of the hysteresis, rad, and of the time in which the part settles, s; longest such time, s.
const LATE_RAD: f64 = 6f64.to_radians();
const SETTLING_S: (f64, f64) = (0.4, 10.0);

/// Lifts up to this are plausible, µm or arcsec: a chip, a film of oil, a seal. Several directions that nearly cancel need hundreds.
const PLAUSIBLE: f64 = 10.0;

fn lifts(seen: &Observations) -> Vec<CandidateFamily> {
    let of_axis = |(axis, ends): (usize, (f64, f64))| {
        let d = directions(seen.machine(), axis);
        let (stretches, shape) = stretches(Place::Axis(axis), ends);
        let lifted = vec![d.along, d.tilts[0], d.tilts[1]];
        let tipped = [&d.across[..], &d.tilts].concat();
        [lifted, tipped, vec![d.along]].map(|components| {
            let outlets = motion(axis, &components);
            let family = CandidateFamily::new(CLAMP_LIFT.name, Place::Axis(axis), outlets, PLAUSIBLE);
            family.over(stretches.clone()).refine(shape.clone())
        })
    };
    seen.moving(AxisKind::Rotary).flat_map(of_axis).collect()
}

/// Stretches of a travel over which a part may be lifted, and how they are refined.
fn stretches(place: Place, (from, to): (f64, f64)) -> (Vec<Effect>, Vec<Refined>) {
    let step = (to - from) / (EDGES - 1) as f64;
    let edge = |k: usize| ParameterValue::Number(from + step * k as f64);
    let stretch = |begins, ends| {
        let lift = Effect::new(CLAMP_LIFT.name, place).with("from", edge(begins)).with("to", edge(ends));
        lift.with("hysteresis", ParameterValue::Number(0.0)).with("rise", ParameterValue::Number(0.0))
    };
    let pairs = (0..EDGES).flat_map(|begins| (begins + 1..EDGES).map(move |ends| (begins, ends)));
    let whole = (0, EDGES - 1);
    let grid = pairs.filter(|pair| *pair != whole).map(|(begins, ends)| stretch(begins, ends)).collect();
    let shape = vec![
        Refined::number("from", (from - step, to), 0.5 * step),
        Refined::number("to", (from, to + step), 0.5 * step),
        Refined::number("hysteresis", (0.0, to - from), LATE_RAD),
        Refined::number("rise", (0.0, SETTLING_S.1), SETTLING_S.0),
    ];
    (grid, shape)
}
