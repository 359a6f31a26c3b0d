//! Leftovers of runs that were killed: completed or removed before anything is written beside them.

use std::fs;

use super::commit::{finish, leftovers};
use super::target::Target;
use crate::verbs::Refusal;

impl Target {
    /// Completes or removes what killed runs left; under the lock nobody else is at work here.
    pub fn tidy(&self) -> Result<(), Refusal> {
        for leftover in leftovers(&self.parent, &self.folder) {
            fs::remove_dir_all(&leftover)
                .map_err(|why| format!("{} of a run that was stopped cannot be removed: {why}", leftover.display()))?;
        }
        finish(&self.folder)
    }
}
