//! Candidates that the sense or the speed of motion drives. It judges nothing.

use super::family::{CandidateFamily, Refined, number};
use super::motions::{directions, motion, slides_move, travelled, visited};
use crate::diagnose::model::linear_model::LinearModel;
use crate::effects::{LATERAL_PLAY, REVERSAL_SPIKE, SERVO_LAG};
use crate::machine::{Effect, Outlet, ParameterValue, Place};

/// Lost motion: all at once, half or all by wind-up; an axis that stands at first may stand on either flank.
pub(super) fn windups(model: &LinearModel, kind: &str, axis: usize, take_up: f64) -> Vec<Effect> {
    let base = |share: f64, start: f64| {
        number(kind, Place::Axis(axis), "take_up", take_up)
            .with("windup_share", ParameterValue::Number(share))
            .with("gap", ParameterValue::Number(0.0))
            .with("start", ParameterValue::Number(start))
    };
    let first = model.context.order().first();
    let stands = first.is_some_and(|&test| !model.context.motion(test).moving.contains(&axis));
    let starts: &[f64] = if stands { &[0.0, 1.0, -1.0] } else { &[0.0] };
    starts.iter().flat_map(|&start| [0.0, 0.5, 1.0].map(|share| base(share, start))).collect()
}

pub(super) fn windup_refined(longest: f64) -> Vec<Refined> {
    vec![
        Refined { name: "windup_share", least: 0.0, most: 1.0, step: 0.25, element: None },
        Refined { name: "take_up", least: 1e-3 * longest, most: longest, step: 0.1 * longest, element: None },
        Refined { name: "gap", least: 0.0, most: longest, step: 0.02 * longest, element: None },
    ]
}

pub(super) fn spikes(place: Place) -> Vec<Effect> {
    let by_travel = [0.02, 0.1, 0.5, 2.0].map(|d| number(REVERSAL_SPIKE.name, place, "travel", d));
    let ringing = [1.0, 3.0, 8.0].map(|hz| {
        let servo = number(REVERSAL_SPIKE.name, place, "servo_hz", hz).with("damping", ParameterValue::Number(0.5));
        servo.with("travel", ParameterValue::Number(0.05))
    });
    by_travel.into_iter().chain(ringing).collect()
}

/// Lag of an axis beyond that of the others; where slides move, also with the radius that a lag of all takes.
pub(super) fn servo_lag(model: &LinearModel, axis: usize) -> Vec<CandidateFamily> {
    let place = Place::Axis(axis);
    let beyond = CandidateFamily::new(SERVO_LAG.name, place, vec![Outlet::Lag { axis }], 50.0).fast();
    let outlets = vec![Outlet::Lag { axis }, Outlet::SlidesAcceleration { axis }];
    let with_common = CandidateFamily::new(SERVO_LAG.name, place, outlets, 1e4).fast();
    if slides_move(model) { vec![beyond, with_common] } else { vec![beyond] }
}

/// Log odds against a joint that tips as another axis reverses, and against one that tips as an axis is only positioned:
/// it shows from test to test alone, as much else does.
const TIPS: f64 = 6.0;
const TIPS_BETWEEN: f64 = 8.0;

/// Travels of another axis over which a joint tips from side to side, mm or deg.
const TIPPING: [f64; 3] = [0.0, 0.6, 2.5];
/// Longest such travel, and the first step in which it is refined.
const LONGEST_TIPPING: f64 = 10.0;
const TIPPING_STEP: f64 = 0.6;

/// Way between tests below which an axis stands, mm or deg.
const LEAST_WAY: f64 = 0.1;

/// Joints that tip to one or the other side as another axis goes one or the other way, within tests or between them.
pub(super) fn tipping(model: &LinearModel, list: &mut Vec<CandidateFamily>) {
    let machine = model.context.machine();
    let axes = 0..machine.axes.len();
    for (driving, tipped) in axes.clone().flat_map(|driving| axes.clone().map(move |tipped| (driving, tipped))) {
        let (from, to) = visited(model, driving);
        if driving == tipped || to - from < machine.axes[driving].kind.from_file_unit(LEAST_WAY) {
            continue;
        }
        let rarity = if travelled(model, driving).is_some() { TIPS } else { TIPS_BETWEEN };
        let place = Place::Axis(tipped);
        // travels of the driving axis are written in the unit of the place
        let travel = |of: f64| machine.axes[tipped].kind.from_file_unit(of);
        let over = |gap: f64| {
            number(LATERAL_PLAY.name, place, "gap", travel(gap))
                .with("of", ParameterValue::Word(machine.axes[driving].name.clone()))
        };
        let (most, step) = (travel(LONGEST_TIPPING), travel(TIPPING_STEP));
        let gap = Refined { name: "gap", least: 0.0, most, step, element: None };
        let outlets = motion(tipped, &directions(machine, tipped).tilts);
        list.push(CandidateFamily {
            rarity,
            ..CandidateFamily::new(LATERAL_PLAY.name, place, outlets, 30.0)
                .over(TIPPING.map(over).to_vec())
                .refine(vec![gap])
        });
    }
}
