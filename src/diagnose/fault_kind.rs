//! Which mistake a person can make in files or set-up. It tells none of them from another.

macro_rules! fault_kinds {
    ($($(#[$meaning:meta])* $kind:ident = $name:literal,)*) => {
        /// What went wrong in files or set-up; all stand in docs/diagnosis.md.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum FaultKind {
            $($(#[$meaning])* $kind,)*
        }

        impl FaultKind {
            /// All of them, as they stand in the schema.
            pub const ALL: &'static [FaultKind] = &[$(FaultKind::$kind,)*];

            /// Name in output.
            pub const fn name(self) -> &'static str {
                match self {
                    $(FaultKind::$kind => $name,)*
                }
            }
        }
    };
}

fault_kinds! {
    /// An axis, or several, count the other way.
    AxisSign = "axis-sign",
    /// The columns of two axes stand under each other's names.
    AxisSwap = "axis-swap",
    /// A column is in another unit than stated, or has a factor too many.
    Unit = "unit",
    /// The column of an axis was written from the other end than the readings.
    AngleReversed = "angle-reversed",
    /// Lengths and positions were paired by different clocks.
    TimeShift = "time-shift",
    /// The column of an axis is off by a constant.
    ColumnShifted = "column-shifted",
    /// Deviations have the wrong sign.
    ReadingSign = "reading-sign",
    /// Readings count from a zero of their own.
    ReadingZero = "reading-zero",
    /// Software took something off the readings, or drew them across a gap.
    ReadingsProcessed = "readings-processed",
    /// Readings stand beside the positions of other rows.
    ReadingsOrder = "readings-order",
    /// Lengths or positions were written with too few digits.
    ValuesRounded = "values-rounded",
    /// A pivot or spindle ball stands elsewhere than stated.
    BallPlace = "ball-place",
    /// A ball, instrument or target is carried by another link than stated.
    BallLink = "ball-link",
    /// A ball was mounted anew where the session states one setup.
    MountedAnew = "mounted-anew",
    /// An axis stood elsewhere than stated, or none moved.
    StandingAxis = "standing-axis",
    /// The bar is another than stated, or has another length.
    BarOther = "bar-other",
    /// The machine file has the line of an axis elsewhere.
    AxisLine = "axis-line",
    /// The machine file has an axis in another direction.
    AxisDirection = "axis-direction",
    /// The machine's code has two axes the wrong way round.
    AxisOrder = "axis-order",
    /// The instrument was moved during the session.
    InstrumentMoved = "instrument-moved",
    /// Columns of points and poses are exchanged.
    SwappedColumns = "swapped-columns",
    /// Rotations are written in another form than stated.
    RotationForm = "rotation-form",
    /// Recordings stand in each other's tests.
    FilesExchanged = "files-exchanged",
    /// A recording does not belong to the session.
    ForeignFile = "foreign-file",
    /// One recording stands in several tests.
    SameRecording = "same-recording",
    /// A recording runs against the direction of its test.
    Direction = "direction",
    /// A recording holds the run there and the run back.
    BothDirections = "both-directions",
    /// A recording covers another arc than its test.
    Arc = "arc",
    /// Rows in which nothing moves, or a run-in, were left in a recording.
    Dwell = "dwell",
    /// Rows stand twice in a recording.
    DoubledRows = "doubled-rows",
    /// Most readings of a test are missing.
    ReadingsMissing = "readings-missing",
    /// The gauge stuck or was off.
    GaugeStuck = "gauge-stuck",
    /// The bar reached the end of its stroke.
    StrokeEnd = "stroke-end",
    /// Tests overlap in time, or began before their session.
    SessionTime = "session-time",
    /// A ball moves at another speed than stated.
    Feed = "feed",
}
