//! Residuals of a test before and after its findings were modelled, round and unrolled, as SVG. Nothing is fitted here.

use std::fmt::Write as _;

use super::diagnosis::{FindingJson, RangeJson};
use crate::diagnose::TestBeforeAfter;
use crate::report::pictures::course::path_data;
use crate::report::pictures::polar::{PolarPlot, PolarTrace, Stroke};
use crate::report::pictures::trace_plots::{Swept, swept};
use crate::report::wording::markup::escape;
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
    motion: &Motion,
    residuals: &TestBeforeAfter,
    findings: &[FindingJson],
) -> BeforeAfterPlots {
    let swept = swept(session, test, motion);
    let here: Vec<&RangeJson> = findings
        .iter()
        .filter(|finding| finding.located.tests.contains(&test.name))
        .filter_map(|finding| finding.located.range.as_ref())
        .collect();
    let located = located_rows(session, test, motion, &here);
    let polar = swept.as_ref().and_then(|swept| polar(swept, residuals, &located));
    let (abscissa, label) = match swept {
        Some(swept) => (swept.value, swept.label),
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

fn polar(swept: &Swept, residuals: &TestBeforeAfter, located: &[(usize, usize)]) -> Option<String> {
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
    plot.arcs = located.iter().map(|&(from, to)| (angle[from], angle[to])).collect();
    Some(plot.to_svg())
}

const WIDTH: f64 = 600.0;
const HEIGHT: f64 = 250.0;
const LEFT: f64 = 58.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 56.0;
const BOTTOM: f64 = 44.0;

/// Both residuals over the position, with the located stretches shaded.
fn unrolled(
    name: &str,
    label: &str,
    abscissa: &[f64],
    residuals: &TestBeforeAfter,
    located: &[(usize, usize)],
) -> String {
    let taken = |row: usize, values: &[f64]| residuals.kept[row] && values[row].is_finite();
    let rows = residuals.before_mm.len().min(abscissa.len());
    let largest = (0..rows)
        .flat_map(|row| {
            [&residuals.before_mm, &residuals.after_mm]
                .map(|values| if taken(row, values) { values[row].abs() } else { 0.0 })
        })
        .fold(1e-6, f64::max)
        * UM_PER_MM;
    let step = round_step(largest / 2.0);
    let reach = step * (largest / step).ceil().max(1.0);
    let (low, high) = abscissa.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
    let (low, high) = if high > low { (low, high) } else { (low - 1.0, low + 1.0) };
    let x = |value: f64| LEFT + (value - low) / (high - low) * (WIDTH - LEFT - RIGHT);
    let y = |um: f64| TOP + (1.0 - um / reach) * (HEIGHT - TOP - BOTTOM) / 2.0;
    let (before, after) = residuals.rms_um();
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         role=\"img\" class=\"ba\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\" fill=\"#1c2128\">\n\
         <title>Residual of {0} before and after</title>\n<style>@media (prefers-color-scheme: dark){{.ba{{fill:#e6e9ee}}\
         .ba-ground{{fill:#14181f}}.ba-lines{{stroke:#e6e9ee}}.ba-before{{stroke:#6cb6ff}}.ba-after{{stroke:#ff9e64}}\
         .ba-here{{fill:#ff8087}}}}</style>\n<rect class=\"ba-ground\" width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#ffffff\"/>\n\
         <text x=\"{LEFT}\" y=\"20\" font-weight=\"600\">{0}</text>\n",
        escape(name)
    );
    for (at, class, colour, says) in [
        (LEFT, "ba-before", "#0063a6", format!("before, {before:.2} µm rms")),
        (LEFT + 190.0, "ba-after", "#c8500a", format!("after, {after:.2} µm rms")),
    ] {
        let _ = writeln!(
            svg,
            "<line class=\"{class}\" x1=\"{at}\" x2=\"{}\" y1=\"38\" y2=\"38\" stroke=\"{colour}\" stroke-width=\"2\"/>\
             <text x=\"{}\" y=\"42\">{says}</text>",
            at + 24.0,
            at + 30.0
        );
    }
    if !located.is_empty() {
        let _ = writeln!(
            svg,
            "<rect class=\"ba-here\" x=\"{}\" y=\"31\" width=\"24\" height=\"13\" fill=\"#b3202c\" fill-opacity=\"0.16\"/><text x=\"{}\" y=\"42\">located here</text>",
            LEFT + 380.0,
            LEFT + 410.0
        );
    }
    for &(from, to) in located {
        let (a, b) = (x(abscissa[from]), x(abscissa[to]));
        let _ = writeln!(
            svg,
            "<rect class=\"ba-here\" x=\"{:.1}\" y=\"{TOP}\" width=\"{:.1}\" height=\"{}\" fill=\"#b3202c\" fill-opacity=\"0.13\"/>",
            a.min(b),
            (b - a).abs().max(2.0),
            HEIGHT - TOP - BOTTOM
        );
    }
    svg.push_str("<g class=\"ba-lines\" stroke=\"#1c2128\">\n");
    let count = (reach / step).round() as i64;
    for k in -count..=count {
        let at = y(k as f64 * step);
        let opacity = if k == 0 { 0.6 } else { 0.16 };
        let _ = writeln!(
            svg,
            "<line x1=\"{LEFT}\" x2=\"{}\" y1=\"{at:.1}\" y2=\"{at:.1}\" stroke-opacity=\"{opacity}\"/>",
            WIDTH - RIGHT
        );
    }
    svg.push_str("</g>\n");
    for k in -count..=count {
        let value = k as f64 * step;
        let _ = writeln!(
            svg,
            "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            LEFT - 6.0,
            y(value) + 4.0,
            plain(value)
        );
    }
    let across = position_step(high - low);
    let first = (low / across - 1e-9).ceil() as i64;
    let last = (high / across + 1e-9).floor() as i64;
    for tick in (first..=last).map(|k| k as f64 * across) {
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            x(tick),
            HEIGHT - BOTTOM + 16.0,
            plain(tick)
        );
    }
    let _ = writeln!(
        svg,
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n<text x=\"{}\" y=\"20\" text-anchor=\"end\">µm</text>",
        (LEFT + WIDTH - RIGHT) / 2.0,
        HEIGHT - 8.0,
        escape(label),
        WIDTH - RIGHT
    );
    for (class, colour, values) in
        [("ba-before", "#0063a6", &residuals.before_mm), ("ba-after", "#c8500a", &residuals.after_mm)]
    {
        let path = path_data(
            rows,
            |row| taken(row, values).then(|| values[row] * UM_PER_MM),
            |row, um| (x(abscissa[row]), y(um)),
        );
        let _ = writeln!(
            svg,
            "<path class=\"{class}\" d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.2\" stroke-linejoin=\"round\"/>"
        );
    }
    svg.push_str("</svg>\n");
    svg
}

/// Smallest step of the series 1, 2, 5 × 10ⁿ not below `wanted`.
fn round_step(wanted: f64) -> f64 {
    let decade = 10f64.powf(wanted.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|k| k * decade).find(|step| *step >= wanted * (1.0 - 1e-9)).unwrap_or(wanted)
}

/// Step of the position axis: for angles those of a protractor.
fn position_step(span: f64) -> f64 {
    let wanted = span / 8.0;
    let protractor = [10.0, 15.0, 30.0, 45.0, 60.0, 90.0, 180.0, 360.0];
    protractor.into_iter().find(|step| *step >= wanted && wanted > 5.0).unwrap_or_else(|| round_step(wanted))
}

fn plain(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.replace('-', "−") }
}
