//! The machine as a control's kinematics description holds it, and what it leaves.

use crate::chain::{Branch, Chain, Composition, Geometry};
use crate::inverse::{Kinematics, Tool};
use crate::machine::{AxisKind, Component, ComponentError, ErrorName, Machine};
use crate::volume::{Figures, PoseError};
use nalgebra::Vector3;

/// A machine without errors whose rotary axes stand where those of `actual` stand with all axes at zero, with nominal
/// directions. An axis carried by another one stands where it does *as its carrier sees it*: what the carrier's tilt moves it
/// turns with no axis, so that a vector which holds it would be wrong by twice as much after half a turn.
pub fn held(actual: &Machine) -> Machine {
    held_where(actual, &|_, _| true)
}

/// The same with those parts of places and vectors alone that are entered: by axis index and component (0 x, 1 y, 2 z).
/// Public for tests, which enter parameters one by one.
pub fn held_where(actual: &Machine, is_entered: &dyn Fn(usize, usize) -> bool) -> Machine {
    let chain = Chain::of(actual);
    let geometry = Geometry::new(&chain, &actual.location_errors(), Composition::Exact);
    let zero = vec![0.0; chain.axis_count()];
    let pose_of = |axis: usize| geometry.pose(chain.carried_by(axis), &zero, None);
    let mut held = actual.clone();
    for branch in [Branch::Workpiece, Branch::Tool] {
        let mut carrier: Option<usize> = None;
        for &index in chain.branch(branch) {
            if actual.axes[index].kind != AxisKind::Rotary {
                continue;
            }
            let (origin, direction) = (actual.axes[index].origin, actual.axes[index].direction);
            let place = pose_of(index).point(&origin);
            let (own, below) = match carrier {
                Some(carrier) => {
                    let frame = pose_of(carrier);
                    let seen = frame.rotation.transpose() * (place - frame.translation_mm);
                    (seen - origin, shift_of(&held, actual, carrier))
                }
                None => (place - origin, Vector3::zeros()),
            };
            let entered = Vector3::from_fn(|k, _| if is_entered(index, k) { own[k] } else { 0.0 });
            // along the line its place says nothing
            held.axes[index].origin += entered - direction * direction.dot(&entered) + below;
            carrier = Some(index);
        }
    }
    held.as_drawn()
}

/// How far a held line stands from its nominal place, mm.
fn shift_of(held: &Machine, actual: &Machine, axis: usize) -> Vector3<f64> {
    held.axes[axis].origin - actual.axes[axis].origin
}

/// Errors that stay over poses when the control holds `held` in place of the nominal machine: tips relative to those with
/// all axes at zero, for a zero shift is taken with the workpiece's zero. The tool is given as it is and as the control has it. A head's
/// last axis carries the tool along with its line: the vector from the line to the tool stays.
pub fn left_over(actual: &Machine, held: &Machine, (real_tool, tool): (Tool, Tool), poses: &[Vec<f64>]) -> Figures {
    let chains = [Chain::of(actual), Chain::of(held)];
    let real = Kinematics::actual(actual, &chains[0], real_tool);
    let is_turning = |axis: &usize| actual.axes[*axis].kind == AxisKind::Rotary;
    let last = chains[0].branch(Branch::Tool).iter().copied().rfind(is_turning);
    let carried = last.map_or_else(Vector3::zeros, |axis| shift_of(held, actual, axis));
    let known = Kinematics::nominal(held, &chains[1], Tool { tip_mm: tool.tip_mm + carried, ..tool });
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

/// The cause that makes most of what stays beside a held machine: without it least would stay. In words.
pub fn what_stays(actual: &Machine, held: &Machine, tools: (Tool, Tool), poses: &[Vec<f64>]) -> String {
    let mut least = (f64::INFINITY, "the error of the directions of the axes".to_string());
    let mut ask = |without: Machine, name: String| {
        let left = left_over(&without, held, tools, poses).position_mm.p95;
        if left < least.0 {
            least = (left, name);
        }
    };
    for (index, axis) in actual.axes.iter().enumerate() {
        for component in Component::ALL {
            let is_it = |error: &ComponentError| error.component == component;
            if axis.component_errors.iter().any(is_it) {
                let mut without = actual.clone();
                without.axes[index].component_errors.retain(|error| !is_it(error));
                ask(without, format!("{} over the travel of {}", ErrorName::motion(component, &axis.name), axis.name));
            }
            if component.is_angle() && axis.location_errors[component.index()] != 0.0 {
                let mut without = actual.clone();
                without.axes[index].location_errors[component.index()] = 0.0;
                ask(without, ErrorName::location(component, &axis.name).to_string());
            }
        }
    }
    least.1
}
