//! Tables of a gauge: preamble, header, rows. XML is in `xml`.

use std::path::Path;

use super::names::{Meaning, meaning, plain_name};
use super::numbers::{fields, number, reading, row_of, time};
use super::raw::{MOST_NAMES, Raw};
use super::sampling::{says_sampling, stated_rate};
use crate::load::checked_text::cut_number::refuse_cut_number;
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::printable::{LONGEST_SHOWN, shortened};
use crate::load::moment::DAY_S;

/// What may part the fields of a line, in the order in which it is tried.
const SEPARATORS: [char; 4] = [';', '\t', ',', ' '];
/// Lines before a table's header, at most.
const PREAMBLE_LINES: usize = 200;

/// True for a row of units below a header: `s;µm`.
fn is_units(row: &[&str]) -> bool {
    row.iter().all(|field| number(field).is_none())
        && row.iter().any(|field| !matches!(meaning(&format!("deviation {field}")), Meaning::Readings(None)))
}

/// Where a table's header stands and how its fields are parted.
struct Header<'t> {
    index: usize,
    line: &'t str,
    separator: char,
    /// The row of units below it, if there is one.
    units: Option<Vec<&'t str>>,
}

/// Lines with something on them, with their numbers from 0.
fn filled(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty())
}

/// The first line that names readings and is followed by numbers.
fn header(text: &str) -> Option<Header<'_>> {
    let lines = || filled(text);
    let is_readings = |name: &&str| matches!(meaning(name), Meaning::Readings(_));
    let names_readings = |line: &str, separator: char| {
        let names = fields(line.trim_start_matches('#'), separator);
        names.iter().any(is_readings) && names.iter().all(|name| number(name).is_none())
    };
    lines().take(PREAMBLE_LINES).find_map(|(index, line)| {
        let mut followed = lines().skip_while(|(next, _)| *next <= index).map(|(_, line)| line);
        let (first, second) = (followed.next()?, followed.next());
        // a line of words about readings is no header: numbers follow one, or units and then numbers
        let fits = |&separator: &char| {
            let names = fields(line.trim_start_matches('#'), separator).len();
            let is_row = |line: &str| {
                let row = row_of(line, separator, names);
                row.len() == names && row.iter().any(|field| number(field).is_some())
            };
            let units = Some(fields(first.trim_start_matches('#'), separator)).filter(|row| row.len() == names);
            match names_readings(line, separator) {
                true if is_row(first) => Some((separator, None)),
                true if second.is_some_and(is_row) => {
                    units.filter(|row| is_units(row)).map(|row| (separator, Some(row)))
                }
                _ => None,
            }
        };
        SEPARATORS.iter().find_map(fits).map(|(separator, units)| Header { index, line, separator, units })
    })
}

/// The names right above the first row of numbers, of which none is known for readings, as a message says them.
fn names_above_numbers(text: &str) -> String {
    let lines: Vec<&str> = filled(text).map(|(_, line)| line).take(PREAMBLE_LINES).collect();
    let named = lines.windows(2).find_map(|pair| {
        SEPARATORS.into_iter().find_map(|separator| {
            let names = fields(pair[0].trim_start_matches('#'), separator);
            let row = row_of(pair[1], separator, names.len());
            let is_header = names.iter().all(|name| number(name).is_none() && !name.is_empty())
                && row.len() == names.len()
                && (row.len() > 1 || separator == SEPARATORS[0])
                && row.iter().any(|field| number(field).is_some());
            is_header.then_some(names)
        })
    });
    let Some(names) = named else { return String::new() };
    let shown: Vec<String> =
        names.iter().take(MOST_NAMES).map(|name| format!("'{}'", shortened(name, LONGEST_SHOWN))).collect();
    format!(" (none of {} is known for them)", shown.join(", "))
}

/// Why a text is no table of a capture.
fn no_header(text: &str) -> String {
    let within = match filled(text).nth(PREAMBLE_LINES) {
        Some(_) => format!(" within its first {PREAMBLE_LINES} lines"),
        None => String::new(),
    };
    format!(
        "has no header that names readings{}{within}; a capture has columns such as time_s and deviation_um, with numbers below",
        names_above_numbers(text)
    )
}

pub(super) fn from_table(file: &Path, text: &str) -> Result<Raw, LoadError> {
    let lines = || filled(text);
    let Some(Header { index: header, line, separator, units }) = header(text) else {
        return Err(LoadError::file(file, no_header(text)));
    };
    let names = fields(line.trim_start_matches('#'), separator);
    let mut raw = Raw { rate_hz: None, ..Raw::default() };
    let day_at = names.iter().position(|name| ["date", "datum"].contains(&plain_name(name).as_str()));
    let (mut time_at, mut reading_at) = (None, None);
    for (k, name) in names.iter().enumerate() {
        let unit = units.as_ref().map_or("", |units| units[k]);
        match meaning(&format!("{name} {unit}")) {
            Meaning::Time(unit_s) if time_at.is_none() => time_at = Some((k, unit_s)),
            Meaning::Readings(column) if reading_at.is_none() => {
                reading_at = Some(k);
                (raw.column, raw.name) = (column, name.to_string());
            }
            _ if day_at == Some(k) => {}
            meant => {
                raw.not_read.push(name.to_string());
                raw.unknown.extend(matches!(meant, Meaning::Other).then(|| name.to_string()));
            }
        }
    }
    if time_at.is_none() {
        // a label that says sampling comes before any other rate, such as that of a filter
        let before = || lines().take_while(|(index, _)| *index < header).map(|(_, line)| line);
        let labelled = before().filter(|line| says_sampling(line)).find_map(stated_rate);
        raw.rate_hz = labelled.or_else(|| before().find_map(stated_rate));
    }
    for (_, line) in lines().take_while(|(index, _)| *index < header) {
        raw.not_read.extend(raw.began.take_line(line).map(|line| format!("'{}'", shortened(line, LONGEST_SHOWN))));
    }
    let (mut times, mut days): (Vec<f64>, f64) = (Vec::new(), 0.0);
    let first = header + usize::from(units.is_some());
    // comments may stand between rows
    for (index, line) in lines().skip_while(|(index, _)| *index <= first).filter(|(_, line)| !line.starts_with('#')) {
        let row = row_of(line, separator, names.len());
        let refuse = |message: String| LoadError::line(file, index + 1, message);
        if row.len() != names.len() {
            return Err(refuse(format!(
                "has {} fields where the header (line {}) has {}; the file may be cut off",
                row.len(),
                header + 1,
                names.len()
            )));
        }
        let or_refuse = |value: Option<f64>, k: usize, allowed: &str| {
            let found = shortened(row[k], LONGEST_SHOWN);
            value.ok_or_else(|| refuse(format!("column {}: '{found}' is {allowed}; correct it", names[k])))
        };
        if let Some((k, unit_s)) = time_at {
            if times.is_empty() {
                // the day may have a column of its own
                raw.stamp = day_at.map_or(String::new(), |day| format!("{} ", row[day])) + row[k];
            }
            let time = or_refuse(time(row[k], unit_s), k, "neither a number nor a time of day")?;
            // a clock that starts again at midnight
            let day = DAY_S / unit_s;
            let is_next_day =
                row[k].contains(':') && times.last().is_some_and(|last| time + days * day < last - 0.5 * day);
            days += f64::from(u8::from(is_next_day));
            times.push(time + days * day);
        }
        if let Some(k) = reading_at {
            raw.readings.push(or_refuse(reading(row[k]), k, "not a number")?);
        }
        raw.lines.push(index + 1);
    }
    refuse_cut_number(file, text, first + 1, separator)?;
    raw.time = time_at.map(|(_, unit_s)| (times, unit_s));
    Ok(raw)
}
