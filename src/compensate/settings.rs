//! What a correction is told beside the program, and what it tells afterwards.

use super::command::Coordinates;
use super::modal::OffsetTable;

/// What is known beside the program.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    pub coordinates: Coordinates,
    /// The tip stays this near to the ideal path, mm.
    pub tolerance_mm: f64,
    /// The tool stays this near to the ideal direction, rad.
    pub tolerance_rad: f64,
    pub offsets: OffsetTable,
    /// Lengths of tools by number, mm.
    pub tools: Vec<(u32, f64)>,
    /// Length of the tool from the spindle's nose while no length is in force, mm; `None`: the machine's gauge length.
    pub tool_length_mm: Option<f64>,
    /// Words that hold when the program begins.
    pub initial: String,
    /// Blocks that cannot be corrected stay, with a comment; else they end the run.
    pub mark: bool,
    /// Decimals of lengths in mm and of angles in degrees.
    pub decimals: [usize; 2],
    /// Arcs become arcs where they can, with rotary words of their own; else straight blocks alone.
    pub keeps_arcs: bool,
}

/// A block that is not corrected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line} {reason}")]
pub struct NotCorrected {
    /// From 1.
    pub line: u64,
    /// What was found, what is allowed, what to do.
    pub reason: String,
}

/// Largest amount and the line where it was.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Largest {
    pub amount: f64,
    pub line: u64,
}

impl Largest {
    pub(super) fn take(&mut self, amount: f64, line: u64) {
        if amount > self.amount {
            *self = Largest { amount, line };
        }
    }
}

/// An axis of which it is not known on which flank of its lost motion or play it stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnknownFlank {
    /// By index.
    pub axis: usize,
    /// The first feed move that finds it so.
    pub line: u64,
    /// What stands open to either side: the largest length, mm, and angle, rad.
    pub off_mm: f64,
    pub off_rad: f64,
}

/// What was done.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Summary {
    pub lines: u64,
    /// Moves that were corrected, and the blocks written for them.
    pub moves: u64,
    pub blocks: u64,
    /// Moves that stayed because not all axes had a position yet, or because they go to machine coordinates.
    pub left: u64,
    /// Largest change of a coordinate by letter, mm or deg.
    pub changed: [Largest; 9],
    /// Largest angle that the tool stays off, rad.
    pub off: Largest,
    /// How far from its path a feed move starts after a rapid that stayed as it was, mm.
    pub starts_off: Largest,
    /// Line from which on reversal spikes stay, for it goes on in coordinates of the workpiece; `None`: they do not, or there are none.
    pub spikes_stay_from: Option<u64>,
    /// Axes with lost motion or play that stand in feed moves and have not moved before.
    pub unknown_flanks: Vec<UnknownFlank>,
    /// Blocks that stay with a comment, the first of them.
    pub marked: Vec<NotCorrected>,
    pub marked_count: u64,
    /// M codes that are not the same on all controls, with the first line of each.
    pub unusual_m: Vec<(u16, u64)>,
}

/// Names of the work offsets in the order of the table.
pub const OFFSET_NAMES: [&str; 9] = ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"];
