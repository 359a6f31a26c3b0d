//! The candidates of a search: which effect at which place through which outlets, over which grid of shapes. It judges nothing.

use super::family::Family;
use super::linear::linear;
use super::play::tipping;
use super::poses::for_poses;
use super::rotary::rotary;
use super::setups::setup;
use crate::diagnose::model::linear_model::Ground;
use crate::machine::AxisKind;

/// All families for a session.
pub fn families(ground: &Ground) -> Vec<Family> {
    let machine = ground.context.machine();
    let mut list = Vec::new();
    for axis in 0..machine.axes.len() {
        match machine.axes[axis].kind {
            AxisKind::Rotary => rotary(ground, axis, &mut list),
            AxisKind::Linear => linear(ground, axis, &mut list),
        }
    }
    if ground.has_sweeps() {
        tipping(ground, &mut list);
    }
    setup(ground, &mut list);
    if !ground.has_sweeps() {
        for_poses(ground, &mut list);
    }
    // positions too coarse for every shape of a cause leave nothing of it to search
    list.retain(|family| !family.grid.is_empty());
    list
}
