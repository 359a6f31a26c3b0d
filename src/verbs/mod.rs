//! One file per verb: reads files, calls the rooms, hands results to `report`, writes files whole or not at all.

pub mod check;
pub mod clearance;
pub mod compensate;
pub mod control;
pub mod diagnose;
pub mod history;
pub mod identify;
pub mod import;
pub mod init;
pub mod inverse;
mod options;
pub mod output;
pub mod plan;
pub mod reconcile;
pub mod shell;
pub mod simulate;
mod solids;
pub mod survey;
pub mod volume;

pub use output::{Refusal, ending};
