//! Writing results: whole or not at all, and never over a user's input.

use std::fs;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use super::Refusal;
use fiveaxis::session::Session;

/// Prints a result; a reader that stops reading (`| head`) is no failure.
pub fn print(text: &str) -> Result<(), Refusal> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(why) if why.kind() != ErrorKind::BrokenPipe => {
            Err(format!("standard output cannot be written: {why}").into())
        }
        _ => Ok(()),
    }
}

/// Prints a line of a result; ends the program, with success, when nobody reads any more.
pub fn line(text: std::fmt::Arguments) {
    if let Err(why) = writeln!(std::io::stdout().lock(), "{text}") {
        if why.kind() == ErrorKind::BrokenPipe {
            std::process::exit(0);
        }
        remark(format_args!("fiveaxis: standard output cannot be written: {why}"));
        std::process::exit(2);
    }
}

/// Prints a line on standard error; when nobody reads it there is no one to tell.
pub fn remark(text: std::fmt::Arguments) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// Files to be written into one folder.
#[derive(Debug, Default)]
pub struct OutputFolder {
    files: Vec<(PathBuf, Vec<u8>)>,
    former: Vec<PathBuf>,
}

impl OutputFolder {
    /// Adds a file by its name relative to the folder.
    pub fn add(&mut self, name: impl Into<PathBuf>, content: impl Into<Vec<u8>>) {
        let file = (name.into(), content.into());
        // two tests may share one recording
        if !self.files.contains(&file) {
            self.files.push(file);
        }
    }

    /// Files of an earlier run, relative to the folder: those that are not written again are removed.
    pub fn replace(&mut self, former: Vec<PathBuf>) {
        self.former = former;
    }

    /// Writes all files, each under a temporary name first; refuses when a file would replace one of `inputs`.
    pub fn write(&self, folder: &Path, inputs: &[PathBuf]) -> Result<(), Refusal> {
        let inputs: Vec<PathBuf> = inputs.iter().filter_map(|input| input.canonicalize().ok()).collect();
        for name in self.files.iter().map(|(name, _)| name).chain(&self.former) {
            let target = folder.join(name);
            if target.canonicalize().is_ok_and(|target| inputs.contains(&target)) {
                return Err(format!(
                    "{} is an input of this command and is not overwritten; name another folder",
                    target.display()
                )
                .into());
            }
        }
        let mut staged = Vec::new();
        let outcome = self.stage(folder, &mut staged);
        if let Err(refusal) = outcome {
            for (temporary, _) in &staged {
                // the original refusal is what the user must read
                let _ = fs::remove_file(temporary);
            }
            return Err(refusal);
        }
        // before the new ones take their places: old programs never lie beside new ones
        for former in self.former.iter().filter(|former| self.files.iter().all(|(name, _)| name != *former)) {
            remove(&folder.join(former), folder)?;
        }
        for (temporary, target) in &staged {
            fs::rename(temporary, target).map_err(|why| format!("{} cannot be written: {why}", target.display()))?;
        }
        Ok(())
    }

    fn stage(&self, folder: &Path, staged: &mut Vec<(PathBuf, PathBuf)>) -> Result<(), Refusal> {
        for (name, content) in &self.files {
            let target = folder.join(name);
            let parent = target.parent().unwrap_or(folder);
            fs::create_dir_all(parent).map_err(|why| format!("folder {} cannot be made: {why}", parent.display()))?;
            let mut temporary = target.clone().into_os_string();
            temporary.push(".part");
            let temporary = PathBuf::from(temporary);
            staged.push((temporary.clone(), target));
            fs::write(&temporary, content)
                .map_err(|why| format!("{} cannot be written: {why}", temporary.display()))?;
        }
        Ok(())
    }
}

/// Removes a file, and the folders that it leaves empty below `top`.
fn remove(file: &Path, top: &Path) -> Result<(), Refusal> {
    match fs::remove_file(file) {
        Err(why) if why.kind() != ErrorKind::NotFound => {
            return Err(format!("{} of an earlier plan cannot be removed: {why}", file.display()).into());
        }
        _ => {}
    }
    let above = file.ancestors().skip(1).take_while(|above| *above != top);
    for above in above {
        // a folder with other files stays
        if fs::remove_dir(above).is_err() {
            break;
        }
    }
    Ok(())
}

/// Files that a session was read from: none of them may be overwritten.
pub fn session_inputs(file: &Path, session: &Session) -> Vec<PathBuf> {
    let folder = file.parent().map(PathBuf::from).unwrap_or_default();
    let recordings = session.tests.iter().filter_map(|test| test.recording_file.as_ref());
    let mut inputs = vec![file.to_path_buf(), folder.join(&session.machine_file)];
    inputs.extend(recordings.map(|name| folder.join(name)));
    inputs
}
