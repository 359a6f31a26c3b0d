//! Recordings (CSV) to a [`Recording`]: separators, headers and numbers. What the rows may say is judged in `rows`.

use std::borrow::Cow;
use std::path::Path;

use super::rows::{Rows, check_rows, check_rows_of_parts};
use crate::load::checked_text::limits::{COLUMNS, CSV_BYTES, LINE_BYTES, ROWS};
use crate::load::checked_text::message::{LoadError, nearest};
use crate::load::checked_text::printable::{hidden_in, shortened};
use crate::load::checked_text::text::read_limited;
use crate::machine::Machine;
use crate::readings::Kind;
use crate::session::{Clock, LengthColumn, Recording};

/// A recording as its file has it, not yet judged for a bar: `length_mm` holds the numbers of its column of readings.
#[derive(Clone)]
pub(super) struct Parsed {
    recording: Recording,
    header_line: usize,
    /// Line of each row in the file.
    line_of_row: Vec<u32>,
}

impl Parsed {
    /// Reads a file whose readings stand in the wanted columns.
    pub fn load(file: &Path, machine: &Machine, wanted: &Wanted) -> Result<Parsed, LoadError> {
        Parsed::of(file, &read_limited(file, CSV_BYTES)?, machine, wanted)
    }

    /// The recording of another kind than lengths with the columns that hold its readings, and the line of every row; its
    /// lengths are all missing and the readings stand among its channels.
    pub fn into_parts(self, file: &Path, machine: &Machine, rows: Rows) -> Result<(Recording, Vec<u32>), LoadError> {
        let Parsed { recording, line_of_row, .. } = self;
        let line = |row: usize| line_of_row.get(row).map_or(row + 1, |&line| line as usize);
        check_rows_of_parts(file, &recording, line, machine, rows)?;
        Ok((recording, line_of_row))
    }

    /// The recording in lengths, its rows judged; `bar_length_mm` is the calibrated length that readings must lie near to,
    /// and from which deviations are counted.
    pub fn into_recording(
        self,
        file: &Path,
        machine: &Machine,
        bar_length_mm: Option<f64>,
        rows: Rows,
    ) -> Result<Recording, LoadError> {
        let Parsed { mut recording, line_of_row, header_line } = self;
        let column = recording.column;
        if column.is_deviation() {
            let Some(bar_mm) = bar_length_mm else {
                return Err(LoadError::line(
                    file,
                    header_line,
                    format!(
                        "{} is the reading minus the bar's calibrated length, and the test states no bar_length; add it to the test",
                        column.name()
                    ),
                ));
            };
            recording.length_mm.iter_mut().for_each(|value| *value = *value * column.unit_mm() + bar_mm);
        }
        let line = |row: usize| line_of_row.get(row).map_or(row + 1, |&line| line as usize);
        check_rows(file, &recording, line, machine, bar_length_mm, rows)?;
        Ok(recording)
    }
}

/// Columns in which readings are looked for.
#[derive(Clone, Default)]
pub(super) struct Wanted {
    pub kind: Kind,
    /// Names in the file for the usual ones: usual name, name in the file.
    pub renamed: Vec<(String, String)>,
}

impl Wanted {
    /// Name of a column in the file.
    pub fn in_file<'a>(&'a self, usual: &'a str) -> &'a str {
        self.renamed.iter().find(|(name, _)| name == usual).map_or(usual, |(_, own)| own)
    }

    /// True for a column that holds a number of a reading.
    fn holds(&self, name: &str) -> bool {
        self.kind != Kind::Length
            && self.kind.column_sets().iter().flat_map(|set| set.iter()).any(|usual| self.in_file(usual) == name)
    }

    /// The set of columns that a header has, under their names in the file.
    pub fn set_in(&self, names: &[&str]) -> Option<Vec<String>> {
        let sets = self.kind.column_sets().iter();
        let own = sets.map(|set| set.iter().map(|usual| self.in_file(usual).to_string()).collect::<Vec<_>>());
        own.into_iter().find(|set| set.iter().all(|name| names.contains(&name.as_str())))
    }
}

/// What a column holds.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Column {
    Time,
    Pose,
    Axis(usize),
    Length(LengthColumn),
    /// A number of a reading of several.
    Part,
    Channel,
}

impl Column {
    fn is_leading(self) -> bool {
        matches!(self, Column::Time | Column::Pose | Column::Axis(_))
    }

    fn may_be_empty(self) -> bool {
        matches!(self, Column::Length(_) | Column::Part | Column::Channel)
    }
}

/// Longest header, characters.
const LONGEST_HEADER: usize = 100;
/// Longest field that a message repeats, characters.
const LONGEST_FIELD: usize = 40;
/// What a header looks like, for messages.
const HEADER_EXAMPLE: &str = "time_s,A_deg,length_mm";

/// Header and separator of a file.
struct Header<'a> {
    line: usize,
    separator: char,
    names: Vec<&'a str>,
    columns: Vec<Column>,
}

impl Header<'_> {
    /// Name of the column that holds the readings.
    fn readings(&self) -> &str {
        let is_length = |column: &Column| matches!(column, Column::Length(_));
        self.columns.iter().position(is_length).map_or(LengthColumn::default().name(), |index| self.names[index])
    }
}

/// Reads the text of a recording; `file` is its name in messages.
pub fn recording_from_csv(
    file: &Path,
    text: &str,
    machine: &Machine,
    bar_length_mm: Option<f64>,
) -> Result<Recording, LoadError> {
    Parsed::of(file, text, machine, &Wanted::default())?.into_recording(file, machine, bar_length_mm, Rows::Plausible)
}

impl Parsed {
    fn of(file: &Path, text: &str, machine: &Machine, wanted: &Wanted) -> Result<Parsed, LoadError> {
        refuse_many_rows(file, text)?;
        let lines = || text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        let Some((first, header)) =
            lines().take(PREAMBLE_LINES).find(|(_, line)| is_header(line, wanted)).or(lines().next())
        else {
            return Err(LoadError::file(
                file,
                format!("is empty; a recording has a header such as {HEADER_EXAMPLE} and a row per sample"),
            ));
        };
        let lines = lines().skip_while(|(index, _)| *index <= first);
        let header = header_of(file, first + 1, header, machine, wanted)?;
        let mut values: Vec<Vec<f64>> = vec![Vec::new(); header.columns.len()];
        let mut leading_texts = Vec::new();
        let mut line_of_row: Vec<u32> = Vec::new();
        let mut fields = Vec::with_capacity(header.columns.len());
        for (index, line) in lines {
            fields.clear();
            fields.extend(fields_of(line, header.separator));
            read_row(file, index + 1, &header, &fields, &mut values)?;
            leading_texts.push(leading_text(&header, &fields));
            line_of_row.push((index + 1) as u32);
        }
        let Some(&last_line) = line_of_row.last() else {
            return Err(LoadError::file(file, "has a header but no row; a recording has a row per sample"));
        };
        refuse_cut_number(file, text, &header, last_line as usize)?;
        let header_line = header.line;
        Ok(Parsed { recording: assemble(&header, values, leading_texts, machine, wanted), line_of_row, header_line })
    }
}

/// Refuses a file by its lines before their numbers take memory.
fn refuse_many_rows(file: &Path, text: &str) -> Result<(), LoadError> {
    let mut rows = 0usize;
    for (index, line) in text.lines().enumerate() {
        if let Some(message) = LINE_BYTES.exceeded(line.len()) {
            return Err(LoadError::line(file, index + 1, message));
        }
        rows += usize::from(!line.trim().is_empty());
    }
    // the header is no row
    ROWS.exceeded(rows.saturating_sub(1)).map_or(Ok(()), |message| Err(LoadError::file(file, message)))
}

/// Fields of clock and positions with commas between them.
fn leading_text(header: &Header, fields: &[&str]) -> String {
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

/// Lines before the header that other programs may write, at most.
const PREAMBLE_LINES: usize = 200;

/// True for a line that names a column of readings: what stands before it is another program's preamble.
fn is_header(line: &str, wanted: &Wanted) -> bool {
    let names_one = |name: &str| match wanted.kind {
        Kind::Length => length_column(name).is_some(),
        Kind::SamePoint => ["pose", "time_s"].contains(&name),
        _ => wanted.holds(name),
    };
    let names_readings = |separator| names_of(line, separator).iter().any(|name| names_one(name));
    [';', '\t', ','].into_iter().any(names_readings)
}

fn length_column(name: &str) -> Option<LengthColumn> {
    LengthColumn::ALL.into_iter().find(|column| column.name() == name)
}

/// Fields of a line without the spaces around them; separators between quotes separate nothing.
fn fields_of(line: &str, separator: char) -> impl Iterator<Item = &str> {
    let mut quoted = false;
    line.split(move |character| {
        quoted ^= character == '"';
        character == separator && !quoted
    })
    .map(str::trim)
}

/// Names of a header, which some programs begin with a number sign.
fn names_of(line: &str, separator: char) -> Vec<&str> {
    let line = line.trim_start().trim_start_matches('#');
    fields_of(line, separator).map(|name| name.trim_matches('"').trim()).collect()
}

fn header_of<'a>(
    file: &Path,
    line: usize,
    text: &'a str,
    machine: &Machine,
    wanted: &Wanted,
) -> Result<Header<'a>, LoadError> {
    let separator = [';', '\t'].into_iter().find(|&separator| text.contains(separator)).unwrap_or(',');
    let names: Vec<&str> = names_of(text, separator);
    let refuse = |message: String| LoadError::line(file, line, message);
    if let Some(message) = COLUMNS.exceeded(names.len()) {
        return Err(refuse(message));
    }
    let mut columns = Vec::new();
    for (index, name) in names.iter().enumerate() {
        if let Some(hidden) = hidden_in(name) {
            return Err(refuse(format!(
                "column {} has the hidden character {hidden} in its name; remove it",
                index + 1
            )));
        }
        if name.chars().count() > LONGEST_HEADER {
            let start = shortened(name, LONGEST_FIELD);
            return Err(refuse(format!(
                "column '{start}' has a longer name than {LONGEST_HEADER} characters; shorten it"
            )));
        }
        if names[..index].contains(name) {
            return Err(refuse(format!("column '{name}' stands twice; each column stands once")));
        }
        columns.push(if wanted.holds(name) { Column::Part } else { column(name, machine, wanted).map_err(refuse)? });
    }
    // numbered poses stand still while they are read: a time beside the number is a channel
    if columns.contains(&Column::Pose) {
        columns.iter_mut().filter(|column| **column == Column::Time).for_each(|column| *column = Column::Channel);
    }
    let found = names.join(" ");
    let readings: Vec<&str> = columns
        .iter()
        .zip(&names)
        .filter(|(column, _)| matches!(column, Column::Length(_)))
        .map(|(_, name)| *name)
        .collect();
    if let [one, other, ..] = readings[..] {
        return Err(refuse(format!("{one} and {other} both hold readings; keep one of them")));
    }
    if wanted.kind != Kind::Length && wanted.set_in(&names).is_none() {
        return Err(refuse(no_set(wanted, &names)));
    }
    if readings.is_empty() && wanted.kind == Kind::Length {
        let hint = nearest("length_mm", &names).map(|name| format!("; '{name}' may be meant")).unwrap_or_default();
        return Err(refuse(format!(
            "no column length_mm{hint} (columns found: {found}); a header is {HEADER_EXAMPLE}"
        )));
    }
    let has_clock = columns.iter().any(|column| matches!(column, Column::Time | Column::Pose));
    let has_axis = columns.iter().any(|column| matches!(column, Column::Axis(_)));
    if has_axis && !has_clock {
        return Err(refuse(format!(
            "no column time_s, or pose for static poses (columns found: {found}); a header is {HEADER_EXAMPLE}"
        )));
    }
    Ok(Header { line, separator, names, columns })
}

/// Which columns of readings are missing.
fn no_set(wanted: &Wanted, names: &[&str]) -> String {
    let set_words = |set: &&[&str]| set.iter().map(|usual| wanted.in_file(usual)).collect::<Vec<_>>().join(" ");
    let sets: Vec<String> = wanted.kind.column_sets().iter().map(set_words).collect();
    format!(
        "a {} has the columns {} (columns found: {}); rename them, or say 'columns' in the test",
        wanted.kind.name(),
        sets.join(", or "),
        names.join(" ")
    )
}

/// What a header names.
fn column(name: &str, machine: &Machine, wanted: &Wanted) -> Result<Column, String> {
    match name {
        "time_s" => return Ok(Column::Time),
        "pose" => return Ok(Column::Pose),
        _ => {}
    }
    if let Some(readings) = length_column(name) {
        return match wanted.kind {
            Kind::Length => Ok(Column::Length(readings)),
            kind => Err(format!(
                "column '{name}' holds lengths and the test is a {}; give them a test of their own",
                kind.name()
            )),
        };
    }
    let (axis_name, unit) = name.rsplit_once('_').unwrap_or((name, ""));
    if axis_name.eq_ignore_ascii_case("deviation") {
        return Err(format!(
            "column '{name}': deviations are deviation_um or deviation_mm; rename or convert the column"
        ));
    }
    if ["length", "time", "pose"].contains(&axis_name.to_ascii_lowercase().as_str()) {
        return Err(format!(
            "column '{name}': lengths are length_mm, times time_s, static poses pose; convert the column"
        ));
    }
    if unit == "deg" && machine.carried_link(axis_name).is_some() {
        return Ok(Column::Channel);
    }
    let Some(axis) = machine.axis_index(axis_name) else {
        let looks_like_axis = matches!(unit, "mm" | "deg") && axis_name.len() <= 2;
        if looks_like_axis {
            let axes = machine.axis_names().join(" ");
            return Err(format!("column '{name}': the machine has no axis '{axis_name}'; its axes are {axes}"));
        }
        return Ok(Column::Channel);
    };
    let due = machine.axes[axis].kind.position_unit();
    if unit == due {
        Ok(Column::Axis(axis))
    } else {
        Err(format!(
            "column '{name}': positions of axis {axis_name} are {axis_name}_{due}; rename or convert the column"
        ))
    }
}

/// Adds one row's numbers to the columns.
fn read_row(
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

/// A number; an empty field is NaN; a decimal comma is accepted where the separator allows it.
fn number(field: &str, separator: char) -> Option<f64> {
    if field.is_empty() {
        return Some(f64::NAN);
    }
    plain(field, separator).parse().ok()
}

/// A field without quotes and with a decimal point.
fn plain(field: &str, separator: char) -> Cow<'_, str> {
    let bare = field.trim_matches('"').trim();
    // between quotes a comma separates nothing, whatever the separator
    let is_quoted = field.len() != bare.len();
    match (separator != ',' || is_quoted) && bare.contains(',') {
        true => Cow::Owned(bare.replacen(',', ".", 1)),
        false => Cow::Borrowed(bare),
    }
}

/// Refuses a last number that a broken transfer has cut: no line end and fewer decimals than every row before.
fn refuse_cut_number(file: &Path, text: &str, header: &Header, last_line: usize) -> Result<(), LoadError> {
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

fn assemble(
    header: &Header,
    values: Vec<Vec<f64>>,
    leading_texts: Vec<String>,
    machine: &Machine,
    wanted: &Wanted,
) -> Recording {
    let rows = values.first().map_or(0, Vec::len);
    let leading = header.columns.iter().zip(&header.names).filter(|(column, _)| column.is_leading());
    let leading: Vec<&str> = leading.map(|(_, name)| *name).collect();
    let mut recording = Recording {
        clock: Clock::Absent,
        axes: Vec::new(),
        positions: Vec::new(),
        length_mm: Vec::new(),
        channels: Vec::new(),
        leading_texts,
        leading_header: leading.join(","),
        column: LengthColumn::default(),
    };
    for ((column, list), name) in header.columns.iter().zip(values).zip(&header.names) {
        match *column {
            Column::Time => recording.clock = Clock::TimeS(list),
            Column::Pose => recording.clock = Clock::Pose(list),
            Column::Axis(axis) => {
                recording.axes.push(axis);
                let kind = machine.axes[axis].kind;
                recording.positions.push(list.into_iter().map(|value| kind.from_file_unit(value)).collect());
            }
            Column::Length(column) => (recording.column, recording.length_mm) = (column, list),
            Column::Part | Column::Channel => recording.channels.push((name.to_string(), list)),
        }
    }
    if wanted.kind != Kind::Length {
        recording.length_mm = vec![f64::NAN; rows];
    }
    if recording.axes.is_empty() {
        recording.clock = Clock::Absent;
    }
    recording
}
