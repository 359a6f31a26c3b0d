//! Rotary axes whose lines lie elsewhere than the machine file says, by what the lengths say.

use crate::statistics::least_along;
use nalgebra::Vector3;

use super::ball_places::WORTH;
use super::misplaced::told;
use crate::diagnose::preflight::quick_fit::{Refit, nominal_mm};
use crate::diagnose::preflight::suspicion::{RARELY, Suspicion};
use crate::identify::Quantity;
use crate::machine::AxisKind;
use crate::session::Session;

pub(crate) const AXIS_LINE: &str = "axis-line";

/// A line so far from where the machine file puts it is tried there, mm.
const OTHER_LINE_MM: f64 = 1.0;

/// Steps in which shifts of a line are tried first, mm.
const GRID_MM: f64 = 5.0;

/// Rounds over the three coordinates: each is found beside what the others were.
const ROUNDS: usize = 2;

/// Rotary axes whose lines lie elsewhere: where a fit of the session as it is puts them, and where the lengths do by the
/// nominal machine, from which a fit may not get there.
pub(crate) fn other_lines(session: &Session, as_it_is: &Refit) -> Vec<Suspicion> {
    let machine = &session.machine;
    let fitted = |axis: usize| {
        let mut shift = Vector3::zeros();
        for (unknown, value) in as_it_is.unknowns.iter().zip(&as_it_is.values) {
            match unknown.quantity {
                Quantity::Location { axis: other, component } if other == axis && component.index() < 3 => {
                    shift[component.index()] = *value;
                }
                _ => {}
            }
        }
        shift
    };
    let rotary = (0..machine.axes.len()).filter(|&axis| machine.axes[axis].kind == AxisKind::Rotary);
    rotary
        .flat_map(|axis| [Some(fitted(axis)), by_lengths(session, axis)].map(|shift| (axis, shift)))
        .filter_map(|(axis, shift)| Some((axis, shift?)))
        .filter(|(_, shift)| shift.norm() > OTHER_LINE_MM)
        .map(|(axis, shift)| with_line(session, axis, shift))
        .collect()
}

fn with_line(session: &Session, axis: usize, shift: Vector3<f64>) -> Suspicion {
    let machine = &session.machine;
    let mut undone = session.clone();
    undone.machine.axes[axis].origin += shift;
    let name = &machine.axes[axis].name;
    let says = format!(
        "the line of {name} lies {} mm from where the machine file puts it: correct 'origin' of {name} to {}",
        told(&shift, &Vector3::zeros()),
        told(&(machine.axes[axis].origin + shift), &machine.axes[axis].origin)
    );
    let mut found = Suspicion::new(AXIS_LINE, name, Vec::new(), says, undone);
    found.components = vec![name.clone()];
    found.weight = RARELY;
    found
}

/// Where the lengths put the line of an axis by the nominal machine; `None` where that explains them little better.
fn by_lengths(session: &Session, axis: usize) -> Option<Vector3<f64>> {
    let miss = |shift: Vector3<f64>| {
        let mut moved = session.clone();
        moved.machine.axes[axis].origin += shift;
        nominal_mm(&moved).unwrap_or(f64::INFINITY)
    };
    let before = miss(Vector3::zeros());
    let (mut best, mut least) = (Vector3::zeros(), before);
    for _ in 0..ROUNDS {
        let before_round = least;
        for k in 0..3 {
            let along = |mm: f64| miss(best + Vector3::ith(k, mm));
            let (mm, left) = least_along(&along, GRID_MM);
            if left < least {
                (best[k], least) = (best[k] + mm, left);
            }
        }
        if least >= before_round {
            break;
        }
    }
    (least < WORTH * before).then_some(best)
}
