//! A bar that has another length from a moment on: an extension that was screwed anew or works loose, a gauge that was zeroed anew.
//! Bars of a wrong length all through, and bars that grow, are in `thermal`.
//!
//! `reading = distance + s` from t0 on.

use super::candidates::{CandidateFamily, Observations, Refined, none, with_number};
use super::contract::{
    DefaultValue, Documented, Driver, Kind, NAMED_BAR, Notable, Parameter, ParameterUnit, Signature, Unseen, no_check,
    plain_measure, read_with_a_bar, single_function,
};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError, Profile};
use crate::machine::{Effect, Outlet, ParameterValue, Place};

/// Change of a bar's length.
pub static BAR_CHANGE: Kind = Kind {
    name: "bar-change",
    driver: Driver::Event,
    formula: "reading = distance + s from t0 on",
    size_meaning: "change of length",
    cause: "an extension that was screwed anew or works loose, a gauge that was zeroed anew, a bar that was knocked or held in the hand",
    remedy: "calibrate the bar and repeat the tests after it, or state a 'bar_setup' of their own in them",
    titles: &[("", "The bar has another length from a moment on")],
    measures: Some(""),
    notable: Notable { length: 2.0, angle: 2.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::RepeatAtEnd },
    // the length that a bar has all through is listed
    unseen: Unseen::Never,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: true,
    signature: Signature::Jump,
    candidates: changes,
    candidates_of_poses: none,
    documented: Documented {
        place: "`bar`",
        components: "`length`, reading minus distance",
        functions: "1 from t0 on",
        parameters: "`time` t0, `bar`",
        unit: "um",
    },
    parameters: &[
        Parameter::number(
            "time",
            ParameterUnit::Plain,
            DefaultValue::Required,
            (-1e9, 1e9),
            "session time of the change, s",
        ),
        NAMED_BAR,
    ],
    check: no_check,
    outlets: read_with_a_bar,
    measure: plain_measure,
    functions: single_function,
    profiles,
};

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let time = BAR_CHANGE.number(context, effect, "time");
    Ok(vec![context.profile_in(
        |test| context.ends_at_s(test) >= time && context.has_named_bar(test, effect),
        |test, row| f64::from(u8::from(context.session_time_s(test, row) >= time)),
    )])
}

/// Seconds before a test at which it is tried beside the jumps of the readings.
const JUST_BEFORE_S: f64 = 1e-6;
/// Changes up to this are plausible, µm: as of bars that are not as long as stated.
const PLAUSIBLE: f64 = 30.0;

/// Log odds against it beside a ball that slips: magnets hold balls, threads hold bars.
const LOG_ODDS_AGAINST: f64 = 3.0;

/// Changes of each bar before each of its tests but the first, and where the residual jumps.
fn changes(seen: &Observations) -> Vec<CandidateFamily> {
    let context = seen.context;
    let lengths = seen.bars_mm();
    let is_alone = lengths.len() == 1;
    let of_bar = |bar_mm: f64| {
        let with_it = context.order().iter().filter(|&&test| context.has_bar(test, bar_mm));
        let moments = with_it.enumerate().flat_map(|(index, &test)| {
            let before = (index > 0).then_some(context.session().tests[test].started_at_s - JUST_BEFORE_S);
            before.into_iter().chain(seen.jumps_s[test].iter().copied())
        });
        let at = |time: f64| {
            let change = with_number(BAR_CHANGE.name, Place::Bar, "time", time);
            if is_alone { change } else { change.with("bar", ParameterValue::Number(bar_mm)) }
        };
        let grid: Vec<Effect> = moments.map(at).collect();
        let family = CandidateFamily::new(BAR_CHANGE.name, Place::Bar, vec![Outlet::Reading], PLAUSIBLE);
        let shape = vec![Refined::number("time", (0.0, seen.latest_s()), 3.0)];
        (!grid.is_empty()).then(|| family.over(grid).refine(shape).rare(LOG_ODDS_AGAINST))
    };
    lengths.into_iter().filter_map(of_bar).collect()
}
