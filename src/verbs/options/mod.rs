//! Options that several verbs have.

pub(crate) mod directions;
pub(crate) mod errors;
pub mod recorded;
pub mod report;
pub mod save;
