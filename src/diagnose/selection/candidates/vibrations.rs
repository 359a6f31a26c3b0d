//! Candidates that vibrate or ripple in time. It judges nothing.

use super::family::{CandidateFamily, Refined, number, refined};
use super::motions::travelled;
use crate::diagnose::model::linear_model::LinearModel;
use crate::diagnose::noise::spectrum::{aliased, lines};
use crate::diagnose::selection::ripples::waves;
use crate::effects::{BEAT, VIBRATION};
use crate::machine::{AxisKind, Outlet, ParameterValue, Place};
use std::f64::consts::TAU;

/// Lines of the spectrum that are tried.
const PEAKS: usize = 4;

/// Frequencies at which the traces together have the most power, tried as vibration of ball and joints.
pub(super) fn vibrations(model: &LinearModel, list: &mut Vec<CandidateFamily>) {
    let machine = model.context.machine();
    let mut lines: Vec<f64> = lines(model, &model.residual_mm).into_iter().take(PEAKS).map(|line| line.hz).collect();
    let aliases = aliased(model, &model.residual_mm, &lines);
    lines.extend(aliases);
    if lines.is_empty() {
        return;
    }
    let mut places: Vec<(Place, Outlet)> = (0..3).map(|k| (Place::SpindleBall, Outlet::SpindleBall(k))).collect();
    places.extend((0..machine.axes.len()).map(|axis| (Place::Axis(axis), Outlet::own(machine, axis))));
    let mut places: Vec<(Place, Vec<Outlet>)> = places.into_iter().map(|(place, one)| (place, vec![one])).collect();
    places.push((Place::SpindleBall, (0..3).map(Outlet::SpindleBall).collect()));
    for (place, outlets) in places {
        let clocked =
            |f: &f64| number(VIBRATION.name, place, "frequency", *f).with("clock", ParameterValue::Word("test".into()));
        let mut family =
            CandidateFamily::new(VIBRATION.name, place, outlets, 10.0).over(lines.iter().map(clocked).collect()).fast();
        family.by_test = true;
        list.push(family.refine(vec![Refined {
            name: "frequency",
            least: 0.02,
            most: 1e3,
            step: 0.004,
            element: None,
        }]));
    }
}

/// Log odds against one of the many ripples that were looked at, and amplitudes that are plausible, µm or arcsec.
const RARE: f64 = 15.0;
const RIPPLES: f64 = 10.0;
/// First step of a frequency, in beats over the session, and of a period or order, as a share of one over the travel.
const PHASE: f64 = 0.1;
const ALONG: f64 = 0.05;

/// The loudest ripples of each moving axis that wander with time.
pub(super) fn beats(model: &LinearModel, list: &mut Vec<CandidateFamily>) {
    let machine = model.context.machine();
    let tests = || 0..model.tests();
    let begins = tests().map(|test| model.context.session().tests[test].started_at_s).fold(f64::MAX, f64::min);
    let ends = tests().map(|test| model.context.ends_at_s(test)).fold(f64::MIN, f64::max);
    let session_s = (ends - begins).max(1.0);
    for axis in 0..machine.axes.len() {
        let Some((from, to)) = travelled(model, axis) else { continue };
        let (place, own) = (Place::Axis(axis), Outlet::own(machine, axis));
        for wave in waves(model, axis, &own) {
            let (name, along) = match machine.axes[axis].kind {
                AxisKind::Linear => ("period", TAU / wave.per_unit),
                AxisKind::Rotary => ("order", wave.per_unit),
            };
            let beat = number(BEAT.name, place, "frequency", wave.hz).with(name, ParameterValue::Number(along));
            let ripples = wave.per_unit * (to - from) / TAU;
            let shape = vec![
                refined("frequency", wave.least_hz, 1e3, PHASE / (session_s * wave.hz)),
                refined(name, 0.9 * along, 1.1 * along, ALONG / ripples * along),
            ];
            let family =
                CandidateFamily::new(BEAT.name, place, vec![own], RIPPLES).over(vec![beat]).refine(shape).fast();
            list.push(CandidateFamily { rarity: RARE, ..family });
        }
    }
}
