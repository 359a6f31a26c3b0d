//! Axis positions of chains without a closed form (arms, machines of fewer or more axes): damped Newton steps from many starts.

use nalgebra::{DMatrix, DVector};

use super::kinematics::{AxisInWorkpiece, Kinematics};
use super::solve::{Inverse, InverseError, Solution, Target};
use crate::machine::AxisKind;

/// Starts over the travel of all axes.
const STARTS: usize = 400;
/// Newton steps from one start.
const MOST_STEPS: usize = 80;
/// Length that counts as much as a radian, mm: the reach of a small arm.
const LENGTH_PER_RAD: f64 = 300.0;
/// A target is met within this, mm and rad (times [`LENGTH_PER_RAD`]).
const TARGET_TOLERANCE: f64 = 1e-9;
/// Travel of axes without a range, mm or rad on either side.
const OPEN_TRAVEL: (f64, f64) = (1000.0, std::f64::consts::PI);

impl Kinematics<'_> {
    /// Solutions found from `near` and from starts spread over the travel.
    pub(super) fn searched(&self, target: &Target, near: &[f64]) -> Result<Inverse, InverseError> {
        let machine = self.machine();
        let wanted = if target.across.is_some() { 6 } else { 5 };
        // more axes than the pose asks for: any number of solutions, the one nearest to `near` within the travel is told
        let is_any = machine.axes.len() > wanted;
        let mut solutions = Vec::new();
        let mut axes = Vec::new();
        for start in 0..STARTS {
            let from: Vec<f64> = match start {
                0 => near.to_vec(),
                _ => machine
                    .axes
                    .iter()
                    .enumerate()
                    .map(|(k, axis)| {
                        let open = if axis.kind == AxisKind::Linear { OPEN_TRAVEL.0 } else { OPEN_TRAVEL.1 };
                        let (low, high) = axis.range.unwrap_or((-open, open));
                        low + (high - low) * spread(start, k)
                    })
                    .collect(),
            };
            if let Some(solution) = self.newton(target, from, &mut axes) {
                self.add(self.rounds(solution, near).solutions, &mut solutions);
            }
            if is_any && solutions.iter().any(|solution| solution.outside.is_empty()) {
                break;
            }
        }
        if solutions.is_empty() {
            let axes = machine.axis_names().join(" ");
            return Err(InverseError::NotFound { starts: STARTS, axes });
        }
        self.order(&mut solutions, near);
        Ok(Inverse { solutions, is_complete: false, reach: None })
    }

    /// Damped steps (Levenberg, Marquardt) from one start; `None` where they do not arrive.
    fn newton(&self, target: &Target, mut positions: Vec<f64>, axes: &mut Vec<AxisInWorkpiece>) -> Option<Solution> {
        let mut damping = 1e-3;
        let (mut off, mut jacobian) = self.distance(target, &positions, axes);
        for _ in 0..MOST_STEPS {
            if off.amax() < TARGET_TOLERANCE * 1e-3 {
                break;
            }
            let mut normal = jacobian.tr_mul(&jacobian);
            let size = normal.diagonal().amax();
            (0..positions.len()).for_each(|k| normal[(k, k)] += damping * size);
            let step = normal.cholesky()?.solve(&jacobian.tr_mul(&off));
            let tried: Vec<f64> = positions.iter().zip(step.iter()).map(|(q, step)| q + step).collect();
            let (rest, next) = self.distance(target, &tried, axes);
            if rest.norm() < off.norm() {
                (positions, off, jacobian) = (tried, rest, next);
                damping = (damping * 0.1).max(1e-16);
            } else if step.amax() < 1e-14 {
                break;
            } else {
                damping = (damping * 10.0).min(1e6);
            }
        }
        let pose = self.pose(&positions);
        let (off_mm, off_rad) = ((pose.tip_mm - target.tip_mm).norm(), pose.angle_to(&target.axis));
        (off.amax() < TARGET_TOLERANCE).then_some(Solution {
            positions,
            outside: Vec::new(),
            free: None,
            off_mm,
            off_rad,
        })
    }

    /// What lacks to the target, in mm, and how each axis changes it.
    fn distance(
        &self,
        target: &Target,
        positions: &[f64],
        axes: &mut Vec<AxisInWorkpiece>,
    ) -> (DVector<f64>, DMatrix<f64>) {
        let motion = self.component_errors(positions);
        let pose = self.pose_and_axes(positions, motion.as_deref(), axes);
        let rows = if target.across.is_some() { 9 } else { 6 };
        let mut off = DVector::zeros(rows);
        off.fixed_rows_mut::<3>(0).copy_from(&(target.tip_mm - pose.tip_mm));
        off.fixed_rows_mut::<3>(3).copy_from(&((target.axis - pose.axis) * LENGTH_PER_RAD));
        if let Some(across) = target.across {
            off.fixed_rows_mut::<3>(6).copy_from(&((across - pose.across) * LENGTH_PER_RAD));
        }
        let mut jacobian = DMatrix::zeros(rows, positions.len());
        for (k, axis) in axes.iter().enumerate() {
            jacobian.fixed_view_mut::<3, 1>(0, k).copy_from(&axis.moves(&pose.tip_mm));
            jacobian.fixed_view_mut::<3, 1>(3, k).copy_from(&(axis.turns(&pose.axis) * LENGTH_PER_RAD));
            if target.across.is_some() {
                jacobian.fixed_view_mut::<3, 1>(6, k).copy_from(&(axis.turns(&pose.across) * LENGTH_PER_RAD));
            }
        }
        (off, jacobian)
    }
}

/// The `start`-th of numbers spread evenly over 0 … 1, another sequence for every `axis`: fractions of multiples of roots of
/// primes.
fn spread(start: usize, axis: usize) -> f64 {
    const PRIMES: [f64; 24] = [
        2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0, 31.0, 37.0, 41.0, 43.0, 47.0, 53.0, 59.0, 61.0, 67.0,
        71.0, 73.0, 79.0, 83.0, 89.0,
    ];
    (start as f64 * PRIMES[axis % PRIMES.len()].sqrt()).fract()
}
