//! A summary of simulated traces as terminal text and JSON; the traces themselves are recordings, see `recording`.

use serde_json::{Value, json};

use crate::report::wording::table::Table;
use crate::session::Session;
use crate::simulate::{SetupErrors, Trace};
use crate::units::UM_PER_MM;

/// Smallest and largest reading of a trace, mm.
fn span_mm(trace: &Trace) -> (f64, f64) {
    let finite = trace.length_mm.iter().copied().filter(|length| length.is_finite());
    finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), length| (low.min(length), high.max(length)))
}

/// What was written where, a line per test.
pub fn simulation_text(session: &Session, traces: &[Trace], folder: &str) -> String {
    let mut table = Table::new(&["test", "rows", "shortest mm", "longest mm", "range µm"]);
    for trace in traces {
        let (low, high) = span_mm(trace);
        table.row(vec![
            trace.test.clone(),
            trace.length_mm.len().to_string(),
            format!("{low:.4}"),
            format!("{high:.4}"),
            format!("{:.2}", (high - low) * UM_PER_MM),
        ]);
    }
    format!("{}: {} recordings written to {folder}\n\n{}", session.name, traces.len(), table.text())
}

/// `fiveaxis simulate --json`: the tests, and the setup errors that were drawn.
pub fn simulation_json(session: &Session, traces: &[Trace], setup: &SetupErrors) -> Value {
    let um = |values: &[f64]| values.iter().map(|value| value * UM_PER_MM).collect::<Vec<_>>();
    let tests: Vec<Value> = session
        .tests
        .iter()
        .zip(traces)
        .enumerate()
        .map(|(index, (test, trace))| {
            let (low, high) = span_mm(trace);
            json!({
                "name": trace.test,
                "recording": test.recording_file.clone().unwrap_or_else(|| format!("{}.csv", test.name)),
                "rows": trace.length_mm.len(),
                "shortest_mm": low,
                "longest_mm": high,
                "pivot_error_um": um(setup.pivot_mm[index].as_slice()),
                "spindle_ball_error_um": um(setup.spindle_mm[index].as_slice()),
                "bar_error_um": setup.bar_mm[index] * UM_PER_MM,
            })
        })
        .collect();
    json!({"session": session.name, "machine": session.machine.name, "tests": tests})
}
