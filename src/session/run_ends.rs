//! Where a run begins and ends outside its rows: their path carried on by the overshoot. It knows no program.

use super::motion::Motion;
use super::recording::Clock;
use super::test::{Session, Test};

/// Which end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RunEnd {
    Start,
    End,
}

/// Positions outside one end of the rows, one after the other, at these shares of the overshoot; none for static poses.
///
/// A parabola through three rows, the overshoot apart, follows arcs and straight sweeps alike.
pub fn beyond(session: &Session, motion: &Motion, test: &Test, end: RunEnd, shares: &[f64]) -> Vec<f64> {
    let overshoot = test.run_in();
    let is_static = test.recording.as_ref().is_some_and(|recording| matches!(recording.clock, Clock::Pose(_)));
    if is_static || overshoot <= 0.0 || motion.rows() < 3 {
        return Vec::new();
    }
    let row = |from_end: usize| match end {
        RunEnd::Start => motion.row(from_end),
        RunEnd::End => motion.row(motion.rows() - 1 - from_end),
    };
    let axes = &session.machine.axes;
    let longest = (motion.rows() - 1) / 2;
    let mut way = 0.0;
    let mut reach = 0;
    while reach < longest && way < overshoot {
        let (here, next) = (row(reach), row(reach + 1));
        way += axes
            .iter()
            .zip(here.iter().zip(next))
            .map(|(axis, (here, next))| axis.kind.to_file_unit(next - here).powi(2))
            .sum::<f64>()
            .sqrt();
        reach += 1;
    }
    if way <= 0.0 {
        return Vec::new();
    }
    let scale = overshoot / way;
    let mut positions = Vec::with_capacity(shares.len() * axes.len());
    for share in shares {
        let u = share * scale;
        let weights = [(u + 1.0) * (u + 2.0) / 2.0, -u * (u + 2.0), u * (u + 1.0) / 2.0];
        for axis in 0..axes.len() {
            let q = |k: usize| row(k * reach)[axis];
            // exactly still axes stay exactly still
            let start = q(0);
            positions.push(start + weights[1] * (q(1) - start) + weights[2] * (q(2) - start));
        }
    }
    positions
}
