//! Residuals of a test before and after its findings were modelled, round and unrolled, as SVG. Nothing is fitted here.

use super::diagnosis::{FindingJson, RangeJson};
use super::unrolled::unrolled;
use crate::diagnose::TestBeforeAfter;
use crate::machine::Machine;
use crate::methods::{Course, TestTrace};
use crate::report::pictures::polar::{Arrow, PolarPlot, PolarTrace, Stroke};
use crate::report::pictures::trace_plots::{label_spokes, polar_points, swept_label};
use crate::session::{Motion, Session, Test};
use crate::units::UM_PER_MM;

/// Plots of one test.
#[derive(Debug, Clone, PartialEq)]
pub struct BeforeAfterPlots {
    pub test: String,
    /// The test that runs the same way back; it is in the polar plot too.
    pub back: Option<String>,
    /// Absent for static poses and straight sweeps.
    pub polar: Option<String>,
    pub unrolled: String,
    /// Part of the test lies in the range of a finding.
    pub is_located: bool,
}

/// A test with where its axes stand, the angles over which it is drawn, and its residuals.
#[derive(Clone, Copy)]
pub struct TestShown<'a> {
    pub test: &'a Test,
    pub trace: &'a TestTrace,
    pub residuals: &'a TestBeforeAfter,
}

/// Plots of a test with the ranges of the findings that show in it marked; `back` runs the same way in the other sense.
pub fn before_after_plots(
    session: &Session,
    shown: TestShown,
    back: Option<TestShown>,
    findings: &[FindingJson],
) -> BeforeAfterPlots {
    let TestShown { test, trace, residuals } = shown;
    let Course { motion, swept } = &trace.course;
    let here: Vec<&RangeJson> = findings
        .iter()
        .filter(|finding| finding.located.tests.contains(&test.name))
        .filter_map(|finding| finding.located.range.as_ref())
        .collect();
    let located = located_rows(session, test, motion, &here);
    let polar = polar(&session.machine, shown, back, &located);
    let (abscissa, label) = match swept {
        Some(swept) => (swept.value.clone(), swept_label(&session.machine, swept.over)),
        None => ((0..motion.rows()).map(|row| row as f64 + 1.0).collect(), "reading".to_string()),
    };
    let unrolled = unrolled(&test.name, &label, &abscissa, residuals, &located);
    let back = back.map(|back| back.test.name.clone());
    BeforeAfterPlots { test: test.name.clone(), back, polar, unrolled, is_located: !located.is_empty() }
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

/// Residuals round the circle: before and after, or before in both senses, with what is left of each in grey.
fn polar(machine: &Machine, shown: TestShown, back: Option<TestShown>, located: &[(usize, usize)]) -> Option<String> {
    let angle = shown.trace.angle_rad()?;
    let (traces, arrows) = match back {
        None => (before_and_after(shown, "", [Stroke::Own(0), Stroke::Own(1)])?, vec![arrow(shown, 0)?]),
        Some(back) => {
            let of = |index: usize, one: TestShown| {
                let way = if is_ccw(one) { "ccw, " } else { "cw, " };
                Some((before_and_after(one, way, [Stroke::Own(index), Stroke::Grey])?, arrow(one, index)?))
            };
            let ((there, arrow_there), (again, arrow_back)) = (of(0, shown)?, of(1, back)?);
            ([there, again].concat(), vec![arrow_there, arrow_back])
        }
    };
    let names: Vec<&str> = [Some(shown), back].iter().flatten().map(|one| one.test.name.as_str()).collect();
    let mut plot = PolarPlot::new(names.join(" and "), traces);
    plot.subtitle = "residual: measured − model".into();
    plot.heavy_circle = "residual zero · outward: read longer than the model";
    label_spokes(machine, shown.trace, &mut plot);
    plot.arrows = arrows;
    plot.arcs = located.iter().map(|&(from, to)| (angle[from], angle[to])).collect();
    Some(plot.to_svg())
}

/// Both residuals of a test as traces; `way` stands before their labels.
fn before_and_after(shown: TestShown, way: &str, strokes: [Stroke; 2]) -> Option<Vec<PolarTrace>> {
    let TestShown { trace, residuals, .. } = shown;
    let angle = trace.angle_rad()?;
    let points = |values: &[f64]| {
        polar_points(angle, |row| if residuals.kept[row] { values[row] * UM_PER_MM } else { f64::NAN })
    };
    let (before, after) = residuals.rms_um();
    let [of_before, of_after] = strokes;
    Some(vec![
        PolarTrace {
            stroke: of_before,
            label: format!("{way}before, {before:.2} µm rms"),
            points: points(&residuals.before_mm),
        },
        PolarTrace {
            stroke: of_after,
            label: format!("{way}after, {after:.2} µm rms"),
            points: points(&residuals.after_mm),
        },
    ])
}

/// Whether a test runs counter-clockwise in its picture.
fn is_ccw(shown: TestShown) -> bool {
    shown.trace.turned_rad().unwrap_or(0.0) >= 0.0
}

/// Where a test begins and which way it runs.
fn arrow(shown: TestShown, stroke: usize) -> Option<Arrow> {
    let from = *shown.trace.angle_rad()?.first()?;
    Some(Arrow { stroke, from, is_ccw: is_ccw(shown) })
}
