//! A set of files takes the place of an older one: whole folders in one step where they hold nothing else, else by a list of
//! moves that the next run completes. It judges no file.

use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use super::manifest::MANIFEST;
use super::own_names::OWN_PREFIX;
use super::target::Target;
use crate::verbs::Refusal;

/// Beside a folder: its next content as a whole; after the exchange its former one.
const WHOLE: &str = "whole-";
/// In a folder: files that are being written.
const PART: &str = "part-";
/// In a folder: files that are all written and take their places.
const MOVES: &str = "moves-";
/// In a set of moves: the list, the new files, the former files.
const LIST: &str = "list";
const NEW: &str = "new";
const FORMER: &str = "former";

/// A set of files, all written, none in its place; removed again when it is dropped.
pub struct Staged {
    target: Target,
    files: Vec<(PathBuf, Vec<u8>)>,
    former: Vec<PathBuf>,
    staging: PathBuf,
    is_whole: bool,
}

impl Staged {
    /// Writes all files beside their places.
    pub fn stage(target: Target, files: Vec<(PathBuf, Vec<u8>)>, former: Vec<PathBuf>) -> Result<Staged, Refusal> {
        let mut staged = Staged { target, files, former, staging: PathBuf::new(), is_whole: false };
        staged.is_whole = staged.strangers(&staged.target.folder).is_empty() && !is_stood_in(&staged.target.folder);
        if staged.is_whole && staged.stage_whole().is_ok() {
            return Ok(staged);
        }
        staged.stage_moves()?;
        Ok(staged)
    }

    fn stage_whole(&mut self) -> Result<(), Refusal> {
        self.staging = new_folder(&self.target.parent, WHOLE)?;
        let made = match self.target.folder.metadata() {
            Ok(old) => {
                has_same_owner(&old, &self.staging).and_then(|()| fs::set_permissions(&self.staging, old.permissions()))
            }
            Err(_) => Ok(()),
        };
        let written = made.map_err(Refusal::from).and_then(|()| write_tree(&self.staging, &self.files));
        if written.is_err() {
            self.unstage();
        }
        written
    }

    fn stage_moves(&mut self) -> Result<(), Refusal> {
        self.is_whole = false;
        let folder = &self.target.folder;
        fs::create_dir_all(folder).map_err(|why| format!("folder {} cannot be made: {why}", folder.display()))?;
        self.staging = new_folder(folder, PART)?;
        let list = |word: &'static str| move |name: &PathBuf| format!("{word} {}\n", name.display());
        let is_new = |name: &&PathBuf| !self.files.iter().any(|(other, _)| other == *name);
        let moves: String = (self.files.iter().map(|(name, _)| name).map(list("put")))
            .chain(self.former.iter().filter(is_new).map(list("remove")))
            .collect();
        let written = write_tree(&self.staging.join(NEW), &self.files)
            .and_then(|()| write_new(&self.staging.join(LIST), moves.as_bytes()));
        if written.is_err() {
            self.unstage();
        }
        written
    }

    /// Puts the set in its place: after this all files are new, or all are as they were.
    pub fn commit(mut self) -> Result<(), Refusal> {
        if self.is_whole {
            if exchange(&self.staging, &self.target.folder).is_ok() {
                // what is staged is the former content now; a file that came to it at the last moment stays
                for name in self.strangers(&self.staging) {
                    let place = self.target.folder.join(&name);
                    let _ = make_above(&place).and_then(|()| fs::rename(self.staging.join(&name), place));
                }
                self.unstage();
                return Ok(());
            }
            self.unstage();
            self.stage_moves()?;
        }
        let folder = self.target.folder.clone();
        let name = self.staging.file_name().unwrap_or_default().to_string_lossy().replacen(PART, MOVES, 1);
        let moves = folder.join(name);
        fs::rename(&self.staging, &moves).map_err(|why| format!("{} cannot be written: {why}", folder.display()))?;
        self.staging = PathBuf::new();
        finish(&folder)
    }

    /// What a folder holds beside plain files that this set replaces or removes.
    fn strangers(&self, folder: &Path) -> Vec<PathBuf> {
        let is_ours = |name: &PathBuf| {
            let is_named = self.files.iter().any(|(other, _)| other == name)
                || self.former.contains(name)
                || name.as_path() == Path::new(MANIFEST);
            is_named && folder.join(name).symlink_metadata().is_ok_and(|found| found.is_file())
        };
        let known = self.files.len() + self.former.len() + 1;
        names_below(folder, known).into_iter().filter(|name| !is_ours(name)).collect()
    }

    fn unstage(&mut self) {
        if !self.staging.as_os_str().is_empty() {
            // the next run removes what is left
            let _ = fs::remove_dir_all(&self.staging);
            self.staging = PathBuf::new();
        }
    }
}

impl Drop for Staged {
    fn drop(&mut self) {
        self.unstage();
    }
}

/// Makes a folder that was not there, with a name of its own.
fn new_folder(above: &Path, kind: &str) -> Result<PathBuf, Refusal> {
    for number in 0..u16::MAX {
        let folder = above.join(format!("{OWN_PREFIX}{kind}{}-{number}", std::process::id()));
        match fs::create_dir(&folder) {
            Err(why) if why.kind() == ErrorKind::AlreadyExists => {}
            Err(why) => return Err(format!("{} cannot be written: {why}", above.display()).into()),
            Ok(()) => return Ok(folder),
        }
    }
    Err(format!("{} is full of unfinished results; remove {OWN_PREFIX}{kind}*", above.display()).into())
}

/// Writes files below a folder.
fn write_tree(folder: &Path, files: &[(PathBuf, Vec<u8>)]) -> Result<(), Refusal> {
    for (name, content) in files {
        let file = folder.join(name);
        let above = file.parent().unwrap_or(folder);
        fs::create_dir_all(above).map_err(|why| format!("folder {} cannot be made: {why}", above.display()))?;
        write_new(&file, content)?;
    }
    Ok(())
}

/// Writes a file that is not there yet: nothing is followed, nothing is replaced.
fn write_new(file: &Path, content: &[u8]) -> Result<(), Refusal> {
    let written =
        OpenOptions::new().write(true).create_new(true).open(file).and_then(|mut open| open.write_all(content));
    written.map_err(|why| format!("{} cannot be written: {why}", file.display()).into())
}

/// Names of what is below a folder, folders that cannot be read or hold nothing among them; not many more than `enough`.
fn names_below(folder: &Path, enough: usize) -> Vec<PathBuf> {
    let mut names = Vec::new();
    let mut folders = vec![PathBuf::new()];
    while let Some(next) = folders.pop().filter(|_| names.len() <= enough) {
        let entries = fs::read_dir(folder.join(&next));
        let is_unknown = entries.is_err() && folder.symlink_metadata().is_ok();
        let found: Vec<_> = entries.into_iter().flatten().filter_map(Result::ok).collect();
        if is_unknown || found.is_empty() && !next.as_os_str().is_empty() {
            names.push(next);
            continue;
        }
        for entry in found {
            let name = next.join(entry.file_name());
            match entry.file_type() {
                Ok(kind) if kind.is_dir() => folders.push(name),
                _ => names.push(name),
            }
        }
    }
    names
}

/// Whether this run stands in a folder: exchanged, it would stand in one that is gone.
fn is_stood_in(folder: &Path) -> bool {
    std::env::current_dir().and_then(|here| here.canonicalize()).is_ok_and(|here| here.starts_with(folder))
}

/// Refuses a folder that would change hands.
#[cfg(unix)]
fn has_same_owner(old: &fs::Metadata, staging: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::MetadataExt as _;
    let new = staging.metadata()?;
    match (new.uid(), new.gid()) == (old.uid(), old.gid()) {
        true => Ok(()),
        false => Err(ErrorKind::PermissionDenied.into()),
    }
}

#[cfg(not(unix))]
fn has_same_owner(_: &fs::Metadata, _: &Path) -> std::io::Result<()> {
    Ok(())
}

/// Gives a new folder its place in one step, and an old one that stands there the place of the new.
#[cfg(any(target_os = "linux", target_os = "macos"))]
fn exchange(staging: &Path, folder: &Path) -> std::io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    match folder.symlink_metadata() {
        Err(_) => fs::rename(staging, folder),
        Ok(_) => Ok(renameat_with(CWD, staging, CWD, folder, RenameFlags::EXCHANGE)?),
    }
}

#[cfg(not(any(target_os = "linux", target_os = "macos")))]
fn exchange(staging: &Path, folder: &Path) -> std::io::Result<()> {
    match folder.symlink_metadata() {
        Err(_) => fs::rename(staging, folder),
        Ok(_) => Err(ErrorKind::Unsupported.into()),
    }
}

/// Real folders of our own with some kinds of names in a folder.
fn own_folders(folder: &Path, kinds: &[&str]) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let is_ours = |name: &str| {
        let rest = name.strip_prefix(OWN_PREFIX);
        let rest = rest.and_then(|rest| kinds.iter().find_map(|kind| rest.strip_prefix(kind)));
        rest.is_some_and(|rest| !rest.is_empty() && rest.chars().all(|c| c.is_ascii_digit() || c == '-'))
    };
    let mut found: Vec<PathBuf> = entries
        .filter_map(Result::ok)
        .filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()))
        .filter(|entry| entry.file_name().to_str().is_some_and(is_ours))
        .map(|entry| entry.path())
        .collect();
    found.sort();
    found
}

/// What runs that were killed left unfinished: beside a folder, and in it.
pub fn leftovers(parent: &Path, folder: &Path) -> Vec<PathBuf> {
    [own_folders(parent, &[WHOLE]), own_folders(folder, &[PART])].concat()
}

/// Whether files of a killed run have not all taken their places.
pub fn is_unfinished(folder: &Path) -> bool {
    !own_folders(folder, &[MOVES]).is_empty()
}

/// Moves all files of every finished set to their places; when one cannot be moved, all go back.
pub fn finish(folder: &Path) -> Result<(), Refusal> {
    for moves in own_folders(folder, &[MOVES]) {
        let list = match fs::read_to_string(moves.join(LIST)) {
            Ok(list) => list,
            // a run that was killed while it removed the folder: all had taken its place
            Err(why) if why.kind() == ErrorKind::NotFound => String::new(),
            Err(why) => {
                return Err(format!("{} cannot be read: {why}; remove its folder", moves.join(LIST).display()).into());
            }
        };
        let outcome = list.lines().try_for_each(|line| one_move(folder, &moves, line));
        if let Err(why) = &outcome {
            list.lines().for_each(|line| undo(folder, &moves, line));
            let _ = fs::remove_dir_all(&moves);
            return Err(format!("{} cannot be written: {why}", folder.display()).into());
        }
        for name in list.lines().filter_map(|line| line.strip_prefix("remove ")) {
            remove_empty_above(&folder.join(name), folder);
        }
        fs::remove_dir_all(&moves).map_err(|why| format!("{} cannot be removed: {why}", moves.display()))?;
    }
    Ok(())
}

/// Does one line of a list; what is done already is left.
fn one_move(folder: &Path, moves: &Path, line: &str) -> std::io::Result<()> {
    let (name, new) = match (line.strip_prefix("put "), line.strip_prefix("remove ")) {
        (Some(name), _) => (name, Some(moves.join(NEW).join(name))),
        (None, Some(name)) => (name, None),
        (None, None) => return Err(ErrorKind::InvalidData.into()),
    };
    let (place, former) = (folder.join(name), moves.join(FORMER).join(name));
    if new.as_ref().is_some_and(|new| new.symlink_metadata().is_err()) {
        return Ok(());
    }
    if place.symlink_metadata().is_ok() && former.symlink_metadata().is_err() {
        make_above(&former)?;
        fs::rename(&place, &former)?;
    }
    if let Some(new) = new {
        make_above(&place)?;
        fs::rename(new, &place)?;
    }
    Ok(())
}

/// Takes one line of a list back.
fn undo(folder: &Path, moves: &Path, line: &str) {
    let (put, remove) = (line.strip_prefix("put "), line.strip_prefix("remove "));
    let Some(name) = put.or(remove) else { return };
    let (place, former, new) = (folder.join(name), moves.join(FORMER).join(name), moves.join(NEW).join(name));
    if former.symlink_metadata().is_ok() {
        let _ = fs::rename(former, place);
    } else if put.is_some() && new.symlink_metadata().is_err() {
        let _ = fs::remove_file(&place);
        remove_empty_above(&place, folder);
    }
}

fn make_above(file: &Path) -> std::io::Result<()> {
    file.parent().map_or(Ok(()), fs::create_dir_all)
}

/// Removes the folders that a file leaves empty below `top`.
fn remove_empty_above(file: &Path, top: &Path) {
    for above in file.ancestors().skip(1).take_while(|above| *above != top) {
        // a folder with other files stays
        if fs::remove_dir(above).is_err() {
            break;
        }
    }
}
