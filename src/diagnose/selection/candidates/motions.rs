//! What the axes of a session did, and the motions that they may have beside their own. It names no effect.

use crate::chain::{Geometry, LinkId};
use crate::diagnose::model::linear_model::LinearModel;
use crate::machine::{AxisKind, Component, Machine, Outlet};
use crate::statistics::median;
use nalgebra::Vector3;

/// Components across and along the nearest coordinate direction of an axis.
pub(super) struct Directions {
    pub across: [Component; 2],
    pub along: Component,
    pub tilts: [Component; 2],
}

pub(super) fn directions(machine: &Machine, axis: usize) -> Directions {
    let k = machine.axes[axis].own_component().direction_index();
    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
    Directions {
        across: [Component::ALL[i], Component::ALL[j]],
        along: Component::ALL[k],
        tilts: [Component::ALL[i + 3], Component::ALL[j + 3]],
    }
}

/// Motion outlets of an axis for some components.
pub(super) fn motion(axis: usize, components: &[Component]) -> Vec<Outlet> {
    components.iter().map(|&component| Outlet::Motion { axis, component }).collect()
}

/// Smallest and largest position that recordings reach with an axis in motion; `None` when it never moves.
pub(crate) fn travelled(model: &LinearModel, axis: usize) -> Option<(f64, f64)> {
    let mut ends: Option<(f64, f64)> = None;
    for test in 0..model.tests() {
        let motion = model.context.motion(test);
        if motion.moving.contains(&axis) {
            for q in motion.axis(axis) {
                ends = Some(ends.map_or((q, q), |(from, to)| (from.min(q), to.max(q))));
            }
        }
    }
    ends.filter(|(from, to)| to - from > 1e-6)
}

/// Smallest and largest position of an axis, standing or moving.
pub(crate) fn visited(model: &LinearModel, axis: usize) -> (f64, f64) {
    (0..model.tests())
        .flat_map(|test| model.context.motion(test).axis(axis))
        .fold((f64::MAX, f64::MIN), |(a, b), q| (a.min(q), b.max(q)))
}

/// Whether any slide moves in any test.
pub(super) fn slides_move(model: &LinearModel) -> bool {
    let axes = &model.context.machine().axes;
    (0..model.tests())
        .any(|test| model.context.motion(test).moving.iter().any(|&axis| axes[axis].kind == AxisKind::Linear))
}

/// Median distance of neighbouring positions of an axis in motion.
pub(super) fn finest_step(model: &LinearModel, axis: usize) -> f64 {
    let steps = (0..model.tests()).filter(|&test| model.context.motion(test).moving.contains(&axis)).flat_map(|test| {
        let positions: Vec<f64> = model.context.motion(test).axis(axis).collect();
        positions.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 0.0).collect::<Vec<_>>()
    });
    median(steps).unwrap_or(1.0)
}

/// The load on the joint changes its direction to gravity in the session.
pub(super) fn turns_against_gravity(model: &LinearModel, axis: usize) -> bool {
    gravity_turns_in(model, axis, |rows| {
        [0, rows / 2, rows.saturating_sub(1)].into_iter().filter(|&r| r < rows).collect()
    })
}

/// Whether gravity changes its direction in the link that an axis carries, over the rows that `looked_at` picks by their number.
pub(super) fn gravity_turns_in(model: &LinearModel, axis: usize, looked_at: impl Fn(usize) -> Vec<usize>) -> bool {
    let chain = model.context.chain();
    let geometry = Geometry::nominal(chain);
    let link = chain.carried_by(axis);
    let gravity = model.context.machine().gravity;
    let mut first = None;
    (0..model.tests()).any(|test| {
        let motion = model.context.motion(test);
        looked_at(motion.rows()).into_iter().any(|row| {
            let seen = geometry.pose(link, motion.row(row), None).rotation.transpose() * gravity;
            (seen - *first.get_or_insert(seen)).norm() > 0.02
        })
    })
}

/// Whether a weight beyond an axis may have a moment about a direction of R that stands in the link before it.
pub(super) fn has_moment(model: &LinearModel, axis: usize, about: Vector3<f64>) -> bool {
    let chain = model.context.chain();
    let geometry = Geometry::nominal(chain);
    let own = chain.carried_by(axis);
    let carrier = LinkId { depth: own.depth.saturating_sub(1), ..own };
    let gravity = model.context.machine().gravity;
    (0..model.tests()).any(|test| {
        let motion = model.context.motion(test);
        let turned = |row: usize| geometry.pose(carrier, motion.row(row), None).rotation * about;
        (0..motion.rows()).any(|row| gravity.cross(&turned(row)).norm() > LEAST_MOMENT)
    })
}

/// Share of the full moment below which there is none.
const LEAST_MOMENT: f64 = 0.02;

/// The slide nearest to the spindle: where growth of the spindle shows.
pub(super) fn last_before_spindle(model: &LinearModel, axis: usize) -> bool {
    let chain = model.context.chain();
    let machine = model.context.machine();
    let branch = chain.branch(crate::chain::Branch::Tool);
    branch.iter().rev().find(|&&k| machine.axes[k].kind == AxisKind::Linear) == Some(&axis)
}
