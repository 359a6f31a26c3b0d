//! Fields of a table's rows to numbers, readings and times. What they mean is told by names.

use crate::load::checked_text::fields::{fields_of, with_decimal_point};

/// Fields of a line without quotes; separators between quotes separate nothing.
pub(super) fn fields(line: &str, separator: char) -> Vec<&str> {
    let parts: Vec<&str> = match separator {
        ' ' => line.split_whitespace().collect(),
        _ => fields_of(line, separator).collect(),
    };
    parts.into_iter().map(|field| field.trim().trim_matches('"')).collect()
}

/// Fields of a row below a header of so many names; a separator at the end of a row begins no field.
pub(super) fn row_of(line: &str, separator: char, names: usize) -> Vec<&str> {
    let mut row = fields(line, separator);
    if row.len() == names + 1 && row.last().is_some_and(|last| last.is_empty()) {
        row.pop();
    }
    row
}

/// The minus sign of typography.
const MINUS: char = '\u{2212}';

pub(super) fn number(field: &str) -> Option<f64> {
    with_decimal_point(field).replace(MINUS, "-").parse().ok().filter(|value: &f64| value.is_finite())
}

/// What gauges write where there is no reading: none at all, or one beyond their stroke.
const MISSING: [&str; 12] = ["", "-", "--", "---", "nan", "n/a", "na", "null", "#n/a", "ovl", "overload", "overrange"];

/// A reading, NaN where the gauge wrote that there is none; `None` for anything else.
pub(super) fn reading(field: &str) -> Option<f64> {
    let is_missing = MISSING.contains(&field.to_lowercase().as_str());
    if is_missing { Some(f64::NAN) } else { number(field) }
}

/// A time: a number in the column's unit, or a time of day `hh:mm:ss.fff`, with or without a date before it, in s over `unit_s`.
pub(super) fn time(field: &str, unit_s: f64) -> Option<f64> {
    if let Some(value) = number(field) {
        return Some(value);
    }
    let clock = field.rsplit(['T', ' ']).next()?.trim_end_matches('Z');
    let parts: Vec<f64> = clock.split(':').map(number).collect::<Option<_>>()?;
    let seconds = match parts.as_slice() {
        [hours, minutes, seconds] if *minutes < 60.0 && *seconds < 60.0 => (hours * 60.0 + minutes) * 60.0 + seconds,
        [minutes, seconds] if *seconds < 60.0 => minutes * 60.0 + seconds,
        _ => return None,
    };
    Some(seconds / unit_s)
}
