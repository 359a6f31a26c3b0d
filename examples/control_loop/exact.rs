//! Programs driven exactly: a control that neither waits nor rounds corners. What remains with it is no fault of a planner.

use std::fmt::Write as _;
use std::path::Path;

use fiveaxis::machine::{AxisKind, Machine};

use crate::course::{positions, read};
use crate::plain_program::Move;

/// Rapids, mm/s and rad/s.
const RAPID: [f64; 2] = [200.0, 1.5];
/// At stops of the program, s: the operator mounts the bar.
const STOP_S: f64 = 3.0;

/// Writes the trace of a program as the control's recorder does.
pub fn trace(machine: &Machine, program: &Path, trace: &Path) {
    let text = std::fs::read_to_string(program).expect("program");
    let list = read(&text);
    let letters: Vec<String> = machine
        .axes
        .iter()
        .map(|axis| format!("{}_{}", axis.name, if axis.kind == AxisKind::Rotary { "deg" } else { "mm" }))
        .collect();
    let mut out = format!("time_s,{},line\n", letters.join(","));
    let mut row = 0usize;
    let mut put = |place: &[f64; 6], line: usize| {
        let _ = write!(out, "{:.3}", 1e-3 * row as f64);
        for (axis, q) in machine.axes.iter().zip(positions(machine, place)) {
            let _ = write!(out, ",{:.9}", axis.kind.to_file_unit(q));
        }
        let _ = writeln!(out, ",{line}");
        row += 1;
    };
    let mut here = [0.0; 6];
    let mut left_s = 0.0;
    for (index, line) in text.lines().enumerate() {
        let stop_s = pause_s(line);
        (0..(1e3 * stop_s) as usize).for_each(|_| put(&here, index + 1));
        for next in list.iter().filter(|next| next.line == index + 1) {
            let seconds = duration_s(machine, next);
            // rows lie on the servo clock, moves end between them
            let mut at = left_s;
            while at < seconds {
                put(&next.at(at / seconds), next.line);
                at += 1e-3;
            }
            left_s = at - seconds;
            here = next.to;
        }
    }
    put(&here, 0);
    std::fs::write(trace, out).expect("written");
}

/// Time of a dwell or a stop.
fn pause_s(line: &str) -> f64 {
    match line.trim() {
        "M0" => STOP_S,
        line => line.strip_prefix("G4 P").map_or(0.0, |seconds| seconds.trim().parse().expect("seconds")),
    }
}

fn duration_s(machine: &Machine, next: &Move) -> f64 {
    if !next.is_rapid {
        return 60.0 * next.minutes;
    }
    let (from, to) = (positions(machine, &next.from), positions(machine, &next.to));
    let of = |k: usize| (to[k] - from[k]).abs() / RAPID[usize::from(machine.axes[k].kind == AxisKind::Rotary)];
    (0..to.len()).map(of).fold(0.0, f64::max)
}
