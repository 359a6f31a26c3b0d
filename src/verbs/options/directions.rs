//! `--directions`: the sense of the axes where the machine file does not state it. It reads and writes no file.

use clap::ValueEnum;
use fiveaxis::machine::{Directions, Machine};

use crate::verbs::Refusal;

/// The words of the option.
#[derive(Clone, Copy, ValueEnum)]
pub enum DirectionsName {
    /// A positive command moves the tool in the positive sense relative to the workpiece
    Iso841,
    /// A positive command moves the carried part right-handed
    Carried,
}

impl DirectionsName {
    /// What it says.
    pub fn directions(self) -> Directions {
        match self {
            DirectionsName::Iso841 => Directions::Iso841,
            DirectionsName::Carried => Directions::Carried,
        }
    }
}

/// Takes the option over where the file does not state the sense; `file` is its name in messages.
pub fn say(machine: &mut Machine, said: Option<DirectionsName>, file: &str) -> Result<(), Refusal> {
    let Some(said) = said else { return Ok(()) };
    machine.say_directions(said.directions()).map_err(|why| format!("{file}: {why}").into())
}
