//! Errors of the tool at poses and their mean, 95 % and largest values.

use nalgebra::Vector3;

use crate::chain::Chain;
use crate::inverse::{Kinematics, Tool};
use crate::machine::Machine;
use crate::statistics::mean;

/// Error of the tool at one pose.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseError {
    /// Tip of the nominal machine in the workpiece, mm.
    pub tip_mm: Vector3<f64>,
    /// Tip of the erring machine minus that of the nominal one, in the workpiece's directions, mm.
    pub off_mm: Vector3<f64>,
    /// Angle between the tool's directions, rad.
    pub turned_rad: f64,
}

/// Mean, 95 % quantile and largest of amounts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Share {
    pub mean: f64,
    pub p95: f64,
    pub largest: f64,
}

/// Figures of a set of poses.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Figures {
    /// Distance of the tip, mm.
    pub position_mm: Share,
    /// The same after the workpiece's zero was taken with this machine: without the mean error, mm.
    pub zeroed_mm: Share,
    /// Angle of the tool, rad.
    pub direction_rad: Share,
}

/// Errors at poses.
pub fn pose_errors(machine: &Machine, chain: &Chain, tool: Tool, poses: &[Vec<f64>]) -> Vec<PoseError> {
    let nominal = Kinematics::nominal(machine, chain, tool);
    let actual = Kinematics::actual(machine, chain, tool);
    let one = |positions: &Vec<f64>| {
        let (ideal, real) = (nominal.pose_with(positions, None), actual.pose(positions));
        PoseError { tip_mm: ideal.tip_mm, off_mm: real.tip_mm - ideal.tip_mm, turned_rad: real.angle_to(&ideal.axis) }
    };
    poses.iter().map(one).collect()
}

/// Figures of amounts.
pub fn share(mut amounts: Vec<f64>) -> Share {
    if amounts.is_empty() {
        return Share::default();
    }
    amounts.sort_by(f64::total_cmp);
    let count = amounts.len();
    let at = ((0.95 * count as f64).ceil() as usize).clamp(1, count) - 1;
    Share { mean: mean(amounts.iter().copied()).unwrap_or(f64::NAN), p95: amounts[at], largest: amounts[count - 1] }
}

impl Figures {
    /// Figures of errors.
    pub fn of(errors: &[PoseError]) -> Figures {
        let sum: Vector3<f64> = errors.iter().map(|error| error.off_mm).sum();
        let mean = sum / errors.len().max(1) as f64;
        Figures {
            position_mm: share(errors.iter().map(|error| error.off_mm.norm()).collect()),
            zeroed_mm: share(errors.iter().map(|error| (error.off_mm - mean).norm()).collect()),
            direction_rad: share(errors.iter().map(|error| error.turned_rad).collect()),
        }
    }
}
