//! Candidates that vibrate. It judges nothing.

use super::super::ground::Ground;
use super::super::spectrum::{aliased, lines};
use super::{Family, Refined, number};
use crate::machine::{Outlet, ParameterValue, Place};

/// Lines of the spectrum that are tried.
const PEAKS: usize = 4;

/// Frequencies at which the traces together have the most power, tried as vibration of ball and joints.
pub(super) fn vibrations(ground: &Ground, list: &mut Vec<Family>) {
    let machine = ground.context.machine();
    let mut lines: Vec<f64> = lines(ground, &ground.residual_mm).into_iter().take(PEAKS).map(|line| line.hz).collect();
    let aliases = aliased(ground, &ground.residual_mm, &lines);
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
            |f: &f64| number("vibration", place, "frequency", *f).with("clock", ParameterValue::Word("test".into()));
        let mut family =
            Family::new("vibration", place, outlets, 10.0).over(lines.iter().map(clocked).collect()).fast();
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
