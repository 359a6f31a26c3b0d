//! Which characters a name may hold and how others are shown: the one rule for what reaches a terminal, page or program.

use std::borrow::Cow;

/// Longest field or name of a file that a message repeats, characters.
pub const LONGEST_SHOWN: usize = 40;

/// True for characters that are not seen, or change how others are seen: controls, line breaks, zero widths, reversed text,
/// and code points that are no characters (XML forbids them).
pub fn is_hidden(character: char) -> bool {
    character.is_control()
        || matches!(
            character,
            '\u{ad}'
                | '\u{61c}'
                | '\u{180e}'
                | '\u{200b}'..='\u{200f}'
                | '\u{2028}'..='\u{202e}'
                | '\u{2060}'..='\u{206f}'
                | '\u{feff}'
                | '\u{fff9}'..='\u{fffb}'
                | '\u{fdd0}'..='\u{fdef}'
                | '\u{e0000}'..='\u{e007f}'
        )
        || (character as u32) & 0xfffe == 0xfffe
}

/// The first hidden character of a text, as messages name it: `U+001B`.
pub fn hidden_in(text: &str) -> Option<String> {
    text.chars().find(|&character| is_hidden(character)).map(|character| format!("U+{:04X}", character as u32))
}

/// The text with hidden characters written out, `\u{1b}`.
pub fn escaped(text: &str) -> Cow<'_, str> {
    escaped_but(text, |_| false)
}

/// As [`escaped`], line ends and tabs kept: for whole outputs.
pub fn escaped_lines(text: &str) -> Cow<'_, str> {
    escaped_but(text, |character| matches!(character, '\n' | '\t'))
}

fn escaped_but(text: &str, is_kept: impl Fn(char) -> bool) -> Cow<'_, str> {
    let is_shown = |character: char| !is_hidden(character) || is_kept(character);
    if text.chars().all(is_shown) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        match is_shown(character) {
            true => out.push(character),
            false => out.extend(character.escape_unicode()),
        }
    }
    Cow::Owned(out)
}

/// The beginning of a long text, for messages.
pub fn shortened(text: &str, most: usize) -> Cow<'_, str> {
    match text.char_indices().nth(most) {
        None => Cow::Borrowed(text),
        Some((end, _)) => Cow::Owned(format!("{}…", &text[..end])),
    }
}
