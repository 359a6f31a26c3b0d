//! Poses spread evenly over a work volume or a part. It knows no errors.

use nalgebra::{Matrix3, Vector3};

use crate::chain::Chain;
use crate::inverse::{Kinematics, Tool};
use crate::machine::{AxisKind, Machine};

/// A box in the workpiece's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// Corners, mm.
    pub low: Vector3<f64>,
    pub high: Vector3<f64>,
}

/// Why no poses were found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum VolumeError {
    #[error("axis {axis} states no range; say range: [from, to] in the machine file")]
    NoRange { axis: String },
    #[error(
        "only {found} of {tried} poses over the part are within the travel of the slides; is the part's box in the workpiece's frame (R of the machine file), and is the tool as long as stated?"
    )]
    OutOfReach { found: usize, tried: usize },
    #[error("a part needs three slides that span space; the machine has {slides}")]
    Slides { slides: usize },
}

/// Least share of a part's poses that must be within the travel.
const LEAST_SHARE: f64 = 0.01;

/// Poses (mm, rad by axis index): over the travel of all axes, or over a part.
pub fn poses(machine: &Machine, tool: Tool, part: Option<&Part>, count: usize) -> Result<Vec<Vec<f64>>, VolumeError> {
    let ranges: Vec<(f64, f64)> = machine
        .axes
        .iter()
        .map(|axis| match (axis.range, part, axis.kind) {
            (Some(range), ..) => Ok(range),
            // the part says where the slides go
            (None, Some(_), AxisKind::Linear) => Ok((f64::NEG_INFINITY, f64::INFINITY)),
            _ => Err(VolumeError::NoRange { axis: axis.name.clone() }),
        })
        .collect::<Result<_, _>>()?;
    let over_travel = |index: usize| -> Vec<f64> {
        let one = |(axis, (from, to)): (usize, &(f64, f64))| match from.is_finite() {
            true => from + (to - from) * spread(index, axis),
            false => 0.0,
        };
        ranges.iter().enumerate().map(one).collect()
    };
    let Some(part) = part else { return Ok((1..=count).map(over_travel).collect()) };
    let sliding: Vec<usize> = machine.axes_of(AxisKind::Linear).collect();
    let &[x, y, z] = sliding.as_slice() else { return Err(VolumeError::Slides { slides: sliding.len() }) };
    let chain = Chain::of(machine);
    let kinematics = Kinematics::nominal(machine, &chain, tool);
    let mut axes = Vec::new();
    let mut found = Vec::new();
    for index in 1..=count {
        let mut positions = over_travel(index);
        let at = |k: usize| part.low[k] + (part.high[k] - part.low[k]) * spread(index, machine.axes.len() + k);
        let tip = Vector3::new(at(0), at(1), at(2));
        let pose = kinematics.pose_and_axes(&positions, None, &mut axes);
        let ways = Matrix3::from_columns(&[x, y, z].map(|axis| axes[axis].direction));
        let Some(back) = ways.try_inverse() else { return Err(VolumeError::Slides { slides: 3 }) };
        let step = back * (tip - pose.tip_mm);
        [x, y, z].iter().zip(step.iter()).for_each(|(&axis, step)| positions[axis] += step);
        let is_inside = |(q, (from, to)): (&f64, &(f64, f64))| (*from..=*to).contains(q);
        if positions.iter().zip(&ranges).all(is_inside) {
            found.push(positions);
        }
    }
    match (found.len() as f64) < LEAST_SHARE * count as f64 || found.is_empty() {
        true => Err(VolumeError::OutOfReach { found: found.len(), tried: count }),
        false => Ok(found),
    }
}

/// The `index`-th number of an evenly spread sequence in 0 … 1: Halton's, in the base of the `dimension`-th prime.
fn spread(index: usize, dimension: usize) -> f64 {
    const PRIMES: [usize; 30] = [
        2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71, 73, 79, 83, 89, 97, 101, 103, 107,
        109, 113,
    ];
    let base = PRIMES[dimension % PRIMES.len()];
    let (mut rest, mut digit, mut value) = (index, 1.0, 0.0);
    while rest > 0 {
        digit /= base as f64;
        value += digit * (rest % base) as f64;
        rest /= base;
    }
    value
}
