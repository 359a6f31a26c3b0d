//! Rotary axes whose lines lie elsewhere than the machine file says, by what the lengths say.

use crate::diagnose::fault_kind::FaultKind;
use crate::statistics::least_along;
use nalgebra::Vector3;

use super::ball_places::WORTH;
use super::misplaced::{told, told_sizes};
use crate::diagnose::preflight::quick_fit::{Refit, nominal_mm};
use crate::diagnose::preflight::suspicion::{RARELY, Suspicion};
use crate::identify::Quantity;
use crate::machine::AxisKind;
use crate::session::Session;

/// A line so far by the lengths from where the machine file puts it is tried there, mm.
const OTHER_LINE_MM: f64 = 1.0;

/// A location error larger than this may be a line that the machine file puts elsewhere, mm: machines in use have tens of µm.
const NO_ERROR_MM: f64 = 0.2;

/// Steps in which shifts of a line are tried first, mm.
const GRID_MM: f64 = 5.0;

/// Share of a coordinate in a line's direction from which on the line lies along it.
const ALONG_ITSELF: f64 = 0.99;

/// Rounds over the coordinates: each is found beside what the others were.
const ROUNDS: usize = 2;

/// Rotary axes whose lines lie elsewhere: where a fit of the session as it is puts them, and where the lengths do by the
/// nominal machine, from which a fit may not get there.
pub(crate) fn other_lines(session: &Session, as_it_is: &Refit) -> Vec<Suspicion> {
    let machine = &session.machine;
    let rotary = machine.axes_of(AxisKind::Rotary);
    let by_lengths = rotary
        .filter_map(|axis| Some((axis, by_lengths(session, axis)?)))
        .filter(|(_, shift)| shift.norm() > OTHER_LINE_MM)
        .map(|(axis, shift)| with_line(session, axis, shift));
    fitted_lines(session, as_it_is).into_iter().chain(by_lengths).collect()
}

/// The same where a fit of the session as it is puts them: what it takes for a location error that no machine has.
pub(crate) fn fitted_lines(session: &Session, as_it_is: &Refit) -> Vec<Suspicion> {
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
    let rotary = machine.axes_of(AxisKind::Rotary);
    rotary
        .map(|axis| (axis, fitted(axis)))
        .filter(|(_, shift)| shift.norm() > NO_ERROR_MM)
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
    let mut found = Suspicion::new(FaultKind::AxisLine, name, Vec::new(), says, undone);
    found.components = vec![name.clone()];
    found.detail = told_sizes(&shift, &Vector3::zeros());
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
    // along itself a line is the same
    let across: Vec<usize> = (0..3).filter(|&k| session.machine.axes[axis].direction[k].abs() < ALONG_ITSELF).collect();
    let found = (0..across.len()).map(|first| {
        let mut order = across.clone();
        order.rotate_left(first);
        descended(&miss, before, &order)
    });
    let (best, least) = found.min_by(|one, other| one.1.total_cmp(&other.1))?;
    (least < WORTH * before).then_some(best)
}

/// Least misfit over some coordinates of a line in turn, and where it is. Which of them comes first matters: a robust misfit has
/// more than one valley.
fn descended(miss: &(impl Fn(Vector3<f64>) -> f64 + Sync), before: f64, order: &[usize]) -> (Vector3<f64>, f64) {
    let (mut best, mut least) = (Vector3::zeros(), before);
    for _ in 0..ROUNDS {
        let before_round = least;
        for &k in order {
            let along = |mm: f64| miss(best + Vector3::ith(k, mm));
            let found = least_along(&along, GRID_MM);
            if found.value < least {
                (best[k], least) = (best[k] + found.at, found.value);
            }
        }
        if least >= before_round {
            break;
        }
    }
    (best, least)
}
