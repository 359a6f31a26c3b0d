//! The machine files that the project ships.

use std::path::{Path, PathBuf};

/// YAML machines in the order of their names.
#[allow(dead_code, reason = "shared by tests of which not all need it")]
pub fn machine_files() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("machines")
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|file| file.extension().is_some_and(|extension| extension == "yaml"))
        .collect();
    files.sort();
    assert!(files.len() >= 25);
    files
}

/// Whether the long form of a test is asked for: `FIVEAXIS_TESTS=all`.
#[allow(dead_code, reason = "shared by tests of which not all need it")]
pub fn is_thorough() -> bool {
    std::env::var("FIVEAXIS_TESTS").is_ok_and(|wanted| wanted == "all")
}

/// Every so many machines from one on; all of them in the long form of a test.
#[allow(dead_code, reason = "shared by tests of which not all need it")]
pub fn some_machines(first: usize, every: usize) -> Vec<PathBuf> {
    let is_one = |k: usize| is_thorough() || k % every == first;
    machine_files().into_iter().enumerate().filter(|(k, _)| is_one(*k)).map(|(_, file)| file).collect()
}
