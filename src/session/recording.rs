//! What a ball bar recorded: positions as commanded, lengths as read. No interpretation, no files.

use std::sync::Arc;

use super::motion::Motion;

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

/// Which column of a file holds the readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LengthColumn {
    /// Absolute ball-to-ball length.
    #[default]
    LengthMm,
    /// Reading minus the bar's calibrated length, µm.
    DeviationUm,
    /// Reading minus the bar's calibrated length, mm.
    DeviationMm,
}

impl LengthColumn {
    /// All of them.
    pub const ALL: [LengthColumn; 3] = [LengthColumn::LengthMm, LengthColumn::DeviationUm, LengthColumn::DeviationMm];

    /// Header of the column.
    pub fn name(self) -> &'static str {
        match self {
            LengthColumn::LengthMm => "length_mm",
            LengthColumn::DeviationUm => "deviation_um",
            LengthColumn::DeviationMm => "deviation_mm",
        }
    }

    /// True for readings that are counted from the bar's length.
    pub fn is_deviation(self) -> bool {
        self != LengthColumn::LengthMm
    }

    /// Size of the column's unit, mm.
    pub fn unit_mm(self) -> f64 {
        match self {
            LengthColumn::DeviationUm => 1e-3,
            _ => 1.0,
        }
    }

    /// Length of which the column counts its values, mm, for a bar of `bar_mm`.
    pub fn origin_mm(self, bar_mm: f64) -> f64 {
        if self.is_deviation() { bar_mm } else { 0.0 }
    }
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
    pub leading_texts: Arc<Vec<String>>,
    /// Header of the clock and position columns as in the file.
    pub leading_header: String,
    /// Column of the file that held the readings.
    pub column: LengthColumn,
    /// How the positions in the file scatter about those here; none where they are those of the file.
    pub scatter: Option<Scatter>,
}

/// Positions of an axis that were read with noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    pub axis: usize,
    /// Root mean square of what the file has less the even motion, mm or rad.
    pub by: f64,
}

impl Recording {
    /// Column of the positions of an axis.
    pub fn column_of(&self, axis: usize) -> Option<usize> {
        self.axes.iter().position(|&other| other == axis)
    }

    /// The same where the recording is one in time.
    pub fn swept(&self, axis: usize) -> Option<usize> {
        self.column_of(axis).filter(|_| self.time_s().is_some())
    }

    /// A recording of readings along a motion: what [`crate::simulate`] gives, for [`crate::identify`] to take.
    /// `length_mm` has one absolute length (mm) for each row of the motion, NaN where there is none.
    ///
    /// ```
    /// use fiveaxis::chain::Composition;
    /// use fiveaxis::load::load_session;
    /// use fiveaxis::session::Recording;
    /// use fiveaxis::simulate::simulate;
    ///
    /// let mut session = load_session("examples/thesis/chapter5/session.yaml".as_ref())?;
    /// let traces = simulate(&session, Composition::Exact)?;
    /// for (test, trace) in session.tests.iter_mut().zip(&traces) {
    ///     test.recording = Some(Recording::from_trace(&trace.motion, trace.length_mm.clone()));
    /// }
    /// assert_eq!(session.tests[0].rows(), traces[0].length_mm.len());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_trace(motion: &Motion, length_mm: Vec<f64>) -> Recording {
        let numbered = || (0..motion.rows()).map(|row| row as f64).collect();
        Recording {
            clock: motion.time_s.clone().map_or_else(|| Clock::Pose(numbered()), Clock::TimeS),
            axes: motion.moving.clone(),
            positions: motion.moving.iter().map(|&axis| motion.axis(axis).collect()).collect(),
            length_mm,
            channels: Vec::new(),
            leading_texts: Arc::default(),
            leading_header: String::new(),
            column: LengthColumn::default(),
            scatter: None,
        }
    }

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

    /// A length as the file's column counts it, for a bar of `bar_mm`.
    pub fn in_column(&self, length_mm: f64, bar_mm: f64) -> f64 {
        (length_mm - self.column.origin_mm(bar_mm)) / self.column.unit_mm()
    }

    /// Whether rows follow each other along a path; static poses have no neighbours.
    pub fn is_run(&self) -> bool {
        !matches!(self.clock, Clock::Pose(_))
    }

    /// Times in seconds as the file of a recording without positions has them, where it does and they rise.
    pub fn written_time_s(&self) -> Option<Vec<f64>> {
        let column = self.leading_header.split(',').position(|name| name == "time_s")?;
        let of_row = |text: &String| text.split(',').nth(column)?.parse::<f64>().ok().filter(|time| time.is_finite());
        let time: Vec<f64> = self.leading_texts.iter().map(of_row).collect::<Option<_>>()?;
        time.windows(2).all(|pair| pair[0] <= pair[1]).then_some(time)
    }

    /// Times in seconds, when the recording has them.
    pub fn time_s(&self) -> Option<&[f64]> {
        match &self.clock {
            Clock::TimeS(time) => Some(time),
            _ => None,
        }
    }
}
