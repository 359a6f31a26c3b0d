//! Which motion a positive command makes: the sense of axes as the machine file states it. It moves nothing; `chain` does.

use std::fmt;

/// Sense of the axes of a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Directions {
    /// A positive command moves the tool in the positive sense relative to the workpiece (ISO 841): an axis that carries
    /// the workpiece moves it the other way.
    Iso841,
    /// A positive command moves the carried part right-handed relative to its carrier.
    Carried,
}

impl Directions {
    /// All senses that a file may state.
    pub const ALL: [Directions; 2] = [Directions::Iso841, Directions::Carried];

    /// The word in files and options.
    pub fn name(self) -> &'static str {
        match self {
            Directions::Iso841 => "iso841",
            Directions::Carried => "carried",
        }
    }

    /// What the word means.
    pub fn meaning(self) -> &'static str {
        match self {
            Directions::Iso841 => "a positive command moves the tool in the positive sense relative to the workpiece",
            Directions::Carried => "a positive command moves the carried part right-handed",
        }
    }

    /// The sense that a word of a file stands for.
    pub fn named(word: &str) -> Option<Directions> {
        Directions::ALL.into_iter().find(|directions| directions.name() == word)
    }
}

impl fmt::Display for Directions {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

/// The machine file and what was said beside it do not agree.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "the machine file states directions: {in_file}, the option says {said}; keep one, after a look at the machine: `check` says in words what each sense means"
)]
pub struct DirectionsDiffer {
    /// What the file states.
    pub in_file: Directions,
    /// What was said beside it.
    pub said: Directions,
}

/// What leaves the desk for a machine needs a stated sense; this says what to write.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "the machine file does not say which way its axes go: write 'directions: iso841' (a positive command moves the tool in the \
     positive sense relative to the workpiece, as most controls do) or 'directions: carried' (it moves the carried part \
     right-handed) under its name, or give --directions; `check` says in words what each sense means"
)]
pub struct DirectionsUnstated;
