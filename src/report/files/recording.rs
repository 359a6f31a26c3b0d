//! Recordings as CSV that `load` reads. It keeps the rows, order, position columns and channels of the recording it stands for.

use std::fmt::Write as _;
use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use crate::machine::Machine;
use crate::readings::{Kind, LEVER_MM, Part, euler_xyz, quaternion, rotation};
use crate::session::{LengthColumn, Motion, Recording, Test};

/// Readings of a test as CSV, in the unit and from the origin of `column`: with the clock and position columns of its own
/// recording and its channels where it has them, else those of its path. A reading that is not finite is left empty.
pub fn recording_csv(
    machine: &Machine,
    test: &Test,
    motion: &Motion,
    length_mm: &[f64],
    column: LengthColumn,
) -> String {
    let bar_mm = test.bar_length_mm;
    match &test.recording {
        Some(recording) => {
            let has_leading = !recording.leading_header.is_empty();
            let header = if has_leading { format!("{},", recording.leading_header) } else { String::new() };
            let mut text = format!("{header}{}{}\n", channel_names(recording), column.name());
            for (row, length) in length_mm.iter().enumerate() {
                if has_leading {
                    let Some(leading) = recording.leading_texts.get(row) else { break };
                    let _ = write!(text, "{leading},");
                }
                let _ = writeln!(text, "{}{}", channels_at(recording, row), field(*length, column, bar_mm));
            }
            text
        }
        None => path_csv(machine, test, motion, length_mm, column),
    }
}

/// Headers of a recording's further columns, each with a comma behind it.
fn channel_names(recording: &Recording) -> String {
    let quoted = |name: &String| match name.contains([',', '"', ';', '\t']) {
        true => format!("\"{}\",", name.replace('"', "\"\"")),
        false => format!("{name},"),
    };
    recording.channels.iter().map(|(name, _)| quoted(name)).collect()
}

/// What they hold at a row: it was measured beside the readings, so a simulation repeats it.
fn channels_at(recording: &Recording, row: usize) -> String {
    let value = |values: &Vec<f64>| values.get(row).copied().filter(|value| value.is_finite());
    let field =
        |(_, values): &(String, Vec<f64>)| value(values).map_or_else(|| ",".into(), |value| format!("{value},"));
    recording.channels.iter().map(field).collect()
}

/// Readings with a time and the positions of the moving axes.
pub fn path_csv(machine: &Machine, test: &Test, motion: &Motion, length_mm: &[f64], column: LengthColumn) -> String {
    let headers: Vec<String> = motion
        .moving
        .iter()
        .map(|&axis| format!("{}_{}", machine.axes[axis].name, machine.axes[axis].kind.position_unit()))
        .collect();
    let mut text = format!("time_s,{},{}\n", headers.join(","), column.name());
    let decimals = time_decimals(motion.time_s.as_deref().unwrap_or_default());
    for (row, length) in length_mm.iter().enumerate() {
        let time = motion.time_s.as_ref().map_or(row as f64, |time| time[row]);
        let _ = write!(text, "{time:.decimals$}");
        for &axis in &motion.moving {
            // positions as fine as the lengths: a coarser command would be another motion
            let _ = write!(text, ",{:.9}", machine.axes[axis].kind.to_file_unit(motion.row(row)[axis]));
        }
        let _ = writeln!(text, ",{}", field(*length, column, test.bar_length_mm));
    }
    text
}

/// Decimals of times: 0.1 ms, and finer where rows follow each other faster, to a hundredth of the least step.
fn time_decimals(time_s: &[f64]) -> usize {
    const USUAL: f64 = 4.0;
    const FINEST: f64 = 15.0;
    let steps = time_s.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0);
    let least = steps.fold(1.0, f64::min);
    (2.0 - least.log10()).ceil().clamp(USUAL, FINEST) as usize
}

/// A reading to 1e-10 mm, empty when there is none.
fn field(length_mm: f64, column: LengthColumn, bar_mm: Option<f64>) -> String {
    if !length_mm.is_finite() {
        return String::new();
    }
    let value = (length_mm - column.origin_mm(bar_mm.unwrap_or(0.0))) / column.unit_mm();
    match column {
        LengthColumn::DeviationUm => format!("{value:.7}"),
        _ => format!("{value:.10}"),
    }
}

/// Readings of several numbers as CSV: with the clock and position columns of their recording and its channels, then the columns that held the
/// readings. `numbers` are the values of each number of the kind, row by row, turns counted from the rotation that was read.
pub fn parts_csv(machine: &Machine, test: &Test, part: &Part, motion: &Motion, numbers: &[&[f64]]) -> String {
    let columns: Vec<String> = match part.columns.is_empty() {
        false => part.columns.to_vec(),
        true => part.kind.column_sets()[0].iter().map(|name| name.to_string()).collect(),
    };
    let (header, leading) = leading(machine, test, motion);
    let names = test.recording.as_ref().map(channel_names).unwrap_or_default();
    let mut text = format!("{header},{names}{}\n", columns.join(","));
    text = text.trim_end_matches([',', '\n']).to_string() + "\n";
    let coordinates = part.kind.scalars().iter().filter(|scalar| !scalar.is_turn()).count();
    for (row, leading) in leading.iter().enumerate() {
        let mut fields: Vec<f64> = numbers.iter().take(coordinates).map(|values| values[row]).collect();
        if part.kind == Kind::SamePoint {
            fields.clear();
        }
        if let [x, y, z] = numbers[coordinates.min(numbers.len())..] {
            let turn = Vector3::new(x[row], y[row], z[row]) / LEVER_MM;
            let read = part.measured.get(row).copied().unwrap_or_else(Matrix3::identity);
            fields.extend(rotation_fields(&(rotation(&turn) * read), columns.len() - coordinates));
        }
        let channels = test.recording.as_ref().map(|recording| channels_at(recording, row)).unwrap_or_default();
        let _ = match channels.strip_suffix(',') {
            Some(channels) => write!(text, "{leading},{channels}"),
            None => write!(text, "{leading}"),
        };
        for field in fields {
            let _ = if field.is_finite() { write!(text, ",{field:.10}") } else { write!(text, ",") };
        }
        text.push('\n');
    }
    text
}

/// A recording with some columns as another one of the same rows has them: two instruments may be read into one file. A column that it has not is
/// added. `None` where the other has none either, or rows differ.
pub fn with_columns_of(text: &str, other: &str, columns: &[String]) -> Option<String> {
    let header = text.lines().next()?;
    let place = |header: &str, column: &String| header.split(',').position(|name| name == column);
    let of_column = |column: &String| Some((place(header, column), place(other.lines().next()?, column)?));
    let places: Vec<(Option<usize>, usize)> = columns.iter().map(of_column).collect::<Option<_>>()?;
    let are_alike = !places.is_empty() && text.lines().count() == other.lines().count();
    let row = |(line, other): (&str, &str)| {
        let mut fields: Vec<&str> = line.split(',').collect();
        let others: Vec<&str> = other.split(',').collect();
        for &(to, from) in &places {
            match to {
                Some(to) => *fields.get_mut(to)? = others.get(from)?,
                None => fields.push(others.get(from)?),
            }
        }
        Some(fields.join(",") + "\n")
    };
    text.lines().zip(other.lines()).map(row).collect::<Option<String>>().filter(|_| are_alike)
}

/// A rotation in the columns that a file has for it.
fn rotation_fields(rotation: &Matrix3<f64>, columns: usize) -> Vec<f64> {
    match columns {
        4 => quaternion(rotation).to_vec(),
        3 => euler_xyz(rotation).map(f64::to_degrees).to_vec(),
        _ => rotation.transpose().iter().copied().collect(),
    }
}

/// Header and rows of clock and positions: the recording's own texts, or those of the motion.
fn leading(machine: &Machine, test: &Test, motion: &Motion) -> (String, Arc<Vec<String>>) {
    if let Some(recording) = test.recording.as_ref().filter(|recording| !recording.leading_header.is_empty()) {
        return (recording.leading_header.clone(), recording.leading_texts.clone());
    }
    let names = motion.moving.iter().map(|&axis| {
        let axis = &machine.axes[axis];
        format!("{}_{}", axis.name, axis.kind.position_unit())
    });
    let names: Vec<String> = names.collect();
    let clock = if motion.time_s.is_some() { "time_s" } else { "pose" };
    let decimals = time_decimals(motion.time_s.as_deref().unwrap_or_default());
    let rows = (0..motion.rows()).map(|row| {
        let mut text = match &motion.time_s {
            Some(time) => format!("{:.decimals$}", time[row]),
            None => row.to_string(),
        };
        for &axis in &motion.moving {
            let _ = write!(text, ",{:.9}", machine.axes[axis].kind.to_file_unit(motion.row(row)[axis]));
        }
        text
    });
    (format!("{clock},{}", names.join(",")), Arc::new(rows.collect()))
}
