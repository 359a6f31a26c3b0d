//! One file per verb: reads files, calls the rooms, hands results to `report`, writes files whole or not at all.

pub mod check;
pub mod clearance;
pub mod compensate;
pub mod control;
pub mod diagnose;
mod directions;
pub mod ending;
mod errors;
mod former_plan;
pub mod history;
pub mod identify;
pub mod import;
pub mod init;
mod init_urdf;
pub mod inverse;
pub mod output;
pub mod plan;
mod plan_files;
mod plan_json;
mod plan_settings;
mod plan_text;
pub mod progress;
pub mod reconcile;
pub mod report;
pub mod save;
pub mod shell;
pub mod simulate;
mod solids;
pub mod survey;
pub mod volume;

/// Why a verb stopped: one message for the user; `ending` knows the exit code, which is 2 for most.
pub type Refusal = Box<dyn std::error::Error>;
