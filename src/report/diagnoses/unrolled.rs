//! Residuals of a test before and after its findings were modelled, over the position, as SVG. Nothing is fitted here.

use std::fmt::Write as _;
use std::ops::RangeInclusive;

use crate::diagnose::TestBeforeAfter;
use crate::report::pictures::course::path_data;
use crate::report::wording::markup::escape;
use crate::units::UM_PER_MM;

const WIDTH: f64 = 600.0;
const HEIGHT: f64 = 250.0;
const LEFT: f64 = 58.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 56.0;
const BOTTOM: f64 = 44.0;

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
    let scales = Scales::of(abscissa, residuals);
    let mut svg = head(name);
    legend(&mut svg, residuals.rms_um(), !located.is_empty());
    shade(&mut svg, &scales, abscissa, located);
    value_axis(&mut svg, &scales);
    position_axis(&mut svg, &scales, label);
    curves(&mut svg, &scales, abscissa, residuals);
    svg.push_str("</svg>\n");
    svg
}

/// Where positions and residuals lie in the picture.
struct Scales {
    /// First and last position of the picture.
    low: f64,
    high: f64,
    /// Residual at the upper edge, and that between two lines, µm.
    reach_um: f64,
    step_um: f64,
}

impl Scales {
    /// Scales that hold all positions and all readings that were kept.
    fn of(abscissa: &[f64], residuals: &TestBeforeAfter) -> Scales {
        let rows = 0..residuals.before_mm.len().min(abscissa.len());
        let both = [&residuals.before_mm, &residuals.after_mm];
        let sizes = rows.flat_map(|row| both.map(|values| kept_um(residuals, values, row).map_or(0.0, f64::abs)));
        let largest_um = sizes.fold(1e-6 * UM_PER_MM, f64::max);
        let step_um = round_step(largest_um / 2.0);
        let (low, high) = abscissa.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
        let (low, high) = if high > low { (low, high) } else { (low - 1.0, low + 1.0) };
        Scales { low, high, reach_um: step_um * (largest_um / step_um).ceil().max(1.0), step_um }
    }

    /// Where a position lies, px.
    fn x(&self, position: f64) -> f64 {
        LEFT + (position - self.low) / (self.high - self.low) * (WIDTH - LEFT - RIGHT)
    }

    /// Where a residual lies, px.
    fn y(&self, um: f64) -> f64 {
        TOP + (1.0 - um / self.reach_um) * (HEIGHT - TOP - BOTTOM) / 2.0
    }

    /// Numbers of the lines across, zero in the middle.
    fn lines(&self) -> RangeInclusive<i64> {
        let count = (self.reach_um / self.step_um).round() as i64;
        -count..=count
    }
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
fn shade(svg: &mut String, scales: &Scales, abscissa: &[f64], located: &[(usize, usize)]) {
    for &(from, to) in located {
        let (a, b) = (scales.x(abscissa[from]), scales.x(abscissa[to]));
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
fn value_axis(svg: &mut String, scales: &Scales) {
    svg.push_str("<g class=\"ba-lines\" stroke=\"#1c2128\">\n");
    for k in scales.lines() {
        let at = scales.y(k as f64 * scales.step_um);
        let opacity = if k == 0 { 0.6 } else { 0.16 };
        let _ = writeln!(
            svg,
            "<line x1=\"{LEFT}\" x2=\"{}\" y1=\"{at:.1}\" y2=\"{at:.1}\" stroke-opacity=\"{opacity}\"/>",
            WIDTH - RIGHT
        );
    }
    svg.push_str("</g>\n");
    for k in scales.lines() {
        let um = k as f64 * scales.step_um;
        let _ = writeln!(
            svg,
            "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            LEFT - 6.0,
            scales.y(um) + 4.0,
            plain(um)
        );
    }
}

/// Positions under the picture, and what both axes measure.
fn position_axis(svg: &mut String, scales: &Scales, label: &str) {
    let across = position_step(scales.high - scales.low);
    let first = (scales.low / across - 1e-9).ceil() as i64;
    let last = (scales.high / across + 1e-9).floor() as i64;
    for tick in (first..=last).map(|k| k as f64 * across) {
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            scales.x(tick),
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
fn curves(svg: &mut String, scales: &Scales, abscissa: &[f64], residuals: &TestBeforeAfter) {
    let rows = residuals.before_mm.len().min(abscissa.len());
    for ((class, colour), values) in [(BEFORE, &residuals.before_mm), (AFTER, &residuals.after_mm)] {
        let path =
            path_data(rows, |row| kept_um(residuals, values, row), |row, um| (scales.x(abscissa[row]), scales.y(um)));
        let _ = writeln!(
            svg,
            "<path class=\"{class}\" d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.2\" stroke-linejoin=\"round\"/>"
        );
    }
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

/// A number without needless zeros.
fn plain(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.replace('-', "−") }
}
