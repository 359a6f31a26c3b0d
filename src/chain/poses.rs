//! Positions of all axes over many poses, axis by axis, as the batch kernels read them; no lengths and no geometry.

use super::structure::Chain;
use super::trig::{LARGEST_ANGLE_RAD, sines_and_cosines};
use crate::machine::AxisKind;

/// Positions of every axis over many poses, mm or rad.
#[derive(Debug, Clone, PartialEq)]
pub struct Poses {
    rows: usize,
    axes: Vec<AxisPoses>,
}

/// One axis over all poses.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum AxisPoses {
    /// The same position at every pose.
    Standing(f64),
    /// One position per pose.
    Moving { position: Vec<f64>, turn: Option<Turn> },
}

/// Sines and cosines of an axis's positions, kept when the same poses are evaluated again and again.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Turn {
    pub sine: Vec<f64>,
    pub cosine: Vec<f64>,
}

impl Poses {
    /// Poses from rows of `axis_count` positions each (as in [`crate::session::Motion`]).
    pub fn from_rows(axis_count: usize, rows: &[f64]) -> Poses {
        let columns = (0..axis_count).map(|axis| rows.iter().skip(axis).step_by(axis_count).copied().collect());
        Poses::from_columns(columns)
    }

    /// Poses from one column of positions per axis; shorter columns end the poses.
    pub fn from_columns(columns: impl IntoIterator<Item = Vec<f64>>) -> Poses {
        let columns: Vec<Vec<f64>> = columns.into_iter().collect();
        let rows = columns.iter().map(Vec::len).min().unwrap_or(0);
        Poses { rows, axes: columns.into_iter().map(|column| AxisPoses::of(column, rows)).collect() }
    }

    /// The same poses with the sines and cosines of turning axes computed once.
    pub fn with_sines(mut self, chain: &Chain) -> Poses {
        for (axis, poses) in self.axes.iter_mut().enumerate() {
            if let AxisPoses::Moving { position, turn } = poses
                && axis < chain.axis_count()
                && chain.joint(axis).kind == AxisKind::Rotary
                && turn.is_none()
            {
                let (sine, cosine) = sines_and_cosines(position);
                *turn = Some(Turn { sine, cosine });
            }
        }
        self
    }

    /// Number of poses.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Axes that do not stand still, by index.
    pub fn moving(&self) -> Vec<usize> {
        (0..self.axes.len()).filter(|&axis| matches!(self.axes[axis], AxisPoses::Moving { .. })).collect()
    }

    /// Position of an axis at a pose; axes beyond the columns given stand at zero.
    pub fn position(&self, axis: usize, row: usize) -> f64 {
        match self.axes.get(axis) {
            None => 0.0,
            Some(AxisPoses::Standing(q)) => *q,
            Some(AxisPoses::Moving { position, .. }) => position[row],
        }
    }

    /// Position of an axis that stands still, `None` for one that moves.
    pub fn standing(&self, axis: usize) -> Option<f64> {
        match self.axes.get(axis) {
            None => Some(0.0),
            Some(AxisPoses::Standing(q)) => Some(*q),
            Some(AxisPoses::Moving { .. }) => None,
        }
    }

    /// Positions of an axis pose by pose, empty for one that stands still.
    pub fn positions(&self, axis: usize) -> &[f64] {
        match self.axes.get(axis) {
            Some(AxisPoses::Moving { position, .. }) => position,
            _ => &[],
        }
    }

    pub(super) fn turn(&self, axis: usize) -> Option<&Turn> {
        match self.axes.get(axis) {
            Some(AxisPoses::Moving { turn, .. }) => turn.as_ref(),
            _ => None,
        }
    }
}

impl AxisPoses {
    fn of(mut position: Vec<f64>, rows: usize) -> AxisPoses {
        position.truncate(rows);
        let first = position.first().copied().unwrap_or(0.0);
        if position.iter().all(|&q| q == first) {
            return AxisPoses::Standing(first);
        }
        // beyond the vector reduction's range the standard library computes the sines, once
        let turn = position.iter().any(|q| q.abs() > LARGEST_ANGLE_RAD).then(|| {
            let (sine, cosine) = position.iter().map(|q| q.sin_cos()).unzip();
            Turn { sine, cosine }
        });
        AxisPoses::Moving { position, turn }
    }
}
