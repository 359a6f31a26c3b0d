//! Finds the reference data that lives beside the project; a stranger's clone does not have it.

use std::path::PathBuf;

use crate::skipped;

/// Folder `name` of the reference data, or `None` with a line that says that the test was skipped.
pub fn folder(name: &str) -> Option<PathBuf> {
    let root = std::env::var_os("FIVEAXIS_SHARED")
        .map(PathBuf::from)
        .unwrap_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared"));
    let folder = root.join(name);
    if folder.is_dir() {
        return Some(folder);
    }
    skipped::skipped(&format!("reference data '{name}' is not beside the project"));
    None
}
