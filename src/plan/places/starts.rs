//! Where the axes stand from which setups are looked for: linear axes near zero, other rotary axes at some static places.

use super::candidate::Avoid;
use super::free_range::free_parts;
use crate::chain::Chain;
use crate::machine::{AxisKind, Machine};

/// Static positions of a rotary axis that the swept one carries: they change the lever, degrees.
const CARRIED_DEG: [f64; 8] = [0.0, 30.0, -30.0, 60.0, -60.0, 90.0, -90.0, 180.0];
/// Static positions of a rotary axis that carries the swept one: they turn the whole setup, degrees.
const CARRYING_DEG: [f64; 3] = [0.0, 90.0, -90.0];

/// Start positions: linear axes at the place in their range nearest zero, other rotary axes at some static places.
pub(crate) fn static_positions(machine: &Machine, chain: &Chain, axis: usize, avoid: &Avoid) -> Vec<Vec<f64>> {
    let near_zero = |k: usize| machine.axes[k].near_zero();
    let mut starts = vec![(0..machine.axes.len()).map(near_zero).collect::<Vec<f64>>()];
    let branch = chain.carried_by(axis).branch;
    for other in machine.axes_of(AxisKind::Rotary).filter(|&k| k != axis) {
        if chain.carried_by(other).branch != branch {
            continue;
        }
        let fits = |q: &f64| free_parts(machine, other, avoid).iter().any(|(low, high)| q >= low && q <= high);
        let carried = chain.carried_by(other).depth > chain.carried_by(axis).depth;
        let degrees: &[f64] = if carried { &CARRIED_DEG } else { &CARRYING_DEG };
        let mut places: Vec<f64> = degrees.iter().map(|deg| deg.to_radians()).filter(fits).collect();
        if places.is_empty() {
            // off the usual places: the middle of what is left
            places = free_parts(machine, other, avoid).iter().map(|(low, high)| 0.5 * (low + high)).collect();
        }
        starts = starts
            .iter()
            .flat_map(|start| {
                places.iter().map(|&q| {
                    let mut start = start.clone();
                    start[other] = q;
                    start
                })
            })
            .collect();
    }
    starts
}
