//! Results of several methods on one machine: which disagree beyond their budgets, what would explain it, which test decides.
//!
//! | file | holds |
//! |---|---|
//! | `design` | a claim's tests as a map from readings to its errors |
//! | `budget` | the covariance of a claim's errors: repeats, bar, slides, ball |
//! | `compare` | least squares over all claims; which circles stand out |
//! | `causes` | assumptions read otherwise and physics left out, with what each does |
//! | `prepared` | claims stacked with designs, budgets and causes |
//! | `deciding` | the test that tells the causes left apart |
//! | `comparison` | all of it for stated values: `verdict` |
//!
//! The machine's own errors are free: nothing is said of them, only of what no one machine can show to all methods.

mod budget;
mod causes;
mod chance;
mod compare;
mod comparison;
mod deciding;
mod design;
mod error;
mod prepared;
mod verdict;

pub use budget::{Budget, Limits};
pub use causes::{Cause, Kind};
pub use chance::chance;
pub use comparison::Reconciliation;
pub use deciding::{Candidate, DecidingTest};
pub use design::{Design, Group};
pub use error::ReconcileError;
pub use prepared::Prepared;
pub use verdict::{Difference, Disagreement, Verdict};
