//! `fiveaxis init`: a machine file from a data sheet or from a robot description.

mod described;
mod verb;

pub use verb::{Arguments, run};
