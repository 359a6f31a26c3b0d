//! Columns as they stand in a file of a gauge, to times in s and readings in mm. How a file is read is in `table` and `xml`.

use std::path::Path;

use crate::load::checked_text::limits::{CAPTURE_SECONDS, ROWS};
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::printable::{LONGEST_SHOWN, shortened};
use crate::load::moment::{Moment, Stated};
use crate::session::LengthColumn;
use crate::statistics::median;

/// What a gauge wrote.
#[derive(Debug, Clone, PartialEq)]
pub struct CaptureFile {
    /// Times since the first row, s, rising.
    pub time_s: Vec<f64>,
    /// Readings, mm: absolute lengths, or deviations from the bar's length, as `column` says; NaN where there is none.
    pub reading_mm: Vec<f64>,
    /// What the readings are.
    pub column: LengthColumn,
    /// Columns or elements that were not read.
    pub not_read: Vec<String>,
    /// When the first row was read, where the file states it.
    pub began_at: Option<Moment>,
    /// The file is no UTF-8 text and was read as Windows-1252.
    pub is_latin: bool,
}

/// What a file does not say by itself.
#[derive(Debug, Clone, Copy, Default)]
pub struct CaptureHints {
    /// Readings a second, for files without times.
    pub rate_hz: Option<f64>,
    /// What readings without a unit are.
    pub column: Option<LengthColumn>,
}

/// In a second.
const NANOSECONDS: f64 = 1e9;
/// Columns as they stand in a file.
#[derive(Default)]
pub(super) struct Raw {
    /// Times in the file's unit with that unit, s.
    pub time: Option<(Vec<f64>, f64)>,
    pub readings: Vec<f64>,
    pub column: Option<LengthColumn>,
    /// Name of the readings.
    pub name: String,
    pub rate_hz: Option<f64>,
    /// Line of each row, for messages.
    pub lines: Vec<usize>,
    pub not_read: Vec<String>,
    /// When the recording began, as words before the readings state it.
    pub began: Stated,
    /// Stamp of the first row.
    pub stamp: String,
    /// Read from XML, which has no columns.
    pub is_xml: bool,
}

impl Raw {
    pub fn finished(self, file: &Path, hints: CaptureHints) -> Result<CaptureFile, LoadError> {
        if let Some(message) = ROWS.exceeded(self.readings.len()) {
            return Err(LoadError::file(file, message));
        }
        let Some(column) = hints.column.or(self.column) else {
            return Err(LoadError::file(
                file,
                format!(
                    "the readings '{}' have no unit; {} or say --unit",
                    shortened(&self.name, LONGEST_SHOWN),
                    match self.is_xml {
                        true => "state um or mm in an element Unit",
                        false => "name the column deviation_um, deviation_mm or length_mm,",
                    }
                ),
            ));
        };
        let time_s: Vec<f64> = match (self.time, hints.rate_hz.or(self.rate_hz)) {
            (Some((time, unit_s)), None) => time.iter().map(|value| value * unit_s).collect(),
            (_, Some(rate)) => (0..self.readings.len()).map(|row| row as f64 / rate).collect(),
            (None, None) => {
                let add = if self.is_xml { "an element SampleRate in Hz" } else { "a column time_s" };
                return Err(LoadError::file(
                    file,
                    format!(
                        "has neither times nor a sampling rate; add {add} or say --rate with the readings a second"
                    ),
                ));
            }
        };
        if let Some(row) = (1..time_s.len()).find(|&row| time_s[row] < time_s[row - 1]) {
            let message = format!("times go from {} to {} s; times rise from row to row", time_s[row - 1], time_s[row]);
            return Err(match self.lines.get(row) {
                Some(&line) => LoadError::line(file, line, message),
                None => LoadError::file(file, message),
            });
        }
        let first_s = time_s.first().copied().unwrap_or(0.0);
        // to the nanosecond, so that a clock's zero changes nothing
        let since_first = |time: f64| ((time - first_s) * NANOSECONDS).round() / NANOSECONDS;
        let Some(time_s) = spread(time_s.into_iter().map(since_first).collect()) else {
            return Err(LoadError::file(
                file,
                match self.is_xml {
                    true => "all readings have the same time; the clock stood, say --rate with the readings a second",
                    false => "all rows have the same time; the clock stood, or the column is another",
                },
            ));
        };
        if let Some(message) = CAPTURE_SECONDS.exceeded(time_s.last().map_or(0, |last_s| last_s.ceil() as usize)) {
            return Err(LoadError::file(file, message));
        }
        let reading_mm = self.readings.iter().map(|value| value * column.unit_mm()).collect();
        // the rows' own stamps are nearer than the preamble
        let began_at = Moment::of_stamp(&self.stamp, self.began).or(self.began.moment());
        Ok(CaptureFile { time_s, reading_mm, column, not_read: self.not_read, began_at, is_latin: false })
    }
}

/// Times with repeated stamps set apart: a clock that counts more coarsely than the gauge reads gives several rows one stamp.
/// They lie evenly up to the next stamp, or over as long as stamps are usually apart where a pause follows. `None` where no two
/// stamps differ.
fn spread(mut time_s: Vec<f64>) -> Option<Vec<f64>> {
    let groups: Vec<(usize, usize)> = {
        let begins: Vec<usize> = (0..time_s.len()).filter(|&row| row == 0 || time_s[row] > time_s[row - 1]).collect();
        let ends = begins.iter().skip(1).copied().chain([time_s.len()]);
        begins.iter().copied().zip(ends).collect()
    };
    if groups.len() == time_s.len() {
        return Some(time_s);
    }
    let usual = median(groups.windows(2).map(|pair| time_s[pair[1].0] - time_s[pair[0].0]))?;
    let next: Vec<f64> = groups.iter().skip(1).map(|(begin, _)| time_s[*begin]).collect();
    for (k, (begin, end)) in groups.into_iter().enumerate() {
        let room = next.get(k).map_or(usual, |next| (next - time_s[begin]).min(usual));
        let step = room / (end - begin) as f64;
        (begin..end).for_each(|row| time_s[row] += step * (row - begin) as f64);
    }
    Some(time_s)
}
