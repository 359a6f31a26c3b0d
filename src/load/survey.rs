//! Shard files of a survey to outcomes: a line that says of which survey and shard, a header, a row per topology. It plans nothing.

use std::path::Path;

use crate::load::checked_text::limits::YAML_BYTES;
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::text::read_limited;
use crate::machine::StructuralCode;
use crate::plan::OnePivot;
use crate::survey::{Family, Outcome, Shard};
use crate::units::Measure;

/// What a shard file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct ShardFile {
    /// Conditions of the survey, as its first line states them.
    pub conditions: String,
    pub shard: Shard,
    /// Rows in the file's order.
    pub outcomes: Vec<Outcome>,
    /// Bytes up to the end of the last whole line.
    pub whole_bytes: u64,
    /// A last line without its end: the run that wrote it was stopped.
    pub torn: bool,
}

/// First line of a shard file, without the line's end.
pub fn shard_title(conditions: &str, shard: Shard) -> String {
    format!("# {conditions}; shard {shard}")
}

/// Reads a shard file; `header` is the line of column names it must have.
pub fn load_shard(file: &Path, header: &str) -> Result<ShardFile, LoadError> {
    let text = read_limited(file, YAML_BYTES)?;
    let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
    let torn = whole.len() < text.len();
    let mut lines = whole.lines();
    let title = lines.next().and_then(|line| line.strip_prefix("# ")?.rsplit_once("; shard "));
    let (conditions, shard) = title.ok_or_else(|| {
        LoadError::line(file, 1, "is no shard of a survey; its first line says of which survey it is; name folders that 'fiveaxis survey --shard' wrote")
    })?;
    let shard = Shard::parse(shard).map_err(|why| LoadError::line(file, 1, why.to_string()))?;
    if let Some(found) = lines.next().filter(|found| *found != header) {
        let found: String = found.chars().take(60).collect();
        return Err(LoadError::line(
            file,
            2,
            format!(
                "has the columns '{found}…', which this version does not write; run the shard again with this version"
            ),
        ));
    }
    let outcomes = lines
        .enumerate()
        .map(|(index, line)| outcome(line).map_err(|why| LoadError::line(file, index + 3, why)))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(ShardFile { conditions: conditions.to_string(), shard, outcomes, whole_bytes: whole.len() as u64, torn })
}

fn outcome(line: &str) -> Result<Outcome, String> {
    let cells: Vec<&str> = line.split(',').collect();
    const CELLS: usize = 15;
    if cells.len() != CELLS {
        return Err(format!("has {} cells, a row has {CELLS}; delete the file and run the shard again", cells.len()));
    }
    let damaged = |what: &str, cell: &str| {
        let cell: String = cell.chars().take(40).collect();
        format!("has '{cell}' for {what}; the file was changed or damaged, delete it and run the shard again")
    };
    let count = |index: usize, what: &str| cells[index].parse::<usize>().map_err(|_| damaged(what, cells[index]));
    let number = |index: usize, what: &str| {
        cells[index]
            .parse::<f64>()
            .ok()
            .filter(|x| x.is_finite() && *x >= 0.0)
            .ok_or_else(|| damaged(what, cells[index]))
    };
    let optional = |index: usize, what: &str| match cells[index] {
        "" => Ok(None),
        _ => number(index, what).map(Some),
    };
    let code = StructuralCode::parse(cells[0]).map_err(|_| damaged("code", cells[0]))?;
    let family = Family::of(&code);
    if cells[1] != family.name() {
        return Err(damaged("family", cells[1]));
    }
    let one_pivot = match (cells[11], optional(12, "one_pivot_minutes")?) {
        ("", None) => None,
        (_, Some(minutes)) => Some(OnePivot { determined: count(11, "one_pivot_determined")?, minutes }),
        (cell, None) => return Err(damaged("one_pivot_determined", cell)),
    };
    let read = Outcome {
        family,
        errors: count(2, "errors")?,
        visible: count(3, "visible")?,
        determined: count(4, "determined")?,
        undetermined: cells[5].split_whitespace().map(str::to_string).collect(),
        tests: count(6, "tests")?,
        pivot_setups: count(7, "pivot_setups")?,
        minutes: number(8, "minutes")?,
        position_mm: optional(9, "worst_position_um")?.map(|um| um / Measure::Length.to_output(1.0)),
        orientation_rad: optional(10, "worst_orientation_arcsec")?.map(|arcsec| arcsec / Measure::Angle.to_output(1.0)),
        one_pivot,
        considered: count(14, "setups_considered")?,
        code,
    };
    let verdict = if read.is_fully_tested_from_one_pivot() { "yes" } else { "no" };
    if cells[13] != verdict {
        return Err(damaged("fully_tested_from_one_pivot", cells[13]));
    }
    Ok(read)
}
