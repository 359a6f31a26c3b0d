//! What G and M codes mean for a correction: motions, modes, and those that make the path another one.

/// A code's part in the path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Meaning {
    Motion(Motion),
    /// First and second axis of arcs (0 X, 1 Y, 2 Z).
    Plane([usize; 2]),
    Inches,
    Millimetres,
    Absolute,
    Incremental,
    AbsoluteCentres,
    IncrementalCentres,
    InverseTime,
    PerMinute,
    PerRevolution,
    /// Work offset 0 … 8: G54 … G59.3.
    WorkOffset(usize),
    ToolLength,
    ToolLengthGiven,
    ToolCentrePoint,
    NoToolLength,
    MachineCoordinates,
    SetOffsets,
    /// Goes to a place that only the control knows.
    Reference,
    /// Words of this block are no positions.
    Dwell,
    /// Of no meaning for the path.
    Other,
    /// Changes the path in a way that is not followed here.
    Refused(&'static str),
    /// The same with axis words, without them of no meaning for the path: `G5.1 Q1` and `G5 P10000` switch look-ahead on.
    RefusedWithPlace(&'static str),
}

/// Modal motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    Rapid,
    Line,
    /// Clockwise.
    Clockwise,
    Counter,
    /// A canned cycle or another motion that is not followed.
    Cycle,
    /// G80.
    None,
}

const CYCLE: &str = "is a canned cycle; let the CAM system write its moves out";
const RADIUS: &str = "has the control offset the path by the tool's radius; let the CAM system do that";
const TURNED: &str = "turns, scales or mirrors coordinates in the control; program the plain ones";
const SPLINE: &str = "is a curve that is not followed here; use lines and arcs";
const PROBE: &str = "ends where a probe triggers, which is not known here";
const SHIFTED: &str = "shifts the coordinates by what is not known here; use G54 to G59.3 with stated offsets";
const LATHE: &str = "is a lathe's";

/// Meaning of a G code in tenths; `None` for one that is not known.
pub fn g_code(tenths: u16) -> Option<Meaning> {
    use Meaning::*;
    Some(match tenths {
        0 => Motion(self::Motion::Rapid),
        10 => Motion(self::Motion::Line),
        20 => Motion(self::Motion::Clockwise),
        30 => Motion(self::Motion::Counter),
        800 => Motion(self::Motion::None),
        40 => Dwell,
        170 => Plane([0, 1]),
        180 => Plane([2, 0]),
        190 => Plane([1, 2]),
        200 => Inches,
        210 => Millimetres,
        900 => Absolute,
        910 => Incremental,
        901 => AbsoluteCentres,
        911 => IncrementalCentres,
        930 => InverseTime,
        940 => PerMinute,
        950 => PerRevolution,
        540 | 550 | 560 | 570 | 580 | 590 => WorkOffset(usize::from(tenths / 10 - 54)),
        591..=593 => WorkOffset(usize::from(5 + tenths - 590)),
        430 => ToolLength,
        431 => ToolLengthGiven,
        434 => ToolCentrePoint,
        490 => NoToolLength,
        530 => MachineCoordinates,
        100 => SetOffsets,
        280 | 300 | 281 | 301 => Reference,
        // exact stop, look-ahead, no radius offset, no turned coordinates, spindle speed, return of cycles
        80 | 90 | 150 | 400 | 500 | 501 | 610 | 611 | 640 | 690 | 921 | 970 | 980 | 990 => Other,
        730 | 740 | 760 | 810 | 820 | 830 | 840 | 850 | 860 | 870 | 880 | 890 => Refused(CYCLE),
        410..=429 => Refused(RADIUS),
        160 | 510 | 511 | 680 | 682 | 683 => Refused(TURNED),
        50 | 51 => RefusedWithPlace(SPLINE),
        52..=59 => Refused(SPLINE),
        380..=389 | 310 => Refused(PROBE),
        520 | 920 | 922 | 923 => Refused(SHIFTED),
        70 | 330 | 960 => Refused(LATHE),
        432 | 435 => Refused("is a tool correction that is not followed here; use G43, G43.1 or G43.4"),
        650 | 660 | 670 => Refused("calls a macro; let the control write it out"),
        _ => return None,
    })
}

impl Meaning {
    /// Codes of one group exclude each other in a block; `None` for those of no group.
    pub fn group(&self) -> Option<u8> {
        use Meaning::*;
        Some(match self {
            // G80 beside a motion stands in the first line of many programs
            Motion(self::Motion::None) => return None,
            Motion(_) => 0,
            Plane(_) => 1,
            Inches | Millimetres => 2,
            Absolute | Incremental => 3,
            AbsoluteCentres | IncrementalCentres => 4,
            InverseTime | PerMinute | PerRevolution => 5,
            WorkOffset(_) => 6,
            ToolLength | ToolLengthGiven | ToolCentrePoint | NoToolLength => 7,
            SetOffsets | Reference | Dwell => 8,
            MachineCoordinates | Other | Refused(_) | RefusedWithPlace(_) => return None,
        })
    }
}

/// Why an M code is refused.
pub fn refused_m_code(code: u16) -> Option<&'static str> {
    matches!(code, 960 | 970 | 980 | 990 | 900 | 910 | 710 | 730)
        .then_some("calls a subprogram or restores modes, which is not followed here; write it out in one program")
}

/// M codes that leave axes and path alone on all controls of the trade: stops, spindle, coolant, tool change, overrides, ends.
pub fn is_usual_m_code(tenths: u16) -> bool {
    matches!(tenths / 10, 0..=9 | 19 | 30 | 48..=53 | 60..=65 | 67 | 68 | 70 | 72)
}

/// M codes that take effect at the end of their block: stops and ends, tool change, spindle stop, coolant off. Controls that stop spindle and
/// coolant as a block begins are as well served by the end of its last piece.
pub fn acts_at_the_end(tenths: u16) -> bool {
    matches!(tenths / 10, 0 | 1 | 2 | 5 | 9 | 30 | 60)
}
