//! Programs corrected for the errors of a machine: blocks in, blocks out. It opens no files.
//!
//! ```text
//! bytes ─block─▶ words ─modal─▶ move ─path─▶ ideal poses ─correct─▶ axis positions ─pieces─▶ commands ─rewrite─▶ bytes
//! ```
//!
//! The *ideal* path is that of the machine without errors. A block that moves is replaced by one or more blocks, arcs by arcs,
//! after which the erring machine's tool runs along the ideal path within a tolerance, in the time of the block. All other
//! bytes stay. What is not understood is refused with its reason, never guessed.

mod block;
mod codes;
mod command;
mod correct;
mod memory;
mod modal;
mod moves;
mod path;
mod pieces;
mod places;
mod program;
mod rewrite;
mod settings;
mod state;
mod written;

pub use block::{Block, LONGEST_LINE, Word};
pub use command::Coordinates;
pub use correct::{Corrected, Corrector};
pub use modal::{LETTERS, OffsetTable};
pub use settings::{Largest, NotCorrected, OFFSET_NAMES, Settings, Summary, UnknownFlank};
pub use state::Compensator;
