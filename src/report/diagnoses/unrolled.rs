//! Residuals of a test before and after its findings were modelled, over the position, as SVG. Nothing is fitted here.

use std::fmt::Write as _;

use crate::diagnose::TestBeforeAfter;
use crate::report::pictures::course::path_data;
use crate::report::pictures::frame::{BOTTOM, Edges, Frame, RIGHT, WIDTH, plain};
use crate::report::wording::markup::escape;
use crate::units::UM_PER_MM;

const EDGES: Edges = Edges { height: 250.0, left: 58.0, top: 56.0 };
const HEIGHT: f64 = EDGES.height;
const LEFT: f64 = EDGES.left;
const TOP: f64 = EDGES.top;

/// Class of the style and colour on white of both residuals.
const BEFORE: (&str, &str) = ("ba-before", "#0063a6");
const AFTER: (&str, &str) = ("ba-after", "#c8500a");

/// Both residuals over the position, with the located stretches shaded.
pub fn unrolled(
    name: &str,
    label: &str,
    abscissa: &[f64],
    residuals: &TestBeforeAfter,
    located: &[(usize, usize)],
) -> String {
    let frame = frame_of(abscissa, residuals);
    let mut svg = head(name);
    legend(&mut svg, residuals.rms_um(), !located.is_empty());
    shade(&mut svg, &frame, abscissa, located);
    value_axis(&mut svg, &frame);
    position_axis(&mut svg, &frame, label);
    curves(&mut svg, &frame, abscissa, residuals);
    svg.push_str("</svg>\n");
    svg
}

/// A frame that holds all positions and all readings that were kept.
fn frame_of(abscissa: &[f64], residuals: &TestBeforeAfter) -> Frame {
    let rows = 0..residuals.before_mm.len().min(abscissa.len());
    let both = [&residuals.before_mm, &residuals.after_mm];
    let sizes = rows.flat_map(|row| both.map(|values| kept_um(residuals, values, row).map_or(0.0, f64::abs)));
    Frame::of(EDGES, abscissa, sizes.fold(0.0, f64::max))
}

/// A residual of a reading that was kept, µm.
fn kept_um(residuals: &TestBeforeAfter, values_mm: &[f64], row: usize) -> Option<f64> {
    (residuals.kept[row] && values_mm[row].is_finite()).then(|| values_mm[row] * UM_PER_MM)
}

/// Beginning of the picture: its style, ground and the test's name.
fn head(name: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         role=\"img\" class=\"ba\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\" fill=\"#1c2128\">\n\
         <title>Residual of {0} before and after</title>\n<style>@media (prefers-color-scheme: dark){{.ba{{fill:#e6e9ee}}\
         .ba-ground{{fill:#14181f}}.ba-lines{{stroke:#e6e9ee}}.ba-before{{stroke:#6cb6ff}}.ba-after{{stroke:#ff9e64}}\
         .ba-here{{fill:#ff8087}}}}</style>\n<rect class=\"ba-ground\" width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#ffffff\"/>\n\
         <text x=\"{LEFT}\" y=\"20\" font-weight=\"600\">{0}</text>\n",
        escape(name)
    )
}

/// What the colours mean, with the rms of both residuals.
fn legend(svg: &mut String, (before, after): (f64, f64), is_located: bool) {
    for (at, (class, colour), says) in [
        (LEFT, BEFORE, format!("before, {before:.2} µm rms")),
        (LEFT + 190.0, AFTER, format!("after, {after:.2} µm rms")),
    ] {
        let _ = writeln!(
            svg,
            "<line class=\"{class}\" x1=\"{at}\" x2=\"{}\" y1=\"38\" y2=\"38\" stroke=\"{colour}\" stroke-width=\"2\"/>\
             <text x=\"{}\" y=\"42\">{says}</text>",
            at + 24.0,
            at + 30.0
        );
    }
    if is_located {
        let _ = writeln!(
            svg,
            "<rect class=\"ba-here\" x=\"{}\" y=\"31\" width=\"24\" height=\"13\" fill=\"#b3202c\" fill-opacity=\"0.16\"/><text x=\"{}\" y=\"42\">located here</text>",
            LEFT + 380.0,
            LEFT + 410.0
        );
    }
}

/// The located stretches, shaded.
fn shade(svg: &mut String, frame: &Frame, abscissa: &[f64], located: &[(usize, usize)]) {
    for &(from, to) in located {
        let (a, b) = (frame.x(abscissa[from]), frame.x(abscissa[to]));
        let _ = writeln!(
            svg,
            "<rect class=\"ba-here\" x=\"{:.1}\" y=\"{TOP}\" width=\"{:.1}\" height=\"{}\" fill=\"#b3202c\" fill-opacity=\"0.13\"/>",
            a.min(b),
            (b - a).abs().max(2.0),
            HEIGHT - TOP - BOTTOM
        );
    }
}

/// Lines across the picture with their residuals.
fn value_axis(svg: &mut String, frame: &Frame) {
    svg.push_str("<g class=\"ba-lines\" stroke=\"#1c2128\">\n");
    for um in frame.levels() {
        let at = frame.y(um);
        let opacity = if um == 0.0 { 0.6 } else { 0.16 };
        let _ = writeln!(
            svg,
            "<line x1=\"{LEFT}\" x2=\"{}\" y1=\"{at:.1}\" y2=\"{at:.1}\" stroke-opacity=\"{opacity}\"/>",
            WIDTH - RIGHT
        );
    }
    svg.push_str("</g>\n");
    for um in frame.levels() {
        let _ = writeln!(
            svg,
            "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            LEFT - 6.0,
            frame.y(um) + 4.0,
            plain(um)
        );
    }
}

/// Positions under the picture, and what both axes measure.
fn position_axis(svg: &mut String, frame: &Frame, label: &str) {
    for tick in frame.ticks() {
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            frame.x(tick),
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
}

/// Both residuals, broken where readings were left out.
fn curves(svg: &mut String, frame: &Frame, abscissa: &[f64], residuals: &TestBeforeAfter) {
    let rows = residuals.before_mm.len().min(abscissa.len());
    for ((class, colour), values) in [(BEFORE, &residuals.before_mm), (AFTER, &residuals.after_mm)] {
        let path =
            path_data(rows, |row| kept_um(residuals, values, row), |row, um| (frame.x(abscissa[row]), frame.y(um)));
        let _ = writeln!(
            svg,
            "<path class=\"{class}\" d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.2\" stroke-linejoin=\"round\"/>"
        );
    }
}
