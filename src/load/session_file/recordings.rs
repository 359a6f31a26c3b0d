//! The recordings that a session names: where they may lie, and each file read once however many tests name it.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;

use super::test_file::TestFile;
use crate::load::checked_text::document::{Document, Step};
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::text::lies_in;
use crate::load::recording::{Parsed, Wanted};
use crate::load::rows::Rows;
use crate::machine::Machine;
use crate::readings::Kind;
use crate::session::Recording;

/// A recording as read, with the line of every row for messages (of lengths none: they are judged already).
pub(crate) struct Read {
    pub recording: Recording,
    pub lines: Vec<u32>,
    pub file: PathBuf,
}

/// Reads the recordings of one session.
pub(crate) struct RecordingReader<'a> {
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
        (machine, wanted): (&Machine, &Wanted),
    ) -> Result<Option<Read>, LoadError> {
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
        let parsed = self.parsed(name, &file, (machine, wanted))?;
        let parsed = Rc::try_unwrap(parsed).unwrap_or_else(|shared| Parsed::clone(&shared));
        if wanted.kind == Kind::Length {
            let recording = parsed.into_recording(&file, machine, raw.bar_length, self.rows)?;
            return Ok(Some(Read { recording, lines: Vec::new(), file }));
        }
        let (recording, lines) = parsed.into_parts(&file, machine, self.rows)?;
        Ok(Some(Read { recording, lines, file }))
    }

    /// A file as read, from the earlier test that named it too where there is one.
    fn parsed(&self, name: &str, file: &Path, (machine, wanted): (&Machine, &Wanted)) -> Result<Rc<Parsed>, LoadError> {
        // what another kind, or other columns, read of a file is another recording
        let is_plain = wanted.kind == Kind::Length;
        let path = plain_path(name);
        if let Some(parsed) = self.kept.borrow().get(&path).filter(|_| is_plain) {
            return Ok(parsed.clone());
        }
        let parsed = Rc::new(Parsed::load(file, machine, wanted)?);
        if is_plain && self.named.get(&path).is_some_and(|&tests| tests > 1) {
            self.kept.borrow_mut().insert(path, parsed.clone());
        }
        Ok(parsed)
    }
}

/// A relative path without `.`: `./a.csv` and `a.csv` are one file.
fn plain_path(name: &str) -> PathBuf {
    Path::new(name).components().filter(|part| *part != Component::CurDir).collect()
}
