//! How our own names in a folder begin, and what becomes of files there that are not ours.

/// What happens to files in the way that this program did not write, or that were changed since.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Foreign {
    /// They stay, and nothing is written.
    Kept,
    /// They are replaced, as the user asked for.
    Replaced,
}

impl Foreign {
    /// What `--force` says.
    pub fn with(force: bool) -> Foreign {
        if force { Foreign::Replaced } else { Foreign::Kept }
    }
}

/// How every name of our own in a folder begins: list of files, sets that are being written.
pub(super) const OWN_PREFIX: &str = ".fiveaxis-";
