//! The residual of one test over a position as SVG: its own scale, readings left out as crosses. It reads no sessions.

use std::fmt::Write as _;

use super::course::path_data;
use super::frame::{BOTTOM, Edges, Frame, RIGHT, WIDTH, plain};
use crate::identify::TestFit;
use crate::report::wording::markup::escape;
use crate::units::UM_PER_MM;

/// Most crosses drawn: one for each pixel across.
const MOST_CROSSES: usize = 600;

const EDGES: Edges = Edges { height: 230.0, left: 62.0, top: 40.0 };
const HEIGHT: f64 = EDGES.height;
const LEFT: f64 = EDGES.left;
const TOP: f64 = EDGES.top;

/// Residual over a position (`label` with its unit): readings that took part as a line, the others as crosses.
pub fn residual_svg(name: &str, label: &str, abscissa: &[f64], fit: &TestFit) -> String {
    let sizes = fit.residual_mm.iter().zip(&fit.kept).filter(|(value, kept)| **kept && value.is_finite());
    let largest_um = sizes.map(|(value, _)| value.abs() * UM_PER_MM).fold(0.0, f64::max);
    let frame = Frame::of(EDGES, abscissa, largest_um);
    let name = escape(name);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" \
         height=\"{HEIGHT}\" role=\"img\" class=\"unrolled\" font-family=\"Helvetica, Arial, sans-serif\" \
         font-size=\"12\" fill=\"#1c2128\">\n<title>Residual of {name}</title>\n<style>@media (prefers-color-scheme: dark)\
         {{.unrolled{{fill:#e6e9ee}}.unrolled-ground{{fill:#14181f}}.unrolled-lines{{stroke:#e6e9ee}}\
         .unrolled-trace{{stroke:#4fd6a8}}.unrolled-out{{stroke:#ff8087}}}}</style>\n\
         <rect class=\"unrolled-ground\" width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#ffffff\"/>\n\
         <text x=\"{LEFT}\" y=\"24\" font-weight=\"600\">Residual of {name}: {:.2} µm rms</text>\n",
        fit.rms_mm * UM_PER_MM
    );
    graticule(&mut svg, &frame, label);
    trace(&mut svg, &frame, abscissa, fit);
    svg.push_str("</svg>\n");
    svg
}

fn graticule(svg: &mut String, frame: &Frame, label: &str) {
    svg.push_str("<g class=\"unrolled-lines\" stroke=\"#1c2128\">\n");
    for level in frame.levels() {
        let opacity = if level == 0.0 { 0.7 } else { 0.18 };
        let (at, end) = (frame.y(level), WIDTH - RIGHT);
        let _ = writeln!(
            svg,
            "<line x1=\"{LEFT}\" x2=\"{end}\" y1=\"{at:.1}\" y2=\"{at:.1}\" stroke-opacity=\"{opacity}\"/>"
        );
    }
    for tick in frame.ticks() {
        let (at, end) = (frame.x(tick), HEIGHT - BOTTOM);
        let _ =
            writeln!(svg, "<line x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{TOP}\" y2=\"{end}\" stroke-opacity=\"0.12\"/>");
    }
    svg.push_str("</g>\n");
    for level in frame.levels() {
        let (x, y) = (LEFT - 6.0, frame.y(level) + 4.0);
        let _ = writeln!(svg, "<text x=\"{x}\" y=\"{y:.1}\" text-anchor=\"end\">{}</text>", plain(level));
    }
    for tick in frame.ticks() {
        let (x, y) = (frame.x(tick), HEIGHT - BOTTOM + 16.0);
        let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y}\" text-anchor=\"middle\">{}</text>", plain(tick));
    }
    let _ = writeln!(
        svg,
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n\
         <text transform=\"translate(14 {}) rotate(-90)\" text-anchor=\"middle\">µm</text>",
        (LEFT + WIDTH - RIGHT) / 2.0,
        HEIGHT - 8.0,
        escape(label),
        (TOP + HEIGHT - BOTTOM) / 2.0
    );
}

fn trace(svg: &mut String, frame: &Frame, abscissa: &[f64], fit: &TestFit) {
    let rows = abscissa.len().min(fit.residual_mm.len()).min(fit.kept.len());
    let um = |row: usize| fit.residual_mm[row] * UM_PER_MM;
    let path = path_data(
        rows,
        |row| (fit.kept[row] && um(row).is_finite()).then(|| um(row)),
        |row, um| (frame.x(abscissa[row]), frame.y(um)),
    );
    let _ = writeln!(
        svg,
        "<path class=\"unrolled-trace\" d=\"{path}\" fill=\"none\" stroke=\"#00805c\" stroke-width=\"1.2\" \
         stroke-linejoin=\"round\"/>"
    );
    let every = fit.left_out.len().div_ceil(MOST_CROSSES).max(1);
    for &row in fit.left_out.iter().step_by(every) {
        let Some(&at) = abscissa.get(row) else { continue };
        // one far outside stands at the edge
        let um = (fit.residual_mm[row] * UM_PER_MM).clamp(-frame.reach_um, frame.reach_um);
        let (x, y) = (frame.x(at) - 4.0, frame.y(um) - 4.0);
        let _ = writeln!(
            svg,
            "<path class=\"unrolled-out\" d=\"M{x:.1} {y:.1}l8 8m0 -8l-8 8\" stroke=\"#b3202c\" stroke-width=\"1.6\"/>"
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reading_left_out_is_a_cross_at_the_edge_and_breaks_the_line() {
        let residual_mm = vec![1e-3, -1e-3, 0.5, 1e-3];
        let kept = vec![true, true, false, true];
        let fit = TestFit { name: "t".into(), residual_mm, kept, rms_mm: 1e-3, left_out: vec![2] };
        let svg = residual_svg("a < b", "C, °", &[0.0, 90.0, 180.0, 270.0], &fit);
        assert_eq!(svg.matches("unrolled-out\" d=").count(), 1);
        // the largest kept residual is the edge, and so is the cross: 4 px above it in drawing
        assert!(svg.contains(&format!("{:.1}l8 8", TOP - 4.0)), "{svg}");
        let path = svg.split(" d=\"").nth(1).unwrap().split('"').next().unwrap();
        assert_eq!(path.matches('M').count(), 2);
        assert!(svg.contains("a &lt; b"));
    }
}
