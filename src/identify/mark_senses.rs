//! What the marks of programs say of an axis's sense. A mark leads slides along the bar, where it points if axes go as stated: one
//! that goes the other way has turned it elsewhere, or leads the slides elsewhere, and the bar gets longer by less.

use crate::chain::Geometry;
use crate::identify::model::problem::Problem;
use crate::session::{RunEnd, beyond, marked};

/// What slides lose of a mark's move and a gauge's levels are off by, standard deviation, mm: lost motion of axes in use. It is
/// common to all marks, so one of them speaks for all.
const LOST_MM: f64 = 0.02;

/// χ² of the mark that speaks loudest with an axis's sense turned minus χ² as stated; 0 where no capture showed marks.
pub(super) fn worse_by_marks(problems: [&Problem; 2]) -> f64 {
    let [stated, _] = problems;
    let marks = (0..stated.tests.len()).flat_map(|test| [RunEnd::Start, RunEnd::End].map(|end| (test, end)));
    let worse_by = marks.filter_map(|(test, end)| {
        let [as_stated, turned] = [0, 1].map(|k| off_mm(problems[k], stated, test, end));
        Some((turned?.powi(2) - as_stated?.powi(2)) / (LOST_MM * LOST_MM))
    });
    worse_by.fold(0.0, |loudest: f64, worse_by| if worse_by.abs() > loudest.abs() { worse_by } else { loudest })
}

/// How much longer the bar got at a mark than a model has it, mm; the program was written for the stated one.
fn off_mm(model: &Problem, stated: &Problem, test: usize, end: RunEnd) -> Option<f64> {
    let session = stated.session;
    let of_test = &session.tests[test];
    let marks = of_test.marks?;
    let seen_mm = marks.seen_mm?[usize::from(end == RunEnd::End)];
    let from = beyond(session, &stated.tests[test].motion, of_test, end, &[1.0]);
    let to = marked(&session.machine, of_test, from.get(..session.machine.axes.len())?, marks.move_mm)?;
    let geometry = Geometry::nominal(model.chain);
    let length_mm = |q: &[f64]| of_test.bar(&geometry, model.tests[test].links, q).norm();
    Some(seen_mm - (length_mm(&to) - length_mm(&from)))
}
