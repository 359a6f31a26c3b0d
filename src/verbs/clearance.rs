//! `fiveaxis clearance`: the least clearance over every sweep of a session, with pose and pair.

use std::path::PathBuf;

use clap::Args;
use fiveaxis::chain::Chain;
use fiveaxis::collision::{CONE_MARGIN_RAD, Instrument, Scene, Scratch, least_cone_rad, sweep_clearance};
use fiveaxis::load::{load_kit, load_machine_and_bodies, load_session, standard_kit};
use fiveaxis::machine::Machine;
use fiveaxis::plan::{CutRunIn, cut_run_ins, rows_with_run_in};
use fiveaxis::report::meetings::{can_touch_note, meetings_json, touching_json};
use fiveaxis::session::{Motion, RunEnd, Test};
use serde_json::{Map, Value, json};

use super::output::{print_json, settle};
use super::{Refusal, solids};

/// Arguments of `clearance`.
#[derive(Args)]
pub struct Arguments {
    /// Session file; its machine file has bodies
    session: PathBuf,
    /// Kit file; the common 100 mm bar with extensions unless given
    #[arg(long)]
    kit: Option<PathBuf>,
    /// How finely the least clearance is found, mm
    #[arg(long, default_value_t = 0.05)]
    tolerance: f64,
    /// JSON on standard output
    #[arg(long)]
    json: bool,
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    if !(arguments.tolerance >= 1e-3 && arguments.tolerance <= 10.0) {
        return Err(format!("--tolerance {} is not between 0.001 and 10 mm", arguments.tolerance).into());
    }
    settle(&arguments.session)?;
    let session = load_session(&arguments.session)?;
    let folder = arguments.session.parent().map(PathBuf::from).unwrap_or_default();
    let machine_file = folder.join(&session.machine_file);
    let (machine, bodies) = load_machine_and_bodies(&machine_file)?;
    solids::require(&machine_file, &bodies)?;
    let kit = arguments.kit.as_deref().map_or_else(standard_kit, load_kit)?;
    let chain = Chain::of(&machine);
    let world = solids::world(&machine_file, &machine, &bodies)?;
    let can_touch = world.meetings_by_one_axis(&machine);
    let mut scratch = Scratch::default();
    let mut tests = Vec::new();
    for test in &session.tests {
        let instrument = Instrument::of(&world, &bodies, &kit, test)?;
        let motion = Motion::of(&session, &chain, test)?;
        let scene = instrument.scene(&world);
        tests.push(measured(&machine, (test, &motion), &scene, arguments.tolerance, &mut scratch));
    }
    if arguments.json {
        let value = json!({
            "tests": tests,
            "tolerance_mm": arguments.tolerance,
            "cone_margin_deg": CONE_MARGIN_RAD.to_degrees(),
            "touching": touching_json(&world.touching),
            "can_touch": meetings_json(&machine, &can_touch),
        });
        return print_json(&value);
    }
    print_tests(&tests);
    if let Some(note) = can_touch_note(&machine, &can_touch) {
        println!("{note}");
    }
    Ok(())
}

/// What a test keeps clear, and what stops its run-ins.
fn measured(
    machine: &Machine,
    (test, motion): (&Test, &Motion),
    scene: &Scene,
    tolerance_mm: f64,
    scratch: &mut Scratch,
) -> Value {
    let rows = rows_with_run_in(machine, test, motion);
    let least = sweep_clearance(scene, &rows, tolerance_mm, scratch);
    let cone_left = least_cone_rad(scene, &rows, scratch).map(|left| (left.to_degrees() * 1e2).round() / 1e2);
    let positions: Map<String, Value> = machine
        .axes
        .iter()
        .zip(&least.positions)
        .map(|(axis, &q)| (axis.name.clone(), json!((axis.kind.to_file_unit(q) * 1e4).round() / 1e4)))
        .collect();
    json!({
        "name": test.name,
        "clearance_mm": (least.mm * 1e3).round() / 1e3,
        "pair": [least.pair.0, least.pair.1],
        "positions": positions,
        "cone_left_deg": cone_left,
        "run_in_cut": cut_run_ins(machine, test, motion).iter().map(|cut| cut_json(machine, cut)).collect::<Vec<_>>(),
    })
}

fn print_tests(tests: &[Value]) {
    println!("{:<24} {:>12}  nearest pair and pose", "test", "clearance mm");
    for test in tests {
        let pose: Vec<String> = test["positions"]
            .as_object()
            .map(|map| map.iter().map(|(axis, q)| format!("{axis} {q}")).collect())
            .unwrap_or_default();
        let text = |value: &Value| value.as_str().unwrap_or_default().to_string();
        let least_mm = test["clearance_mm"].as_f64();
        let is_cone = text(&test["pair"][1]).starts_with("cone");
        let verdict = match least_mm.is_some_and(|mm| mm <= 0.0) {
            true if is_cone => "TOO STEEP ",
            true => "COLLIDES ",
            false => "",
        };
        println!(
            "{:<24} {:>12}  {verdict}{} – {} at {}",
            text(&test["name"]),
            least_mm.map_or("nothing near".into(), |mm| format!("{mm:.3}")),
            text(&test["pair"][0]),
            text(&test["pair"][1]),
            pose.join(" ")
        );
        if let Some(left) = test["cone_left_deg"].as_f64().filter(|left| *left < CONE_MARGIN_RAD.to_degrees()) {
            println!(
                "  the bar comes to {left:.2} deg from the edge of a cup's cone, and {} deg are to stay",
                CONE_MARGIN_RAD.to_degrees()
            );
        }
        for cut in test["run_in_cut"].as_array().into_iter().flatten() {
            let what = if cut["end"] == "start" { "run-in begins" } else { "run-out ends" };
            println!(
                "  {what} at {axis} {}, the limit of {axis}, and not at {}: the sweep is checked as far as that",
                cut["limit"],
                cut["wanted"],
                axis = text(&cut["axis"])
            );
        }
    }
}

/// A cut run-in, positions in mm or deg.
fn cut_json(machine: &Machine, cut: &CutRunIn) -> Value {
    let axis = &machine.axes[cut.axis];
    let [wanted, limit] = [cut.wanted, cut.limit].map(|q| (axis.kind.to_file_unit(q) * 1e4).round() / 1e4 + 0.0);
    let end = match cut.end {
        RunEnd::Start => "start",
        RunEnd::End => "end",
    };
    json!({ "end": end, "axis": axis.name, "wanted": wanted, "limit": limit })
}
