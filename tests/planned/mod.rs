//! Plans of shipped machines whose programs are read back.

use std::path::Path;

use fiveaxis::load::{load_machine_and_bodies, standard_kit};
use fiveaxis::machine::Machine;
use fiveaxis::plan::{PlannedTest, Settings, plan};

/// A shipped machine and the tests planned for it, circles on one machine, the others' plans as they come.
pub fn planned(name: &str) -> (Machine, Vec<PlannedTest>) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines").join(name);
    let (machine, bodies) = load_machine_and_bodies(&file).expect("shipped machine");
    let mut settings = Settings::default();
    settings.coupled.circles = name.starts_with("hermle");
    let plan = plan(&machine, &bodies, &standard_kit().expect("kit"), &settings).expect("plan");
    (machine, plan.tests)
}
