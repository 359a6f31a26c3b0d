//! The setup sheet: one printable HTML page with a picture of each setup from two sides. It computes nothing.

use std::fmt::Write as _;

use crate::machine::Machine;
use crate::plan::{Plan, PlannedTest};
use crate::units::Measure;

/// A part in a view.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    pub name: String,
    /// Ball bar, cups, stand; else the machine.
    pub instrument: bool,
    /// Polygon, right and up, mm.
    pub points: Vec<[f64; 2]>,
}

/// A machine with its instrument seen from one side.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Pivot ball, right and up, mm.
    pub middle: [f64; 2],
    pub outlines: Vec<Outline>,
}

/// Half of the picture's edge, mm on the machine.
const HALF_MM: f64 = 420.0;

const STYLE: &str = "body{font:13px/1.45 sans-serif;margin:2em;color:#222}table{border-collapse:collapse;margin:.6em 0}\
td,th{border:1px solid #bbb;padding:2px 8px;text-align:left}section{break-inside:avoid;border-top:2px solid #444;margin-top:1.2em}\
svg{width:46%;height:auto;border:1px solid #ccc;margin-right:1%}.tick{display:inline-block;width:1em;height:1em;border:1px solid #444}";

/// The page of a plan; `pictures` has two views for each test.
pub fn setup_sheet(machine: &Machine, plan: &Plan, pictures: &[[View; 2]]) -> String {
    let mut out = String::new();
    let title = escaped(&machine.name);
    let _ = write!(
        out,
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>Setup sheet, {title}</title><style>{STYLE}</style></head><body>\
         <h1>Setup sheet: {title} {}</h1><p>{} tests in both directions, {} pivot setups, about {:.0} minutes.</p>",
        escaped(&machine.code.to_string()),
        plan.tests.len(),
        plan.pivot_setups,
        plan.minutes
    );
    for (index, planned) in plan.tests.iter().enumerate() {
        let test = &planned.test;
        let (p, s) = (test.pivot.at, test.spindle_ball.at);
        let _ =
            write!(out, "<section><h2><span class=\"tick\"></span> {}. {}</h2><table>", index + 1, escaped(&test.name));
        let mut row = |key: &str, value: String| {
            let _ = write!(out, "<tr><th>{key}</th><td>{}</td></tr>", escaped(&value));
        };
        row(
            "pivot",
            format!("on {} (link {}), ball {:.3} mm above it", planned.mount, test.pivot.link, planned.height_mm),
        );
        row("pivot ball, all axes at zero", format!("x {:.3}  y {:.3}  z {:.3} mm", p.x, p.y, p.z));
        row("spindle ball, all axes at zero", format!("x {:.3}  y {:.3}  z {:.3} mm", s.x, s.y, s.z));
        if test.spindle_ball.indexed_about.is_some() {
            row("spindle", "indexed by 180° from all other tests, the cup not taken out".into());
        }
        row("bar", format!("{} mm", test.bar_length_mm.unwrap_or(0.0)));
        let stands: Vec<String> = machine
            .axes
            .iter()
            .enumerate()
            .filter_map(|(k, axis)| {
                let q = axis.kind.to_file_unit(test.positions[k]?);
                let reading =
                    machine.machine_zero[k].map(|zero| format!(" (control {:.4})", q + zero)).unwrap_or_default();
                Some(format!("{} {q:.4}{reading}", axis.name))
            })
            .collect();
        row("stand", stands.join(", "));
        row(
            "sweep",
            format!(
                "{} {}° to {}° and back, run-in {}, {} mm/min at the ball",
                super::what_moves(planned, machine),
                planned.sweep.from_deg,
                planned.sweep.to_deg,
                run_in_in_words(planned),
                test.feed_mm_per_min.unwrap_or(0.0)
            ),
        );
        if planned.run.len() > 4 {
            row("travel", travel(machine, planned));
        }
        row("way to the start", super::approach_in_words(planned, machine));
        let (one, other) = &planned.sweep.pair;
        row("least clearance", format!("{:.1} mm, {one} – {other}", planned.sweep.clearance_mm));
        out.push_str("</table>");
        if let Some(views) = pictures.get(index) {
            for (view, side) in views.iter().zip(["front", "side"]) {
                picture(&mut out, view, side);
            }
        }
        out.push_str("</section>");
    }
    out.push_str("<section><h2>What these tests determine</h2><table><tr><th>error</th><th>1 sigma</th><th>relative to the spindle ball</th><th></th></tr>");
    for error in &plan.errors {
        let measure = if error.is_angle { Measure::Angle } else { Measure::Length };
        let _ = write!(
            out,
            "<tr><td>{}</td><td>{:.2} {unit}</td><td>{:.2} {unit}</td><td>{}{}</td></tr>",
            error.name,
            measure.to_output(error.sigma),
            measure.to_output(error.sigma_relative),
            if error.determined { "" } else { "undetermined: " },
            escaped(&error.reason),
            unit = measure.output_unit(),
        );
    }
    out.push_str("</table></section></body></html>\n");
    out
}

/// How far outside the arc the run begins: in the unit of the axis that moves fastest.
fn run_in_in_words(planned: &PlannedTest) -> String {
    let run_in = planned.test.overshoot.unwrap_or(0.0);
    match planned.run.len() {
        0..=4 => format!("{run_in}°"),
        _ => format!("straight on by {run_in} mm or {run_in}°, whichever is reached first"),
    }
}

/// From where to where every axis goes in a run of several axes, run-in included.
fn travel(machine: &Machine, planned: &PlannedTest) -> String {
    let range = |k: usize| {
        let shown = |q: f64| machine.axes[k].kind.to_file_unit(q);
        let ends =
            planned.run.iter().fold((f64::MAX, f64::MIN), |(low, high), row| (low.min(row[k]), high.max(row[k])));
        (shown(ends.0), shown(ends.1))
    };
    let moving = (0..machine.axes.len()).map(|k| (k, range(k))).filter(|(_, (low, high))| high - low > 1e-6);
    let words: Vec<String> =
        moving.map(|(k, (low, high))| format!("{} {low:.3} to {high:.3}", machine.axes[k].name)).collect();
    words.join(", ")
}

fn picture(out: &mut String, view: &View, side: &str) {
    let [x, y] = view.middle;
    let _ = write!(
        out,
        "<svg viewBox=\"{:.0} {:.0} {:.0} {:.0}\" role=\"img\" aria-label=\"{side}\">",
        x - HALF_MM,
        -y - HALF_MM,
        2.0 * HALF_MM,
        2.0 * HALF_MM
    );
    for outline in &view.outlines {
        let points: Vec<String> = outline.points.iter().map(|p| format!("{:.1},{:.1}", p[0], -p[1])).collect();
        let look = if outline.instrument {
            "fill=\"#c33\" fill-opacity=\".75\" stroke=\"#600\""
        } else {
            "fill=\"#678\" fill-opacity=\".18\" stroke=\"#345\""
        };
        let _ = write!(
            out,
            "<polygon {look} stroke-width=\"1\" points=\"{}\"><title>{}</title></polygon>",
            points.join(" "),
            escaped(&outline.name)
        );
    }
    let _ = write!(
        out,
        "<text x=\"{:.0}\" y=\"{:.0}\" font-size=\"28\">{side}</text></svg>",
        x - HALF_MM + 12.0,
        -y - HALF_MM + 34.0
    );
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
