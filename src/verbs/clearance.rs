//! `fiveaxis clearance`: the least clearance over every sweep of a session, with pose and pair.

use std::path::PathBuf;

use clap::Args;
use fiveaxis::chain::Chain;
use fiveaxis::collision::{Instrument, Scene, Scratch, least_cone_rad, sweep_clearance};
use fiveaxis::load::{load_kit, load_machine_and_bodies, load_session, standard_kit};
use fiveaxis::machine::Machine;
use fiveaxis::plan::{cut_run_ins, rows_with_run_in};
use fiveaxis::report::clearance::{SessionClearance, TestClearance, clearance_json, clearance_text};
use fiveaxis::session::{Motion, Test};

use super::output::{print, print_json, settle};
use super::{Refusal, solids};

/// Arguments of `clearance`.
#[derive(Args)]
#[command(
    after_help = "Example: fiveaxis plan machines/hermle-c600u.yaml --out plan, then fiveaxis clearance plan/session.yaml"
)]
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
    solids::require(&machine_file, &machine, &bodies)?;
    let kit = arguments.kit.as_deref().map_or_else(standard_kit, load_kit)?;
    let chain = Chain::of(&machine);
    let world = solids::world(&machine_file, &machine, &bodies)?;
    let can_touch = world.meetings_by_one_axis(&machine);
    let mut tests = Vec::new();
    for test in &session.tests {
        let instrument = Instrument::of(&world, &machine, &bodies, &kit, test)?;
        let motion = Motion::of(&session, &chain, test)?;
        let scene = instrument.scene(&world);
        tests.push(measured(&machine, (test, &motion), &scene, arguments.tolerance));
    }
    let clearance =
        SessionClearance { tests, tolerance_mm: arguments.tolerance, touching: world.touching.clone(), can_touch };
    match arguments.json {
        true => print_json(&clearance_json(&machine, &clearance)),
        false => print(&clearance_text(&machine, &clearance)),
    }
}

/// What a test keeps clear over its sweep and its run-ins.
fn measured(machine: &Machine, (test, motion): (&Test, &Motion), scene: &Scene, tolerance_mm: f64) -> TestClearance {
    let rows = rows_with_run_in(machine, test, motion);
    let scratch = &mut Scratch::default();
    TestClearance {
        name: test.name.clone(),
        least: sweep_clearance(scene, &rows, tolerance_mm, scratch),
        cone_left_rad: least_cone_rad(scene, &rows, scratch),
        cut: cut_run_ins(machine, test, motion),
    }
}
