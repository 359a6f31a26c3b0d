//! A program in work: where the axes stand, which words hold, what the control that reads the new program knows.

use super::block::Block;
use super::codes::Motion;
use super::command::Control;
use super::correct::Corrector;
use super::modal::{FeedMode, Modal, OffsetTable};
use super::path::Path;
use super::rewrite::Changes;
use super::settings::{Settings, Summary};

/// What the control that reads the new program holds.
#[derive(Debug, Clone, Default)]
pub(super) struct Told {
    pub(super) motion: Option<Motion>,
    pub(super) feed_mode: Option<FeedMode>,
    pub(super) feed: Option<f64>,
}

/// Where the line in hand stands: before the first % or block, in the program, behind its closing %.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Text {
    Before,
    Program,
    After,
}

/// How long the pieces of a move take.
#[derive(Debug, Clone, Copy)]
pub(super) enum Timing {
    Rapid,
    /// In the program's mode with its feed, for a move of this length, mm.
    Feed {
        mode: FeedMode,
        feed: f64,
        length_mm: f64,
    },
    /// The whole move in this time, min.
    Time(f64),
}

/// A block that moves.
#[derive(Clone, Copy)]
pub(super) struct Moving<'m> {
    pub(super) line: &'m [u8],
    pub(super) block: &'m Block,
    pub(super) path: &'m Path,
    pub(super) timing: Timing,
}

/// Corrects a program.
pub struct Compensator<'a> {
    pub(super) settings: Settings,
    pub(super) control: Control<'a>,
    pub(super) corrector: Corrector<'a>,
    pub(super) modal: Modal,
    /// Ideal coordinates by letter, and those that the new program has commanded; both with all offsets in them.
    pub(super) here: [Option<f64>; 9],
    pub(super) sent: [Option<f64>; 9],
    pub(super) told: Told,
    pub(super) offsets: OffsetTable,
    /// The block in hand counts in machine coordinates (G53).
    pub(super) in_machine: bool,
    /// Modes that M70 has kept.
    pub(super) kept: Option<Modal>,
    pub(super) text: Text,
    pub(super) block: Block,
    pub(super) changes: Changes,
    pub(super) summary: Summary,
}
