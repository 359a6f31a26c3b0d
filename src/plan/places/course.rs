//! How the axes move in a test: one alone, one with linear axes following, or two on a circle. Nominal positions only.

use super::candidate::Candidate;
use super::drive::{Drive, STEP_DEG};
use super::run_in::{RUN_IN, RunIn, written};
use crate::machine::{AxisKind, Machine};
use crate::session::{Follow, Path};

impl Candidate {
    /// Positions of all axes at an angle of the path, rad: mm and rad.
    pub fn pose(&self, angle_rad: f64) -> Vec<f64> {
        let mut q = self.solved.positions.clone();
        match &self.drive {
            Drive::Turn => q[self.axis] = angle_rad,
            Drive::Follow(_, swing) => {
                q.iter_mut().enumerate().for_each(|(axis, q)| *q += swing.at(axis, angle_rad));
                q[self.axis] = angle_rad;
            }
            Drive::Circle(_, swing) => q.iter_mut().enumerate().for_each(|(axis, q)| *q += swing.at(axis, angle_rad)),
        }
        q
    }

    /// True when the axis turns alone, the linear axes standing still.
    pub fn is_plain(&self) -> bool {
        self.drive == Drive::Turn
    }

    /// True when two linear axes draw a circle.
    pub fn is_circle(&self) -> bool {
        matches!(self.drive, Drive::Circle(..))
    }

    /// True when linear axes follow the turning one.
    pub fn follows(&self) -> bool {
        matches!(self.drive, Drive::Follow(..))
    }

    /// Rows of the motion over an arc with run-in and run-out, and the angle at each row, deg.
    pub fn rows(&self, machine: &Machine, from_deg: f64, to_deg: f64) -> (Vec<Vec<f64>>, Vec<f64>) {
        let steps = match self.drive {
            Drive::Turn => 1,
            _ => ((to_deg - from_deg) / STEP_DEG).round().max(1.0) as usize,
        };
        let mut angles: Vec<f64> =
            (0..=steps).map(|k| from_deg + (to_deg - from_deg) * k as f64 / steps as f64).collect();
        let mut way: Vec<Vec<f64>> = angles.iter().map(|deg| self.pose(deg.to_radians())).collect();
        let ends = [(from_deg, -1.0), (to_deg, 1.0)].map(|(end, way)| {
            let at = |beyond: f64| self.pose((end + way * beyond).to_radians());
            let reach = RunIn::of(machine, RUN_IN, &at).kept;
            let kept = if self.follows() { written(end, way, reach) } else { reach };
            (end + way * kept, at(kept))
        });
        let [(before, first), (after, last)] = ends;
        angles.insert(0, before);
        angles.push(after);
        way.insert(0, first);
        way.push(last);
        (way, angles)
    }

    /// The session's path over an arc.
    pub fn path(&self, from: f64, to: f64) -> Path {
        let sweep = |follow, length_mm| Path::Sweep { axis: self.axis, from, to, step: STEP_DEG, follow, length_mm };
        match &self.drive {
            Drive::Turn => sweep(Follow::None, None),
            Drive::Follow(follow, _) => sweep(*follow, Some(self.bar_mm)),
            Drive::Circle(plane, _) => {
                Path::Circle { plane: plane.clone(), radius_mm: self.bar_mm, from, to, step: STEP_DEG }
            }
        }
    }

    /// Positions of the axes that stand still, mm or rad.
    pub fn standing(&self, machine: &Machine) -> Vec<Option<f64>> {
        let moves = |axis: usize| match &self.drive {
            Drive::Turn => axis == self.axis,
            Drive::Follow(..) => axis == self.axis || machine.axes[axis].kind == AxisKind::Linear,
            Drive::Circle(plane, _) => axis == plane.first || axis == plane.second,
        };
        self.solved.positions.iter().enumerate().map(|(axis, &q)| (!moves(axis)).then_some(q)).collect()
    }

    /// Radius on which one ball goes round as seen from the other, mm; of the carried ball about the axis where the bar keeps
    /// its direction. The feed is counted on it.
    pub fn way_radius_mm(&self) -> f64 {
        match &self.drive {
            Drive::Turn | Drive::Follow(Follow::None | Follow::Axial, _) => self.solved.rho_mm,
            Drive::Follow(Follow::Radial | Follow::Tangential, _) | Drive::Circle(..) => self.bar_mm,
        }
    }
}
