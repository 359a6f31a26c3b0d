//! The thesis's estimates as a terminal table and as JSON; computes nothing, see `methods`.

use std::fmt::Write as _;

use serde_json::{Value, json};

use crate::methods::{Bar, CompensatedTrace, Runs, ThesisEstimate, ThesisValue};
use crate::report::wording::table::Table;
use crate::session::Session;
use crate::units::UM_PER_MM;

/// Results, circles and remarks as text for a terminal.
pub fn thesis_text(estimate: &ThesisEstimate, session: &Session) -> String {
    let mut text = format!("{}: {} by the thesis's {}\n\n", session.machine.name, session.name, estimate.method);
    let mut results = Table::new(&["error", "value", "unit", "sd of run", "sd of mean", "outer tilt left in"]);
    for value in &estimate.values {
        let measure = value.name.component.measure();
        let deviation = |value: Option<f64>| value.map_or("–".into(), |sd| format!("{:.2}", measure.to_output(sd)));
        results.row(vec![
            value.name.to_string(),
            format!("{:+.2}", measure.to_output(value.value)),
            measure.output_unit().into(),
            deviation(value.run_deviation),
            deviation(value.mean_deviation),
            value.left_in.as_ref().map_or(String::new(), |(taken_out, left_in)| {
                format!("{:+.2} with {taken_out}", measure.to_output(*left_in))
            }),
        ]);
    }
    text.push_str(&results.text());
    text.push_str("\ncircles in the turning plane, mean of all runs (± standard deviation of a run)\n");
    let mut circles = Table::new(&["axis", "bar", "at mm", "runs", "centre µm", "", "radius mm", "rms µm"]);
    for runs in &estimate.runs {
        let centre = |k: usize| {
            let deviation = runs.centre_scatter[k].of_one_run;
            let deviation = deviation.map_or(String::new(), |variance| format!(" ±{:.2}", variance.sqrt() * UM_PER_MM));
            format!("{} {:+.2}{deviation}", coordinate(runs, k), runs.centre_mm[k] * UM_PER_MM)
        };
        circles.row(vec![
            session.machine.axes[runs.axis].name.clone(),
            bar_word(runs).into(),
            format!("{:+.2}", runs.at_mm),
            runs.circles.len().to_string(),
            centre(0),
            centre(1),
            format!("{:.4}", runs.radius_mm),
            format!("{:.2}", mean_rms_um(runs)),
        ]);
    }
    text.push_str(&circles.text());
    text.push_str("\ndeviations, largest minus smallest, and what the circles leave\n");
    let mut traces = Table::new(&["test", "measured µm", "compensated µm", "residual rms µm"]);
    for trace in &estimate.traces {
        traces.row(vec![
            trace.test.clone(),
            format!("{:.2}", range_um(&trace.measured_mm)),
            format!("{:.2}", range_um(&trace.compensated_mm)),
            format!("{:.2}", rms_um(&trace.residual_mm)),
        ]);
    }
    text.push_str(&traces.text());
    text.push('\n');
    for remark in &estimate.remarks {
        let _ = writeln!(text, "note: {remark}");
    }
    text
}

/// Letter of a coordinate of the turning plane.
fn coordinate(runs: &Runs, k: usize) -> char {
    let along = runs.circles.first().map_or(0, |circle| circle.plane[k].iamax());
    ['X', 'Y', 'Z'][along % 3]
}

/// The whole estimate as JSON; lengths in µm and angles in arcsec where the key or `unit` says so.
pub fn thesis_json(estimate: &ThesisEstimate, session: &Session) -> Value {
    let errors: serde_json::Map<String, Value> =
        estimate.values.iter().map(|value| (value.name.to_string(), value_json(value))).collect();
    json!({
        "method": estimate.method.to_string(),
        "location_errors": errors,
        "circles": estimate.runs.iter().map(|runs| runs_json(runs, session)).collect::<Vec<_>>(),
        "traces": estimate.traces.iter().map(trace_json).collect::<Vec<_>>(),
        "remarks": estimate.remarks,
    })
}

fn value_json(value: &ThesisValue) -> Value {
    let measure = value.name.component.measure();
    let output = |value: Option<f64>| value.map(|value| measure.to_output(value));
    json!({
        "value": measure.to_output(value.value),
        "unit": measure.output_unit(),
        "sd_of_run": output(value.run_deviation),
        "sd_of_mean": output(value.mean_deviation),
        "left_in": value.left_in.as_ref().map(|(taken_out, left_in)| json!({
            "error": taken_out.to_string(),
            "value": measure.to_output(*left_in),
        })),
    })
}

fn runs_json(runs: &Runs, session: &Session) -> Value {
    json!({
        "axis": session.machine.axes[runs.axis].name,
        "bar": bar_word(runs),
        "at_mm": runs.at_mm,
        "centre_um": runs.centre_mm.iter().map(|c| c * UM_PER_MM).collect::<Vec<_>>(),
        "centre_sd_of_run_um": runs.centre_scatter.map(|s| s.of_one_run.map(|variance| variance.sqrt() * UM_PER_MM)),
        "radius_mm": runs.radius_mm,
        "runs": runs.circles.iter().map(|circle| json!({
            "test": session.tests[circle.test].name,
            "centre_um": circle.centre_mm.iter().map(|c| c * UM_PER_MM).collect::<Vec<_>>(),
            "radius_mm": circle.radius_mm,
            "rms_um": circle.rms_mm * UM_PER_MM,
        })).collect::<Vec<_>>(),
    })
}

fn trace_json(trace: &CompensatedTrace) -> Value {
    let um = |values: &[f64]| values.iter().map(|value| value * UM_PER_MM).collect::<Vec<_>>();
    json!({
        "test": trace.test,
        "angle_deg": trace.angle_rad.iter().map(|angle| angle.to_degrees()).collect::<Vec<_>>(),
        "measured_um": um(&trace.measured_mm),
        "compensated_um": um(&trace.compensated_mm),
        "residual_um": um(&trace.residual_mm),
    })
}

fn bar_word(runs: &Runs) -> &'static str {
    match runs.bar {
        Bar::Short => "short",
        Bar::Extended => "extended",
    }
}

fn mean_rms_um(runs: &Runs) -> f64 {
    let squares: f64 = runs.circles.iter().map(|circle| circle.rms_mm * circle.rms_mm).sum();
    (squares / runs.circles.len() as f64).sqrt() * UM_PER_MM
}

fn range_um(values: &[f64]) -> f64 {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (high - low) * UM_PER_MM
}

fn rms_um(values: &[f64]) -> f64 {
    let squares: f64 = values.iter().map(|value| value * value).sum();
    (squares / values.len().max(1) as f64).sqrt() * UM_PER_MM
}
