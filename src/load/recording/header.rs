//! The header of a recording: what its columns hold, and which of them are wanted. It reads no numbers.

use std::path::Path;

use crate::load::checked_text::fields::fields_of;
use crate::load::checked_text::limits::COLUMNS;
use crate::load::checked_text::message::{LoadError, nearest};
use crate::load::checked_text::printable::{LONGEST_SHOWN, hidden_in, shortened};
use crate::machine::Machine;
use crate::readings::Kind;
use crate::session::LengthColumn;

/// Columns in which readings are looked for.
#[derive(Clone, Default)]
pub struct Wanted {
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

    /// Sets of columns that may hold the readings, under their names in the file, the usual one first.
    pub fn sets(&self) -> impl Iterator<Item = Vec<String>> + '_ {
        let own = |set: &&[&str]| set.iter().map(|usual| self.in_file(usual).to_string()).collect();
        self.kind.column_sets().iter().map(own)
    }

    /// The set of columns that a header has, under their names in the file.
    pub fn set_in(&self, names: &[&str]) -> Option<Vec<String>> {
        self.sets().find(|set| set.iter().all(|name| names.contains(&name.as_str())))
    }
}

/// What a column holds.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Column {
    Time,
    Pose,
    Axis(usize),
    Length(LengthColumn),
    /// A number of a reading of several.
    Part,
    Channel,
}

impl Column {
    /// True for what says where and when a row was read.
    pub fn is_leading(self) -> bool {
        matches!(self, Column::Time | Column::Pose | Column::Axis(_))
    }

    /// True where a field may be missing.
    pub fn may_be_empty(self) -> bool {
        matches!(self, Column::Length(_) | Column::Part | Column::Channel)
    }
}

/// Longest header, characters.
const LONGEST_HEADER: usize = 100;
/// What a header looks like, for messages.
pub const HEADER_EXAMPLE: &str = "time_s,A_deg,length_mm";

/// Header and separator of a file.
pub struct Header<'a> {
    pub line: usize,
    pub separator: char,
    pub names: Vec<&'a str>,
    pub columns: Vec<Column>,
}

impl Header<'_> {
    /// Name of the column that holds the readings.
    pub fn readings(&self) -> &str {
        let is_length = |column: &Column| matches!(column, Column::Length(_));
        self.columns.iter().position(is_length).map_or(LengthColumn::default().name(), |index| self.names[index])
    }
}

/// True for a line that names a column of readings: what stands before it is another program's preamble.
pub fn is_header(line: &str, wanted: &Wanted) -> bool {
    let names_one = |name: &str| match wanted.kind {
        Kind::Length => length_column(name).is_some(),
        Kind::SamePoint => ["pose", "time_s"].contains(&name),
        _ => wanted.holds(name),
    };
    let names_readings = |separator| names_of(line, separator).iter().any(|name| names_one(name));
    [';', '\t', ','].into_iter().any(names_readings)
}

/// The column of lengths of a name.
fn length_column(name: &str) -> Option<LengthColumn> {
    LengthColumn::ALL.into_iter().find(|column| column.name() == name)
}

/// Names of a header, which some programs begin with a number sign.
fn names_of(line: &str, separator: char) -> Vec<&str> {
    let line = line.trim_start().trim_start_matches('#');
    fields_of(line, separator).map(|name| name.trim_matches('"').trim()).collect()
}

/// The header that a line is, when it has the columns that a recording needs.
pub fn header_of<'a>(
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
            let start = shortened(name, LONGEST_SHOWN);
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

/// Whether a name is that of a column which says when a row was read or where an axis stood.
pub fn says_where(name: &str, machine: &Machine) -> bool {
    column(name, machine, &Wanted::default()).is_ok_and(Column::is_leading)
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
