//! `fiveaxis init`: a machine file from a data sheet or from a robot description.

mod arguments;
mod ask;
mod described;
mod sheet;
mod verb;

pub use arguments::Arguments;
pub use verb::run;
