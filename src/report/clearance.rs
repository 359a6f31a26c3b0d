//! Least clearances of a session's sweeps as terminal text and JSON. They come measured.

use std::fmt::Write as _;

use serde_json::{Map, Value, json};

use crate::collision::{CONE_MARGIN_RAD, Meeting, SweepClearance};
use crate::machine::Machine;
use crate::plan::CutRunIn;
use crate::report::wording::meetings::{can_touch_note, meetings_json, touching_json};
use crate::session::RunEnd;
use crate::units::rounded;

/// What a session's sweeps keep clear.
#[derive(Debug, Clone)]
pub struct SessionClearance {
    pub tests: Vec<TestClearance>,
    /// How finely the least clearance was found, mm.
    pub tolerance_mm: f64,
    /// Pairs of bodies that the machine file lists: never compared.
    pub touching: Vec<(String, String)>,
    /// Pairs of bodies that meet on the travel of the one joint between them.
    pub can_touch: Vec<Meeting>,
}

/// What a test keeps clear, and what stops its run-ins.
#[derive(Debug, Clone)]
pub struct TestClearance {
    pub name: String,
    pub least: SweepClearance,
    /// How far the bar stays from the edge of a cup's cone, rad; `None` without cups.
    pub cone_left_rad: Option<f64>,
    pub cut: Vec<CutRunIn>,
}

impl TestClearance {
    /// Where each axis stands at the least clearance, mm or deg.
    fn positions<'m>(&'m self, machine: &'m Machine) -> impl Iterator<Item = (&'m str, f64)> {
        let axes = machine.axes.iter().zip(&self.least.positions);
        axes.map(|(axis, &q)| (axis.name.as_str(), rounded(axis.kind.to_file_unit(q), 4)))
    }

    /// How far the bar stays from the edge of a cup's cone as it is shown, deg.
    fn cone_left_deg(&self) -> Option<f64> {
        self.cone_left_rad.map(|left| rounded(left.to_degrees(), 2))
    }

    fn json(&self, machine: &Machine) -> Value {
        let positions: Map<String, Value> =
            self.positions(machine).map(|(axis, q)| (axis.to_string(), json!(q))).collect();
        json!({
            "name": self.name,
            "clearance_mm": rounded(self.least.mm, 3),
            "pair": [self.least.pair.0, self.least.pair.1],
            "positions": positions,
            "cone_left_deg": self.cone_left_deg(),
            "run_in_cut": self.cut.iter().map(|cut| cut_json(machine, cut)).collect::<Vec<_>>(),
        })
    }

    /// Before the pair, where it comes too near.
    fn verdict(&self) -> &'static str {
        match self.least.mm <= 0.0 {
            true if self.least.pair.1.starts_with("cone") => "TOO STEEP ",
            true => "COLLIDES ",
            false => "",
        }
    }
}

/// `fiveaxis clearance --json`.
pub fn clearance_json(machine: &Machine, clearance: &SessionClearance) -> Value {
    json!({
        "tests": clearance.tests.iter().map(|test| test.json(machine)).collect::<Vec<_>>(),
        "tolerance_mm": clearance.tolerance_mm,
        "cone_margin_deg": CONE_MARGIN_RAD.to_degrees(),
        "touching": touching_json(&clearance.touching),
        "can_touch": meetings_json(machine, &clearance.can_touch),
    })
}

/// Clearances for the terminal: a line per test, with what is too near and what is cut, and bodies that can meet.
pub fn clearance_text(machine: &Machine, clearance: &SessionClearance) -> String {
    let mut text = String::new();
    let _ = writeln!(text, "{:<24} {:>12}  nearest pair and pose", "test", "clearance mm");
    for test in &clearance.tests {
        test_text(&mut text, machine, test);
    }
    if let Some(note) = can_touch_note(machine, &clearance.can_touch) {
        let _ = writeln!(text, "{note}");
    }
    text
}

fn test_text(text: &mut String, machine: &Machine, test: &TestClearance) {
    let pose: Vec<String> = test.positions(machine).map(|(axis, q)| format!("{axis} {}", json!(q))).collect();
    let least = match test.least.mm.is_finite() {
        true => format!("{:.3}", test.least.mm),
        false => "nothing near".into(),
    };
    let (one, other) = &test.least.pair;
    let _ = writeln!(text, "{:<24} {least:>12}  {}{one} – {other} at {}", test.name, test.verdict(), pose.join(" "));
    let margin_deg = CONE_MARGIN_RAD.to_degrees();
    if let Some(left) = test.cone_left_deg().filter(|left| *left < margin_deg) {
        let _ = writeln!(
            text,
            "  the bar comes to {left:.2} deg from the edge of a cup's cone, and {margin_deg} deg are to stay"
        );
    }
    for cut in &test.cut {
        let what = match cut.end {
            RunEnd::Start => "run-in begins",
            RunEnd::End => "run-out ends",
        };
        let [wanted, limit] = cut_at(machine, cut);
        let axis = &machine.axes[cut.axis].name;
        let _ = writeln!(
            text,
            "  {what} at {axis} {}, the limit of {axis}, and not at {}: the sweep is checked as far as that",
            json!(limit),
            json!(wanted)
        );
    }
}

/// Where a cut run-in was to begin, or run-out to end, and the limit at which it does, mm or deg.
fn cut_at(machine: &Machine, cut: &CutRunIn) -> [f64; 2] {
    [cut.wanted, cut.limit].map(|q| rounded(machine.axes[cut.axis].kind.to_file_unit(q), 4))
}

/// A cut run-in, positions in mm or deg.
fn cut_json(machine: &Machine, cut: &CutRunIn) -> Value {
    let axis = &machine.axes[cut.axis];
    let [wanted, limit] = cut_at(machine, cut);
    let end = match cut.end {
        RunEnd::Start => "start",
        RunEnd::End => "end",
    };
    json!({ "end": end, "axis": axis.name, "wanted": wanted, "limit": limit })
}
