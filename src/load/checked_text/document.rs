//! A YAML file with the place of every key, for messages; typed values are read by `serde_yaml` beside it.

use std::path::{Path, PathBuf};

use std::fmt;

use saphyr::{LoadableYamlNode, MarkedYamlOwned, YamlDataOwned};
use serde::de::{
    Deserialize, DeserializeOwned, Deserializer, EnumAccess, MapAccess, SeqAccess, VariantAccess, Visitor,
};

use super::limits::{DEPTH, TEXT};
use super::message::{LoadError, did_you_mean};
use super::printable::hidden_in;

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
    /// Parses the text of `file`; malformed YAML, doubled keys, deep nesting and texts with hidden characters are refused with
    /// their place.
    pub fn parse(file: &Path, text: String) -> Result<Document, LoadError> {
        refuse_deep_nesting(file, &text)?;
        let documents = MarkedYamlOwned::load_from_str(&text).map_err(|why| LoadError {
            file: file.to_path_buf(),
            line: Some(why.marker().line()),
            column: Some(why.marker().col() + 1),
            message: match why.info() {
                "duplicated key in mapping" => {
                    format!("the key '{}' stands twice; each key stands once", key_at(&text, why.marker()))
                }
                info if info.contains("alias") => format!("{ALIAS_BOMB} ({info})"),
                info => format!("is not valid YAML here: {info}"),
            },
        })?;
        if documents.len() > 1 {
            return Err(LoadError::file(file, "holds several YAML documents ('---'); one is allowed"));
        }
        let root = documents.into_iter().next();
        let is_map = root.as_ref().is_some_and(|node| matches!(node.data, YamlDataOwned::Mapping(_)));
        if !is_map {
            return Err(LoadError::file(file, "is empty or no list of keys; it starts with 'name:' and further keys"));
        }
        let document = Document { file: file.to_path_buf(), text, root };
        document.read::<Plain>()?;
        Ok(document)
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

/// The key that begins at a place.
fn key_at<'a>(text: &'a str, place: &saphyr::Marker) -> &'a str {
    let line = text.lines().nth(place.line().saturating_sub(1)).unwrap_or_default();
    let start = line.char_indices().nth(place.col()).map_or(line.len(), |(at, _)| at);
    line[start..].split(':').next().unwrap_or_default().trim()
}

/// `serde_yaml`'s words in ours, its own place removed (ours stands in front).
fn readable(message: &str) -> String {
    let message = message.rsplit_once(" at line ").map_or(message, |(head, _)| head);
    let words: Vec<&str> = message.split('`').collect();
    let before = words[0];
    let within = |what: &str| before.strip_suffix(what).map(|path| path.trim_end_matches(": "));
    let under = |path: &str| if path.is_empty() { String::new() } else { format!(" under {path}") };
    if let Some(path) = within("unknown field ").or_else(|| within("unknown variant ")) {
        let valid: Vec<&str> = words.iter().skip(3).step_by(2).copied().collect();
        let kind = if before.ends_with("field ") { "key" } else { "word" };
        let hint = did_you_mean(words[1], &valid);
        return format!("unknown {kind} '{}'{}{hint} (allowed: {})", words[1], under(path), valid.join(", "));
    }
    if let Some(path) = within("missing field ") {
        return format!("the key '{}' is missing{}; add it", words[1], under(path));
    }
    if let Some((path, rest)) = message.split_once("invalid type: ")
        && let Some((found, due)) = rest.rsplit_once(", expected ")
    {
        let path = path.trim_end_matches(": ");
        let path = if path.is_empty() { String::new() } else { format!("{path}: ") };
        return format!("{path}found {}, due is {}", plain_type(found), plain_type(due));
    }
    if let Some((path, rest)) = message.split_once("invalid length ")
        && let Some((found, due)) = rest.split_once(", expected ")
    {
        let due: String = due.chars().filter(char::is_ascii_digit).collect();
        return format!("{path}has {found} entries, due are {due}");
    }
    if message.contains("repetition limit exceeded") {
        return ALIAS_BOMB.to_string();
    }
    message.to_string()
}

/// Rust's names of types in words of the file's author.
fn plain_type(words: &str) -> String {
    let plain = match words {
        "f64" => "a number",
        "a sequence" | "sequence" => "a list",
        "a map" | "map" => "keys and values",
        "unit value" => "nothing",
        "a boolean" => "true or false",
        "an array of length 3" => "a list of three numbers",
        "an array of length 2" => "a list of two numbers",
        "a tuple of size 2" => "a pair [position, value]",
        _ if words.starts_with("struct ") => "keys and values",
        _ => {
            return words
                .replace("string \"", "the text \"")
                .replace("floating point `", "the number `")
                .replace("integer `", "the number `");
        }
    };
    plain.to_string()
}

const ALIAS_BOMB: &str = "repeats its anchors (&name, *name) too many times; write the values out";

/// A value of any kind whose texts can be shown anywhere: the border that no hidden character of a file passes.
struct Plain;

impl<'de> Deserialize<'de> for Plain {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Plain, D::Error> {
        deserializer.deserialize_any(PlainVisitor)
    }
}

struct PlainVisitor;

impl<'de> Visitor<'de> for PlainVisitor {
    type Value = Plain;

    fn expecting(&self, out: &mut fmt::Formatter) -> fmt::Result {
        out.write_str("a value")
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Plain, E> {
        if let Some(hidden) = hidden_in(text) {
            return Err(E::custom(format!(
                "the text holds the hidden character {hidden}; line breaks, control characters and invisible ones are not allowed, remove it"
            )));
        }
        match TEXT.exceeded(text.chars().count()) {
            Some(message) => Err(E::custom(message)),
            None => Ok(Plain),
        }
    }

    fn visit_bool<E>(self, _: bool) -> Result<Plain, E> {
        Ok(Plain)
    }

    fn visit_i64<E>(self, _: i64) -> Result<Plain, E> {
        Ok(Plain)
    }

    fn visit_u64<E>(self, _: u64) -> Result<Plain, E> {
        Ok(Plain)
    }

    fn visit_i128<E>(self, _: i128) -> Result<Plain, E> {
        Ok(Plain)
    }

    fn visit_u128<E>(self, _: u128) -> Result<Plain, E> {
        Ok(Plain)
    }

    fn visit_f64<E>(self, _: f64) -> Result<Plain, E> {
        Ok(Plain)
    }

    fn visit_unit<E>(self) -> Result<Plain, E> {
        Ok(Plain)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Plain, A::Error> {
        while list.next_element::<Plain>()?.is_some() {}
        Ok(Plain)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Plain, A::Error> {
        while map.next_entry::<Plain, Plain>()?.is_some() {}
        Ok(Plain)
    }

    fn visit_enum<A: EnumAccess<'de>>(self, tagged: A) -> Result<Plain, A::Error> {
        tagged.variant::<Plain>()?.1.newtype_variant::<Plain>()
    }
}

/// Refuses nesting that would exhaust the parsers' stacks, judged by brackets and indentation before parsing.
///
/// Brackets in quoted text count too: telling quotes from apostrophes needs the parser that this protects.
fn refuse_deep_nesting(file: &Path, text: &str) -> Result<(), LoadError> {
    let mut open = 0usize;
    for (index, line) in text.lines().enumerate() {
        if line.trim().is_empty() || line.trim_start().starts_with('#') {
            continue;
        }
        let content = line.trim_start_matches([' ', '-', '?']);
        let indent = line.len() - content.len();
        for character in content.chars() {
            match character {
                '[' | '{' => open += 1,
                ']' | '}' => open = open.saturating_sub(1),
                _ => {}
            }
        }
        if open > DEPTH.most || indent > 4 * DEPTH.most {
            return Err(LoadError::line(
                file,
                index + 1,
                format!("is nested deeper than {} levels; no such file needs that", DEPTH.most),
            ));
        }
    }
    Ok(())
}
