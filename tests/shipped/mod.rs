//! The machine files that the project ships, and the codes of which there must be some.

use std::path::{Path, PathBuf};

use fiveaxis::load::load_session;
use fiveaxis::session::Session;

/// The ten codes of the thesis's Table 1.1 as printed.
#[allow(dead_code, reason = "shared by tests of which not all need it")]
pub const TABLE_1_1: [&str; 10] = [
    "[wXYbZABt]",
    "[wXYbZBAt]",
    "[wXYbZCAt]",
    "[wXYbZCBt]",
    "[wABXYbZt]",
    "[wBAXYbZt]",
    "[wCAXYbZt]",
    "[wCBXYbZt]",
    "[wCXYbZAt]",
    "[wCXYbZBt]",
];

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

/// The first machine of a structural code.
#[allow(dead_code, reason = "shared by tests of which not all need it")]
pub fn machine_of(code: &str) -> PathBuf {
    let line = format!("code: \"{code}\"");
    let is_it = |file: &PathBuf| std::fs::read_to_string(file).is_ok_and(|text| text.contains(&line));
    machine_files().into_iter().find(is_it).unwrap_or_else(|| panic!("{code} does not ship"))
}

/// Chapter 5 of the thesis as the project ships it, with two runs there and back of each program.
#[allow(dead_code, reason = "shared by tests of which not all need it")]
pub fn chapter5() -> Session {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/thesis/chapter5/session.yaml");
    let mut session = load_session(&file).expect("chapter 5");
    session.tests.retain(|test| test.name.ends_with("-1") || test.name.ends_with("-2"));
    assert_eq!(session.tests.len(), 16);
    session
}
