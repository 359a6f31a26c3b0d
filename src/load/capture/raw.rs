//! Columns as they stand in a file of a gauge, to times in s and readings in mm. How a file is read is in `table` and `xml`.

use std::borrow::Cow;
use std::path::Path;

use super::names::other_unit;
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
    /// The file states times; else they follow from the number of rows and the rate, and a row that is lost shifts all behind it.
    pub has_times: bool,
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

/// Most columns that a message names.
pub(super) const MOST_NAMES: usize = 8;
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
    /// Columns of a table whose names are not understood.
    pub unknown: Vec<String>,
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
            let name = shortened(&self.name, LONGEST_SHOWN);
            if let Some(unit) = other_unit(&self.name) {
                let says = format!(
                    "the readings '{name}' have the unit '{unit}', which is not read; convert them to um or mm, and say --unit"
                );
                return Err(LoadError::file(file, says));
            }
            return Err(LoadError::file(
                file,
                format!(
                    "the readings '{name}' have no unit; {} or say --unit",
                    match self.is_xml {
                        true => "state um or mm in an element Unit",
                        false => "name the column deviation_um, deviation_mm or length_mm,",
                    }
                ),
            ));
        };
        let has_times = self.time.is_some() && hints.rate_hz.or(self.rate_hz).is_none();
        let time_s: Vec<f64> = match (self.time, hints.rate_hz.or(self.rate_hz)) {
            (Some((time, unit_s)), None) => time.iter().map(|value| value * unit_s).collect(),
            (_, Some(rate)) => (0..self.readings.len()).map(|row| row as f64 / rate).collect(),
            (None, None) => {
                let add = if self.is_xml { "an element SampleRate in Hz" } else { "a column time_s" };
                let columns: Vec<Cow<str>> =
                    self.unknown.iter().take(MOST_NAMES).map(|name| shortened(name, LONGEST_SHOWN)).collect();
                let unknown = match columns.as_slice() {
                    [] => String::new(),
                    names => format!(" (not understood: column {})", names.join(", ")),
                };
                return Err(LoadError::file(
                    file,
                    format!(
                        "has neither times nor a sampling rate{unknown}; add {add} or say --rate with the readings a second"
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
        Ok(CaptureFile { time_s, reading_mm, column, not_read: self.not_read, began_at, has_times, is_latin: false })
    }
}

/// Steps between stamps that are so many times the usual one lie between packets, and in how many packets at least, of how many rows
/// at most, a recording comes for it to count as sent in packets. The steps within them then make up so small a share of all time.
const BETWEEN_PACKETS: f64 = 5.0;
const PACKETS: usize = 10;
const ROWS_OF_A_PACKET: usize = 100;
const WITHIN_PACKETS: f64 = 0.2;

/// The longest step between rows of one packet, s, where a radio sent several at a time and the stamps are those of their arrival; 0
/// where each row has a stamp of its own.
fn step_within_packets(time_s: &[f64]) -> f64 {
    let steps = || time_s.windows(2).map(|pair| pair[1] - pair[0]);
    let most_s = BETWEEN_PACKETS * median(steps()).unwrap_or(0.0);
    let packets = steps().filter(|step| *step > most_s).count();
    let within_s: f64 = steps().filter(|step| *step <= most_s).sum();
    let all_s: f64 = steps().sum();
    let is_sent = packets >= PACKETS.max(time_s.len() / ROWS_OF_A_PACKET) && within_s < WITHIN_PACKETS * all_s;
    if is_sent { most_s } else { 0.0 }
}

/// Times with repeated stamps set apart, and with the stamps of packets: a clock that counts more coarsely than the gauge reads gives
/// several rows one stamp, and a radio several that lie close together. They lie evenly up to the next stamp, or over as long as stamps
/// are usually apart where a pause follows. `None` where no two stamps differ.
fn spread(mut time_s: Vec<f64>) -> Option<Vec<f64>> {
    let near_s = step_within_packets(&time_s);
    let groups: Vec<(usize, usize)> = {
        let begins: Vec<usize> =
            (0..time_s.len()).filter(|&row| row == 0 || time_s[row] - time_s[row - 1] > near_s).collect();
        let ends = begins.iter().skip(1).copied().chain([time_s.len()]);
        begins.iter().copied().zip(ends).collect()
    };
    if groups.len() == time_s.len() {
        return Some(time_s);
    }
    let usual = median(groups.windows(2).map(|pair| time_s[pair[1].0] - time_s[pair[0].0]))?;
    let next: Vec<f64> = groups.iter().skip(1).map(|(begin, _)| time_s[*begin]).collect();
    for (k, (begin, end)) in groups.into_iter().enumerate() {
        let first_s = time_s[begin];
        let room = next.get(k).map_or(usual, |next| (next - first_s).min(usual));
        let step = room / (end - begin) as f64;
        (begin..end).for_each(|row| time_s[row] = first_s + step * (row - begin) as f64);
    }
    Some(time_s)
}
