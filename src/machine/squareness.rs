//! Squareness errors of the linear axes of a machine: those that are no choice of R. No values.

use super::axis::{Axis, AxisKind};
use super::error_name::{Component, ErrorName};
use super::serial_machine::Machine;

/// Orientation errors of a linear axis that are no choice of R: R's x runs along X and its x–y plane contains Y, so EB0X,
/// EC0X and EA0Y are zero; of inclined axes all count.
pub fn squareness(machine: &Machine) -> Vec<ErrorName> {
    let linear = machine.axes.iter().filter(|axis| axis.kind == AxisKind::Linear);
    linear
        .flat_map(|axis| {
            let free = axis.slots().into_iter().filter(|component| !is_by_choice_of_r(axis, *component));
            free.map(|component| ErrorName::location(component, &axis.name))
        })
        .collect()
}

/// True for errors of linear axes that are zero by the choice of R.
pub fn is_by_choice_of_r(axis: &Axis, component: Component) -> bool {
    match axis.coordinate_direction() {
        Some(0) => true,
        Some(1) => component == Component::EA,
        _ => false,
    }
}
