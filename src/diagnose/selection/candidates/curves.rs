//! Free curves over positions, for what has no form in the catalogue. It judges nothing.

use super::family::CandidateFamily;
use crate::diagnose::model::linear_model::LinearModel;
use crate::effects::UNKNOWN;
use crate::machine::{AxisKind, Effect, Machine, Outlet, ParameterValue, Place};

/// Free curve over the positions of an axis.
pub(super) fn unknown(
    place: Place,
    axis: usize,
    machine: &Machine,
    outlets: Vec<Outlet>,
    ends: (f64, f64),
    driver: &str,
) -> CandidateFamily {
    let kind = machine.axes[axis].kind;
    let effect = Effect::new(UNKNOWN.name, place)
        .with("driver", ParameterValue::Word(driver.into()))
        .with("from", ParameterValue::Number(kind.to_file_unit(ends.0)))
        .with("to", ParameterValue::Number(kind.to_file_unit(ends.1)))
        .with("count", ParameterValue::Number(14.0));
    CandidateFamily::new(UNKNOWN.name, place, outlets, 30.0).over(vec![effect])
}

/// Positions of a standing rotary axis closer than this are one posture, rad.
const SAME_POSTURE_RAD: f64 = 0.02;

/// Tests that a posture needs: one alone has no repeat.
const POSTURE_TESTS: usize = 2;

/// Names of the tests of an axis in which another rotary axis stands where it stands in fewer than half of them: what a cable, a load or a
/// table of the control does to an axis may hang on where another one stands.
pub(super) fn postures(model: &LinearModel, axis: usize) -> Vec<Vec<String>> {
    let session = model.context.session();
    let axes = &session.machine.axes;
    let swept: Vec<usize> =
        (0..model.tests()).filter(|&test| model.context.motion(test).moving.contains(&axis)).collect();
    let mut list = Vec::new();
    for other in (0..axes.len()).filter(|&other| other != axis && axes[other].kind == AxisKind::Rotary) {
        let mut groups: Vec<(f64, Vec<usize>)> = Vec::new();
        for &test in &swept {
            let motion = model.context.motion(test);
            if motion.moving.contains(&other) || motion.rows() == 0 {
                continue;
            }
            let at = motion.row(0)[other];
            match groups.iter_mut().find(|(place, _)| (place - at).abs() < SAME_POSTURE_RAD) {
                Some((_, tests)) => tests.push(test),
                None => groups.push((at, vec![test])),
            }
        }
        let few = groups.into_iter().map(|(_, tests)| tests);
        let few = few.filter(|tests| tests.len() >= POSTURE_TESTS && 2 * tests.len() < swept.len());
        for tests in few {
            let names = tests.iter().map(|&test| session.tests[test].name.clone()).collect();
            if !list.contains(&names) {
                list.push(names);
            }
        }
    }
    list
}
