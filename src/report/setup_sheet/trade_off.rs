//! The trade-off curve: worst uncertainty over the goal against machine time, the plan marked. It computes nothing.

use std::fmt::Write as _;

use crate::plan::{Plan, Settings, TradeOff};
use crate::units::Measure;

const WIDTH: f64 = 420.0;
const HEIGHT: f64 = 230.0;
/// Room for numbers: left, right, top, bottom.
const ROOM: [f64; 4] = [52.0, 12.0, 14.0, 40.0];

/// The picture with its heading and a table of the same; nothing for a plan without tests.
pub(super) fn trade_off(out: &mut String, plan: &Plan, settings: &Settings) {
    let Some(scales) = Scales::of(plan, settings) else { return };
    out.push_str("<h2>Time against uncertainty</h2><div class=\"pair\"><div>");
    let _ = write!(
        out,
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"trade-off curve\" font-size=\"12\">"
    );
    axes(out, &scales);
    let position = |point: &TradeOff| point.position_mm / settings.goal.position_mm;
    let orientation = |point: &TradeOff| point.orientation_rad / settings.goal.orientation_rad;
    series(out, &scales, plan, &position, ("worst position", "#a30", 0.0));
    series(out, &scales, plan, &orientation, ("worst orientation", "#03a", 16.0));
    out.push_str("</svg></div><div><p>Worst standard deviation as a multiple of the goal, after one test, two, and so on in the order of choice; the large dots are this plan.</p>");
    table(out, &plan.curve);
    out.push_str("</div></div>");
}

/// Where minutes and ratios to the goal lie in the picture.
struct Scales {
    /// Decades of the lower and the upper edge.
    low: f64,
    high: f64,
    /// Minutes at the right edge.
    most: f64,
}

impl Scales {
    /// Scales that hold the goal and all points of the curve; nothing for a plan without tests.
    fn of(plan: &Plan, settings: &Settings) -> Option<Scales> {
        let goal = &settings.goal;
        let ratios_of =
            |point: &TradeOff| [point.position_mm / goal.position_mm, point.orientation_rad / goal.orientation_rad];
        let ratios = plan.curve.iter().flat_map(ratios_of);
        let shown: Vec<f64> = ratios.filter(|ratio| *ratio > 0.0 && ratio.is_finite()).chain([1.0]).collect();
        let low = shown.iter().copied().fold(f64::MAX, f64::min).log10().min(-0.3).floor();
        let high = shown.iter().copied().fold(f64::MIN, f64::max).log10().ceil().max(low + 1.0);
        Some(Scales { low, high, most: plan.curve.last()?.minutes.max(plan.minutes) * 1.08 })
    }

    /// Where a time lies, px.
    fn x(&self, minutes: f64) -> f64 {
        ROOM[0] + minutes / self.most * (WIDTH - ROOM[0] - ROOM[1])
    }

    /// Where a ratio to the goal lies, px.
    fn y(&self, ratio: f64) -> f64 {
        let part = (ratio.log10().clamp(self.low, self.high) - self.low) / (self.high - self.low);
        HEIGHT - ROOM[3] - part * (HEIGHT - ROOM[2] - ROOM[3])
    }
}

/// Lines of the decades, minutes below, and the line of the goal.
fn axes(out: &mut String, scales: &Scales) {
    for decade in scales.low as i32..=scales.high as i32 {
        let at = scales.y(10f64.powi(decade));
        let _ = write!(
            out,
            "<line x1=\"{}\" y1=\"{at:.1}\" x2=\"{}\" y2=\"{at:.1}\" stroke=\"#ddd\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            ROOM[0],
            WIDTH - ROOM[1],
            ROOM[0] - 5.0,
            at + 4.0,
            10f64.powi(decade)
        );
    }
    let steps = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0];
    let step = steps.into_iter().find(|step| scales.most / step < 8.0).unwrap_or(500.0);
    for k in 0..=(scales.most / step) as usize {
        let minutes = step * k as f64;
        let _ = write!(
            out,
            "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{minutes}</text>",
            scales.x(minutes),
            HEIGHT - ROOM[3] + 16.0
        );
    }
    let _ = write!(
        out,
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">minutes</text>\
         <line x1=\"{}\" y1=\"{goal:.1}\" x2=\"{}\" y2=\"{goal:.1}\" stroke=\"#080\" stroke-dasharray=\"5 4\"/>\
         <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"#060\">goal</text>",
        0.5 * (WIDTH + ROOM[0]),
        HEIGHT - 8.0,
        ROOM[0],
        WIDTH - ROOM[1],
        WIDTH - ROOM[1] - 2.0,
        scales.y(1.0) - 4.0,
        goal = scales.y(1.0),
    );
}

/// One curve of ratios to the goal with its dots, and its name and colour at a height below the first name's, px.
fn series(
    out: &mut String,
    scales: &Scales,
    plan: &Plan,
    ratio: &dyn Fn(&TradeOff) -> f64,
    (name, colour, below): (&str, &str, f64),
) {
    let dots = || plan.curve.iter().map(|point| (point, scales.x(point.minutes), scales.y(ratio(point))));
    let points: Vec<String> = dots().map(|(_, x, y)| format!("{x:.1},{y:.1}")).collect();
    let _ = write!(
        out,
        "<polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.8\" points=\"{}\"/>",
        points.join(" ")
    );
    for (point, x, y) in dots() {
        let chosen = (point.minutes - plan.minutes).abs() < 1e-6;
        let (radius, edge) = if chosen { (6.0, "#111") } else { (3.0, colour) };
        let _ = write!(
            out,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"{colour}\" stroke=\"{edge}\" stroke-width=\"1.5\"><title>{} tests, {:.1} min</title></circle>",
            point.tests, point.minutes
        );
    }
    let _ = write!(
        out,
        "<text x=\"{}\" y=\"{}\" fill=\"{colour}\">{name}</text>",
        ROOM[0] + 8.0,
        HEIGHT - ROOM[3] - 24.0 + below
    );
}

/// The curve in numbers.
fn table(out: &mut String, curve: &[TradeOff]) {
    out.push_str("<table class=\"wide\"><tr><th>tests</th><th>minutes</th><th>pivots</th><th>worst position</th><th>worst orientation</th></tr>");
    for point in curve {
        let _ = write!(
            out,
            "<tr><td>{}</td><td>{:.1}</td><td>{}</td><td>{:.2} µm</td><td>{:.2} arcsec</td></tr>",
            point.tests,
            point.minutes,
            point.pivot_setups,
            Measure::Length.to_output(point.position_mm),
            Measure::Angle.to_output(point.orientation_rad)
        );
    }
    out.push_str("</table>");
}
