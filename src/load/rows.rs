//! What the rows of a recording may say: rising times, positions inside ranges, lengths a bar can read. No text is read here.

use std::path::Path;

use super::range::outside_range;
use crate::load::checked_text::message::LoadError;
use crate::machine::Machine;
use crate::session::{LengthColumn, Recording};
use crate::statistics::median;
use crate::units::OtherUnit;

/// How far a reading may lie from the bar's calibrated length, mm: the stroke of long-range bars with room to spare.
pub(super) const STROKE_LIMIT_MM: f64 = 5.0;
/// Readings outside the stroke that a file may hold: one in so many. Single wrong readings are left to the fit, which
/// reports them; more than these are a wrong bar, unit or file.
const ONE_OUTSIDE_IN: usize = 10;
/// Two balls of usual size touch at about this distance, mm: shorter readings are no distances.
const SHORTEST_DISTANCE_MM: f64 = 5.0;

/// How far the rows of a recording are believed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rows {
    /// Positions lie in the axes' ranges and lengths in the bar's stroke, or the file is refused.
    Plausible,
    /// Taken as they are, for a search of the mistake in them.
    AsRecorded,
}

/// Checks a recording against its machine and bar; `line` gives the line of a row in the file.
pub fn check_rows(
    file: &Path,
    recording: &Recording,
    line: impl Fn(usize) -> usize,
    machine: &Machine,
    bar_length_mm: Option<f64>,
    rows: Rows,
) -> Result<(), LoadError> {
    if recording.readings() == 0 {
        let column = recording.column.name();
        return Err(LoadError::file(file, format!("has no reading: every {column} is empty")));
    }
    if let (Some(bar), Rows::Plausible, false) = (bar_length_mm, rows, recording.column.is_deviation()) {
        refuse_swapped(file, recording, machine, bar)?;
    }
    check_clock(file, recording, &line)?;
    if rows == Rows::AsRecorded {
        return Ok(());
    }
    check_positions(file, recording, &line, machine)?;
    match bar_length_mm {
        Some(bar) => refuse_outside_stroke(file, recording, line, bar),
        None => refuse_no_distances(file, recording),
    }
}

/// The same for readings of other kinds than lengths: their own numbers are judged where they are read.
pub fn check_rows_of_parts(
    file: &Path,
    recording: &Recording,
    line: impl Fn(usize) -> usize,
    machine: &Machine,
    rows: Rows,
) -> Result<(), LoadError> {
    check_clock(file, recording, &line)?;
    match rows {
        Rows::AsRecorded => Ok(()),
        Rows::Plausible => check_positions(file, recording, &line, machine),
    }
}

/// Times rise.
fn check_clock(file: &Path, recording: &Recording, line: &impl Fn(usize) -> usize) -> Result<(), LoadError> {
    if let Some(time) = recording.time_s()
        && let Some(row) = (1..time.len()).find(|&row| time[row] <= time[row - 1])
    {
        let (before, now) = (time[row - 1], time[row]);
        let message = format!("time_s goes from {before} to {now}; times rise from row to row, sort or split the file");
        return Err(LoadError::line(file, line(row), message));
    }
    Ok(())
}

/// Positions lie in the axes' ranges.
fn check_positions(
    file: &Path,
    recording: &Recording,
    line: &impl Fn(usize) -> usize,
    machine: &Machine,
) -> Result<(), LoadError> {
    for (&axis, column) in recording.axes.iter().zip(&recording.positions) {
        for (row, &value) in column.iter().enumerate() {
            if let Some(message) = outside_range(machine, axis, value) {
                return Err(LoadError::line(file, line(row), message));
            }
        }
    }
    Ok(())
}

/// A column that holds lengths under another name while length_mm does not.
fn refuse_swapped(file: &Path, recording: &Recording, machine: &Machine, bar: f64) -> Result<(), LoadError> {
    let is_length = |value: f64| (value - bar).abs() <= STROKE_LIMIT_MM;
    let lengths = || recording.length_mm.iter().copied();
    if is_length(median(lengths()).unwrap_or(f64::NAN)) {
        return Ok(());
    }
    let time = recording.time_s().map(|time| ("time_s".to_string(), time.to_vec()));
    let positions = recording.axes.iter().zip(&recording.positions).map(|(&axis, column)| {
        let axis = &machine.axes[axis];
        let values = column.iter().map(|&value| axis.kind.to_file_unit(value)).collect();
        (format!("{}_{}", axis.name, axis.kind.position_unit()), values)
    });
    // every row of the column: a sweep only passes the bar's length somewhere
    let holds_lengths = |values: &Vec<f64>| values.iter().all(|&value| is_length(value));
    match time.into_iter().chain(positions).find(|(_, values)| holds_lengths(values)) {
        Some((name, values)) => Err(LoadError::line(
            file,
            1,
            format!(
                "the columns {name} and length_mm seem swapped: {name} holds about {:.4}, the bar's length is {bar} mm, length_mm holds about {:.4}; correct the header",
                median(values.into_iter()).unwrap_or(f64::NAN),
                median(lengths()).unwrap_or(f64::NAN)
            ),
        )),
        None => Ok(()),
    }
}

fn refuse_outside_stroke(
    file: &Path,
    recording: &Recording,
    line: impl Fn(usize) -> usize,
    bar: f64,
) -> Result<(), LoadError> {
    if recording.column == LengthColumn::DeviationUm {
        refuse_in_other_unit(file, recording, bar)?;
    }
    let is_outside = |length: &f64| length.is_finite() && (length - bar).abs() > STROKE_LIMIT_MM;
    let outside = recording.length_mm.iter().filter(|length| is_outside(length)).count();
    let readings = recording.readings();
    if outside <= (readings / ONE_OUTSIDE_IN).max(1).min(readings - 1) {
        return Ok(());
    }
    let stroke = format!("bar_length is {bar} mm and a reading lies within ±{STROKE_LIMIT_MM} mm of it");
    let middle = median(recording.length_mm.iter().copied()).unwrap_or(f64::NAN);
    if outside == readings {
        let near = |factor: f64| (middle * factor - bar).abs() <= STROKE_LIMIT_MM;
        if recording.column.is_deviation() {
            return Err(LoadError::file(file, no_deviations(recording, middle - bar, bar, &stroke)));
        }
        let unit = [OtherUnit::METRES, OtherUnit::INCHES].into_iter().find(|unit| near(unit.size));
        let hint = if let Some(OtherUnit { name, .. }) = unit {
            &format!("the column seems to be in {name}, length_mm is in mm")
        } else if middle.abs() <= STROKE_LIMIT_MM {
            "the column seems to be the deviation, length_mm is the absolute ball-to-ball length; name it deviation_mm"
        } else {
            "check bar_length and which recording belongs to the test"
        };
        return Err(LoadError::file(file, format!("readings are about {middle} mm but {stroke}; {hint}")));
    }
    let row = recording.length_mm.iter().position(is_outside).unwrap_or(0);
    Err(LoadError::line(
        file,
        line(row),
        format!(
            "{} {} is the first of {outside} readings out of {readings} outside the bar's stroke: {stroke}; one in {ONE_OUTSIDE_IN} may be wrong, check the recording",
            recording.column.name(),
            recording.in_column(recording.length_mm[row], bar)
        ),
    ))
}

/// Deviations that are all smaller than this are in another unit, µm: balls are set to tens of micrometres, and gauges read to 0.1.
const LEAST_DEVIATION_UM: f64 = 0.5;

/// Deviations in µm that no gauge could tell from zero, and that are not zero throughout.
fn refuse_in_other_unit(file: &Path, recording: &Recording, bar: f64) -> Result<(), LoadError> {
    let finite = recording.length_mm.iter().filter(|length| length.is_finite());
    let largest_um = finite.map(|length| 1e3 * (length - bar).abs()).fold(0.0, f64::max);
    // lengths near a bar's are doubles: computed zeros are smaller than 1e-6
    if !(1e-4..LEAST_DEVIATION_UM).contains(&largest_um) {
        return Ok(());
    }
    let found = format!(
        "the largest reading of {} is {largest_um:.4} µm, where gauges tell 0.1 µm and balls are set to tens of µm; the column seems to be in mm, name it deviation_mm",
        recording.column.name()
    );
    Err(LoadError::file(file, found))
}

/// Why a column of deviations, all outside the stroke, holds something else.
fn no_deviations(recording: &Recording, middle_mm: f64, bar: f64, stroke: &str) -> String {
    let column = recording.column;
    let found = middle_mm / column.unit_mm();
    let hint = if (found - bar).abs() <= STROKE_LIMIT_MM {
        "the column seems to hold absolute lengths, name it length_mm"
    } else if column == LengthColumn::DeviationMm && (middle_mm * 1e-3).abs() <= STROKE_LIMIT_MM {
        "the column seems to be in µm, name it deviation_um"
    } else {
        "check which recording belongs to the test"
    };
    format!("readings of {} are about {found} but {stroke}; {hint}", column.name())
}

/// Without a bar the readings are absolute distances: they cannot be shorter than two balls.
fn refuse_no_distances(file: &Path, recording: &Recording) -> Result<(), LoadError> {
    let middle = median(recording.length_mm.iter().copied()).unwrap_or(f64::NAN);
    if middle >= SHORTEST_DISTANCE_MM {
        return Ok(());
    }
    Err(LoadError::file(
        file,
        format!(
            "readings are about {middle} mm, shorter than two balls can be apart ({SHORTEST_DISTANCE_MM} mm); length_mm is the absolute ball-to-ball length in mm, convert metres or deviations"
        ),
    ))
}
