//! Machines whose code has two neighbouring axes in the wrong order, where the nominal lengths allow it. Whether it has is for others
//! to judge.

use crate::chain::Chain;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::SESSION;
use crate::diagnose::preflight::places::ball_places::NOMINAL_MM;
use crate::diagnose::preflight::quick_fit::nominal_mm;
use crate::diagnose::preflight::suspicion::{SOMETIMES, Suspicion};
use crate::machine::{AxisKind, Machine};
use crate::session::{Motion, Path, Session, Test};

/// The session with each pair of neighbours of which one turns the other way round.
pub(crate) fn other_orders(session: &Session) -> Vec<Suspicion> {
    let machine = &session.machine;
    // what else counts axes by their place is not put in order here
    if !machine.effects.is_empty() || !machine.link_names.is_empty() {
        return Vec::new();
    }
    let is_rotary = |axis: usize| machine.axes[axis].kind == AxisKind::Rotary;
    let bed = machine.code.workpiece_side.len();
    let chain = Chain::of(machine);
    let motions: Vec<Motion> = session.tests.iter().filter_map(|test| Motion::of(session, &chain, test).ok()).collect();
    let leaves_zero = |axis: usize| motions.iter().any(|motion| motion.leaves_zero(axis));
    (1..machine.axes.len())
        .filter(|&second| second != bed && (is_rotary(second - 1) || is_rotary(second)))
        // the order of two axes of which one stands at zero shows in no length; its errors may look like those of the other
        .filter(|&second| leaves_zero(second - 1) && leaves_zero(second))
        .filter_map(|second| {
            let undone = exchanged(session, second);
            let is_allowed = nominal_mm(&undone).is_some_and(|left| left < NOMINAL_MM);
            let [one, other] = [second - 1, second].map(|axis| machine.axes[axis].name.clone());
            let says = format!(
                "{other} carries {one} in the machine file's code, {one} carries {other} by the lengths: write the code as {}",
                undone.machine.code
            );
            let mut found = Suspicion::new(FaultKind::AxisOrder, SESSION, Vec::new(), says, undone);
            (found.components, found.weight) = (vec![one, other], SOMETIMES);
            is_allowed.then_some(found)
        })
        .collect()
}

/// The session with an axis and the one before it in each other's place.
fn exchanged(session: &Session, second: usize) -> Session {
    let mut undone = session.clone();
    of_machine(&mut undone.machine, second);
    undone.tests.iter_mut().for_each(|test| of_test(test, second));
    undone
}

fn of_machine(machine: &mut Machine, second: usize) {
    machine.axes.swap(second - 1, second);
    if machine.machine_zero.len() > second {
        machine.machine_zero.swap(second - 1, second);
    }
    let bed = machine.code.workpiece_side.len();
    match second < bed {
        true => machine.code.workpiece_side.swap(second - 1, second),
        false => machine.code.tool_side.swap(second - 1 - bed, second - bed),
    }
}

fn of_test(test: &mut Test, second: usize) {
    let other = |axis: &mut usize| *axis = in_exchange(*axis, second - 1, second);
    for by_axis in [&mut test.positions, &mut test.approached] {
        if by_axis.len() > second {
            by_axis.swap(second - 1, second);
        }
    }
    test.recording.iter_mut().flat_map(|recording| &mut recording.axes).for_each(other);
    match &mut test.path {
        Some(Path::Sweep { axis, .. }) => other(axis),
        Some(Path::Circle { plane, .. }) => {
            other(&mut plane.first);
            other(&mut plane.second);
        }
        None => {}
    }
}

/// Which axis stands in the place of one where two are exchanged.
pub(crate) fn in_exchange(axis: usize, a: usize, b: usize) -> usize {
    match axis {
        axis if axis == a => b,
        axis if axis == b => a,
        axis => axis,
    }
}
