//! What `diagnose` answers to sessions of the gallery, each asked once for all tests.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, Mutex};

use serde_json::Value;

/// An answer, with what was written beside it.
pub struct Answer {
    pub json: Value,
    pub code: Option<i32>,
    folder: PathBuf,
}

impl Answer {
    /// The saved session with its files.
    pub fn saved(&self) -> PathBuf {
        self.folder.join("saved")
    }

    /// The page with its plots.
    pub fn page(&self) -> PathBuf {
        self.folder.join("page")
    }
}

static ANSWERS: Mutex<BTreeMap<String, Arc<Answer>>> = Mutex::new(BTreeMap::new());

/// What `diagnose --json` answers to the session of a folder of the gallery, the session saved and the page beside it where files are
/// sound.
pub fn answer(name: &str) -> Arc<Answer> {
    // one after the other: each run has both cores
    let mut answers = ANSWERS.lock().expect("answers");
    answers.entry(name.to_string()).or_insert_with(|| Arc::new(asked(name))).clone()
}

fn asked(name: &str) -> Answer {
    let session = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/gallery").join(name).join("session.yaml");
    // a static value is never dropped: no folder that its end would remove
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("answers").join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).expect("what an earlier run left");
    }
    std::fs::create_dir_all(&folder).expect("folder");
    let run = |written: &[&OsStr]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fiveaxis"));
        command.args(["diagnose".as_ref(), session.as_os_str(), "--json".as_ref()]).args(written);
        command.output().expect("output")
    };
    let (saved, page) = (folder.join("saved"), folder.join("page"));
    let mut output = run(&["--save".as_ref(), saved.as_os_str(), "--report".as_ref(), page.as_os_str()]);
    // nothing is saved of files with a mistake, and the refusal is the answer then
    if !output.status.success() {
        output = run(&[]);
    }
    let message = String::from_utf8_lossy(&output.stderr);
    let json = serde_json::from_slice(&output.stdout).unwrap_or_else(|why| panic!("{name}: {why}: {message}"));
    Answer { json, code: output.status.code(), folder }
}
