//! Session files beside a machine and a recording: no panic.
#![no_main]

use std::sync::LazyLock;

use fiveaxis::load::load_session;
use fiveaxis::report::session_yaml;
use libfuzzer_sys::fuzz_target;

static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a folder");
    let machine = "name: mill\ncode: '[wCAbYXZt]'\naxes: {A: {range: [-30, 110]}}\n";
    std::fs::write(folder.path().join("machine.yaml"), machine).expect("written");
    let recording = "time_s,A_deg,length_mm\n0.0,-20.0,100.0\n0.1,-19.0,100.1\n";
    std::fs::write(folder.path().join("a.csv"), recording).expect("written");
    folder
});

fuzz_target!(|text: &str| {
    let file = FOLDER.path().join("session.yaml");
    std::fs::write(&file, text).expect("written");
    if let Ok(session) = load_session(&file) {
        assert!(!session_yaml(&session).is_empty());
    }
});
