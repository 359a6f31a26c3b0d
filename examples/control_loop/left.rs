//! What the gauge sees beside a machine without errors that runs the plan's own programs.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use crate::course::{Course, Place};
use crate::gauge::{Gauge, Look, name_of};
use crate::plain_machine::{Plain, distance};

/// Readings of all programs in motion, µm rms.
pub struct Seen {
    /// Less what the errorless machine would read with the balls where they really are.
    pub raw_um: f64,
    /// Less what other places of the balls and another length of the bar explain: what a gauge can lay on the machine.
    pub fitted_um: f64,
    /// The same by program, with the largest, and what of it the control made: its way beside the corrected program's.
    pub by_program: Vec<Kept>,
}

/// What one program keeps, µm.
pub struct Kept {
    pub program: String,
    pub rms_um: f64,
    pub largest_um: f64,
    pub control_um: f64,
}

/// Step of the derivatives by a ball's place, mm.
const STEP_MM: f64 = 1e-3;

/// Compares looks with the programs as planned; of looks at uncorrected programs every row stands for itself.
pub fn seen(gauge: &Gauge, courses: &BTreeMap<String, Course>, looks: &[&Look]) -> Seen {
    let plain = Plain { machine: &gauge.session.machine, errs: false, tip: [0.0; 3], axis: [0.0, 0.0, 1.0] };
    let mut names: Vec<String> = Vec::new();
    let mut rows: Vec<Row> = Vec::new();
    for (program, look) in looks.iter().enumerate() {
        let test = gauge.test(&look.program);
        let course = courses.get(&look.program);
        let bar = test.bar_length_mm.expect("bar");
        let length = |pivot: [f64; 3], spindle: [f64; 3], q: &[f64]| {
            distance(plain.ball(&test.pivot.link, pivot, q), plain.ball(&test.spindle_ball.link, spindle, q)) - bar
        };
        let (pivot, spindle): ([f64; 3], [f64; 3]) = (test.pivot.at.into(), test.spindle_ball.at.into());
        let mut place = |name: String| {
            names.iter().position(|other| *other == name).unwrap_or_else(|| {
                names.push(name);
                names.len() - 1
            })
        };
        let columns = [place(name_of(&test.pivot)), place(name_of(&test.spindle_ball)), place(format!("bar {bar}"))];
        for reading in look.readings.iter().filter(|reading| reading.moves) {
            let itself = || Place { planned: reading.q.clone(), corrected: reading.q.clone() };
            let place = course.map_or_else(itself, |course| course.place(&reading.q, reading.line));
            let q = &place.planned;
            let control_mm = length(pivot, spindle, &reading.q) - length(pivot, spindle, &place.corrected);
            let ideal = length(gauge.mounted(&test.pivot), gauge.mounted(&test.spindle_ball), q);
            let drawn = length(pivot, spindle, q);
            let mut slopes = vec![(3 * columns[2], 1.0)];
            for k in 0..3 {
                let mut off = [pivot, spindle];
                off[0][k] += STEP_MM;
                off[1][k] += STEP_MM;
                slopes.push((3 * columns[0] + k, (length(off[0], spindle, q) - drawn) / STEP_MM));
                slopes.push((3 * columns[1] + k, (length(pivot, off[1], q) - drawn) / STEP_MM));
            }
            rows.push(Row {
                program,
                raw_mm: reading.off_mm - ideal,
                off_mm: reading.off_mm - drawn,
                control_mm,
                slopes,
            });
        }
    }
    let left = left(&rows, 3 * names.len());
    let um = |list: &[f64]| 1e3 * (list.iter().map(|off| off * off).sum::<f64>() / list.len() as f64).sqrt();
    let kept = |(program, look): (usize, &&Look)| {
        let of_program = || rows.iter().zip(&left).filter(|(row, _)| row.program == program);
        let off: Vec<f64> = of_program().map(|(_, left)| *left).collect();
        let control: Vec<f64> = of_program().map(|(row, _)| row.control_mm).collect();
        Kept {
            program: look.program.clone(),
            rms_um: um(&off),
            largest_um: 1e3 * off.iter().fold(0.0, |most: f64, off| most.max(off.abs())),
            control_um: um(&control),
        }
    };
    Seen {
        raw_um: um(&rows.iter().map(|row| row.raw_mm).collect::<Vec<f64>>()),
        fitted_um: um(&left),
        by_program: looks.iter().enumerate().map(kept).collect(),
    }
}

/// One reading: less the errorless machine's, with the balls where they are and where the session says; slopes by ball and bar.
struct Row {
    program: usize,
    raw_mm: f64,
    off_mm: f64,
    control_mm: f64,
    slopes: Vec<(usize, f64)>,
}

/// What the least-squares fit of the slopes leaves, mm.
fn left(rows: &[Row], count: usize) -> Vec<f64> {
    let mut normal = DMatrix::<f64>::zeros(count, count);
    let mut right = DVector::<f64>::zeros(count);
    for row in rows {
        for (i, a) in &row.slopes {
            right[*i] += a * row.off_mm;
            row.slopes.iter().for_each(|(j, b)| normal[(*i, *j)] += a * b);
        }
    }
    let most = normal.diagonal().max();
    let solution = normal.svd(true, true).solve(&right, 1e-9 * most).expect("both sides");
    rows.iter().map(|row| row.off_mm - row.slopes.iter().map(|(i, a)| a * solution[*i]).sum::<f64>()).collect()
}
