//! The recordings that a session names: where they may lie, and each file read once however many tests name it.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;

use super::document::{Document, Step};
use super::message::LoadError;
use super::recording::Parsed;
use super::rows::Rows;
use super::test::TestFile;
use super::text::lies_in;
use crate::machine::Machine;
use crate::session::Recording;

/// Reads the recordings of one session.
pub(super) struct RecordingReader<'a> {
    document: &'a Document,
    folder: &'a Path,
    rows: Rows,
    /// How many tests name a file: one that several name is kept until all of them have it.
    named: HashMap<PathBuf, usize>,
    kept: RefCell<HashMap<PathBuf, Rc<Parsed>>>,
}

impl<'a> RecordingReader<'a> {
    pub fn new(document: &'a Document, folder: &'a Path, tests: &[TestFile], rows: Rows) -> RecordingReader<'a> {
        let mut named = HashMap::new();
        for name in tests.iter().filter_map(|test| test.recording.as_ref()) {
            *named.entry(plain_path(name)).or_insert(0) += 1;
        }
        RecordingReader { document, folder, rows, named, kept: RefCell::default() }
    }

    /// The recording of the test with this index; `None` for a planned test whose file is not there yet.
    pub fn recording(
        &self,
        index: usize,
        raw: &TestFile,
        name: &str,
        machine: &Machine,
    ) -> Result<Option<Recording>, LoadError> {
        let refuse = |message: String| {
            self.document.refuse(&[Step::Key("tests"), Step::Index(index), Step::Key("recording")], message)
        };
        let stays_inside =
            Path::new(name).components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        if !stays_inside || name.is_empty() {
            return Err(refuse(format!(
                "recording '{name}' leaves the session's folder; put the file beside the session"
            )));
        }
        let file = self.folder.join(name);
        if !file.exists() && (raw.sweep.is_some() || raw.circle.is_some()) {
            // a planned test names the file that its recording will have
            return Ok(None);
        }
        if file.exists() && !lies_in(&file, &[self.folder]) {
            return Err(refuse(format!(
                "recording '{name}' is a link out of the session's folder; put a copy beside the session"
            )));
        }
        let parsed = self.parsed(name, &file, machine)?;
        let parsed = Rc::try_unwrap(parsed).unwrap_or_else(|shared| Parsed::clone(&shared));
        parsed.into_recording(&file, machine, raw.bar_length, self.rows).map(Some)
    }

    /// A file as read, from the earlier test that named it too where there is one.
    fn parsed(&self, name: &str, file: &Path, machine: &Machine) -> Result<Rc<Parsed>, LoadError> {
        let path = plain_path(name);
        if let Some(parsed) = self.kept.borrow().get(&path) {
            return Ok(parsed.clone());
        }
        let parsed = Rc::new(Parsed::load(file, machine)?);
        if self.named.get(&path).is_some_and(|&tests| tests > 1) {
            self.kept.borrow_mut().insert(path, parsed.clone());
        }
        Ok(parsed)
    }
}

/// A relative path without `.`: `./a.csv` and `a.csv` are one file.
fn plain_path(name: &str) -> PathBuf {
    Path::new(name).components().filter(|part| *part != Component::CurDir).collect()
}
