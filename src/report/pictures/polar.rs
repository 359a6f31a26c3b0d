//! Polar plots of length deviations as SVG text: graticule, nominal circle, traces, legend. It reads no sessions.
//!
//! The nominal circle is drawn at a fixed radius; a deviation of one division moves a trace by one ring, outward when
//! the bar reads long. Colours stand as attributes, so that any renderer shows the light version; a media query holds
//! the dark one. There are no scripts, no fonts to fetch and no identifiers that could clash on a page.

use std::fmt::Write as _;

use crate::report::wording::markup::escape;

/// One line of a polar plot.
#[derive(Debug, Clone, PartialEq)]
pub struct PolarTrace {
    /// Text in the legend.
    pub label: String,
    /// Angle (rad, counter-clockwise from the right) and deviation (µm); a value that is not finite breaks the line.
    pub points: Vec<(f64, f64)>,
    /// Which of the strokes it has.
    pub stroke: Stroke,
}

/// How a trace is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stroke {
    /// In a colour of its own, by number.
    Own(usize),
    /// Thin and grey: what stands beside the traces that are looked at, such as readings left out.
    Grey,
}

/// Which way a trace was run, as an arrow outside the rings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrow {
    /// Colour of the trace it belongs to.
    pub stroke: usize,
    /// Where the run began, rad.
    pub from: f64,
    pub is_ccw: bool,
}

/// A polar plot of deviations about a nominal circle.
#[derive(Debug, Clone, PartialEq)]
pub struct PolarPlot {
    /// Heading.
    pub title: String,
    /// Second line under the heading; may be empty.
    pub subtitle: String,
    /// What the heavy circle stands for, and what lies outside of it.
    pub heavy_circle: &'static str,
    /// Deviation between two rings, µm.
    pub division_um: f64,
    /// Lines from the centre with their labels, rad.
    pub spokes: Vec<(f64, String)>,
    /// Arcs marked outside the rings, from and to, rad.
    pub arcs: Vec<(f64, f64)>,
    pub arrows: Vec<Arrow>,
    pub traces: Vec<PolarTrace>,
}

/// Half the height of the plotting field, px.
const OUTER_PX: f64 = 232.0;
/// Radius of the nominal circle, px; leaves room for as many rings inside as outside.
const NOMINAL_PX: f64 = 132.0;
/// Width of the picture, px.
const WIDTH_PX: f64 = 600.0;
/// Rings on either side of the nominal circle when the traces need no more.
const RINGS: usize = 4;
/// Rings beyond which only some are drawn.
const MOST_RINGS: usize = 8;
/// Light colour, dark colour and dash pattern by trace; hues after Okabe and Ito, told apart also without colour.
const STROKES: [(&str, &str, &str); 8] = [
    ("#0063a6", "#6cb6ff", ""),
    ("#c8500a", "#ff9e64", "8 3"),
    ("#00805c", "#4fd6a8", "2.5 2.5"),
    ("#a4477f", "#f2a3cf", "9 3 2.5 3"),
    ("#8a6a00", "#f0c94a", "14 4"),
    ("#4b4fc4", "#aab0ff", "5 2 5 5"),
    ("#5b6470", "#b8c1cc", "1.5 4"),
    ("#b3202c", "#ff8087", "12 3 2 3 2 3"),
];

/// Smallest division of the series 1, 2, 5 × 10ⁿ µm with which all deviations stay within four divisions.
pub fn division_um(largest_deviation_um: f64) -> f64 {
    let wanted = largest_deviation_um.abs() / RINGS as f64;
    if !wanted.is_finite() || wanted <= 0.0 {
        return 1.0;
    }
    let decade = 10f64.powi(wanted.log10().floor() as i32);
    // 1e-9: a deviation of exactly four divisions still fits
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|step| step * decade).find(|&d| d >= wanted * (1.0 - 1e-9)).unwrap_or(decade)
}

impl PolarPlot {
    /// A plot with the division chosen by [`division_um`] and spokes every 30°.
    pub fn new(title: impl Into<String>, traces: Vec<PolarTrace>) -> PolarPlot {
        let spokes = (0..12).map(|k| ((30.0 * k as f64).to_radians(), format!("{}°", 30 * k))).collect();
        let division_um = division_um(largest(&traces));
        PolarPlot {
            title: title.into(),
            subtitle: String::new(),
            heavy_circle: "nominal length · outward: longer",
            division_um,
            spokes,
            arcs: Vec::new(),
            arrows: Vec::new(),
            traces,
        }
    }

    /// Labels the spokes at 0, 90, 180 and 270°.
    pub fn label_quarters(&mut self, labels: [String; 4]) {
        for (quarter, label) in labels.into_iter().enumerate() {
            if let Some(spoke) = self.spokes.get_mut(3 * quarter) {
                spoke.1 = label;
            }
        }
    }

    /// The plot as one SVG element with its own background; can stand in a file or inside a page.
    pub fn to_svg(&self) -> String {
        let division_um = if self.division_um > 0.0 && self.division_um.is_finite() { self.division_um } else { 1.0 };
        let needed = (largest(&self.traces) / division_um - 1e-9).ceil().max(0.0);
        // more than a thousand rings cannot be told apart: the scale is then cut there
        let rings = RINGS.max(needed.min(1000.0) as usize);
        let scale = Scale { px_per_um: (OUTER_PX - NOMINAL_PX) / (rings as f64 * division_um) };
        let head = if self.subtitle.is_empty() { 44.0 } else { 62.0 };
        let centre_y = head + 28.0 + OUTER_PX;
        let legend_y = centre_y + OUTER_PX + 56.0;
        let height = legend_y + 22.0 * (self.traces.len() as f64 / 2.0).ceil() + 14.0;
        let mut svg = String::new();
        let title = escape(&self.title);
        let _ = write!(
            svg,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH_PX} {height}\" width=\"{WIDTH_PX}\" \
             height=\"{height}\" role=\"img\" class=\"polar\" font-family=\"Helvetica, Arial, sans-serif\" \
             font-size=\"12\" fill=\"#1c2128\">\n<title>{title}</title>\n{}",
            dark_style()
        );
        let _ =
            writeln!(svg, "<rect class=\"polar-ground\" width=\"{WIDTH_PX}\" height=\"{height}\" fill=\"#ffffff\"/>");
        let middle = WIDTH_PX / 2.0;
        let _ = writeln!(
            svg,
            "<text x=\"{middle}\" y=\"30\" text-anchor=\"middle\" font-size=\"17\" font-weight=\"600\">{title}</text>"
        );
        if !self.subtitle.is_empty() {
            let _ = writeln!(
                svg,
                "<text x=\"{middle}\" y=\"50\" text-anchor=\"middle\" fill-opacity=\"0.75\">{}</text>",
                escape(&self.subtitle)
            );
        }
        let _ = writeln!(svg, "<g transform=\"translate({middle} {centre_y})\">");
        self.graticule(&mut svg, rings, division_um, &scale);
        self.arcs.iter().for_each(|&(from, to)| mark_arc(&mut svg, from, to));
        self.arrows.iter().enumerate().for_each(|(index, arrow)| draw_arrow(&mut svg, index, arrow));
        self.traces.iter().for_each(|trace| draw_trace(&mut svg, trace, &scale));
        svg.push_str("</g>\n");
        let _ = writeln!(
            svg,
            "<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">1 division = {} µm · heavy circle: {}</text>",
            legend_y - 8.0,
            number(division_um),
            self.heavy_circle
        );
        self.legend(&mut svg, legend_y + 14.0);
        svg.push_str("</svg>\n");
        svg
    }

    fn graticule(&self, svg: &mut String, rings: usize, division_um: f64, scale: &Scale) {
        let every = rings.div_ceil(MOST_RINGS);
        svg.push_str("<g class=\"polar-lines\" fill=\"none\" stroke=\"#1c2128\">\n");
        for (angle, _) in &self.spokes {
            let (inner, outer) = (scale.place(*angle, -(rings as f64) * division_um), at(*angle, OUTER_PX + 6.0));
            let _ = writeln!(
                svg,
                "<line x1=\"{:.2}\" y1=\"{:.2}\" x2=\"{:.2}\" y2=\"{:.2}\" stroke-opacity=\"0.18\"/>",
                inner.0, inner.1, outer.0, outer.1
            );
        }
        let drawn = || (1..=rings).filter(|ring| ring % every == 0);
        for ring in drawn() {
            for sign in [-1.0, 1.0] {
                let radius = scale.radius(sign * ring as f64 * division_um);
                let _ = writeln!(svg, "<circle r=\"{radius:.2}\" stroke-opacity=\"0.22\" stroke-width=\"0.8\"/>");
            }
        }
        let _ = writeln!(svg, "<circle r=\"{NOMINAL_PX}\" stroke-opacity=\"0.8\" stroke-width=\"1.6\"/>\n</g>");
        for (angle, label) in &self.spokes {
            let (x, y) = at(*angle, OUTER_PX + 24.0);
            let anchor = match angle.cos() {
                c if c > 0.3 => "start",
                c if c < -0.3 => "end",
                _ => "middle",
            };
            // labels lie just outside the last ring: a start or end anchor needs less room than the middle one
            let x = x - 8.0 * angle.cos();
            let _ = writeln!(
                svg,
                "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{}</text>",
                y + 4.0,
                escape(label)
            );
        }
        // ring values stand beside a line that no spoke of the usual twelve uses
        let along = 75f64.to_radians();
        for ring in drawn() {
            for sign in [-1.0, 1.0] {
                let value = sign * ring as f64 * division_um;
                let (x, y) = scale.place(along, value);
                let sign = if sign > 0.0 { "+" } else { "−" };
                let _ = writeln!(
                    svg,
                    "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" font-size=\"9\" class=\"polar-ring\" \
                     stroke=\"#ffffff\" stroke-width=\"3\" paint-order=\"stroke\">{sign}{}</text>",
                    y + 3.0,
                    number(value.abs())
                );
            }
        }
    }

    fn legend(&self, svg: &mut String, top: f64) {
        for (index, trace) in self.traces.iter().enumerate() {
            let (x, y) = (40.0 + 270.0 * (index % 2) as f64, top + 22.0 * (index / 2) as f64);
            let _ = writeln!(
                svg,
                "<line x1=\"{x}\" y1=\"{y}\" x2=\"{}\" y2=\"{y}\" {}/><text x=\"{}\" y=\"{}\">{}</text>",
                x + 44.0,
                stroke(trace.stroke),
                x + 54.0,
                y + 4.0,
                escape(&trace.label)
            );
        }
    }
}

/// Deviation to pixels.
struct Scale {
    px_per_um: f64,
}

impl Scale {
    fn radius(&self, deviation_um: f64) -> f64 {
        (NOMINAL_PX + deviation_um * self.px_per_um).clamp(0.0, OUTER_PX)
    }

    fn place(&self, angle_rad: f64, deviation_um: f64) -> (f64, f64) {
        at(angle_rad, self.radius(deviation_um))
    }
}

/// Points of a marked arc: a chord of two degrees is no polygon to the eye.
const ARC_STEPS_PER_RAD: f64 = 30.0;

/// A heavy arc just outside the last ring.
fn mark_arc(svg: &mut String, from: f64, to: f64) {
    // more than a turn marks everything, once
    let to = to.clamp(from - std::f64::consts::TAU, from + std::f64::consts::TAU);
    let steps = ((to - from).abs() * ARC_STEPS_PER_RAD).ceil().max(1.0) as usize;
    let mut path = String::new();
    for step in 0..=steps {
        let (x, y) = at(from + (to - from) * step as f64 / steps as f64, OUTER_PX + 4.0);
        let _ = write!(path, "{}{x:.1} {y:.1}", if step == 0 { 'M' } else { 'L' });
    }
    let _ = writeln!(
        svg,
        "<path class=\"polar-arc\" d=\"{path}\" fill=\"none\" stroke=\"#b3202c\" stroke-width=\"5\" stroke-opacity=\"0.55\"/>"
    );
}

/// Point on the picture, whose y runs down.
fn at(angle_rad: f64, radius_px: f64) -> (f64, f64) {
    (radius_px * angle_rad.cos(), -radius_px * angle_rad.sin())
}

fn largest(traces: &[PolarTrace]) -> f64 {
    let deviations = traces.iter().flat_map(|trace| &trace.points).map(|(_, deviation)| deviation.abs());
    deviations.filter(|deviation| deviation.is_finite()).fold(0.0, f64::max)
}

fn draw_trace(svg: &mut String, trace: &PolarTrace, scale: &Scale) {
    let mut path = String::new();
    let mut pen_down = false;
    for &(angle, deviation) in &trace.points {
        if !(angle.is_finite() && deviation.is_finite()) {
            pen_down = false;
            continue;
        }
        let (x, y) = scale.place(angle, deviation);
        let _ = write!(path, "{}{x:.2} {y:.2}", if pen_down { 'L' } else { 'M' });
        pen_down = true;
    }
    if !path.is_empty() {
        let _ = writeln!(svg, "<path d=\"{path}\" {}/>", stroke(trace.stroke));
    }
}

/// Attributes of a stroke; colours repeat after eight.
fn stroke(stroke: Stroke) -> String {
    let Stroke::Own(index) = stroke else {
        return "class=\"polar-grey\" fill=\"none\" stroke=\"#8b939d\" stroke-width=\"1.1\" stroke-linejoin=\"round\""
            .into();
    };
    let index = index % STROKES.len();
    let (light, _, dash) = STROKES[index];
    let dash = if dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dash}\"") };
    format!(
        "class=\"polar-trace-{index}\" fill=\"none\" stroke=\"{light}\" stroke-width=\"1.7\" stroke-linejoin=\"round\"{dash}"
    )
}

/// Length of an arrow, rad, and of its head, px.
const ARROW_RAD: f64 = 0.22;
const HEAD_PX: f64 = 6.0;

/// An arrow along the circle outside the rings, each a little farther out than the one before.
fn draw_arrow(svg: &mut String, index: usize, arrow: &Arrow) {
    let radius = OUTER_PX + 10.0 + 5.0 * index as f64;
    let sign = if arrow.is_ccw { 1.0 } else { -1.0 };
    let to = arrow.from + sign * ARROW_RAD;
    let (a, b) = (at(arrow.from, radius), at(to, radius));
    let back = to - sign * 1.6 * HEAD_PX / radius;
    let (inner, outer) = (at(back, radius - 0.6 * HEAD_PX), at(back, radius + 0.6 * HEAD_PX));
    // pictures run down, so that a counter-clockwise arc has sweep 0
    let sweep = if arrow.is_ccw { 0 } else { 1 };
    let index = arrow.stroke % STROKES.len();
    let _ = writeln!(
        svg,
        "<path class=\"polar-trace-{index}\" d=\"M{:.1} {:.1}A{radius} {radius} 0 0 {sweep} {:.1} {:.1}M{:.1} {:.1}L{:.1} {:.1}L{:.1} {:.1}\" \
         fill=\"none\" stroke=\"{}\" stroke-width=\"1.7\"/>",
        a.0, a.1, b.0, b.1, inner.0, inner.1, b.0, b.1, outer.0, outer.1, STROKES[index].0
    );
}

fn dark_style() -> String {
    let mut style = String::from(
        "<style>@media (prefers-color-scheme: dark){.polar{fill:#e6e9ee}.polar-ground{fill:#14181f}\
         .polar-lines{stroke:#e6e9ee}.polar-ring{stroke:#14181f}.polar-grey{stroke:#77818d}.polar-arc{stroke:#ff8087}",
    );
    for (index, (_, dark, _)) in STROKES.iter().enumerate() {
        let _ = write!(style, ".polar-trace-{index}{{stroke:{dark}}}");
    }
    style.push_str("}</style>\n");
    style
}

/// A number with at most three decimals and none that are zero.
fn number(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn divisions_are_one_two_or_five_and_hold_the_trace_in_four_rings() {
        for (largest, division) in [(8.0, 2.0), (8.1, 5.0), (0.39, 0.1), (20.0, 5.0), (21.0, 10.0), (0.0, 1.0)] {
            assert!((division_um(largest) - division).abs() < 1e-12, "{largest}: {}", division_um(largest));
        }
        assert_eq!(division_um(f64::NAN), 1.0);
    }

    #[test]
    fn a_deviation_of_one_division_lies_on_the_first_ring_outside_the_nominal_circle() {
        let trace = PolarTrace {
            label: "a < b".into(),
            points: vec![(0.0, 5.0), (0.1, f64::NAN), (0.2, 0.0)],
            stroke: Stroke::Own(0),
        };
        let svg = PolarPlot { division_um: 5.0, ..PolarPlot::new("R & D", vec![trace]) }.to_svg();
        assert!(svg.contains("d=\"M157.00 -0.00M"), "{svg}");
        assert!(svg.contains("<circle r=\"157.00\"") && svg.contains("1 division = 5 µm"));
        assert!(svg.contains("a &lt; b") && svg.contains("R &amp; D"));
    }
}
