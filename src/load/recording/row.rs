//! A row of a recording under its header, and the refusal of rows that a transfer has cut. It judges no numbers.

use std::path::Path;

use super::fields::{number, plain};
use super::header::Header;
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::printable::{LONGEST_SHOWN, shortened};

/// Adds one row's numbers to the columns.
pub fn read_row(
    file: &Path,
    line: usize,
    header: &Header,
    fields: &[&str],
    values: &mut [Vec<f64>],
) -> Result<(), LoadError> {
    let refuse = |message: String| Err(LoadError::line(file, line, message));
    let due = header.columns.len();
    if fields.len() != due {
        let hint = if fields.len() < due {
            "the line may be cut off"
        } else if header.separator == ',' {
            "decimal commas need ; between the fields"
        } else {
            "remove what is too much"
        };
        return refuse(format!(
            "has {} fields where the header (line {}) has {due}; {hint}",
            fields.len(),
            header.line
        ));
    }
    for (index, field) in fields.iter().enumerate() {
        let name = header.names[index];
        let Some(value) = number(field) else {
            return refuse(format!(
                "column {name}: '{}' is not a number; correct it or leave a missing {} empty",
                shortened(field, LONGEST_SHOWN),
                header.readings()
            ));
        };
        let is_missing = field.is_empty() && header.columns[index].may_be_empty();
        if !value.is_finite() && !is_missing {
            let shown = if field.is_empty() { "an empty field".into() } else { shortened(field, LONGEST_SHOWN) };
            return refuse(format!(
                "column {name}: {shown} is not a finite number; only a missing {} or channel may be empty",
                header.readings()
            ));
        }
        values[index].push(value);
    }
    Ok(())
}

/// Fields of clock and positions with commas between them.
pub fn leading_text(header: &Header, fields: &[&str]) -> String {
    let mut text = String::new();
    for (column, field) in header.columns.iter().zip(fields) {
        if column.is_leading() {
            if !text.is_empty() {
                text.push(',');
            }
            text.push_str(&plain(field));
        }
    }
    text.shrink_to_fit();
    text
}
