//! A ripple along an axis that beats with time: neither position alone nor time alone repeats it. Ripples that keep to the
//! position are in `harmonics`, those that keep to the time in `vibration`.
//!
//! `E = Σ± a± cos(n q ± 2πft) + b± sin(n q ± 2πft)` while the axis moves, t from the session's beginning, n the order per
//! turn, or `n q = 2π q / period` on a slide.

use super::candidates::{CandidateFamily, Observations, Refined, none, with_number};
use super::context::Profile;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, of_any_axis,
    plain_measure,
};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::machine::{AxisKind, Effect, Machine, Outlet, ParameterValue, Place};
use std::f64::consts::TAU;

/// Ripple of a moving axis that beats with time.
pub static BEAT: Kind = Kind {
    name: "beat",
    driver: Driver::Time,
    formula: "E = sum a cos(n q +- 2 pi f t) + b sin(n q +- 2 pi f t), while the axis moves",
    size_meaning: "amplitude",
    cause: "servo or converter ripple that goes with the speed, beating with the control's cycle, a pump or a neighbouring drive",
    remedy: "repeat at another feed: the pattern wanders; tune the loop or its filters, look for what runs at that beat",
    titles: &[("", "Ripple of {place} that beats with time")],
    measures: Some("amplitude"),
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::BothWays },
    unseen: Unseen::Never,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: true,
    signature: Signature::Beat,
    candidates: beats,
    candidates_of_poses: none,
    documented: Documented {
        place: "any axis",
        components: "all",
        functions: "`cos±`, `sin±` of n q ± 2πft while the axis moves",
        parameters: "`order` or `period`, `frequency`",
        unit: "arcsec, um",
    },
    parameters: &[
        Parameter::number(
            "order",
            ParameterUnit::Plain,
            DefaultValue::Absent,
            (1e-3, 1e6),
            "periods per turn of a rotary axis",
        ),
        Parameter::number(
            "period",
            ParameterUnit::Plain,
            DefaultValue::Absent,
            (1e-3, 1e5),
            "period of a linear axis, mm",
        ),
        Parameter::number(
            "frequency",
            ParameterUnit::Plain,
            DefaultValue::Required,
            (1e-5, 1e5),
            "frequency of the beat, Hz",
        ),
    ],
    check: period_of_its_axis,
    outlets: of_any_axis,
    measure: plain_measure,
    functions: |_| ["cos+", "sin+", "cos-", "sin-"].map(String::from).to_vec(),
    profiles,
};

/// An order goes with a rotary axis, a period with a linear one.
fn period_of_its_axis(machine: &Machine, effect: &Effect) -> Result<(), String> {
    let kind = effect.place.axis().map(|axis| machine.axes[axis].kind);
    match (kind, effect.number("order"), effect.number("period")) {
        (Some(AxisKind::Rotary), Some(_), None) | (Some(AxisKind::Linear), None, Some(_)) | (None, ..) => Ok(()),
        (Some(AxisKind::Rotary), ..) => Err("a rotary axis has an order and no period, e.g. order: 12".into()),
        (Some(AxisKind::Linear), ..) => Err("a linear axis has a period in mm and no order, e.g. period: 10".into()),
    }
}

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let Place::Axis(axis) = effect.place else { return Ok(Vec::new()) };
    let along = effect.number("order").or(effect.number("period").map(|period| TAU / period)).unwrap_or(0.0);
    let omega = TAU * BEAT.number(context, effect, "frequency");
    let wave = |sign: f64, of: fn(f64) -> f64| {
        let rows = |test: usize| -> Vec<f64> {
            let motion = context.motion(test);
            match motion.moving.contains(&axis) {
                true => {
                    let phase =
                        |row: usize| along * motion.row(row)[axis] + sign * omega * context.session_time_s(test, row);
                    (0..motion.rows()).map(|row| of(phase(row))).collect()
                }
                false => vec![0.0; motion.rows()],
            }
        };
        (0..context.tests()).map(rows).collect()
    };
    Ok(vec![wave(1.0, f64::cos), wave(1.0, f64::sin), wave(-1.0, f64::cos), wave(-1.0, f64::sin)])
}

/// Log odds against one of the many ripples that were looked at, and amplitudes that are plausible, µm or arcsec.
const LOG_ODDS_AGAINST: f64 = 15.0;
const PLAUSIBLE: f64 = 10.0;
/// First step of a frequency, in beats over the session, and of a period or order, as a share of one over the travel.
const FIRST_STEP_BEATS: f64 = 0.1;
const FIRST_STEP_ALONG: f64 = 0.05;

/// The loudest ripples of each moving axis that wander with time.
fn beats(seen: &Observations) -> Vec<CandidateFamily> {
    let tests = seen.context.session().tests.iter();
    let begins_s = tests.map(|test| test.started_at_s).fold(f64::MAX, f64::min);
    let session_s = (seen.latest_s() - begins_s).max(1.0);
    let axes = &seen.machine().axes;
    let mut list = Vec::new();
    for (axis, (from, to)) in (0..axes.len()).filter_map(|axis| Some((axis, seen.context.travelled(axis)?))) {
        let (place, own) = (Place::Axis(axis), Outlet::own(seen.machine(), axis));
        for ripple in &seen.ripples[axis] {
            let (name, along) = match axes[axis].kind {
                AxisKind::Linear => ("period", TAU / ripple.per_unit),
                AxisKind::Rotary => ("order", ripple.per_unit),
            };
            let beat = with_number(BEAT.name, place, "frequency", ripple.hz).with(name, ParameterValue::Number(along));
            let ripples = ripple.per_unit * (to - from) / TAU;
            let shape = vec![
                Refined::number("frequency", (ripple.least_hz, 1e3), FIRST_STEP_BEATS / (session_s * ripple.hz)),
                Refined::number(name, (0.9 * along, 1.1 * along), FIRST_STEP_ALONG / ripples * along),
            ];
            let family = CandidateFamily::new(BEAT.name, place, vec![own], PLAUSIBLE);
            list.push(family.over(vec![beat]).refine(shape).fast().rare(LOG_ODDS_AGAINST));
        }
    }
    list
}
