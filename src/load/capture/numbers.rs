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

/// Halves of a day and the hour at which each begins.
const HALVES: [(&str, f64); 2] = [("AM", 0.0), ("PM", 12.0)];

/// A time: a number in the column's unit, or a time of day `hh:mm:ss.fff`, with or without a date before it, AM or PM or the zone's
/// offset behind it, in s over `unit_s`.
pub(super) fn time(field: &str, unit_s: f64) -> Option<f64> {
    if let Some(value) = number(field) {
        return Some(value);
    }
    let half = HALVES.iter().find_map(|(word, begins_h)| {
        let (before, last) = field.split_at_checked(field.len().checked_sub(word.len())?)?;
        last.eq_ignore_ascii_case(word).then_some((before.trim_end(), begins_h))
    });
    let field = half.map_or(field, |(before, _)| before);
    let clock = field.rsplit(['T', ' ']).next()?.trim_end_matches('Z');
    // a zone is the same in all rows
    let clock = clock.split(['+', '-']).next()?;
    let parts: Vec<f64> = clock.split(':').map(number).collect::<Option<_>>()?;
    let seconds = match parts.as_slice() {
        [hours, minutes, seconds] if *minutes < 60.0 && *seconds < 60.0 => {
            let hours = match half {
                Some((_, begins_h)) if *hours <= 12.0 => hours % 12.0 + begins_h,
                Some(_) => return None,
                None => *hours,
            };
            (hours * 60.0 + minutes) * 60.0 + seconds
        }
        [minutes, seconds] if *seconds < 60.0 => minutes * 60.0 + seconds,
        _ => return None,
    };
    Some(seconds / unit_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_of_rows_are_read_with_halves_of_the_day_and_zones() {
        let due = Some(9.0 * 3600.0 + 15.0 * 60.0 + 0.5);
        for stamp in ["09:15:00.5", "11/26/2026 9:15:00.5 AM", "2026-11-26T09:15:00.5+01:00", "2026-11-26T09:15:00.5Z"]
        {
            assert_eq!(time(stamp, 1.0), due, "{stamp}");
        }
        assert_eq!(time("11/26/2026 12:00:01 AM", 1.0), Some(1.0));
        assert_eq!(time("12:00:01 pm", 1.0), Some(43_201.0));
        assert_eq!(time("13:00:01 PM", 1.0), None);
    }
}
