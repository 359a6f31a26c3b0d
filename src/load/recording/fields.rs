//! Fields of a line of a recording, and the numbers that they write. It knows no columns.

use std::borrow::Cow;

use crate::load::checked_text::decimal::{Comma, with_decimal_point};

/// Fields of a line without the spaces around them; separators between quotes separate nothing.
pub fn fields_of(line: &str, separator: char) -> impl Iterator<Item = &str> {
    let mut quoted = false;
    line.split(move |character| {
        quoted ^= character == '"';
        character == separator && !quoted
    })
    .map(str::trim)
}

/// A number; an empty field is NaN; a decimal comma is accepted where the separator allows it.
pub fn number(field: &str, separator: char) -> Option<f64> {
    if field.is_empty() {
        return Some(f64::NAN);
    }
    plain(field, separator).parse().ok()
}

/// A field without quotes and with a decimal point.
pub fn plain(field: &str, separator: char) -> Cow<'_, str> {
    let bare = field.trim_matches('"').trim();
    // between quotes a comma separates nothing, whatever the separator
    let is_quoted = field.len() != bare.len();
    with_decimal_point(bare, if is_quoted { Comma::IsDecimal } else { Comma::beside(separator) })
}
