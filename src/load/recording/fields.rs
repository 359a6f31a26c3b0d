//! Numbers in the fields of a recording. It knows no columns.

use std::borrow::Cow;

use crate::load::checked_text::fields::with_decimal_point;

/// A number; an empty field is NaN; a decimal comma is accepted.
pub fn number(field: &str) -> Option<f64> {
    if field.is_empty() {
        return Some(f64::NAN);
    }
    plain(field).parse().ok()
}

/// A field without quotes and with a decimal point.
pub fn plain(field: &str) -> Cow<'_, str> {
    with_decimal_point(field.trim_matches('"').trim())
}
