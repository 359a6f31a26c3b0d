//! The gallery's ten sessions load, are small, and carry the truth apart from what a diagnosis reads.

use std::path::PathBuf;

fn folders() -> Vec<PathBuf> {
    let root = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/gallery"));
    let mut all: Vec<PathBuf> = std::fs::read_dir(root)
        .expect("gallery")
        .filter_map(|entry| entry.ok().map(|e| e.path()))
        .filter(|path| path.is_dir())
        .collect();
    all.sort();
    all
}

#[test]
fn ten_sessions_are_small_and_complete() {
    let all = folders();
    assert_eq!(all.len(), 10);
    let mut total = 0;
    for folder in all {
        let size: u64 = std::fs::read_dir(&folder)
            .expect("session folder")
            .filter_map(|entry| entry.ok()?.metadata().ok())
            .map(|m| m.len())
            .sum();
        assert!(size < 150_000, "{}: {size} bytes", folder.display());
        total += size;
        for name in ["README.md", "machine.yaml", "session.yaml", "truth.json"] {
            assert!(folder.join(name).is_file(), "{}: no {name}", folder.display());
        }
        let session = std::fs::read_to_string(folder.join("session.yaml")).expect("session");
        assert!(!session.contains("truth"), "{}: the session names its truth", folder.display());
    }
    assert!(total < 1_500_000, "{total} bytes");
}

#[test]
fn every_session_loads() {
    for folder in folders() {
        let out = tempfile::tempdir().expect("scratch folder");
        assert_cmd::Command::new(env!("CARGO_BIN_EXE_fiveaxis"))
            .args([
                "simulate".as_ref(),
                folder.join("session.yaml").as_os_str(),
                "--out".as_ref(),
                out.path().as_os_str(),
            ])
            .assert()
            .success();
    }
}
