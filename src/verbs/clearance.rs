//! `fiveaxis clearance`: the least clearance over every sweep of a session, with pose and pair.

use std::path::PathBuf;

use clap::Args;
use fiveaxis::chain::Chain;
use fiveaxis::collision::{
    CONE_MARGIN_RAD, Instrument, Scene, Scratch, SweepClearance, least_cone_rad, sweep_clearance,
};
use fiveaxis::load::{load_kit, load_machine_and_bodies, load_session, standard_kit};
use fiveaxis::machine::Machine;
use fiveaxis::plan::{CutRunIn, cut_run_ins, rows_with_run_in};
use fiveaxis::report::meetings::{can_touch_note, meetings_json, touching_json};
use fiveaxis::session::{Motion, RunEnd, Test};
use fiveaxis::units::rounded;
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
    let mut tests = Vec::new();
    for test in &session.tests {
        let instrument = Instrument::of(&world, &bodies, &kit, test)?;
        let motion = Motion::of(&session, &chain, test)?;
        let scene = instrument.scene(&world);
        tests.push(Measured::of(&machine, (test, &motion), &scene, arguments.tolerance));
    }
    if arguments.json {
        let value = json!({
            "tests": tests.iter().map(|test| test.json(&machine)).collect::<Vec<_>>(),
            "tolerance_mm": arguments.tolerance,
            "cone_margin_deg": CONE_MARGIN_RAD.to_degrees(),
            "touching": touching_json(&world.touching),
            "can_touch": meetings_json(&machine, &can_touch),
        });
        return print_json(&value);
    }
    print_tests(&machine, &tests);
    if let Some(note) = can_touch_note(&machine, &can_touch) {
        println!("{note}");
    }
    Ok(())
}

/// What a test keeps clear, and what stops its run-ins.
struct Measured {
    name: String,
    least: SweepClearance,
    /// How far the bar stays from the edge of a cup's cone, deg.
    cone_left_deg: Option<f64>,
    cut: Vec<CutRunIn>,
}

impl Measured {
    fn of(machine: &Machine, (test, motion): (&Test, &Motion), scene: &Scene, tolerance_mm: f64) -> Measured {
        let rows = rows_with_run_in(machine, test, motion);
        let scratch = &mut Scratch::default();
        Measured {
            name: test.name.clone(),
            least: sweep_clearance(scene, &rows, tolerance_mm, scratch),
            cone_left_deg: least_cone_rad(scene, &rows, scratch).map(|left| rounded(left.to_degrees(), 2)),
            cut: cut_run_ins(machine, test, motion),
        }
    }

    /// Where each axis stands at the least clearance, mm or deg.
    fn positions<'m>(&'m self, machine: &'m Machine) -> impl Iterator<Item = (&'m str, f64)> {
        let axes = machine.axes.iter().zip(&self.least.positions);
        axes.map(|(axis, &q)| (axis.name.as_str(), rounded(axis.kind.to_file_unit(q), 4)))
    }

    fn json(&self, machine: &Machine) -> Value {
        let positions: Map<String, Value> =
            self.positions(machine).map(|(axis, q)| (axis.to_string(), json!(q))).collect();
        json!({
            "name": self.name,
            "clearance_mm": rounded(self.least.mm, 3),
            "pair": [self.least.pair.0, self.least.pair.1],
            "positions": positions,
            "cone_left_deg": self.cone_left_deg,
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

fn print_tests(machine: &Machine, tests: &[Measured]) {
    println!("{:<24} {:>12}  nearest pair and pose", "test", "clearance mm");
    for test in tests {
        let pose: Vec<String> = test.positions(machine).map(|(axis, q)| format!("{axis} {}", json!(q))).collect();
        let least = match test.least.mm.is_finite() {
            true => format!("{:.3}", test.least.mm),
            false => "nothing near".into(),
        };
        let (one, other) = &test.least.pair;
        println!("{:<24} {least:>12}  {}{one} – {other} at {}", test.name, test.verdict(), pose.join(" "));
        if let Some(left) = test.cone_left_deg.filter(|left| *left < CONE_MARGIN_RAD.to_degrees()) {
            println!(
                "  the bar comes to {left:.2} deg from the edge of a cup's cone, and {} deg are to stay",
                CONE_MARGIN_RAD.to_degrees()
            );
        }
        for cut in &test.cut {
            let what = match cut.end {
                RunEnd::Start => "run-in begins",
                RunEnd::End => "run-out ends",
            };
            let [wanted, limit] = cut_at(machine, cut);
            let axis = &machine.axes[cut.axis].name;
            println!(
                "  {what} at {axis} {}, the limit of {axis}, and not at {}: the sweep is checked as far as that",
                json!(limit),
                json!(wanted)
            );
        }
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
