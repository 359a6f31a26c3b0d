//! One direction of a test from the start of its run-in to the end of its run-out. Curves that several axes draw are in `coupled`.

use super::coordinates::Coordinates;
use super::coupled;
use super::step::{Curves, Step};
use crate::machine::Machine;
use crate::plan::PlannedTest;
use crate::session::{Follow, Path, Test};

/// One direction of a test from the start of its run-in to the end of its run-out.
pub(super) fn run(
    machine: &Machine,
    planned: &PlannedTest,
    test: &Test,
    coordinates: &Coordinates,
    curves: Curves,
) -> Vec<Step> {
    match &test.path {
        Some(Path::Sweep { axis, from, to, follow: Follow::None, .. }) => {
            vec![sweep(machine, planned, *axis, coordinates.offset(*axis), to + (to - from).signum() * test.run_in())]
        }
        Some(Path::Sweep { .. }) => coupled::follow(machine, planned, test, coordinates, curves),
        Some(Path::Circle { .. }) => coupled::circle(machine, test, coordinates, curves),
        None => Vec::new(),
    }
}

/// One direction of a sweep of one axis: run-in, arc and run-out in one block, so that no corner slows it down.
fn sweep(machine: &Machine, planned: &PlannedTest, axis: usize, offset: f64, end_deg: f64) -> Step {
    let feed = planned.test.feed();
    let range = machine.axes[axis].range.map(|(low, high)| (low.to_degrees(), high.to_degrees()));
    Step::Feed {
        axis: machine.axes[axis].name.clone(),
        to: range.map_or(end_deg, |(low, high)| end_deg.clamp(low, high)) + offset,
        per_minute: (feed / planned.rho_mm).to_degrees(),
    }
}
