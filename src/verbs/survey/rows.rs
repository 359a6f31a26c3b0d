//! The rows of one shard on disk: opened, checked against the survey asked for, added to. It plans nothing.

use std::collections::HashSet;
use std::fs::{File, OpenOptions};
use std::io::{Seek, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use fiveaxis::load::{ShardFile, load_shard, shard_title};
use fiveaxis::machine::StructuralCode;
use fiveaxis::report::survey::{HEADER, row};
use fiveaxis::survey::{Outcome, Shard};

use crate::verbs::Refusal;

/// The rows of a shard on disk: what an earlier run left, and where this one goes on.
pub struct Rows {
    /// The file.
    pub name: PathBuf,
    file: Mutex<File>,
    /// Codes whose rows are there.
    pub done: HashSet<String>,
}

impl Rows {
    /// Opens or begins the file of a shard in a folder; one run at a time.
    pub fn open(folder: &Path, conditions: &str, shard: Shard, mine: &[&StructuralCode]) -> Result<Rows, Refusal> {
        std::fs::create_dir_all(folder).map_err(|why| format!("folder {} cannot be made: {why}", folder.display()))?;
        let name = folder.join(file_name(shard));
        let cannot = |why: std::io::Error| format!("{} cannot be written: {why}", name.display());
        let mut file =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&name).map_err(cannot)?;
        if file.try_lock().is_err() {
            return Err(format!(
                "{} is being written by another run; wait for it or choose another folder",
                name.display()
            )
            .into());
        }
        let start = format!("{}\n{HEADER}\n", shard_title(conditions, shard));
        let old = std::fs::read(&name).map_err(cannot)?;
        let mut done = HashSet::new();
        // a run stopped in its first lines leaves a piece of them
        if start.as_bytes().starts_with(&old) {
            file.set_len(0).map_err(cannot)?;
            file.write_all(start.as_bytes()).map_err(cannot)?;
        } else {
            let read = load_shard(&name, HEADER)?;
            check_same(&name, &read, conditions, shard)?;
            done = codes_of(&name, &read, mine)?;
            // a torn last row is done again
            file.set_len(read.whole_bytes).map_err(cannot)?;
        }
        file.seek(SeekFrom::End(0)).map_err(cannot)?;
        Ok(Rows { file: Mutex::new(file), name, done })
    }

    /// Writes one row.
    pub fn add(&self, outcome: &Outcome) -> Result<(), String> {
        let line = format!("{}\n", row(outcome));
        let mut file = self.file.lock().map_err(|_| "another row could not be written".to_string())?;
        file.write_all(line.as_bytes()).map_err(|why| format!("{} cannot be written: {why}", self.name.display()))
    }
}

/// Name of a shard's file.
fn file_name(shard: Shard) -> String {
    format!("shard-{}-of-{}.csv", shard.index, shard.count)
}

/// Refuses rows of another survey.
fn check_same(name: &Path, read: &ShardFile, conditions: &str, shard: Shard) -> Result<(), Refusal> {
    if read.conditions != conditions || read.shard != shard {
        return Err(format!(
            "{}: is of another survey ({}; shard {}), this one is {conditions}; shard {shard}; name another folder, or delete the file to begin anew",
            name.display(),
            read.conditions,
            read.shard
        )
        .into());
    }
    Ok(())
}

/// Codes of a shard's rows, each one of `mine` and once.
fn codes_of(name: &Path, read: &ShardFile, mine: &[&StructuralCode]) -> Result<HashSet<String>, Refusal> {
    let mut seen = HashSet::new();
    for (index, outcome) in read.outcomes.iter().enumerate() {
        let line = index + 3;
        if !mine.contains(&&outcome.code) {
            return Err(format!(
                "{}:{line}: {} is not in shard {}; delete the file and run the shard again",
                name.display(),
                outcome.code,
                read.shard
            )
            .into());
        }
        if !seen.insert(outcome.code.to_string()) {
            return Err(format!(
                "{}:{line}: {} stands twice; delete the file and run the shard again",
                name.display(),
                outcome.code
            )
            .into());
        }
    }
    Ok(seen)
}
