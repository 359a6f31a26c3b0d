//! What a ball bar recorded: positions as commanded, lengths as read. No interpretation, no files.

/// What orders the rows.
#[derive(Debug, Clone, PartialEq)]
pub enum Clock {
    /// Seconds since the start of the recording.
    TimeS(Vec<f64>),
    /// Static poses, numbered in visiting order.
    Pose(Vec<f64>),
    /// Only lengths were recorded; the arc stands in the session.
    Absent,
}

/// One recording; all columns have the same number of rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    pub clock: Clock,
    /// Axis indices of the position columns in the order of the file.
    pub axes: Vec<usize>,
    /// Positions, mm or rad, one vector per column of `axes`.
    pub positions: Vec<Vec<f64>>,
    /// Readings, mm; NaN where the file has none.
    pub length_mm: Vec<f64>,
    /// Further columns, kept by their header.
    pub channels: Vec<(String, Vec<f64>)>,
    /// Texts of clock and position columns as in the file, row by row: so that a simulation can repeat them unchanged.
    pub leading_texts: Vec<String>,
    /// Header of the clock and position columns as in the file.
    pub leading_header: String,
}

impl Recording {
    /// Number of rows, rows without a reading included.
    pub fn len(&self) -> usize {
        self.length_mm.len()
    }

    /// True when there is no row.
    pub fn is_empty(&self) -> bool {
        self.length_mm.is_empty()
    }

    /// Number of rows with a reading.
    pub fn readings(&self) -> usize {
        self.length_mm.iter().filter(|length| length.is_finite()).count()
    }

    /// Times in seconds, when the recording has them.
    pub fn time_s(&self) -> Option<&[f64]> {
        match &self.clock {
            Clock::TimeS(time) => Some(time),
            _ => None,
        }
    }
}
