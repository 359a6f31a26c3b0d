//! All serial five-axis topologies planned on one envelope: what a ball bar determines on each, in what time, from how many pivots. No files.
//!
//! | file | question |
//! |---|---|
//! | `codes` | which topologies are there? |
//! | `alike` | which of them are one machine on the envelope? |
//! | `envelope` | what machine stands for a topology? |
//! | `outcome` | what does its plan reach, and from one pivot setup? |
//! | `tally` | how many of each family are determined in full? |
//! | `shard` | which topologies are one shard's? |

mod alike;
mod codes;
mod envelope;
mod outcome;
mod shard;
mod tally;

pub use alike::representative;
pub use codes::codes;
pub(crate) use envelope::ENVELOPE;
pub use envelope::envelope;
pub use outcome::{Family, Outcome, outcome, outcome_of};
pub use shard::{Shard, ShardError};
pub use tally::{Tally, tallies};

use crate::bodies::Kit;
use crate::machine::StructuralCode;
use crate::plan::Settings;

/// Number of the rules by which topologies are planned and rows written: one more with every change that changes a row.
const RULES: u32 = 3;

/// What must be the same for rows of two files to belong to one survey.
pub fn conditions(kit: &Kit, settings: &Settings, codes: &[StructuralCode]) -> String {
    let all = format!("{ENVELOPE} {kit:?} {settings:?} {codes:?}");
    // FNV-1a, 64 bit
    let hash = all
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
    format!(
        "fiveaxis {}, survey rules {RULES}, conditions {hash:016x}, {} topologies",
        env!("CARGO_PKG_VERSION"),
        codes.len()
    )
}

/// How the survey plans: as `plan` does when nothing is asked for.
pub fn settings() -> Settings {
    Settings::default()
}
