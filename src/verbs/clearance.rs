//! `fiveaxis clearance`: the least clearance over every sweep of a session, with pose and pair.

use std::path::PathBuf;

use clap::Args;
use fiveaxis::chain::Chain;
use fiveaxis::collision::{Instrument, Scratch, World, sweep_clearance};
use fiveaxis::load::{load_kit, load_machine_and_bodies, load_session, standard_kit};
use fiveaxis::machine::Machine;
use fiveaxis::plan::{CutRunIn, RunEnd, cut_run_ins, rows_with_run_in};
use fiveaxis::session::Motion;
use serde_json::{Map, Value, json};

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
    let session = load_session(&arguments.session)?;
    let folder = arguments.session.parent().map(PathBuf::from).unwrap_or_default();
    let machine_file = folder.join(&session.machine_file);
    let (machine, bodies) = load_machine_and_bodies(&machine_file)?;
    solids::require(&machine_file, &bodies)?;
    let kit = arguments.kit.as_deref().map_or_else(standard_kit, load_kit)?;
    let chain = Chain::of(&machine);
    let world = World::new(&chain, &bodies)?;
    let mut scratch = Scratch::default();
    let mut tests = Vec::new();
    for test in &session.tests {
        let instrument = Instrument::of(&world, &bodies, &kit, test)?;
        let motion = Motion::of(&session, &chain, test)?;
        let rows = rows_with_run_in(&machine, test, &motion);
        let least = sweep_clearance(&instrument.scene(&world), &rows, arguments.tolerance, &mut scratch);
        let positions: Map<String, Value> = machine
            .axes
            .iter()
            .zip(&least.positions)
            .map(|(axis, &q)| (axis.name.clone(), json!((axis.kind.to_file_unit(q) * 1e4).round() / 1e4)))
            .collect();
        tests.push(json!({
            "name": test.name,
            "clearance_mm": (least.mm * 1e3).round() / 1e3,
            "pair": [least.pair.0, least.pair.1],
            "positions": positions,
            "run_in_cut": cut_run_ins(&machine, test, &motion).iter().map(|cut| cut_json(&machine, cut)).collect::<Vec<_>>(),
        }));
    }
    if arguments.json {
        let touching: Vec<Value> = world.touching.iter().map(|(a, b)| json!([a, b])).collect();
        println!("{}", json!({ "tests": tests, "tolerance_mm": arguments.tolerance, "touch_at_zero": touching }));
        return Ok(());
    }
    println!("{:<24} {:>12}  nearest pair and pose", "test", "clearance mm");
    for test in &tests {
        let pose: Vec<String> = test["positions"]
            .as_object()
            .map(|map| map.iter().map(|(axis, q)| format!("{axis} {q}")).collect())
            .unwrap_or_default();
        let text = |value: &Value| value.as_str().unwrap_or_default().to_string();
        let verdict = if test["clearance_mm"].as_f64().unwrap_or(0.0) <= 0.0 { "COLLIDES " } else { "" };
        println!(
            "{:<24} {:>12.3}  {verdict}{} – {} at {}",
            text(&test["name"]),
            test["clearance_mm"].as_f64().unwrap_or(f64::NAN),
            text(&test["pair"][0]),
            text(&test["pair"][1]),
            pose.join(" ")
        );
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
    if let Some(note) = touching_note(&world) {
        println!("{note}");
    }
    Ok(())
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

/// What is left out because it touches with all axes at zero: by design, or a body in the wrong place.
pub fn touching_note(world: &World) -> Option<String> {
    let pairs: Vec<String> = world.touching.iter().map(|(one, other)| format!("{one} – {other}")).collect();
    (!pairs.is_empty()).then(|| {
        format!(
            "note: not checked against each other, as they touch with all axes at zero: {}; a body in the wrong place shows here",
            pairs.join(", ")
        )
    })
}
