//! Words for the operator: where the pivot goes, how well that must be met, where the axes are parked.

use super::coordinates::Coordinates;
use super::step::Step;
use crate::machine::Machine;
use crate::plan::PlannedTest;
use crate::units::rounded;

/// Where the pivot goes and how well that must be met.
pub(super) fn pivot_words(machine: &Machine, planned: &PlannedTest, coordinates: &Coordinates) -> Vec<Step> {
    let p = planned.test.pivot.at;
    vec![
        Step::Say(format!("pivot on {} ball {:.3} mm above it", planned.mount, planned.height_mm)),
        Step::Say(format!("pivot ball at x {:.3} y {:.3} z {:.3} with all axes at zero", p.x, p.y, p.z)),
        Step::Say(placing_words(machine, planned, coordinates)),
    ]
}

/// `jog to X -100 Y 0 Z -15, lock the magnet, within 0.06 mm`, and why not farther.
pub fn placing_words(machine: &Machine, planned: &PlannedTest, coordinates: &Coordinates) -> String {
    let placing = &planned.placing;
    // rounded down: what is said holds
    let within = (placing.pivot_mm * 100.0 + 1e-6).floor() / 100.0;
    let Some(jog) = &placing.jog else {
        return format!(
            "the slides do not reach the pivot's place: measure it in, within {within} mm, {}",
            placing.reason
        );
    };
    let shown = |k: &usize| {
        let value = coordinates.reading(machine, *k, jog[*k]);
        format!("{} {}", machine.axes[*k].name, rounded(value, 3))
    };
    let is_linear = |k: &usize| machine.axes[*k].kind == crate::machine::AxisKind::Linear;
    let (linear, rotary): (Vec<usize>, Vec<usize>) = (0..jog.len()).partition(is_linear);
    let list = |axes: &[usize]| axes.iter().map(shown).collect::<Vec<_>>().join(" ");
    format!(
        "place the pivot: at {} jog to {}, setting ball of the spindle in the pivot cup, lock the magnet; within {within} mm, {}",
        list(&rotary),
        list(&sorted_by_name(machine, linear)),
        placing.reason
    )
}

/// X before Y before Z, as operators read them.
fn sorted_by_name(machine: &Machine, mut axes: Vec<usize>) -> Vec<usize> {
    axes.sort_by(|&a, &b| machine.axes[a].name.cmp(&machine.axes[b].name));
    axes
}

/// Where the axes are brought by hand.
pub(super) fn park_words(machine: &Machine, planned: &PlannedTest, coordinates: &Coordinates) -> String {
    let approach = &planned.approach;
    let stands =
        |&k: &usize| format!("{} {:.3}", machine.axes[k].name, coordinates.reading(machine, k, approach.park[k]));
    let parked: Vec<String> = approach.park_order.iter().map(stands).collect();
    format!("bring the axes to park by hand: {}; the program then goes there itself", parked.join(" "))
}
