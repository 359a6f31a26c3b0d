//! Decimal commas of numbers in tables. It reads no numbers.

use std::borrow::Cow;

/// What a comma in a field is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Comma {
    IsDecimal,
    Separates,
}

impl Comma {
    /// In a table whose fields are separated so.
    pub(crate) fn beside(separator: char) -> Comma {
        if separator == ',' { Comma::Separates } else { Comma::IsDecimal }
    }
}

/// A field with a decimal point where it has a decimal comma.
pub(crate) fn with_decimal_point(field: &str, comma: Comma) -> Cow<'_, str> {
    match comma == Comma::IsDecimal && field.contains(',') {
        true => Cow::Owned(field.replacen(',', ".", 1)),
        false => Cow::Borrowed(field),
    }
}
