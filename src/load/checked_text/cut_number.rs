//! Rows of numbers whose last one a broken transfer has cut. It reads no numbers.

use std::path::Path;

use super::message::LoadError;
use super::printable::{LONGEST_SHOWN, shortened};

/// Refuses a last number that a broken transfer has cut: no line end and fewer decimals than every row before. Rows stand below the first
/// `above` lines.
pub fn refuse_cut_number(file: &Path, text: &str, above: usize, separator: char) -> Result<(), LoadError> {
    if text.ends_with(['\n', '\r']) {
        return Ok(());
    }
    let last_field = |line: &str| line.rsplit(separator).next().unwrap_or_default().trim().to_string();
    // a decimal comma stands where commas do not separate
    let decimals = |line: &str| last_field(line).rsplit_once(['.', ',']).map_or(0, |(_, digits)| digits.len());
    let is_row = |line: &str| !line.trim().is_empty() && !line.trim_start().starts_with('#');
    let lines: Vec<(usize, &str)> = text.lines().enumerate().skip(above).filter(|(_, line)| is_row(line)).collect();
    let Some(((index, last), before)) = lines.split_last() else { return Ok(()) };
    let whole = before.iter().filter(|(_, line)| !line.trim_end().ends_with(separator));
    match whole.map(|(_, line)| decimals(line)).min() {
        Some(usual) if decimals(last) < usual => Err(LoadError::line(
            file,
            index + 1,
            format!(
                "the last line ends after '{}' without a line end, where all rows before have at least {usual} decimals; the file is cut off, fetch it again or remove the line",
                shortened(&last_field(last), LONGEST_SHOWN)
            ),
        )),
        _ => Ok(()),
    }
}
