//! One large file written as it is made: beside its place first, and there only when whole.

use std::fs::{self, File};
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::own_names::{Foreign, OWN_PREFIX};
use crate::verbs::Refusal;

/// A file that is not in its place yet; dropped before [`StreamedFile::finish`] it is removed.
pub struct StreamedFile {
    target: PathBuf,
    beside: PathBuf,
    writer: Option<BufWriter<File>>,
}

impl StreamedFile {
    /// Begins a file. Inputs are never replaced, and other files that are there only when asked for.
    pub fn begin(target: &Path, inputs: &[PathBuf], foreign: Foreign) -> Result<StreamedFile, Refusal> {
        let name = target.file_name().ok_or_else(|| format!("'{}' names no file for the result", target.display()))?;
        if let Ok(found) = target.symlink_metadata() {
            let real = target.canonicalize().ok();
            let is_input = |input: &PathBuf| input.canonicalize().ok().is_some_and(|input| Some(input) == real);
            if inputs.iter().any(is_input) {
                return Err(format!(
                    "{} is an input of this command and is not overwritten; name another file",
                    target.display()
                )
                .into());
            }
            if !found.is_file() {
                return Err(
                    format!("{} is no plain file and is not overwritten; name another file", target.display()).into()
                );
            }
            if foreign == Foreign::Kept {
                return Err(format!(
                    "{} is there already; name another file, or replace it with --force",
                    target.display()
                )
                .into());
            }
        }
        let folder = match target.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let mut beside = std::ffi::OsString::from(OWN_PREFIX);
        beside.push(format!("{}-", std::process::id()));
        beside.push(name);
        let beside = folder.join(beside);
        let file = File::options().write(true).create_new(true).open(&beside).map_err(|why| match why.kind() {
            ErrorKind::NotFound => format!("folder {} is not there; make it first", folder.display()),
            _ => format!("{} cannot be written: {why}", target.display()),
        })?;
        Ok(StreamedFile { target: target.to_path_buf(), beside, writer: Some(BufWriter::with_capacity(1 << 16, file)) })
    }

    /// Adds bytes.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), Refusal> {
        let Some(writer) = &mut self.writer else { return Ok(()) };
        writer.write_all(bytes).map_err(|why| format!("{} cannot be written: {why}", self.target.display()).into())
    }

    /// Puts the whole file in its place.
    pub fn finish(mut self) -> Result<(), Refusal> {
        let cannot = |why: std::io::Error| format!("{} cannot be written: {why}", self.target.display());
        if let Some(writer) = self.writer.take() {
            let file = writer.into_inner().map_err(|why| cannot(why.into_error()))?;
            file.sync_all().map_err(cannot)?;
        }
        fs::rename(&self.beside, &self.target).map_err(cannot)?;
        Ok(())
    }
}

impl Drop for StreamedFile {
    fn drop(&mut self) {
        // after `finish` there is none
        let _ = fs::remove_file(&self.beside);
    }
}
