//! `fiveaxis plan`: a test plan for a machine: table, JSON, session file, setup sheet and NC programs.

mod arguments;
mod files;
mod former;
mod settings;
mod verb;

pub use arguments::Arguments;
pub use verb::run;
