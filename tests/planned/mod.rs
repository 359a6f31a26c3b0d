//! Plans with the standard kit, each made once for all tests that ask for it.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex};

use fiveaxis::bodies::Bodies;
use fiveaxis::load::{load_machine_and_bodies, standard_kit};
use fiveaxis::machine::Machine;
use fiveaxis::plan::{Plan, PlannedTest, Settings, plan};

/// By all that a plan is made from.
static PLANS: Mutex<BTreeMap<String, Arc<Plan>>> = Mutex::new(BTreeMap::new());

/// The plan of a machine.
pub fn plan_of(machine: &Machine, bodies: &Bodies, settings: &Settings) -> Arc<Plan> {
    let key = format!("{machine:?} {bodies:?} {settings:?}");
    if let Some(plan) = PLANS.lock().expect("plans").get(&key) {
        return plan.clone();
    }
    // made without the lock: a plan shares its work among threads, and one of them may be asked for another plan meanwhile
    let plan = Arc::new(plan(machine, bodies, &standard_kit().expect("kit"), settings).expect("plan"));
    PLANS.lock().expect("plans").entry(key).or_insert(plan).clone()
}

/// A shipped machine and the tests planned for it, circles on one machine, the others' plans as they come.
pub fn planned(name: &str) -> (Machine, Vec<PlannedTest>) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines").join(name);
    let (machine, bodies) = load_machine_and_bodies(&file).expect("shipped machine");
    let mut settings = Settings::default();
    settings.coupled.circles = name.starts_with("hermle");
    let tests = plan_of(&machine, &bodies, &settings).tests.clone();
    (machine, tests)
}
