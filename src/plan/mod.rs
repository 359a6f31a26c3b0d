//! Setups that are reachable, collision-free and informative, for any serial machine. It reads and writes no files.
//!
//! | room | question |
//! |---|---|
//! | `places` | which setups are within reach of the axes? |
//! | `reach` | how far do they get without collision, and how fast? |
//! | `information` | what do tests tell of the wanted errors? |
//! | `context` | what is a plan made from, and what does each candidate tell and cost? |
//! | `reasons` | what stays undetermined, and why? |
//! | `search` | which tests are chosen? |
//! | `result` | in which order, how mounted, and what would do better? |
//!
//! Rooms import only those above them. The context never changes; what is found of candidates stands in an evaluation beside it.

mod context;
mod information;
mod places;
mod reach;
mod reasons;
mod result;
mod search;

pub use context::choice::OnePivot;
pub use context::error::{IndexError, PlanError};
pub use context::method::{Method, MethodError};
pub use context::settings::{Goal, Settings};
pub use information::block::{Block, Nuisance};
pub use information::posterior::Posterior;
pub use information::uncertainty::Uncertainty;
pub use information::unknowns::Unknowns;
pub use places::candidate::{Avoid, Candidate, Candidates, Coupled, Misses, PivotSite, SpindlePlace};
pub use places::candidates::candidates;
pub use places::circle_setups::PLANES;
pub use places::drive::{Drive, Swing};
pub use places::following::FOLLOWED;
pub use places::free_range::free_parts;
pub use places::run_in::{CutRunIn, GRID_DEG, OFF_LIMIT, bare_session, beyond_path, cut_run_ins, rows_with_run_in};
pub use places::solver::{Pull, Solved, Stance, Unreachable};
pub use reach::approach::{Approach, Parking};
pub use reach::little_moves::LittleMove;
pub use reach::out_of_reach::OutOfReach;
pub use reach::pace::CHORD_MM;
pub use reach::sweep_reach::{ClearArc, ClearSweep};
pub use reasons::forecast::ErrorForecast;
pub use result::advice::plan_with_advice;
pub use result::mounting::{Arm, CupLooks, Mounting};
pub use result::placing::Placing;
pub use result::plan_result::{Plan, PlannedTest, TradeOff};
pub use result::planning::plan;
