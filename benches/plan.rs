//! A complete plan of every shipped machine, one thread: default goal, and a loose one, which is searched for at more rungs.

use std::path::Path;

use divan::Bencher;
use fiveaxis::bodies::{Bodies, Kit};
use fiveaxis::load::{load_machine_and_bodies, standard_kit};
use fiveaxis::machine::Machine;
use fiveaxis::plan::{Goal, Settings, plan};

fn main() {
    divan::main();
}

const MACHINES: [&str; 16] = [
    "fig-1-1-head-head-cb",
    "fig-1-1-table-head-ca",
    "fig-1-1-table-table-ca",
    "head-head-ab-profiler",
    "head-head-ca-moving-table",
    "head-head-ca-overhead-gantry",
    "hermle-c600u",
    "nutating-head-45",
    "nutating-table-45",
    "table-head-ab-blade",
    "table-head-ba-horizontal",
    "table-head-cb-moving-table-y",
    "table-table-ca-cross-table",
    "table-table-ca-moving-table-x",
    "table-table-ca-portal",
    "table-table-cb-moving-table",
];

fn load(name: &str) -> (Machine, Bodies, Kit) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines").join(format!("{name}.yaml"));
    let (machine, bodies) = load_machine_and_bodies(&file).expect("shipped machine");
    (machine, bodies, standard_kit().expect("kit"))
}

#[divan::bench(args = MACHINES, sample_count = 3, sample_size = 1)]
fn complete_plan(bencher: Bencher, name: &str) {
    let (machine, bodies, kit) = load(name);
    bencher.bench_local(|| plan(&machine, &bodies, &kit, &Settings::default()).expect("plan"));
}

#[divan::bench(args = MACHINES, sample_count = 1, sample_size = 1)]
fn complete_plan_at_20_um_and_20_arcsec(bencher: Bencher, name: &str) {
    let (machine, bodies, kit) = load(name);
    let arcsec = std::f64::consts::PI / (180.0 * 3600.0);
    let goal = Goal { position_mm: 20e-3, orientation_rad: 20.0 * arcsec, minutes: None };
    let settings = Settings { goal, ..Settings::default() };
    bencher.bench_local(|| plan(&machine, &bodies, &kit, &settings).expect("plan"));
}
