//! What a correction of a program did, in words and JSON.

use std::fmt::Write as _;

use serde_json::{Value, json};

use crate::compensate::{LETTERS, Summary};
use crate::machine::Machine;
use crate::units::{ARCSEC_PER_RAD, UM_PER_MM};

/// Blocks that stay, told in words up to this many.
const MOST_BLOCKS_TOLD: usize = 10;
/// Directions that stay off by less are told as met, arcsec.
const MET_ARCSEC: f64 = 0.01;

/// Changes by letter in µm or arcsec.
fn changes(summary: &Summary) -> Vec<(char, f64, &'static str, u64)> {
    let with_unit = |(k, largest): (usize, &crate::compensate::Largest)| {
        let (value, unit) = match (3..6).contains(&k) {
            true => (largest.amount.to_radians() * ARCSEC_PER_RAD, "arcsec"),
            false => (largest.amount * UM_PER_MM, "µm"),
        };
        (LETTERS[k] as char, value, unit, largest.line)
    };
    summary.changed.iter().enumerate().filter(|(_, largest)| largest.line > 0).map(with_unit).collect()
}

/// In words.
pub fn summary_text(machine: &Machine, summary: &Summary, file: &str) -> String {
    let mut text = format!(
        "{}: {} lines read, {} moves corrected, written as {} blocks in {file}\n",
        machine.name, summary.lines, summary.moves, summary.blocks
    );
    if summary.left > 0 {
        let _ =
            writeln!(text, "{} moves stay: to machine coordinates, or before every axis had a position", summary.left);
    }
    let changes: Vec<String> = changes(summary)
        .iter()
        .map(|(letter, value, unit, line)| format!("{letter} {value:.1} {unit} (line {line})"))
        .collect();
    if !changes.is_empty() {
        let _ = writeln!(text, "largest changes: {}", changes.join(", "));
    }
    let off = summary.off.amount * ARCSEC_PER_RAD;
    match off > MET_ARCSEC {
        true => {
            let _ = writeln!(
                text,
                "the tool's direction stays off by up to {off:.1} arcsec (line {}): no small turn of the rotary axes takes that away there",
                summary.off.line
            );
        }
        false => text.push_str("the tool's direction is met everywhere\n"),
    }
    if summary.starts_off.line > 0 {
        let _ = writeln!(
            text,
            "the feed move in line {} starts {:.1} µm beside its path, the largest of such: the rapid before it went to machine coordinates or to the end of a travel and stayed; go to the start with a G0 of all axes first",
            summary.starts_off.line,
            summary.starts_off.amount * UM_PER_MM
        );
    }
    if let Some(line) = summary.spikes_stay_from {
        let _ = writeln!(
            text,
            "reversal spikes stay from line {line} on: in coordinates of the workpiece slides turn back by rounding alone"
        );
    }
    for flank in &summary.unknown_flanks {
        let off = [(flank.off_mm * UM_PER_MM, "µm"), (flank.off_rad * ARCSEC_PER_RAD, "arcsec")];
        let off: Vec<String> =
            off.iter().filter(|(size, _)| *size > 0.0).map(|(size, unit)| format!("{size:.1} {unit}")).collect();
        let axis = &machine.axes[flank.axis].name;
        let _ = writeln!(
            text,
            "line {} cuts before {axis} has moved: on which flank {axis} stands is not known, and ± {} stay; move {axis} to one side before the first cut",
            flank.line,
            off.join(" and ")
        );
    }
    for marked in summary.marked.iter().take(MOST_BLOCKS_TOLD) {
        let _ = writeln!(text, "not corrected: {marked}");
    }
    if summary.marked_count as usize > MOST_BLOCKS_TOLD {
        let _ = writeln!(text, "not corrected: {} blocks in all", summary.marked_count);
    }
    for (code, line) in &summary.unusual_m {
        let _ = writeln!(
            text,
            "M{} (first in line {line}) is the machine's own and stays: if it clamps an axis or changes coordinates, this program is wrong after it",
            f64::from(*code) / 10.0
        );
    }
    text
}

/// As JSON.
pub fn summary_json(machine: &Machine, summary: &Summary, file: &str) -> Value {
    let largest: Vec<Value> = changes(summary)
        .iter()
        .map(|(letter, value, unit, line)| {
            json!({ "axis": letter.to_string(), "value": value, "unit": if *unit == "µm" { "um" } else { *unit }, "line": line })
        })
        .collect();
    let marked: Vec<Value> =
        summary.marked.iter().map(|one| json!({ "line": one.line, "reason": one.reason })).collect();
    let unusual: Vec<Value> =
        summary.unusual_m.iter().map(|(code, line)| json!({ "code": f64::from(*code) / 10.0, "line": line })).collect();
    let flanks: Vec<Value> = (summary.unknown_flanks.iter())
        .map(|flank| {
            json!({
                "axis": machine.axes[flank.axis].name,
                "line": flank.line,
                "off_um": flank.off_mm * UM_PER_MM,
                "off_arcsec": flank.off_rad * ARCSEC_PER_RAD,
            })
        })
        .collect();
    json!({
        "machine": machine.name,
        "file": file,
        "lines": summary.lines,
        "moves_corrected": summary.moves,
        "blocks_written": summary.blocks,
        "moves_left": summary.left,
        "largest_changes": largest,
        "direction_off_arcsec": summary.off.amount * ARCSEC_PER_RAD,
        "direction_off_line": summary.off.line,
        "starts_off_um": summary.starts_off.amount * UM_PER_MM,
        "starts_off_line": summary.starts_off.line,
        "spikes_stay_from_line": summary.spikes_stay_from,
        "unknown_flanks": flanks,
        "not_corrected": marked,
        "not_corrected_count": summary.marked_count,
        "own_m_codes": unusual,
    })
}
