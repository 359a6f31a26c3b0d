//! The controls that programs are written for, and what their words can hold. What is to be done is in `step`.

use super::coordinates::Coordinates;
use super::step::Curves;
use crate::machine::Machine;

/// A control's language.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// ISO 6983 as most controls read it.
    Generic,
    LinuxCnc,
    /// Heidenhain conversational.
    Heidenhain,
    Sinumerik,
}

impl Dialect {
    /// All dialects with the endings of their files.
    pub const ALL: [(Dialect, &'static str); 4] =
        [(Dialect::Generic, "nc"), (Dialect::LinuxCnc, "ngc"), (Dialect::Heidenhain, "h"), (Dialect::Sinumerik, "mpf")];

    /// Folder of its programs.
    pub fn folder(self) -> &'static str {
        match self {
            Dialect::Generic => "generic",
            Dialect::LinuxCnc => "linuxcnc",
            Dialect::Heidenhain => "heidenhain",
            Dialect::Sinumerik => "sinumerik",
        }
    }

    /// An axis of the machine whose name the control cannot write, if any.
    pub fn unknown_axis(self, machine: &Machine) -> Option<&str> {
        let known = |name: &str| match self {
            // a letter with a number is written X1=...
            Dialect::Sinumerik => {
                let mut letters = name.chars();
                letters.next().is_some_and(|first| first.is_ascii_uppercase())
                    && letters.all(|letter| letter.is_ascii_digit())
            }
            _ => name.len() == 1 && "XYZABCUVW".contains(name),
        };
        machine.axes.iter().map(|axis| axis.name.as_str()).find(|name| !known(name))
    }

    /// What positions count from on this control. ISO controls of Fanuc's kind make every block with `G53` a rapid one,
    /// and a run needs its feed: the generic dialect has work coordinates whatever is known of the machine's.
    pub fn coordinates(self, machine: &Machine) -> Coordinates {
        match self {
            Dialect::Generic => Coordinates::Work,
            _ => Coordinates::of(machine),
        }
    }

    /// Curves that the control draws by itself.
    pub(super) fn curves(self) -> Curves {
        match self {
            Dialect::Heidenhain => Curves::Plain,
            Dialect::LinuxCnc => Curves::Winding,
            _ => Curves::Carrying,
        }
    }

    /// Decimals of a position, mm or deg: Heidenhain's blocks have places for four, so have ISO controls of 0.1 µm.
    pub(super) fn decimals(self) -> usize {
        match self {
            Dialect::Generic | Dialect::Heidenhain => 4,
            Dialect::LinuxCnc | Dialect::Sinumerik => 5,
        }
    }
}

/// What a program is called.
pub(super) struct Title {
    pub name: String,
    pub number: usize,
}

/// Longest comment: interpreters refuse lines beyond some 250 characters.
const LONGEST_COMMENT: usize = 200;

/// Text inside a comment, on one line: parentheses, ends of lines and `%` would end it or the program, `;` another comment.
pub(super) fn plain(text: &str) -> String {
    let is_plain = |c: char| (c.is_ascii_graphic() || c == ' ') && !"()%".contains(c);
    let shown = |c: char| match c {
        ';' => ',',
        c if is_plain(c) => c,
        _ => ' ',
    };
    text.chars().take(LONGEST_COMMENT).map(shown).collect()
}

/// The same for controls of Fanuc's kind, whose comments hold capitals, digits and few signs.
pub(super) fn capitals(text: &str) -> String {
    let known = |c: char| c.is_ascii_alphanumeric() || " .,+-*/=:".contains(c);
    plain(text).to_uppercase().chars().map(|c| if known(c) { c } else { ' ' }).collect()
}

/// Part of the last digit that is a number's own representation and no rounding.
const REPRESENTATION: f64 = 1e-6;

/// A feed with three decimals, as many as all controls read, rounded down: the machine is never faster than planned.
pub(super) fn feed(value: f64) -> String {
    format!("{:.3}", ((value * 1e3 + REPRESENTATION).floor() * 1e-3).max(1e-3))
}

/// A time in whole milliseconds, s, rounded up for the same reason.
pub(super) fn seconds(value: f64) -> String {
    format!("{:.3}", (value * 1e3 - REPRESENTATION).ceil().max(1.0) * 1e-3)
}
