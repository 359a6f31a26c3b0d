//! What the gauge sees beside a machine without errors that runs the plan's own programs.

use std::collections::BTreeMap;
use std::path::Path;

use fiveaxis::machine::AxisKind;
use nalgebra::{DMatrix, DVector};

use crate::gauge::{Gauge, Look, name_of, trace_rows};
use crate::plain_machine::{Plain, distance};

/// Readings of all programs, µm rms.
pub struct Seen {
    /// Less what the errorless machine would read with the balls where they really are.
    pub raw_um: f64,
    /// Less what other places of the balls and another length of the bar explain: what a gauge can lay on the machine.
    pub fitted_um: f64,
    /// The same by program.
    pub by_program: Vec<(String, f64)>,
}

/// Of a nominal trace every so many rows are compared: 5 ms, 0.1 mm of way.
const NOMINAL_STEP: usize = 5;
/// One degree of a rotary axis counts as this, mm.
const MM_PER_RAD: f64 = 100.0;
/// Step of the derivatives by a ball's place, mm.
const STEP_MM: f64 = 1e-3;

/// Compares looks at the machine with the nominal traces of the same programs.
pub fn seen(gauge: &Gauge, nominal: &BTreeMap<&str, &Path>, looks: &[&Look]) -> Seen {
    let plain = Plain { machine: &gauge.session.machine, errs: false, tip: [0.0; 3], axis: [0.0, 0.0, 1.0] };
    let mut names: Vec<String> = Vec::new();
    let mut rows: Vec<Row> = Vec::new();
    for (program, look) in looks.iter().enumerate() {
        let test = gauge.test(&look.program);
        let bar = test.bar_length_mm.expect("bar");
        let course = course(gauge, nominal[look.program.as_str()]);
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
            let q = nearest(gauge, &course, &reading.q);
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
            rows.push(Row { program, raw_mm: reading.off_mm - ideal, off_mm: reading.off_mm - drawn, slopes });
        }
    }
    let left = left(&rows, 3 * names.len());
    let um = |list: Vec<f64>| 1e3 * (list.iter().map(|off| off * off).sum::<f64>() / list.len() as f64).sqrt();
    let of_program = |program: usize| {
        rows.iter().zip(&left).filter(|(row, _)| row.program == program).map(|(_, left)| *left).collect::<Vec<f64>>()
    };
    Seen {
        raw_um: um(rows.iter().map(|row| row.raw_mm).collect()),
        fitted_um: um(left.clone()),
        by_program: looks.iter().enumerate().map(|(k, look)| (look.program.clone(), um(of_program(k)))).collect(),
    }
}

/// One reading: less the errorless machine's, with the balls where they are and where the session says; slopes by ball and bar.
struct Row {
    program: usize,
    raw_mm: f64,
    off_mm: f64,
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

/// Positions of a nominal trace.
fn course(gauge: &Gauge, trace: &Path) -> Vec<Vec<f64>> {
    trace_rows(gauge.session, trace).into_iter().step_by(NOMINAL_STEP).map(|(_, q)| q).collect()
}

/// The nominal positions nearest to corrected ones.
fn nearest<'c>(gauge: &Gauge, course: &'c [Vec<f64>], q: &[f64]) -> &'c [f64] {
    let weights: Vec<f64> = gauge
        .session
        .machine
        .axes
        .iter()
        .map(|axis| if axis.kind == AxisKind::Rotary { MM_PER_RAD } else { 1.0 })
        .collect();
    let apart = |other: &[f64]| (0..q.len()).map(|k| (weights[k] * (other[k] - q[k])).powi(2)).sum::<f64>();
    course.iter().min_by(|a, b| apart(a).total_cmp(&apart(b))).expect("rows")
}
