//! Recordings as CSV that `load` reads. It keeps the rows, order and position columns of the recording it stands for.

use std::fmt::Write as _;

use crate::machine::Machine;
use crate::session::{Motion, Test};

/// Lengths of a test as CSV: with the clock and position columns of its own recording where it has them, else those of
/// its path. A length that is not finite is left empty.
pub fn recording_csv(machine: &Machine, test: &Test, motion: &Motion, length_mm: &[f64]) -> String {
    match &test.recording {
        Some(recording) if !recording.leading_header.is_empty() => {
            let mut text = format!("{},length_mm\n", recording.leading_header);
            for (leading, length) in recording.leading_texts.iter().zip(length_mm) {
                let _ = writeln!(text, "{leading},{}", field(*length));
            }
            text
        }
        Some(_) => {
            let mut text = String::from("length_mm\n");
            for length in length_mm {
                let _ = writeln!(text, "{}", field(*length));
            }
            text
        }
        None => path_csv(machine, motion, length_mm),
    }
}

/// Lengths with a time and the positions of the moving axes.
pub fn path_csv(machine: &Machine, motion: &Motion, length_mm: &[f64]) -> String {
    let headers: Vec<String> = motion
        .moving
        .iter()
        .map(|&axis| format!("{}_{}", machine.axes[axis].name, machine.axes[axis].kind.position_unit()))
        .collect();
    let mut text = format!("time_s,{},length_mm\n", headers.join(","));
    let decimals = time_decimals(motion.time_s.as_deref().unwrap_or_default());
    for (row, length) in length_mm.iter().enumerate() {
        let time = motion.time_s.as_ref().map_or(row as f64, |time| time[row]);
        let _ = write!(text, "{time:.decimals$}");
        for &axis in &motion.moving {
            // positions as fine as the lengths: a coarser command would be another motion
            let _ = write!(text, ",{:.9}", machine.axes[axis].kind.to_file_unit(motion.row(row)[axis]));
        }
        let _ = writeln!(text, ",{}", field(*length));
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

/// A length to 1e-10 mm, empty when there is none.
fn field(length_mm: f64) -> String {
    if length_mm.is_finite() { format!("{length_mm:.10}") } else { String::new() }
}
