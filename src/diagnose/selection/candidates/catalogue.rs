//! The candidates of a search: which effect at which place through which outlets, over which grid of shapes. It judges nothing.

use super::family::CandidateFamily;
use super::linear::linear;
use super::play::tipping;
use super::poses::for_poses;
use super::rotary::rotary;
use super::setups::setup;
use super::spindles::under_sensors;
use crate::diagnose::model::linear_model::LinearModel;
use crate::machine::AxisKind;

/// All families for a session.
pub fn families(model: &LinearModel) -> Vec<CandidateFamily> {
    let machine = model.context.machine();
    let mut list = Vec::new();
    for axis in 0..machine.axes.len() {
        match machine.axes[axis].kind {
            AxisKind::Rotary => rotary(model, axis, &mut list),
            AxisKind::Linear => linear(model, axis, &mut list),
        }
        under_sensors(model, axis, &mut list);
    }
    if model.has_sweeps() {
        tipping(model, &mut list);
    }
    setup(model, &mut list);
    if !model.has_sweeps() {
        for_poses(model, &mut list);
    }
    // positions too coarse for every shape of a cause leave nothing of it to search
    list.retain(|family| !family.grid.is_empty());
    list
}
