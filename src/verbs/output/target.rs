//! A folder that is written to: where it really is, and its lock.

use std::fs::{self, File, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::verbs::Refusal;

/// Longest wait for another run that writes beside, s: sets are written within a few.
const LONGEST_WAIT: Duration = Duration::from_secs(30);
/// Pause between two looks at a lock.
const PAUSE: Duration = Duration::from_millis(10);

/// A folder by its real place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Target {
    /// The folder, which need not be there yet.
    pub folder: PathBuf,
    /// The folder above it, which is there: sets are staged in it, and its lock is the lock of all that is written below.
    pub parent: PathBuf,
}

impl Target {
    /// The place of a folder as the user names it; makes the folders above it.
    pub fn of(named: &Path) -> Result<Target, Refusal> {
        let cannot = |why: std::io::Error| format!("folder {} cannot be made: {why}", named.display());
        let folder = match named.canonicalize() {
            Ok(folder) => folder,
            Err(why) if why.kind() == ErrorKind::NotFound && named.symlink_metadata().is_err() => {
                let name = named.file_name().ok_or_else(|| format!("'{}' names no folder", named.display()))?;
                let above = match named.parent() {
                    Some(above) if !above.as_os_str().is_empty() => above,
                    _ => Path::new("."),
                };
                fs::create_dir_all(above).map_err(cannot)?;
                above.canonicalize().map_err(cannot)?.join(name)
            }
            Err(why) => return Err(cannot(why).into()),
        };
        if folder.exists() && !folder.is_dir() {
            return Err(format!("{} is a file; name a folder for the results", named.display()).into());
        }
        let parent = folder.parent().unwrap_or(&folder).to_path_buf();
        Ok(Target { folder, parent })
    }
}

/// Locks the folders above all targets, in one order for every run; a lock ends with its value.
pub fn lock_all<'a>(targets: impl Iterator<Item = &'a Target>) -> Result<Vec<File>, Refusal> {
    let mut parents: Vec<&Path> = targets.map(|target| target.parent.as_path()).collect();
    parents.sort();
    parents.dedup();
    let mut locks = Vec::new();
    for parent in parents {
        locks.extend(lock(parent)?);
    }
    Ok(locks)
}

/// Waits for the lock of a folder; `None` where a file system has no locks.
fn lock(folder: &Path) -> Result<Option<File>, Refusal> {
    let Ok(file) = opened(folder) else { return Ok(None) };
    let begun = Instant::now();
    loop {
        match file.try_lock() {
            Ok(()) => return Ok(Some(file)),
            Err(TryLockError::Error(_)) => return Ok(None),
            Err(TryLockError::WouldBlock) if begun.elapsed() < LONGEST_WAIT => std::thread::sleep(PAUSE),
            Err(TryLockError::WouldBlock) => {
                return Err(format!(
                    "another run has been writing in {} for {} s; run this again when it is done",
                    folder.display(),
                    LONGEST_WAIT.as_secs()
                )
                .into());
            }
        }
    }
}

/// A folder can be locked itself: no file is left behind.
#[cfg(unix)]
fn opened(folder: &Path) -> std::io::Result<File> {
    File::open(folder)
}

/// Where folders cannot be opened a file stands for them.
#[cfg(not(unix))]
fn opened(folder: &Path) -> std::io::Result<File> {
    File::options().create(true).truncate(false).write(true).open(folder.join(".fiveaxis-lock"))
}
