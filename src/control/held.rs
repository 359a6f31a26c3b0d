//! The machine as a control's kinematics description holds it, and what it leaves.

use crate::chain::{Chain, Composition, Geometry};
use crate::inverse::{Kinematics, Tool};
use crate::machine::{AxisKind, Machine};
use crate::volume::{Figures, PoseError};

/// A machine without errors whose rotary axes stand where those of `actual` stand with all axes at zero; with
/// `directions` they point where those of `actual` point.
pub fn held(actual: &Machine, directions: bool) -> Machine {
    let chain = Chain::of(actual);
    let geometry = Geometry::new(&chain, &actual.location_errors(), Composition::Exact);
    let zero = vec![0.0; chain.axis_count()];
    let mut held = actual.clone();
    for (index, axis) in held.axes.iter_mut().enumerate() {
        if axis.kind == AxisKind::Rotary {
            let pose = geometry.pose(chain.carried_by(index), &zero, None);
            let place = pose.point(&axis.origin);
            // along the line its place says nothing
            let shift = place - axis.origin;
            axis.origin += shift - axis.direction * axis.direction.dot(&shift);
            if directions {
                axis.direction = (pose.rotation * axis.direction).normalize();
            }
        }
        axis.location_errors = [0.0; 6];
        axis.component_errors.clear();
    }
    held.effects.clear();
    held
}

/// Errors that stay over poses when the control holds `held` in place of the nominal machine: tips relative to those with
/// all axes at zero, for a zero shift is taken with the workpiece's zero.
pub fn left_over(actual: &Machine, held: &Machine, tool: Tool, poses: &[Vec<f64>]) -> Figures {
    let chains = [Chain::of(actual), Chain::of(held)];
    let real = Kinematics::actual(actual, &chains[0], tool);
    let known = Kinematics::nominal(held, &chains[1], tool);
    let zero = vec![0.0; actual.axes.len()];
    let start = real.pose(&zero).tip_mm - known.pose(&zero).tip_mm;
    let errors: Vec<PoseError> = poses
        .iter()
        .map(|pose| {
            let (real, known) = (real.pose(pose), known.pose_with(pose, None));
            PoseError {
                tip_mm: known.tip_mm,
                off_mm: real.tip_mm - known.tip_mm - start,
                turned_rad: real.angle_to(&known.axis),
            }
        })
        .collect();
    Figures::of(&errors)
}
