//! Recordings (CSV) to a [`Recording`]; decimal commas and semicolons are accepted, rows that make no sense are refused.

use std::path::Path;

use super::message::{LoadError, nearest};
use super::range::outside_range;
use super::text::{MAX_CSV_BYTES, read_limited};
use crate::machine::Machine;
use crate::session::{Clock, Recording};

/// Reads a recording; `bar_length_mm` is the calibrated length that readings must lie near to.
pub fn load_recording(file: &Path, machine: &Machine, bar_length_mm: Option<f64>) -> Result<Recording, LoadError> {
    recording_from_csv(file, &read_limited(file, MAX_CSV_BYTES)?, machine, bar_length_mm)
}

/// How far a reading may lie from the bar's calibrated length, mm: the stroke of long-range bars with room to spare.
const STROKE_LIMIT_MM: f64 = 5.0;

/// What a column holds.
enum Column {
    Time,
    Pose,
    Axis(usize),
    Length,
    Channel,
}

/// Reads the text of a recording; `file` is its name in messages.
pub fn recording_from_csv(
    file: &Path,
    text: &str,
    machine: &Machine,
    bar_length_mm: Option<f64>,
) -> Result<Recording, LoadError> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let Some((_, header)) = lines.next() else {
        return Err(LoadError::file(
            file,
            "is empty; a recording has a header such as time_s,A_deg,length_mm and a row per sample",
        ));
    };
    let separator = if header.contains(';') {
        ';'
    } else if header.contains('\t') {
        '\t'
    } else {
        ','
    };
    let names: Vec<&str> = header.split(separator).map(|name| name.trim().trim_matches('"')).collect();
    let columns = columns(file, &names, machine)?;
    let mut values: Vec<Vec<f64>> = vec![Vec::new(); columns.len()];
    let mut leading_texts = Vec::new();
    for (index, line) in lines {
        let fields: Vec<&str> = line.split(separator).collect();
        if fields.len() != columns.len() {
            return Err(LoadError::line(
                file,
                index + 1,
                format!(
                    "has {} fields where the header has {}; the line may be cut off, or decimal commas stand in a file separated by commas",
                    fields.len(),
                    columns.len()
                ),
            ));
        }
        for ((column, field), name) in columns.iter().zip(&fields).zip(&names) {
            let value = number(field.trim(), separator).ok_or_else(|| {
                LoadError::line(file, index + 1, format!("column {name}: '{}' is not a number", field.trim()))
            })?;
            let may_be_missing = matches!(column, Column::Length | Column::Channel);
            let is_missing = may_be_missing && field.trim().is_empty();
            if !value.is_finite() && !is_missing {
                return Err(LoadError::line(
                    file,
                    index + 1,
                    format!(
                        "column {name}: '{}' is not a finite number; leave the field empty for a missing reading",
                        field.trim()
                    ),
                ));
            }
        }
        for (list, field) in values.iter_mut().zip(&fields) {
            list.push(number(field.trim(), separator).unwrap_or(f64::NAN));
        }
        let leading: Vec<String> = columns
            .iter()
            .zip(&fields)
            .filter(|(column, _)| is_leading(column))
            // written again they stand between commas
            .map(|(_, field)| field.trim().replace(',', "."))
            .collect();
        leading_texts.push(leading.join(","));
    }
    if leading_texts.is_empty() {
        return Err(LoadError::file(file, "has a header but no row"));
    }
    let leading: Vec<&str> =
        columns.iter().zip(&names).filter(|(column, _)| is_leading(column)).map(|(_, name)| *name).collect();
    let mut recording = Recording {
        clock: Clock::Absent,
        axes: Vec::new(),
        positions: Vec::new(),
        length_mm: Vec::new(),
        channels: Vec::new(),
        leading_texts,
        leading_header: leading.join(","),
    };
    for ((column, list), name) in columns.into_iter().zip(values).zip(&names) {
        match column {
            Column::Time => recording.clock = Clock::TimeS(list),
            Column::Pose => recording.clock = Clock::Pose(list),
            Column::Axis(axis) => {
                recording.axes.push(axis);
                let kind = machine.axes[axis].kind;
                recording.positions.push(list.into_iter().map(|value| kind.from_file_unit(value)).collect());
            }
            Column::Length => recording.length_mm = list,
            Column::Channel => recording.channels.push((name.to_string(), list)),
        }
    }
    if recording.axes.is_empty() {
        recording.clock = Clock::Absent;
    }
    check_rows(file, &recording, machine, bar_length_mm)?;
    Ok(recording)
}

fn is_leading(column: &Column) -> bool {
    matches!(column, Column::Time | Column::Pose | Column::Axis(_))
}

/// Meaning of each header; the length and at least a clock or the length alone are required.
fn columns(file: &Path, names: &[&str], machine: &Machine) -> Result<Vec<Column>, LoadError> {
    let mut seen: Vec<&str> = Vec::new();
    let mut columns = Vec::new();
    for name in names {
        if seen.contains(name) {
            return Err(LoadError::line(file, 1, format!("column '{name}' stands twice")));
        }
        seen.push(name);
        columns.push(column(file, name, machine)?);
    }
    if !columns.iter().any(|column| matches!(column, Column::Length)) {
        let hint = nearest("length_mm", names).map(|name| format!("; '{name}' may be meant")).unwrap_or_default();
        return Err(LoadError::line(file, 1, format!("no column length_mm{hint}; a header is time_s,A_deg,length_mm")));
    }
    let has_clock = columns.iter().any(|column| matches!(column, Column::Time | Column::Pose));
    let has_axis = columns.iter().any(|column| matches!(column, Column::Axis(_)));
    if has_axis && !has_clock {
        return Err(LoadError::line(
            file,
            1,
            "no column time_s (or pose, for static poses); a header is time_s,A_deg,length_mm",
        ));
    }
    Ok(columns)
}

fn column(file: &Path, name: &str, machine: &Machine) -> Result<Column, LoadError> {
    match name {
        "time_s" => return Ok(Column::Time),
        "pose" => return Ok(Column::Pose),
        "length_mm" => return Ok(Column::Length),
        _ => {}
    }
    let Some((axis_name, unit)) = name.rsplit_once('_') else {
        return Ok(Column::Channel);
    };
    if axis_name == "length" || axis_name == "time" {
        return Err(LoadError::line(
            file,
            1,
            format!("column '{name}': lengths are length_mm and times time_s; convert the column"),
        ));
    }
    let Some(axis) = machine.axis_index(axis_name) else {
        if matches!(unit, "mm" | "deg") && axis_name.len() <= 2 {
            return Err(LoadError::line(
                file,
                1,
                format!(
                    "column '{name}': the machine has no axis '{axis_name}'; its axes are {}",
                    machine.axis_names().join(" ")
                ),
            ));
        }
        return Ok(Column::Channel);
    };
    let due = machine.axes[axis].kind.position_unit();
    if unit == due {
        Ok(Column::Axis(axis))
    } else {
        Err(LoadError::line(file, 1, format!("column '{name}': positions of axis {axis_name} are {axis_name}_{due}")))
    }
}

/// A number; an empty field is NaN; a decimal comma is accepted where the separator allows it.
fn number(field: &str, separator: char) -> Option<f64> {
    let field = field.trim_matches('"');
    if field.is_empty() {
        return Some(f64::NAN);
    }
    if separator != ',' && field.contains(',') {
        return field.replacen(',', ".", 1).parse().ok();
    }
    field.parse().ok()
}

/// Times that rise, positions inside ranges, readings near the bar's length.
fn check_rows(
    file: &Path,
    recording: &Recording,
    machine: &Machine,
    bar_length_mm: Option<f64>,
) -> Result<(), LoadError> {
    if let Some(time) = recording.time_s()
        && let Some(row) = (1..time.len()).find(|&row| time[row] <= time[row - 1])
    {
        return Err(LoadError::line(
            file,
            row + 2,
            format!("time_s goes from {} back to {}; times rise from row to row", time[row - 1], time[row]),
        ));
    }
    for (&axis, column) in recording.axes.iter().zip(&recording.positions) {
        for (row, &value) in column.iter().enumerate() {
            if let Some(message) = outside_range(machine, axis, value) {
                return Err(LoadError::line(file, row + 2, message));
            }
        }
    }
    if recording.readings() == 0 {
        return Err(LoadError::file(file, "has no reading: every length_mm is empty"));
    }
    let Some(bar) = bar_length_mm else { return Ok(()) };
    let mut finite: Vec<f64> = recording.length_mm.iter().copied().filter(|length| length.is_finite()).collect();
    finite.sort_by(f64::total_cmp);
    let median = finite[finite.len() / 2];
    if (median - bar).abs() > STROKE_LIMIT_MM {
        let hint = if (median * 1000.0 - bar).abs() < STROKE_LIMIT_MM {
            "the column seems to be in metres; length_mm is in mm"
        } else if (median * 25.4 - bar).abs() < STROKE_LIMIT_MM {
            "the column seems to be in inches; length_mm is in mm"
        } else if median.abs() < STROKE_LIMIT_MM {
            "the column seems to be the deviation; length_mm is the absolute ball-to-ball length"
        } else {
            "check bar_length and the recording's file name"
        };
        return Err(LoadError::file(
            file,
            format!(
                "readings are about {median} mm but the bar is {bar} mm with a stroke of at most ±{STROKE_LIMIT_MM} mm; {hint}"
            ),
        ));
    }
    Ok(())
}
