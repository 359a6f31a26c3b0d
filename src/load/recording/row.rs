//! A row of a recording under its header, and the refusal of rows that a transfer has cut. It judges no numbers.

use std::path::Path;

use super::fields::{LONGEST_FIELD, number, plain};
use super::header::Header;
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::printable::shortened;

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
        let Some(value) = number(field, header.separator) else {
            return refuse(format!(
                "column {name}: '{}' is not a number; correct it or leave a missing {} empty",
                shortened(field, LONGEST_FIELD),
                header.readings()
            ));
        };
        let is_missing = field.is_empty() && header.columns[index].may_be_empty();
        if !value.is_finite() && !is_missing {
            let shown = if field.is_empty() { "an empty field".into() } else { shortened(field, LONGEST_FIELD) };
            return refuse(format!(
                "column {name}: {shown} is not a finite number; only a missing {} or channel may be empty",
                header.readings()
            ));
        }
        values[index].push(value);
    }
    Ok(())
}

/// Refuses a last number that a broken transfer has cut: no line end and fewer decimals than every row before.
pub fn refuse_cut_number(file: &Path, text: &str, header: &Header, last_line: usize) -> Result<(), LoadError> {
    let separator = header.separator;
    if text.ends_with(['\n', '\r']) {
        return Ok(());
    }
    let decimals = |line: &str| {
        let field = line.rsplit(separator).next().unwrap_or_default();
        let field = plain(field.trim(), separator);
        field.split_once('.').map_or(0, |(_, digits)| digits.len())
    };
    let lines: Vec<&str> = text.lines().skip(header.line).filter(|line| !line.trim().is_empty()).collect();
    let Some((last, before)) = lines.split_last() else { return Ok(()) };
    let usual = before.iter().filter(|line| !line.trim_end().ends_with(separator)).map(|line| decimals(line)).min();
    match usual {
        Some(usual) if decimals(last) < usual => Err(LoadError::line(
            file,
            last_line,
            format!(
                "the last line ends after '{}' without a line end, where all rows before have at least {usual} decimals; the file is cut off, fetch it again or remove the line",
                shortened(last.rsplit(separator).next().unwrap_or_default().trim(), LONGEST_FIELD)
            ),
        )),
        _ => Ok(()),
    }
}

/// Fields of clock and positions with commas between them.
pub fn leading_text(header: &Header, fields: &[&str]) -> String {
    let mut text = String::new();
    for (column, field) in header.columns.iter().zip(fields) {
        if column.is_leading() {
            if !text.is_empty() {
                text.push(',');
            }
            text.push_str(&plain(field, header.separator));
        }
    }
    text.shrink_to_fit();
    text
}
