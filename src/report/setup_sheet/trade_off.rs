//! The trade-off curve: worst uncertainty over the goal against machine time, the plan marked. It computes nothing.

use std::fmt::Write as _;

use super::html_text::escaped;
use crate::plan::{Plan, Settings, TradeOff};

const WIDTH: f64 = 420.0;
const HEIGHT: f64 = 230.0;
/// Room for numbers: left, right, top, bottom.
const ROOM: [f64; 4] = [52.0, 12.0, 14.0, 40.0];

/// The picture with its heading; nothing for a plan without tests.
pub(super) fn trade_off(out: &mut String, plan: &Plan, settings: &Settings) {
    let Some(last) = plan.curve.last() else { return };
    let goal = &settings.goal;
    let position = |point: &TradeOff| point.position_mm / goal.position_mm;
    let orientation = |point: &TradeOff| point.orientation_rad / goal.orientation_rad;
    let ratios = plan.curve.iter().flat_map(|point| [position(point), orientation(point)]);
    let shown: Vec<f64> = ratios.filter(|ratio| *ratio > 0.0 && ratio.is_finite()).chain([1.0]).collect();
    let low = shown.iter().copied().fold(f64::MAX, f64::min).log10().min(-0.3).floor();
    let high = shown.iter().copied().fold(f64::MIN, f64::max).log10().ceil().max(low + 1.0);
    let most = last.minutes.max(plan.minutes) * 1.08;
    let x = |minutes: f64| ROOM[0] + minutes / most * (WIDTH - ROOM[0] - ROOM[1]);
    let y = |ratio: f64| {
        let part = (ratio.log10().clamp(low, high) - low) / (high - low);
        HEIGHT - ROOM[3] - part * (HEIGHT - ROOM[2] - ROOM[3])
    };
    out.push_str("<h2>Time against uncertainty</h2><div class=\"pair\"><div>");
    let _ = write!(
        out,
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"trade-off curve\" font-size=\"12\">"
    );
    for decade in low as i32..=high as i32 {
        let at = y(10f64.powi(decade));
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
    let step =
        [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0].into_iter().find(|step| most / step < 8.0).unwrap_or(500.0);
    for k in 0..=(most / step) as usize {
        let minutes = step * k as f64;
        let _ = write!(
            out,
            "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{minutes}</text>",
            x(minutes),
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
        y(1.0) - 4.0,
        goal = y(1.0),
    );
    let positions: Vec<f64> = plan.curve.iter().map(position).collect();
    let orientations: Vec<f64> = plan.curve.iter().map(orientation).collect();
    let series = [(positions, "#a30", "worst position"), (orientations, "#03a", "worst orientation")];
    for (row, (ratios, colour, name)) in series.into_iter().enumerate() {
        let dots = || plan.curve.iter().zip(&ratios);
        let points: Vec<String> =
            dots().map(|(point, ratio)| format!("{:.1},{:.1}", x(point.minutes), y(*ratio))).collect();
        let _ = write!(
            out,
            "<polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.8\" points=\"{}\"/>",
            points.join(" ")
        );
        for (point, ratio) in dots() {
            let chosen = (point.minutes - plan.minutes).abs() < 1e-6;
            let (radius, edge) = if chosen { (6.0, "#111") } else { (3.0, colour) };
            let _ = write!(
                out,
                "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius}\" fill=\"{colour}\" stroke=\"{edge}\" stroke-width=\"1.5\"><title>{} tests, {:.1} min</title></circle>",
                x(point.minutes),
                y(*ratio),
                point.tests,
                point.minutes
            );
        }
        let _ = write!(
            out,
            "<text x=\"{}\" y=\"{}\" fill=\"{colour}\">{}</text>",
            ROOM[0] + 8.0,
            HEIGHT - ROOM[3] - 24.0 + 16.0 * row as f64,
            escaped(name)
        );
    }
    out.push_str("</svg></div><div><p>Worst standard deviation as a multiple of the goal, after one test, two, and so on in the order of choice; the large dots are this plan.</p>");
    out.push_str("<table class=\"wide\"><tr><th>tests</th><th>minutes</th><th>pivots</th><th>worst position</th><th>worst orientation</th></tr>");
    for point in &plan.curve {
        let _ = write!(
            out,
            "<tr><td>{}</td><td>{:.1}</td><td>{}</td><td>{:.2} µm</td><td>{:.2} arcsec</td></tr>",
            point.tests,
            point.minutes,
            point.pivot_setups,
            crate::units::Measure::Length.to_output(point.position_mm),
            crate::units::Measure::Angle.to_output(point.orientation_rad)
        );
    }
    out.push_str("</table></div></div>");
}
