//! Files as gauges write them, text tables or XML, to columns of times and readings. What they mean is `import`'s to find.

use std::path::Path;

use crate::load::checked_text::limits::{CSV_BYTES, ROWS};
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::printable::shortened;
use crate::load::checked_text::text::read_limited;
use crate::load::moment::{Moment, Stated, is_of_other};
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
/// Lines before a table's header, at most.
const PREAMBLE_LINES: usize = 200;
/// Fewest numbers of a list of readings in XML.
const SERIES: usize = 30;
/// Most open elements of XML among which the one is looked for that an end tag closes.
const MOST_OPEN: usize = 1000;
/// Longest name that a message repeats, characters.
const SHOWN: usize = 40;

/// Reads a capture: a table with a header that names times and readings, or XML with a list of numbers.
pub fn load_capture(file: &Path, hints: CaptureHints) -> Result<CaptureFile, LoadError> {
    let text = read_limited(file, CSV_BYTES)?;
    let raw = if text.trim_start().starts_with('<') { from_xml(file, &text)? } else { from_table(file, &text)? };
    raw.finished(file, hints)
}

/// Columns as they stand in a file.
#[derive(Default)]
struct Raw {
    /// Times in the file's unit with that unit, s.
    time: Option<(Vec<f64>, f64)>,
    readings: Vec<f64>,
    column: Option<LengthColumn>,
    /// Name of the readings.
    name: String,
    rate_hz: Option<f64>,
    /// Line of each row, for messages.
    lines: Vec<usize>,
    not_read: Vec<String>,
    /// When the recording began, as words before the readings state it.
    began: Stated,
    /// Stamp of the first row.
    stamp: String,
}

impl Raw {
    fn finished(self, file: &Path, hints: CaptureHints) -> Result<CaptureFile, LoadError> {
        if let Some(message) = ROWS.exceeded(self.readings.len()) {
            return Err(LoadError::file(file, message));
        }
        let Some(column) = hints.column.or(self.column) else {
            return Err(LoadError::file(
                file,
                format!(
                    "the readings '{}' have no unit; name the column deviation_um, deviation_mm or length_mm, or say --unit",
                    shortened(&self.name, SHOWN)
                ),
            ));
        };
        let time_s: Vec<f64> = match (self.time, hints.rate_hz.or(self.rate_hz)) {
            (Some((time, unit_s)), None) => time.iter().map(|value| value * unit_s).collect(),
            (_, Some(rate)) => (0..self.readings.len()).map(|row| row as f64 / rate).collect(),
            (None, None) => {
                return Err(LoadError::file(
                    file,
                    "has neither times nor a sampling rate; add a column time_s or say --rate with the readings a second",
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
                "all rows have the same time; the clock stood, or the column is another",
            ));
        };
        let reading_mm = self.readings.iter().map(|value| value * column.unit_mm()).collect();
        // the rows' own stamps are nearer than the preamble
        let began_at = Moment::of_stamp(&self.stamp, self.began).or(self.began.moment());
        Ok(CaptureFile { time_s, reading_mm, column, not_read: self.not_read, began_at })
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

/// What a name of a column or element means.
enum Meaning {
    /// Times in this unit, s.
    Time(f64),
    /// Readings, with what they are where the name says it.
    Readings(Option<LengthColumn>),
    Other,
}

/// Words that name readings.
const READINGS: [&str; 9] =
    ["deviation", "reading", "length", "radius", "ballbar", "abweichung", "laenge", "distance", "transducer"];
/// Words that name times.
const TIMES: [&str; 4] = ["time", "zeit", "t", "seconds"];

/// A name in small letters, its words apart.
fn plain_name(name: &str) -> String {
    let plain = name.trim().trim_matches('"').to_lowercase().replace(['µ', 'μ'], "u").replace('ä', "ae");
    plain.chars().map(|character| if character.is_alphanumeric() { character } else { '_' }).collect()
}

fn meaning(name: &str) -> Meaning {
    let plain = plain_name(name);
    let words: Vec<&str> = plain.split('_').filter(|word| !word.is_empty()).collect();
    let has = |list: &[&str]| words.iter().any(|word| list.contains(word));
    if has(&TIMES) {
        return Meaning::Time(if has(&["ms"]) { 1e-3 } else { 1.0 });
    }
    if !has(&READINGS) {
        return Meaning::Other;
    }
    let is_length = has(&["length", "laenge", "distance"]);
    Meaning::Readings(match (has(&["um", "micron", "microns"]), has(&["mm"]), is_length) {
        (true, _, false) => Some(LengthColumn::DeviationUm),
        (_, true, false) => Some(LengthColumn::DeviationMm),
        (_, true, true) => Some(LengthColumn::LengthMm),
        _ => None,
    })
}

/// Fields of a line; a decimal comma is one where the separator is none.
fn fields(line: &str, separator: char) -> Vec<&str> {
    let parts: Vec<&str> = match separator {
        ' ' => line.split_whitespace().collect(),
        _ => line.split(separator).collect(),
    };
    parts.into_iter().map(|field| field.trim().trim_matches('"')).collect()
}

/// Fields of a row below a header of so many names; a separator at the end of a row begins no field.
fn row_of(line: &str, separator: char, names: usize) -> Vec<&str> {
    let mut row = fields(line, separator);
    if row.len() == names + 1 && row.last().is_some_and(|last| last.is_empty()) {
        row.pop();
    }
    row
}

fn number(field: &str, separator: char) -> Option<f64> {
    let plain = if separator == ',' { field.to_string() } else { field.replacen(',', ".", 1) };
    plain.parse().ok().filter(|value: &f64| value.is_finite())
}

/// What gauges write where there is no reading.
const MISSING: [&str; 9] = ["", "-", "--", "---", "nan", "n/a", "na", "null", "#n/a"];

/// A reading, NaN where the gauge wrote that there is none; `None` for anything else.
fn reading(field: &str, separator: char) -> Option<f64> {
    let is_missing = MISSING.contains(&field.to_lowercase().as_str());
    if is_missing { Some(f64::NAN) } else { number(field, separator) }
}

/// A time: a number in the column's unit, or a time of day `hh:mm:ss.fff`, with or without a date before it, in s over `unit_s`.
fn time(field: &str, separator: char, unit_s: f64) -> Option<f64> {
    if let Some(value) = number(field, separator) {
        return Some(value);
    }
    let clock = field.rsplit(['T', ' ']).next()?.trim_end_matches('Z');
    let parts: Vec<f64> = clock.split(':').map(|part| number(part, separator)).collect::<Option<_>>()?;
    let seconds = match parts.as_slice() {
        [hours, minutes, seconds] if *minutes < 60.0 && *seconds < 60.0 => (hours * 60.0 + minutes) * 60.0 + seconds,
        [minutes, seconds] if *seconds < 60.0 => minutes * 60.0 + seconds,
        _ => return None,
    };
    Some(seconds / unit_s)
}

/// True for a row of units below a header: `s;µm`.
fn is_units(row: &[&str], separator: char) -> bool {
    row.iter().all(|field| number(field, separator).is_none())
        && row.iter().any(|field| !matches!(meaning(&format!("deviation {field}")), Meaning::Readings(None)))
}

/// Readings a second that a line of a preamble states: `Sample rate: 250 Hz`.
fn stated_rate(line: &str) -> Option<f64> {
    let lower = line.to_lowercase();
    let before = &lower[..lower.find("hz")?];
    let mut words =
        before.split(|c: char| !(c.is_ascii_digit() || c == '.' || c == ',')).filter(|word| !word.is_empty());
    words.next_back()?.replace(',', ".").parse().ok().filter(|rate| *rate > 0.0)
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
    let separators = [';', '\t', ',', ' '];
    let is_readings = |name: &&str| matches!(meaning(name), Meaning::Readings(_));
    let names_readings = |line: &str, separator: char| {
        let names = fields(line.trim_start_matches('#'), separator);
        names.iter().any(is_readings) && names.iter().all(|name| number(name, separator).is_none())
    };
    lines().take(PREAMBLE_LINES).find_map(|(index, line)| {
        let mut followed = lines().skip_while(|(next, _)| *next <= index).map(|(_, line)| line);
        let (first, second) = (followed.next()?, followed.next());
        // a line of words about readings is no header: numbers follow one, or units and then numbers
        let fits = |&separator: &char| {
            let names = fields(line.trim_start_matches('#'), separator).len();
            let is_row = |line: &str| {
                let row = row_of(line, separator, names);
                row.len() == names && row.iter().any(|field| number(field, separator).is_some())
            };
            let units = Some(fields(first.trim_start_matches('#'), separator)).filter(|row| row.len() == names);
            match names_readings(line, separator) {
                true if is_row(first) => Some((separator, None)),
                true if second.is_some_and(is_row) => {
                    units.filter(|row| is_units(row, separator)).map(|row| (separator, Some(row)))
                }
                _ => None,
            }
        };
        separators.iter().find_map(fits).map(|(separator, units)| Header { index, line, separator, units })
    })
}

fn from_table(file: &Path, text: &str) -> Result<Raw, LoadError> {
    let lines = || filled(text);
    let Some(Header { index: header, line, separator, units }) = header(text) else {
        return Err(LoadError::file(
            file,
            "has no header that names readings; a capture has columns such as time_s and deviation_um, with numbers below",
        ));
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
            _ => raw.not_read.push(name.to_string()),
        }
    }
    if time_at.is_none() {
        raw.rate_hz = lines().take_while(|(index, _)| *index < header).find_map(|(_, line)| stated_rate(line));
    }
    for (_, line) in lines().take_while(|(index, _)| *index < header) {
        raw.not_read.extend(raw.began.take_line(line).map(|line| format!("'{}'", shortened(line, SHOWN))));
    }
    let mut times = Vec::new();
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
            let found = shortened(row[k], SHOWN);
            value.ok_or_else(|| refuse(format!("column {}: '{found}' is {allowed}; correct it", names[k])))
        };
        if let Some((k, unit_s)) = time_at {
            if times.is_empty() {
                // the day may have a column of its own
                raw.stamp = day_at.map_or(String::new(), |day| format!("{} ", row[day])) + row[k];
            }
            times.push(or_refuse(time(row[k], separator, unit_s), k, "neither a number nor a time of day")?);
        }
        if let Some(k) = reading_at {
            raw.readings.push(or_refuse(reading(row[k], separator), k, "not a number")?);
        }
        raw.lines.push(index + 1);
    }
    raw.time = time_at.map(|(_, unit_s)| (times, unit_s));
    Ok(raw)
}

/// A leaf of an XML text, or an attribute.
struct Leaf<'a> {
    name: &'a str,
    tag: &'a str,
    content: &'a str,
    /// Whether an element around it, but the outermost, is about something else than the recording.
    is_of_other: bool,
}

/// Leaves of an XML text, attributes among them. Elements that are not closed do no harm.
fn leaves(text: &str) -> Vec<Leaf<'_>> {
    let mut leaves = Vec::new();
    // open elements, and whether one up to there is about something else
    let mut open: Vec<(&str, bool)> = Vec::new();
    let mut rest = text;
    while let Some(begin) = rest.find('<') {
        rest = &rest[begin + 1..];
        let Some(end) = rest.find('>') else { break };
        let (tag, after) = (&rest[..end], &rest[end + 1..]);
        let name = tag.trim_start_matches('/').split(|c: char| c.is_whitespace() || c == '/').next().unwrap_or(tag);
        if tag.starts_with('/') {
            // an end that fits none is passed over
            let at = open.iter().rev().take(MOST_OPEN).position(|(known, _)| *known == name);
            open.truncate(at.map_or(open.len(), |at| open.len() - 1 - at));
        } else if !tag.starts_with(['?', '!']) {
            let around = open.last().is_some_and(|(_, is_of_other)| *is_of_other);
            let own = around || !open.is_empty() && is_of_other(name);
            let attribute = |(own_name, content)| Leaf { name: own_name, tag: name, content, is_of_other: own };
            leaves.extend(attributes(&tag[name.len()..]).into_iter().map(attribute));
            let content = after.find('<').map_or(after, |next| &after[..next]);
            if !tag.ends_with('/') && after[content.len()..].starts_with(&format!("</{name}")) {
                leaves.push(Leaf { name, tag, content: content.trim(), is_of_other: around });
            }
            if !tag.ends_with('/') {
                open.push((name, own));
            }
        }
        rest = after;
    }
    leaves
}

/// Attributes of a tag behind its name: `t="0.1" v='2'`.
fn attributes(tag: &str) -> Vec<(&str, &str)> {
    let mut found = Vec::new();
    let mut rest = tag;
    while let Some((name, after)) = rest.split_once('=') {
        let after = after.trim_start();
        let Some(quote) = after.chars().next().filter(|quote| matches!(quote, '"' | '\'')) else { break };
        let Some((value, behind)) = after[1..].split_once(quote) else { break };
        found.push((name.trim(), value.trim()));
        rest = behind;
    }
    found
}

fn from_xml(file: &Path, text: &str) -> Result<Raw, LoadError> {
    // a list in one element, or one number in each of many
    let mut series: Vec<(&str, String, Vec<f64>)> = Vec::new();
    let mut raw = Raw::default();
    let mut unit = String::new();
    for Leaf { name, tag, content, is_of_other } in leaves(text) {
        let words = content.split(|c: char| c.is_whitespace() || c == ';' || c == ',').filter(|word| !word.is_empty());
        let numbers: Option<Vec<f64>> = words.map(|word| word.parse().ok().filter(|v: &f64| v.is_finite())).collect();
        let plain = plain_name(name);
        let element = tag.split_whitespace().next().unwrap_or_default();
        match numbers {
            Some(numbers) if numbers.len() == 1 && (plain.contains("rate") || plain.contains("freq")) => {
                raw.rate_hz = numbers.first().copied().filter(|rate| *rate > 0.0);
            }
            Some(numbers) if numbers.len() == 1 && (plain.contains("interval") || plain.contains("period")) => {
                raw.rate_hz = numbers.first().filter(|step| **step > 0.0).map(|step| 1.0 / step);
            }
            Some(numbers) if !numbers.is_empty() => match series.iter_mut().find(|(known, _, _)| *known == name) {
                Some((_, _, list)) => list.extend(numbers),
                None => series.push((name, tag.to_string(), numbers)),
            },
            _ if plain.contains("unit") => unit = plain_name(content),
            _ if !is_of_other && raw.began.take(&format!("{element} {name}"), content) => {}
            _ => raw.not_read.push(name.to_string()),
        }
    }
    let is_time = |name: &str| matches!(meaning(name), Meaning::Time(_));
    let named =
        |name: &str| u8::from(plain_name(name).split('_').any(|word| READINGS.iter().any(|r| word.starts_with(r))));
    let best = (0..series.len())
        .filter(|&k| series[k].2.len() >= SERIES && !is_time(series[k].0))
        .max_by_key(|&k| (named(series[k].0), series[k].2.len()));
    let Some(best) = best else {
        let names: Vec<&str> = series.iter().map(|(name, _, _)| *name).collect();
        return Err(LoadError::file(
            file,
            format!(
                "is XML without a list of at least {SERIES} readings (numbers found in: {}); export the readings as a table with time_s and deviation_um",
                if names.is_empty() { "none".into() } else { names.join(" ") }
            ),
        ));
    };
    let (name, tag, readings) = series.swap_remove(best);
    let named_unit = format!("{name}_{}_{unit}", plain_name(&tag));
    raw.column = match meaning(&format!("deviation_{}", plain_name(&named_unit))) {
        Meaning::Readings(column) => column,
        _ => None,
    };
    if let Some(time) = series.iter().position(|(name, _, list)| is_time(name) && list.len() == readings.len()) {
        let (name, _, times) = series.swap_remove(time);
        let unit_s = if let Meaning::Time(unit_s) = meaning(name) { unit_s } else { 1.0 };
        raw.time = Some((times, unit_s));
        raw.rate_hz = None;
    }
    raw.not_read.extend(series.iter().map(|(name, _, _)| name.to_string()));
    raw.not_read.sort();
    raw.not_read.dedup();
    (raw.name, raw.readings) = (name.to_string(), readings);
    Ok(raw)
}
