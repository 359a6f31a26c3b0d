//! The list of files that runs wrote into a folder, with length and checksum: a file that was changed since is not ours any more.

use std::fs;
use std::path::{Path, PathBuf};

use crate::verbs::Refusal;

/// Name of the list in its folder.
pub const MANIFEST: &str = ".fiveaxis-files";
/// How the list begins.
const HEAD: &str =
    "# files that fiveaxis wrote: length, checksum, name; one that was changed since is not overwritten\n";

/// The files of a folder that runs wrote.
#[derive(Debug, Default, Clone)]
pub struct Manifest {
    entries: Vec<Entry>,
}

#[derive(Debug, Clone, PartialEq)]
struct Entry {
    name: PathBuf,
    length: usize,
    checksum: u64,
}

impl Entry {
    fn of(name: &Path, content: &[u8]) -> Entry {
        Entry { name: name.to_path_buf(), length: content.len(), checksum: checksum(content) }
    }
}

impl Manifest {
    /// The list of a folder; a folder without one has none of our files.
    pub fn read(folder: &Path) -> Result<Manifest, Refusal> {
        let file = folder.join(MANIFEST);
        let Ok(found) = file.symlink_metadata() else { return Ok(Manifest::default()) };
        let refuse = || format!("{} is no list of this program's files; remove it", file.display());
        if !found.is_file() {
            return Err(refuse().into());
        }
        let text = fs::read_to_string(&file).map_err(|why| format!("{} cannot be read: {why}", file.display()))?;
        let lines = text.strip_prefix(HEAD).ok_or_else(refuse)?.lines();
        Ok(Manifest { entries: lines.filter_map(entry).collect() })
    }

    /// Whether a run wrote this content under this name.
    pub fn holds(&self, name: &Path, content: &[u8]) -> bool {
        self.entries.iter().any(|entry| entry.name == name && *entry == Entry::of(name, content))
    }

    /// The list after some files were written and others removed.
    pub fn with(mut self, written: &[(PathBuf, Vec<u8>)], removed: &[PathBuf]) -> Manifest {
        let is_new = |name: &PathBuf| written.iter().any(|(other, _)| other == name);
        self.entries.retain(|entry| !is_new(&entry.name) && !removed.contains(&entry.name));
        self.entries.extend(written.iter().map(|(name, content)| Entry::of(name, content)));
        self.entries.sort_by(|one, other| one.name.cmp(&other.name));
        self
    }

    /// The list as it stands in its file.
    pub fn text(&self) -> String {
        let line = |entry: &Entry| format!("{} {:016x} {}\n", entry.length, entry.checksum, entry.name.display());
        HEAD.to_string() + &self.entries.iter().map(line).collect::<String>()
    }
}

fn entry(line: &str) -> Option<Entry> {
    let mut parts = line.splitn(3, ' ');
    let length = parts.next()?.parse().ok()?;
    let checksum = u64::from_str_radix(parts.next()?, 16).ok()?;
    Some(Entry { name: PathBuf::from(parts.next()?), length, checksum })
}

/// FNV-1a: it tells a changed file from the one that was written, it protects against nobody.
fn checksum(content: &[u8]) -> u64 {
    content.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3))
}
