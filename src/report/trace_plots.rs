//! Plots of one test: deviations round a circle, and the residual unrolled. Values come from the fit; nothing is fitted.

use std::fmt::Write as _;

use super::polar::{PolarPlot, PolarTrace, escape};
use crate::identify::TestFit;
use crate::machine::AxisKind;
use crate::session::{Motion, Path, Session, Test};
use crate::units::UM_PER_MM;

/// Plots of one test as SVG.
#[derive(Debug, Clone, PartialEq)]
pub struct TestPlots {
    pub test: String,
    /// Measured, model and residual; absent for static poses and straight sweeps.
    pub polar: Option<String>,
    /// Residual over the swept position, or over the reading's number.
    pub residual: String,
}

/// Most points of a trace in a polar plot: finer than a pixel on any page.
const MOST_POINTS: usize = 721;

/// Plots of a test that has a recording.
pub fn test_plots(session: &Session, test: &Test, motion: &Motion, fit: &TestFit) -> Option<TestPlots> {
    let recording = test.recording.as_ref()?;
    let finite: Vec<f64> = recording.length_mm.iter().copied().filter(|length| length.is_finite()).collect();
    // an absolute gauge has no nominal length; its mean stands for it
    let nominal_mm = test.bar_length_mm.unwrap_or(finite.iter().sum::<f64>() / finite.len().max(1) as f64);
    let position = swept(session, test, motion);
    let polar = position.as_ref().and_then(|swept| swept.angle_rad.as_ref()).map(|angle_rad| {
        let every = angle_rad.len().div_ceil(MOST_POINTS).max(1);
        let trace = |label: &str, value: &dyn Fn(usize) -> f64| PolarTrace {
            label: label.into(),
            points: (0..angle_rad.len()).step_by(every).map(|row| (angle_rad[row], value(row))).collect(),
        };
        let taken = |row: usize| fit.kept.get(row).copied().unwrap_or(false);
        let read = |row: usize| {
            if taken(row) { (recording.length_mm[row] - nominal_mm) * UM_PER_MM } else { f64::NAN }
        };
        let residual = |row: usize| if taken(row) { fit.residual_mm[row] * UM_PER_MM } else { f64::NAN };
        let model = |row: usize| read(row) - residual(row);
        let mut plot = PolarPlot::new(
            &test.name,
            vec![trace("measured", &read), trace("model", &model), trace("residual (measured − model)", &residual)],
        );
        plot.subtitle = format!("{} · nominal {nominal_mm:.4} mm", moves(session, motion));
        plot.to_svg()
    });
    let (abscissa, label) = match position {
        Some(swept) => (swept.value, swept.label),
        None => ((0..motion.rows()).map(|row| row as f64 + 1.0).collect(), "reading".to_string()),
    };
    let residual = unrolled(&test.name, &label, &abscissa, fit);
    Some(TestPlots { test: test.name.clone(), polar, residual })
}

/// What a test moves: `C`, `X Y C`.
fn moves(session: &Session, motion: &Motion) -> String {
    let names: Vec<&str> = motion.moving.iter().map(|&axis| session.machine.axes[axis].name.as_str()).collect();
    format!("moving {}", names.join(" "))
}

/// The position over which a test is drawn.
struct Swept {
    label: String,
    /// mm or degrees.
    value: Vec<f64>,
    /// Angle round the circle where there is one, rad.
    angle_rad: Option<Vec<f64>>,
}

/// The rotary axis that turns farthest, the angle of a planar circle, or the linear axis that goes farthest.
fn swept(session: &Session, test: &Test, motion: &Motion) -> Option<Swept> {
    motion.time_s.as_ref()?;
    let axes = &session.machine.axes;
    let travel = |axis: usize| {
        let (low, high) =
            motion.axis(axis).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), q| (low.min(q), high.max(q)));
        high - low
    };
    let farthest = |kind: AxisKind| {
        let moving = motion.moving.iter().copied().filter(|&axis| axes[axis].kind == kind && travel(axis) > 0.0);
        moving.max_by(|&a, &b| travel(a).total_cmp(&travel(b)))
    };
    if let Some(axis) = farthest(AxisKind::Rotary) {
        let angle: Vec<f64> = motion.axis(axis).collect();
        let value = angle.iter().map(|angle| angle.to_degrees()).collect();
        return Some(Swept { label: format!("{}, °", axes[axis].name), value, angle_rad: Some(angle) });
    }
    let linear: Vec<usize> = motion.moving.iter().copied().filter(|&axis| travel(axis) > 0.0).collect();
    if let [first, second] = linear[..] {
        let (first, second) = match &test.path {
            Some(Path::Circle { plane, .. }) => (plane.first, plane.second),
            _ => plane_order(session, first, second),
        };
        let pivot = circle_centre(motion, first, second);
        let angle: Vec<f64> = (0..motion.rows())
            .map(|row| (motion.row(row)[second] - pivot.1).atan2(motion.row(row)[first] - pivot.0))
            .collect();
        let value = unwrapped_deg(&angle);
        let label = format!("angle in {}{}, °", axes[first].name, axes[second].name);
        return Some(Swept { label, value, angle_rad: Some(angle) });
    }
    let axis = farthest(AxisKind::Linear)?;
    Some(Swept { label: format!("{}, mm", axes[axis].name), value: motion.axis(axis).collect(), angle_rad: None })
}

/// XY, YZ, ZX: the order in which a circle's angle counts.
fn plane_order(session: &Session, one: usize, other: usize) -> (usize, usize) {
    let along = |axis: usize| session.machine.axes[axis].coordinate_direction().unwrap_or(0);
    if (along(one) + 1) % 3 == along(other) { (one, other) } else { (other, one) }
}

/// Centre of the commanded positions of two axes, from three rows.
fn circle_centre(motion: &Motion, first: usize, second: usize) -> (f64, f64) {
    let point = |row: usize| (motion.row(row)[first], motion.row(row)[second]);
    let rows = motion.rows();
    // thirds of the path are far apart on full turns and short arcs alike
    let (a, b, c) = (point(0), point(rows / 3), point(2 * rows / 3));
    let twice = 2.0 * (a.0 * (b.1 - c.1) + b.0 * (c.1 - a.1) + c.0 * (a.1 - b.1));
    let square = |p: (f64, f64)| p.0 * p.0 + p.1 * p.1;
    let x = (square(a) * (b.1 - c.1) + square(b) * (c.1 - a.1) + square(c) * (a.1 - b.1)) / twice;
    let y = (square(a) * (c.0 - b.0) + square(b) * (a.0 - c.0) + square(c) * (b.0 - a.0)) / twice;
    if x.is_finite() && y.is_finite() { (x, y) } else { (0.0, 0.0) }
}

fn unwrapped_deg(angle_rad: &[f64]) -> Vec<f64> {
    let mut turns = 0.0;
    let mut last: Option<f64> = None;
    angle_rad
        .iter()
        .map(|angle| {
            let degrees = angle.to_degrees();
            if let Some(last) = last {
                turns -= 360.0 * ((degrees - last) / 360.0).round();
            }
            last = Some(degrees);
            degrees + turns
        })
        .collect()
}

const WIDTH: f64 = 600.0;
const HEIGHT: f64 = 230.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 40.0;
const BOTTOM: f64 = 44.0;

/// Residual over a position: points that took part as a line, rows left out as crosses at the edge or in place.
fn unrolled(name: &str, label: &str, abscissa: &[f64], fit: &TestFit) -> String {
    let taken = |row: &usize| fit.kept[*row] && fit.residual_mm[*row].is_finite();
    let rows = || (0..fit.residual_mm.len()).filter(taken);
    let largest = rows().map(|row| fit.residual_mm[row].abs() * UM_PER_MM).fold(0.0, f64::max);
    let step = round_step(largest.max(1e-3) / 2.0);
    let reach = step * (largest / step).ceil().max(1.0);
    let (low, high) = abscissa.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
    let (low, high) = if high > low { (low, high) } else { (low - 1.0, low + 1.0) };
    let x = |value: f64| LEFT + (value - low) / (high - low) * (WIDTH - LEFT - RIGHT);
    let y = |um: f64| TOP + (1.0 - um / reach) * (HEIGHT - TOP - BOTTOM) / 2.0;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" \
         height=\"{HEIGHT}\" role=\"img\" class=\"unrolled\" font-family=\"Helvetica, Arial, sans-serif\" \
         font-size=\"12\" fill=\"#1c2128\">\n<title>Residual of {0}</title>\n<style>@media (prefers-color-scheme: dark)\
         {{.unrolled{{fill:#e6e9ee}}.unrolled-ground{{fill:#14181f}}.unrolled-lines{{stroke:#e6e9ee}}\
         .unrolled-trace{{stroke:#4fd6a8}}.unrolled-out{{stroke:#ff8087}}}}</style>\n\
         <rect class=\"unrolled-ground\" width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#ffffff\"/>\n\
         <text x=\"{LEFT}\" y=\"24\" font-weight=\"600\">Residual of {0}: {1:.2} µm rms</text>\n",
        escape(name),
        fit.rms_mm * UM_PER_MM
    );
    svg.push_str("<g class=\"unrolled-lines\" stroke=\"#1c2128\">\n");
    let count = (reach / step).round() as i64;
    for k in -count..=count {
        let opacity = if k == 0 { 0.7 } else { 0.18 };
        let at = y(k as f64 * step);
        let _ = writeln!(
            svg,
            "<line x1=\"{LEFT}\" x2=\"{}\" y1=\"{at:.1}\" y2=\"{at:.1}\" stroke-opacity=\"{opacity}\"/>",
            WIDTH - RIGHT
        );
    }
    let across = position_step(high - low);
    let ticks: Vec<f64> = {
        let first = (low / across - 1e-9).ceil() as i64;
        let last = (high / across + 1e-9).floor() as i64;
        (first..=last).map(|k| k as f64 * across).collect()
    };
    for &tick in &ticks {
        let at = x(tick);
        let _ = writeln!(
            svg,
            "<line x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{TOP}\" y2=\"{}\" stroke-opacity=\"0.12\"/>",
            HEIGHT - BOTTOM
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
    for &tick in &ticks {
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            x(tick),
            HEIGHT - BOTTOM + 16.0,
            plain(tick)
        );
    }
    let middle = (TOP + HEIGHT - BOTTOM) / 2.0;
    let _ = writeln!(
        svg,
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n\
         <text transform=\"translate(14 {middle}) rotate(-90)\" text-anchor=\"middle\">µm</text>",
        (LEFT + WIDTH - RIGHT) / 2.0,
        HEIGHT - 8.0,
        escape(label)
    );
    let mut path = String::new();
    let mut pen = 'M';
    for row in 0..fit.residual_mm.len().min(abscissa.len()) {
        if taken(&row) {
            let _ = write!(path, "{pen}{:.1} {:.1}", x(abscissa[row]), y(fit.residual_mm[row] * UM_PER_MM));
            pen = 'L';
        } else {
            pen = 'M';
        }
    }
    let _ = writeln!(
        svg,
        "<path class=\"unrolled-trace\" d=\"{path}\" fill=\"none\" stroke=\"#00805c\" stroke-width=\"1.2\" \
         stroke-linejoin=\"round\"/>"
    );
    for &row in &fit.left_out {
        let um = (fit.residual_mm[row] * UM_PER_MM).clamp(-reach, reach);
        let (at, level) = (x(abscissa[row]), y(um));
        let _ = writeln!(
            svg,
            "<path class=\"unrolled-out\" d=\"M{:.1} {:.1}l8 8m0 -8l-8 8\" stroke=\"#b3202c\" stroke-width=\"1.6\"/>",
            at - 4.0,
            level - 4.0
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

/// Step of the position axis: round numbers, for degrees those of a protractor.
fn position_step(span: f64) -> f64 {
    let wanted = span / 8.0;
    [10.0, 15.0, 30.0, 45.0, 60.0, 90.0, 180.0, 360.0]
        .into_iter()
        .find(|step| *step >= wanted && wanted > 5.0)
        .unwrap_or_else(|| round_step(wanted))
}

fn plain(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.replace('-', "−") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_run_on_over_the_half_turn() {
        let degrees = unwrapped_deg(&[3.0f64, 3.1, -3.1, -3.0].map(|v| v));
        assert!(degrees.windows(2).all(|pair| pair[1] > pair[0]), "{degrees:?}");
    }

    #[test]
    fn steps_are_round_and_cover() {
        assert_eq!(round_step(0.3), 0.5);
        assert_eq!(position_step(360.0), 45.0);
        assert_eq!(position_step(1000.0), 180.0);
    }
}
