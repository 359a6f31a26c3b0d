//! Residuals of a test before and after its findings were modelled, round and unrolled, as SVG. Nothing is fitted here.

use super::diagnosis::{FindingJson, RangeJson};
use super::unrolled::unrolled;
use crate::diagnose::TestBeforeAfter;
use crate::machine::Machine;
use crate::methods::{Course, Swept};
use crate::report::pictures::polar::{Arrow, PolarPlot, PolarTrace, Stroke};
use crate::report::pictures::trace_plots::{swept_label, swept_quarters};
use crate::session::{Motion, Session, Test};
use crate::units::UM_PER_MM;

/// Plots of one test.
#[derive(Debug, Clone, PartialEq)]
pub struct BeforeAfterPlots {
    pub test: String,
    /// Absent for static poses and straight sweeps.
    pub polar: Option<String>,
    pub unrolled: String,
    /// Part of the test lies in the range of a finding.
    pub is_located: bool,
}

/// Most points of a polar trace: finer than a pixel.
const MOST_POINTS: usize = 721;

/// Plots of a test with the ranges of the findings that show in it marked.
pub fn before_after_plots(
    session: &Session,
    test: &Test,
    Course { motion, swept }: &Course,
    residuals: &TestBeforeAfter,
    findings: &[FindingJson],
) -> BeforeAfterPlots {
    let here: Vec<&RangeJson> = findings
        .iter()
        .filter(|finding| finding.located.tests.contains(&test.name))
        .filter_map(|finding| finding.located.range.as_ref())
        .collect();
    let located = located_rows(session, test, motion, &here);
    let polar = swept.as_ref().and_then(|swept| polar(&session.machine, swept, residuals, &located));
    let (abscissa, label) = match swept {
        Some(swept) => (swept.value.clone(), swept_label(&session.machine, swept.over)),
        None => ((0..motion.rows()).map(|row| row as f64 + 1.0).collect(), "reading".to_string()),
    };
    let unrolled = unrolled(&test.name, &label, &abscissa, residuals, &located);
    BeforeAfterPlots { test: test.name.clone(), polar, unrolled, is_located: !located.is_empty() }
}

/// Runs of rows inside any located range; a range that covers a whole test marks nothing.
fn located_rows(session: &Session, test: &Test, motion: &Motion, ranges: &[&RangeJson]) -> Vec<(usize, usize)> {
    let rows = motion.rows();
    let inside = |row: usize| {
        ranges.iter().any(|range| {
            let value = match session.machine.axis_index(&range.axis) {
                Some(axis) => session.machine.axes[axis].kind.to_file_unit(motion.row(row)[axis]),
                None => match &motion.time_s {
                    Some(time) => test.started_at_s + time[row],
                    None => return false,
                },
            };
            value >= range.from && value <= range.to
        })
    };
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for row in (0..rows).filter(|&row| inside(row)) {
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == row => *last = row,
            _ => runs.push((row, row)),
        }
    }
    // a little less than all is all: ranges end at the outermost positions
    if runs.iter().map(|(from, to)| to - from + 1).sum::<usize>() * 100 >= rows * 97 { Vec::new() } else { runs }
}

fn polar(machine: &Machine, swept: &Swept, residuals: &TestBeforeAfter, located: &[(usize, usize)]) -> Option<String> {
    let angle = swept.angle_rad.as_ref()?;
    let every = angle.len().div_ceil(MOST_POINTS).max(1);
    let trace = |index: usize, label: &str, values: &[f64]| PolarTrace {
        stroke: Stroke::Own(index),
        label: label.into(),
        points: (0..angle.len())
            .step_by(every)
            .map(|row| (angle[row], if residuals.kept[row] { values[row] * UM_PER_MM } else { f64::NAN }))
            .collect(),
    };
    let (before, after) = residuals.rms_um();
    let mut plot = PolarPlot::new(
        &residuals.name,
        vec![
            trace(0, &format!("before, {before:.2} µm rms"), &residuals.before_mm),
            trace(1, &format!("after, {after:.2} µm rms"), &residuals.after_mm),
        ],
    );
    plot.subtitle = "residual: measured − model".into();
    plot.heavy_circle = "residual zero · outward: read longer than the model";
    plot.label_quarters(swept_quarters(machine, swept.over));
    let is_ccw = swept.value.first() <= swept.value.last();
    plot.arrows = angle.first().map(|&from| Arrow { stroke: 0, from, is_ccw }).into_iter().collect();
    plot.arcs = located.iter().map(|&(from, to)| (angle[from], angle[to])).collect();
    Some(plot.to_svg())
}
