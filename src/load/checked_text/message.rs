//! The one message a bad file gets: file, place, what was found, what is allowed, what to do.

use std::fmt;
use std::path::{Path, PathBuf};

use super::printable::{escaped, escaped_lines, shortened};

/// Longest message, characters: lists of names are cut after it.
const LONGEST_MESSAGE: usize = 2000;
/// Longest misspelt word for which a near one is looked for, bytes.
const LONGEST_WORD: usize = 100;

/// Why a file was not accepted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LoadError {
    /// File as named by the user.
    pub file: PathBuf,
    /// Line, from 1.
    pub line: Option<usize>,
    /// Column, from 1.
    pub column: Option<usize>,
    /// What was found, what is allowed, what to do.
    pub message: String,
}

impl LoadError {
    /// A message about a whole file.
    pub fn file(file: &Path, message: impl Into<String>) -> LoadError {
        LoadError { file: file.to_path_buf(), line: None, column: None, message: message.into() }
    }

    /// A message about a line (from 1) of a file.
    pub fn line(file: &Path, line: usize, message: impl Into<String>) -> LoadError {
        LoadError { line: Some(line), ..LoadError::file(file, message) }
    }
}

impl fmt::Display for LoadError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        // a file's name and what was found in it may hold what a terminal obeys
        write!(out, "{}", escaped(&self.file.to_string_lossy()))?;
        if let Some(line) = self.line {
            write!(out, ":{line}")?;
        }
        if let (Some(_), Some(column)) = (self.line, self.column) {
            write!(out, ":{column}")?;
        }
        write!(out, ": {}", escaped_lines(&shortened(&self.message, LONGEST_MESSAGE)))
    }
}

impl std::error::Error for LoadError {}

/// The valid name nearest to a misspelt one, if any is near.
pub fn nearest<'a>(found: &str, valid: &[&'a str]) -> Option<&'a str> {
    if found.len() > LONGEST_WORD {
        return None;
    }
    let near = |name: &&&str| edit_distance(found, name) <= 1 + found.chars().count() / 3;
    valid.iter().filter(near).min_by_key(|name| edit_distance(found, name)).copied()
}

/// A question that names the valid name nearest to a misspelt one, to stand behind the message; empty where none is near.
pub fn did_you_mean(found: &str, valid: &[&str]) -> String {
    nearest(found, valid).map(|name| format!("; did you mean '{name}'?")).unwrap_or_default()
}

/// Number of insertions, deletions and replacements between two words.
fn edit_distance(one: &str, other: &str) -> usize {
    let other: Vec<char> = other.chars().collect();
    let mut row: Vec<usize> = (0..=other.len()).collect();
    for (i, a) in one.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &b) in other.iter().enumerate() {
            let replace = diagonal + usize::from(a != b);
            diagonal = row[j + 1];
            row[j + 1] = replace.min(row[j] + 1).min(row[j + 1] + 1);
        }
    }
    row[other.len()]
}
