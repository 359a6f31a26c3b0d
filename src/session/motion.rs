//! Positions of all axes, row by row. Where those of a test come from is in `test_motion`.

/// Positions up to this are zero, mm or rad.
const AT_ZERO: f64 = 1e-9;

/// Positions of every axis at every row of a test.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Number of axes; row k of `positions` starts at `k · axis_count`.
    pub axis_count: usize,
    /// mm or rad, row by row.
    pub positions: Vec<f64>,
    /// Seconds since the start of the recording; `None` for static poses.
    pub time_s: Option<Vec<f64>>,
    /// Axes that move, by index.
    pub moving: Vec<usize>,
}

impl Motion {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.positions.len().checked_div(self.axis_count).unwrap_or(0)
    }

    /// Positions of all axes at one row.
    pub fn row(&self, row: usize) -> &[f64] {
        &self.positions[row * self.axis_count..(row + 1) * self.axis_count]
    }

    /// Positions of one axis, row by row.
    pub fn axis(&self, axis: usize) -> impl Iterator<Item = f64> + '_ {
        self.positions.iter().skip(axis).step_by(self.axis_count).copied()
    }

    /// True when an axis leaves its zero: then what turns or shifts its way shows.
    pub fn leaves_zero(&self, axis: usize) -> bool {
        self.axis(axis).any(|q| q.abs() > AT_ZERO)
    }
}
