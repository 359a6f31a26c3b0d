//! Recordings (CSV) to a [`Recording`]: separators, headers and numbers. What the rows may say is judged in `rows`.

mod fields;
mod header;
mod row;

use std::path::Path;

use self::header::{Column, HEADER_EXAMPLE, Header, header_of, is_header};
use self::row::{leading_text, read_row};
use super::rows::{Rows, check_rows, check_rows_of_parts};
use crate::load::checked_text::cut_number::refuse_cut_number;
use crate::load::checked_text::fields::fields_of;
use crate::load::checked_text::limits::{CSV_BYTES, LINE_BYTES, ROWS};
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::text::read_limited;
use crate::machine::Machine;
use crate::readings::Kind;
use crate::session::{Clock, LengthColumn, Recording};

pub(super) use self::header::{Wanted, says_where};

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

/// Lines before the header that other programs may write, at most.
const PREAMBLE_LINES: usize = 200;

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
    /// Reads a text; `file` is its name in messages.
    fn of(file: &Path, text: &str, machine: &Machine, wanted: &Wanted) -> Result<Parsed, LoadError> {
        refuse_many_rows(file, text)?;
        let lines = || text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        let Some((first, header)) =
            lines().take(PREAMBLE_LINES + 1).find(|(_, line)| is_header(line, wanted)).or(lines().next())
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
        if line_of_row.is_empty() {
            return Err(LoadError::file(file, "has a header but no row; a recording has a row per sample"));
        }
        refuse_cut_number(file, text, header.line, header.separator)?;
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

/// The columns in their places.
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
        leading_texts: leading_texts.into(),
        leading_header: leading.join(","),
        column: LengthColumn::default(),
        scatter: None,
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
