//! The least distance of two concentric circles that hold a path between them, for arcs on which a least-squares centre lies where few readings
//! decide. It knows no parts of the path.

use nalgebra::{Matrix3, Vector3};

use super::deviations::CircleRun;

/// Rounds of weights; each brings the width nearer to the least one, 500 to a thousandth of it on arcs of a quarter turn.
const ROUNDS: usize = 500;

/// Width of the narrowest ring that holds the paths, mm.
///
/// `min over r, a, b of the range of δ − r − a·cos φ − b·sin φ`, by Lawson's weights (Lawson 1961): each round weighs a reading by how far it
/// lies from the circle of the last one. No width falls below the least one, so that the narrowest of all rounds is taken.
pub(super) fn least_width_mm(runs: &[CircleRun]) -> f64 {
    let rows: Vec<(Vector3<f64>, f64)> = runs
        .iter()
        .flat_map(|run| run.angle_rad.iter().zip(&run.deviation_mm))
        .map(|(angle, deviation)| (Vector3::new(1.0, angle.cos(), angle.sin()), *deviation))
        .collect();
    let mut weights = vec![1.0 / rows.len().max(1) as f64; rows.len()];
    let mut least = f64::INFINITY;
    for _ in 0..ROUNDS {
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for ((row, deviation), weight) in rows.iter().zip(&weights) {
            normal += row * row.transpose() * *weight;
            right += row * (deviation * weight);
        }
        let Some(factor) = normal.cholesky() else { break };
        let circle = factor.solve(&right);
        let left: Vec<f64> = rows.iter().map(|(row, deviation)| deviation - row.dot(&circle)).collect();
        let (low, high) = left.iter().fold((f64::MAX, f64::MIN), |(low, high), left| (low.min(*left), high.max(*left)));
        least = least.min(high - low);
        weights.iter_mut().zip(&left).for_each(|(weight, left)| *weight *= left.abs());
        let all: f64 = weights.iter().sum();
        if all <= 0.0 {
            break;
        }
        weights.iter_mut().for_each(|weight| *weight /= all);
    }
    if least.is_finite() { least } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::circles::Direction;

    #[test]
    fn the_ring_of_an_arc_is_that_of_its_alternating_ends() {
        // cos 3φ over half a turn alternates four times with one size, beside any circle: no ring is narrower than 2
        let run = |scale: f64, [a, b]: [f64; 2]| {
            let angle_rad: Vec<f64> = (0..=400).map(|k| f64::from(k) / 400.0 * std::f64::consts::PI).collect();
            let deviation = |q: &f64| scale * (3.0 * q).cos() + a * q.cos() + b * q.sin() + 7.0;
            let deviation_mm = angle_rad.iter().map(deviation).collect();
            let (test, axes, third, direction) = (0, [0, 1], 2, Direction::Ccw);
            CircleRun { test, axes, third, direction, radius_mm: 100.0, arc_rad: 3.0, angle_rad, deviation_mm }
        };
        let width = least_width_mm(&[run(1.0, [0.0, 0.0])]);
        assert!((width - 2.0).abs() < 2e-3, "{width}");
        // a centre elsewhere changes nothing, and a second path makes the ring no narrower
        let moved = least_width_mm(&[run(1.0, [5.0, -3.0])]);
        assert!((moved - width).abs() < 2e-3, "{moved}");
        let both = least_width_mm(&[run(1.0, [0.0, 0.0]), run(1.3, [0.2, 0.1])]);
        assert!(both >= width, "{both}");
    }
}
