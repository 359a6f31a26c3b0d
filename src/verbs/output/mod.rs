//! Writing results: whole sets or nothing, and never over an input or a file that somebody else wrote.

mod commit;
pub mod ending;
mod manifest;
mod own_names;
pub mod progress;
mod refusal;
mod streamed;
mod target;
mod tidying;

use std::fs;
use std::io::{ErrorKind, Write as _};
use std::path::{Component, Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::Serialize;

use commit::Staged;
use fiveaxis::load::printable::escaped_lines;
use fiveaxis::session::Session;
use manifest::{MANIFEST, Manifest};
pub use own_names::Foreign;
use own_names::OWN_PREFIX;
pub use refusal::Refusal;
pub use streamed::StreamedFile;
use target::{Target, lock_all};

/// Prints a result; a reader that stops reading (`| head`) is no failure.
pub fn print(text: &str) -> Result<(), Refusal> {
    match std::io::stdout().lock().write_all(escaped_lines(text).as_bytes()) {
        Err(why) if why.kind() != ErrorKind::BrokenPipe => {
            Err(format!("standard output cannot be written: {why}").into())
        }
        _ => Ok(()),
    }
}

/// Prints a line of a result; ends the program, with success, when nobody reads any more.
pub fn line(text: std::fmt::Arguments) {
    if let Err(why) = writeln!(std::io::stdout().lock(), "{}", escaped_lines(&text.to_string())) {
        if why.kind() == ErrorKind::BrokenPipe {
            std::process::exit(0);
        }
        on_standard_error(&format!("fiveaxis: standard output cannot be written: {why}"));
        std::process::exit(2);
    }
}

/// Remarks of this run, for the `warnings` of its JSON.
static REMARKS: Mutex<Vec<String>> = Mutex::new(Vec::new());
/// Whether remarks stay off standard error.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Keeps remarks and signs of life off standard error.
pub fn quieten() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Whether nothing but errors is told on standard error.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Prints a line on standard error, unless remarks are unwanted; it stands among the warnings of the run's JSON too.
pub fn remark(text: std::fmt::Arguments) {
    let text = text.to_string();
    if !is_quiet() {
        on_standard_error(&text);
    }
    if let Ok(mut remarks) = REMARKS.lock() {
        remarks.push(text);
    }
}

/// What was remarked so far.
pub fn remarks() -> Vec<String> {
    REMARKS.lock().map(|remarks| remarks.clone()).unwrap_or_default()
}

/// Prints the one message of a run that failed.
pub fn complain(refusal: &Refusal) {
    on_standard_error(&format!("fiveaxis: {refusal}"));
}

/// When nobody reads it there is no one to tell.
fn on_standard_error(text: &str) {
    // what a message quotes, a file's name or an option, may hold what a terminal obeys
    let _ = writeln!(std::io::stderr().lock(), "{}", escaped_lines(text));
}

/// Prints a result as JSON with the run's remarks as its `warnings`.
pub fn print_json(value: &impl Serialize) -> Result<(), Refusal> {
    #[derive(Serialize)]
    struct Told<'a, T> {
        #[serde(flatten)]
        value: &'a T,
        warnings: Vec<String>,
    }
    print(&format!("{}\n", serde_json::to_string_pretty(&Told { value, warnings: remarks() })?))
}

/// Files to be written into one folder.
#[derive(Debug, Default, Clone)]
pub struct OutputFolder {
    files: Vec<(PathBuf, Vec<u8>)>,
    former: Vec<PathBuf>,
    heads: Vec<(PathBuf, String)>,
}

impl OutputFolder {
    /// Names of its files, for a line of what was written.
    pub fn names(&self) -> String {
        let names: Vec<String> = self.files.iter().map(|(name, _)| name.display().to_string()).collect();
        names.join(", ")
    }

    /// Adds a file by its name relative to the folder.
    pub fn add(&mut self, name: impl Into<PathBuf>, content: impl Into<Vec<u8>>) {
        // `./x.csv` and `x.csv` are one file
        let name: PathBuf = name.into().components().filter(|part| *part != Component::CurDir).collect();
        let file = (name, content.into());
        // two tests may share one recording
        if !self.files.contains(&file) {
            self.files.push(file);
        }
    }

    /// A file that begins like this was written by an earlier run.
    pub fn known_by(&mut self, name: impl Into<PathBuf>, head: impl Into<String>) {
        self.heads.push((name.into(), head.into()));
    }

    /// Files of an earlier run, relative to the folder: those that are not written again are removed.
    pub fn replace(&mut self, former: Vec<PathBuf>) {
        self.former = former;
    }

    /// Writes all files or none; refuses when one would replace one of `inputs` or a file that no run wrote.
    pub fn write(self, folder: &Path, inputs: &[PathBuf]) -> Result<(), Refusal> {
        write_all(vec![(folder.to_path_buf(), self)], inputs, Foreign::Kept)
    }

    /// Takes in the files of another set for the same folder.
    fn join(&mut self, other: OutputFolder) {
        other.files.into_iter().for_each(|(name, content)| self.add(name, content));
        self.former.extend(other.former);
        self.heads.extend(other.heads);
    }

    /// Refuses names that cannot stand in a folder together.
    fn check_names(&self) -> Result<(), Refusal> {
        for (index, (name, _)) in self.files.iter().enumerate() {
            let shown = name.display();
            let is_inside = name.components().all(|part| matches!(part, Component::Normal(_)));
            let text = name.to_string_lossy();
            if !is_inside || text.is_empty() || text.chars().any(char::is_control) {
                return Err(format!("'{}' is no name of a file in the folder; rename it", text.escape_debug()).into());
            }
            if text.starts_with(OWN_PREFIX) {
                return Err(format!("{shown} begins like files of this program itself; rename it").into());
            }
            if self.files[..index].iter().any(|(other, _)| other == name) {
                return Err(format!("two different files would be called {shown}; give them names of their own").into());
            }
            if let Some((other, _)) = self.files.iter().find(|(other, _)| other != name && other.starts_with(name)) {
                return Err(format!(
                    "{shown} would be a file and the folder of {}; rename one of them",
                    other.display()
                )
                .into());
            }
        }
        Ok(())
    }

    /// Refuses to write over inputs, and over what no run wrote.
    fn check_replaced(
        &self,
        folder: &Path,
        manifest: &Manifest,
        inputs: &[PathBuf],
        foreign: Foreign,
    ) -> Result<(), Refusal> {
        let names = self.files.iter().map(|(name, content)| (name, Some(content)));
        for (name, content) in names.chain(self.former.iter().map(|name| (name, None))) {
            check_folders(folder, name)?;
            let target = folder.join(name);
            let Ok(found) = target.symlink_metadata() else { continue };
            if target.canonicalize().is_ok_and(|target| inputs.contains(&target)) {
                return Err(format!(
                    "{} is an input of this command and is not overwritten; name another folder",
                    target.display()
                )
                .into());
            }
            if found.is_dir() {
                return Err(format!("{} is a folder where a file is to be written; move it", target.display()).into());
            }
            let is_own = || found.is_file() && self.is_own(&target, name, content.map(Vec::as_slice), manifest);
            if foreign == Foreign::Kept && !is_own() {
                return Err(format!(
                    "{} was not written by fiveaxis, or was changed since, and is not overwritten; name another folder, or replace it with --force",
                    target.display()
                )
                .into());
            }
        }
        Ok(())
    }

    /// Whether a file that is there was written by a run, or would not change.
    fn is_own(&self, file: &Path, name: &Path, content: Option<&[u8]>, manifest: &Manifest) -> bool {
        if self.former.iter().any(|former| former == name) {
            return true;
        }
        // a pipe would be waited for
        if !file.is_file() {
            return false;
        }
        let Ok(found) = fs::read(file) else { return false };
        let head = self.heads.iter().find(|(of, _)| of == name).map(|(_, head)| head.as_bytes());
        content.is_some_and(|content| found == content)
            || manifest.holds(name, &found)
            || head.is_some_and(|head| found.starts_with(head))
    }
}

/// Refuses a name whose folders are files or lead elsewhere.
fn check_folders(folder: &Path, name: &Path) -> Result<(), Refusal> {
    for above in name.ancestors().skip(1).filter(|above| !above.as_os_str().is_empty()) {
        let above = folder.join(above);
        match above.symlink_metadata() {
            Ok(found) if found.is_symlink() => {
                return Err(format!("{} is a link; nothing is written through it, remove it", above.display()).into());
            }
            Ok(found) if !found.is_dir() => {
                return Err(format!("{} is a file where a folder is needed; move it", above.display()).into());
            }
            _ => {}
        }
    }
    Ok(())
}

/// Writes sets of files, each into its folder: all of them or none.
pub fn write_all(sets: Vec<(PathBuf, OutputFolder)>, inputs: &[PathBuf], foreign: Foreign) -> Result<(), Refusal> {
    let inputs: Vec<PathBuf> = inputs.iter().filter_map(|input| input.canonicalize().ok()).collect();
    let mut joined: Vec<(Target, OutputFolder)> = Vec::new();
    for (folder, set) in sets {
        let target = Target::of(&folder)?;
        match joined.iter_mut().find(|(other, _)| *other == target) {
            Some((_, other)) => other.join(set),
            None => joined.push((target, set)),
        }
    }
    joined.iter().try_for_each(|(_, set)| set.check_names())?;
    let locks = lock_all(joined.iter().map(|(target, _)| target))?;
    let mut manifests = Vec::new();
    for (target, set) in &joined {
        target.tidy()?;
        let manifest = Manifest::read(&target.folder)?;
        set.check_replaced(&target.folder, &manifest, &inputs, foreign)?;
        manifests.push(manifest);
    }
    // dropped on a refusal, what is staged goes again
    let mut staged = Vec::new();
    for ((target, set), manifest) in joined.into_iter().zip(manifests) {
        let manifest = manifest.with(&set.files, &set.former);
        let mut files = set.files;
        files.push((PathBuf::from(MANIFEST), manifest.text().into_bytes()));
        staged.push(Staged::stage(target, files, set.former)?);
    }
    staged.into_iter().try_for_each(Staged::commit)?;
    drop(locks);
    Ok(())
}

/// Completes what a killed run left half done in the folder of a file that is about to be read.
pub fn settle(file: &Path) -> Result<(), Refusal> {
    let folder = match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if !commit::is_unfinished(folder) {
        return Ok(());
    }
    let target = Target::of(folder)?;
    let _locks = lock_all(std::iter::once(&target))?;
    target.tidy()
}

/// Files that a session was read from: none of them may be overwritten.
pub fn session_inputs(file: &Path, session: &Session) -> Vec<PathBuf> {
    let folder = file.parent().map(PathBuf::from).unwrap_or_default();
    let recordings = session.tests.iter().filter_map(|test| test.recording_file.as_ref());
    let mut inputs = vec![file.to_path_buf(), folder.join(&session.machine_file)];
    inputs.extend(recordings.map(|name| folder.join(name)));
    inputs
}
