//! Fields of a line of a table, and decimal commas in them. It reads no numbers.

use std::borrow::Cow;

/// Fields of a line without the spaces around them; separators between quotes separate nothing.
pub(crate) fn fields_of(line: &str, separator: char) -> impl Iterator<Item = &str> {
    let mut quoted = false;
    line.split(move |character| {
        quoted ^= character == '"';
        character == separator && !quoted
    })
    .map(str::trim)
}

/// A field with a decimal point where it has a decimal comma: a comma that separated would be in no field.
pub(crate) fn with_decimal_point(field: &str) -> Cow<'_, str> {
    match field.contains(',') {
        true => Cow::Owned(field.replacen(',', ".", 1)),
        false => Cow::Borrowed(field),
    }
}
