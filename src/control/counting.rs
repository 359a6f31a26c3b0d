//! Which way a control's own coordinates run: along the tool's way over the workpiece, or against it.

use crate::machine::{AxisKind, Machine};

/// Slides whose positive command moves the tool in the negative sense over the workpiece, by index.
pub fn counting_against(machine: &Machine) -> Vec<usize> {
    let way = |axis: usize| {
        let along = machine.axes[axis].direction;
        machine.tool_sign(axis) * along[along.iamax()].signum()
    };
    let slides = machine.axes_of(AxisKind::Linear);
    slides.filter(|&axis| way(axis) < 0.0).collect()
}

/// +1, or −1 where the control's coordinate runs against R's: by coordinate.
pub(super) fn sign_of_coordinate(machine: &Machine, coordinate: usize) -> f64 {
    let is_along = |axis: &usize| machine.axes[*axis].coordinate_direction() == Some(coordinate);
    if counting_against(machine).iter().any(is_along) { -1.0 } else { 1.0 }
}
