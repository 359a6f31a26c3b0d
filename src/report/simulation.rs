//! A summary of simulated traces as terminal text and JSON; the traces themselves are recordings, see `recording`.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use crate::readings::Kind;
use crate::report::wording::table::Table;
use crate::session::{Session, Test};
use crate::simulate::{SetupErrors, Trace};
use crate::units::UM_PER_MM;

/// Smallest and largest reading of a trace, mm.
fn span_mm(trace: &Trace) -> (f64, f64) {
    let finite = trace.length_mm.iter().copied().filter(|length| length.is_finite());
    finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), length| (low.min(length), high.max(length)))
}

/// What was written where, a line per test; `files` are those that hold the readings of each, if any does.
pub fn simulation_text(session: &Session, (traces, files): (&[Trace], &[Option<String>]), folder: &str) -> String {
    let mut table = Table::new(&["test", "rows", "shortest mm", "longest mm", "range µm"]);
    for (test, trace) in session.tests.iter().zip(traces) {
        let (low, high) = span_mm(trace);
        // turns count at a lever where 1 µm stands for 1 arcsec
        let is_turn = test.reading.is_turn();
        let end = |mm: f64| if is_turn { format!("{:.1}″", mm * UM_PER_MM) } else { format!("{mm:.4}") };
        let range = format!("{:.2}{}", (high - low) * UM_PER_MM, if is_turn { "″" } else { "" });
        table.row(vec![trace.test.clone(), trace.length_mm.len().to_string(), end(low), end(high), range]);
    }
    let written: BTreeSet<&String> = files.iter().flatten().collect();
    let is_same_point = |test: &Test| test.reading.part().is_some_and(|part| part.kind == Kind::SamePoint);
    let untouched = match session.tests.iter().any(is_same_point) {
        true => "same_point rows hold positions alone: nothing is simulated in them\n",
        false => "",
    };
    format!("{}: {} recordings written to {folder}\n{untouched}\n{}", session.name, written.len(), table.text())
}

/// `fiveaxis simulate --json`: the tests, and the setup errors that were drawn.
pub fn simulation_json(
    session: &Session,
    (traces, files): (&[Trace], &[Option<String>]),
    setup: &SetupErrors,
) -> Value {
    let um = |values: &[f64]| values.iter().map(|value| value * UM_PER_MM).collect::<Vec<_>>();
    let tests: Vec<Value> = traces
        .iter()
        .enumerate()
        .map(|(index, trace)| {
            let (low, high) = span_mm(trace);
            json!({
                "name": trace.test,
                "recording": files[index],
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
