//! A bar that bends and is stretched by its own weight as it tilts. Bars of a wrong length, and bars that grow, are in `thermal`.
//!
//! `reading = distance + s_b cos²α + s_w sin α`, α the angle of the bar above the level, from the pivot up to the spindle ball.
//! A slender bar bends in proportion to the weight across it, `cos α`, and the chord falls short of the bent length by the square
//! of that; the weight along it, `sin α`, pulls on its joints and magnets. First and second order of one load on a beam
//! that rests on its ends. What is constant belongs to the bar's length: both functions are less their value at `α = 0`.

use super::candidates::{CandidateFamily, Observations, none, with_number};
use super::context::Profile;
use super::contract::{
    Documented, Driver, Kind, NAMED_BAR, Notable, Signature, Unseen, no_check, plain_measure, read_with_a_bar,
};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::machine::{Effect, Outlet, Place};

/// Weight of the bar itself.
pub static BAR_SAG: Kind = Kind {
    name: "bar-sag",
    driver: Driver::Gravity,
    formula: "reading = distance + s_b (cos^2 a - 1) + s_w sin a, a the bar's angle above the level",
    size_meaning: "change of the reading from level to upright",
    cause: "a long or heavy bar bends under its own weight, or hangs in its joints, as it tilts",
    remedy: "shorter or stiffer bar, support it as it was calibrated; measure level and tilted setups with bars of one length",
    titles: &[("", "The bar sags under its own weight")],
    measures: Some("at the steepest bar"),
    notable: Notable { length: 1.0, angle: 1.0 },
    shown_by: ShownBy {
        arm: None,
        rotary: None,
        other: ShowingTest::Said("a sweep or circle with that bar in which it stands level and upright"),
    },
    unseen: Unseen::Listed,
    unmoved: &[],
    form_error: 0.05,
    needs_runs: false,
    signature: Signature::Course,
    candidates: tilting_bars,
    candidates_of_poses: none,
    documented: Documented {
        place: "`bar`",
        components: "`length`",
        functions: "`bends = cos²α − 1`, `hangs = sin α`, α the bar's angle above the level, from the pivot up to the spindle ball",
        parameters: "`bar`",
        unit: "um",
    },
    parameters: &[NAMED_BAR],
    check: no_check,
    outlets: read_with_a_bar,
    measure: plain_measure,
    functions: |_| vec![BENDS.into(), HANGS.into()],
    profiles,
};

/// Names of the functions.
const BENDS: &str = "bends";
const HANGS: &str = "hangs";

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let sines = context.bar_sines();
    let of = |value: fn(f64) -> f64| {
        context.profile(|test, row| if context.has_named_bar(test, effect) { value(sines[test][row]) } else { 0.0 })
    };
    Ok(vec![of(|sine| -sine * sine), of(|sine| sine)])
}

/// Log odds against a bar that gives way: the usual ones are stiff to some tenths of a µm.
const STIFF_BARS: f64 = 3.0;

/// Largest plausible change of a reading, µm.
const PLAUSIBLE: f64 = 10.0;

/// Every bar alike, and each length alone where there are several; bending alone, and with what hangs.
fn tilting_bars(seen: &Observations) -> Vec<CandidateFamily> {
    let tests = &seen.context.session().tests;
    if tests.iter().all(|test| test.reading.part().is_some()) {
        return Vec::new(); // points, poses and sockets have no bar
    }
    let lengths = seen.bars_mm();
    let alone =
        lengths.iter().filter(|_| lengths.len() > 1).map(|&bar| with_number(BAR_SAG.name, Place::Bar, "bar", bar));
    let grid: Vec<Effect> = std::iter::once(Effect::new(BAR_SAG.name, Place::Bar)).chain(alone).collect();
    let whole = CandidateFamily::new(BAR_SAG.name, Place::Bar, vec![Outlet::Reading], PLAUSIBLE);
    let whole = whole.over(grid).rare(STIFF_BARS);
    vec![CandidateFamily { functions: &[BENDS], ..whole.clone() }, whole]
}
