//! A YAML file with the place of every key, for messages; typed values are read by `serde_yaml` beside it.

use std::path::{Path, PathBuf};

use saphyr::{LoadableYamlNode, MarkedYamlOwned, YamlDataOwned};
use serde::de::DeserializeOwned;

use super::message::{LoadError, nearest};

/// Deepest nesting of brackets and indentation that a file of ours can need, with room to spare.
const MAX_DEPTH: usize = 40;

/// A parsed YAML file.
pub struct Document {
    file: PathBuf,
    text: String,
    root: Option<MarkedYamlOwned>,
}

/// One step into a document: a key of a mapping or an index of a list.
#[derive(Debug, Clone, Copy)]
pub enum Step<'a> {
    Key(&'a str),
    Index(usize),
}

impl Document {
    /// Parses the text of `file`; malformed YAML, doubled keys and deep nesting are refused with their place.
    pub fn parse(file: &Path, text: String) -> Result<Document, LoadError> {
        refuse_deep_nesting(file, &text)?;
        let documents = MarkedYamlOwned::load_from_str(&text).map_err(|why| LoadError {
            file: file.to_path_buf(),
            line: Some(why.marker().line()),
            column: Some(why.marker().col() + 1),
            message: format!("is not valid YAML here: {}", why.info()),
        })?;
        if documents.len() > 1 {
            return Err(LoadError::file(file, "holds several YAML documents ('---'); one is allowed"));
        }
        let root = documents.into_iter().next();
        let is_map = root.as_ref().is_some_and(|node| matches!(node.data, YamlDataOwned::Mapping(_)));
        if !is_map {
            return Err(LoadError::file(file, "is empty or no list of keys; it starts with 'name:' and further keys"));
        }
        Ok(Document { file: file.to_path_buf(), text, root })
    }

    /// The typed value; what does not fit is refused with its line and, for a key, the nearest valid one.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T, LoadError> {
        serde_yaml::from_str(&self.text).map_err(|why| {
            let place = why.location();
            LoadError {
                file: self.file.clone(),
                line: place.as_ref().map(|place| place.line()),
                column: place.as_ref().map(|place| place.column()),
                message: readable(&why.to_string()),
            }
        })
    }

    /// A refusal at the place of a key or value.
    pub fn refuse(&self, steps: &[Step], message: impl Into<String>) -> LoadError {
        let place = self.place(steps);
        LoadError {
            file: self.file.clone(),
            line: place.map(|(line, _)| line),
            column: place.map(|(_, column)| column),
            message: message.into(),
        }
    }

    /// True when the file has this key at its top.
    pub fn has(&self, key: &str) -> bool {
        self.place(&[Step::Key(key)]).is_some()
    }

    /// Line and column, from 1, of the deepest step that exists.
    fn place(&self, steps: &[Step]) -> Option<(usize, usize)> {
        let mut node = self.root.as_ref()?;
        let mut found = None;
        for step in steps {
            let next = match (step, &node.data) {
                (Step::Key(key), YamlDataOwned::Mapping(map)) => {
                    map.iter().find(|(name, _)| name.data.as_str() == Some(key)).map(|(name, value)| {
                        found = Some((name.span.start.line(), name.span.start.col() + 1));
                        value
                    })
                }
                (Step::Index(index), YamlDataOwned::Sequence(list)) => list.get(*index).inspect(|value| {
                    found = Some((value.span.start.line(), value.span.start.col() + 1));
                }),
                _ => None,
            };
            match next {
                Some(next) => node = next,
                None => break,
            }
        }
        found
    }
}

/// `serde_yaml`'s words for an unknown key with the nearest valid one, its own place removed (ours stands in front).
fn readable(message: &str) -> String {
    let message = message.rsplit_once(" at line ").map_or(message, |(head, _)| head);
    let words: Vec<&str> = message.split('`').collect();
    if message.contains("unknown field") && words.len() > 3 {
        let valid: Vec<&str> = words.iter().skip(3).step_by(2).copied().collect();
        let hint = nearest(words[1], &valid).map(|name| format!("; did you mean '{name}'?")).unwrap_or_default();
        return format!("unknown key '{}'{hint} (allowed: {})", words[1], valid.join(", "));
    }
    message.to_string()
}

/// Refuses nesting that would exhaust the parsers' stacks, judged by brackets and indentation before parsing.
fn refuse_deep_nesting(file: &Path, text: &str) -> Result<(), LoadError> {
    let mut open = 0usize;
    for (index, line) in text.lines().enumerate() {
        let indent = line.len() - line.trim_start_matches([' ', '-', '?']).len();
        for character in line.chars() {
            match character {
                '[' | '{' => open += 1,
                ']' | '}' => open = open.saturating_sub(1),
                _ => {}
            }
        }
        if open > MAX_DEPTH || indent > 4 * MAX_DEPTH {
            return Err(LoadError::line(
                file,
                index + 1,
                format!("is nested deeper than {MAX_DEPTH} levels; no such file needs that"),
            ));
        }
    }
    Ok(())
}
