//! Text as YAML writes it: plain where it reads back as the same text, quoted where not.

use std::fmt::Write as _;

/// A scalar of text: plain where YAML cannot take it for anything else, quoted otherwise.
pub(crate) fn text(value: &str) -> String {
    let mut characters = value.chars();
    let starts_as_word = characters.next().is_some_and(|first| first.is_ascii_alphabetic());
    let is_word = starts_as_word && characters.all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.' | '/'));
    let has_other_meaning = ["true", "false", "null", "yes", "no", "on", "off"].contains(&&*value.to_ascii_lowercase());
    if is_word && !has_other_meaning {
        return value.to_string();
    }
    let mut quoted = String::from("\"");
    for character in value.chars() {
        match character {
            '"' | '\\' => quoted.extend(['\\', character]),
            ' '..='~' => quoted.push(character),
            other if other.is_alphanumeric() => quoted.push(other),
            other => {
                let _ = write!(quoted, "\\U{:08X}", other as u32);
            }
        }
    }
    quoted.push('"');
    quoted
}
