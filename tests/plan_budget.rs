//! Plans of all shipped machines with a time: no worse than the ordinary plan.

mod shipped;

use std::path::Path;

use fiveaxis::load::{load_machine_and_bodies, standard_kit};
use fiveaxis::plan::{Goal, Plan, Settings, plan};
use rayon::prelude::*;
use shipped::machine_files;

fn planned(file: &Path, goal: Goal) -> Plan {
    let (machine, bodies) = load_machine_and_bodies(file).expect("shipped machine");
    let settings = Settings { goal, ..Settings::default() };
    plan(&machine, &bodies, &standard_kit().expect("kit"), &settings).expect("plan")
}

fn undetermined(plan: &Plan) -> usize {
    plan.errors.iter().filter(|error| !error.determined).count()
}

#[test]
fn a_minute_more_than_the_default_plan_leaves_no_more_errors_undetermined() {
    let worse: Vec<String> = machine_files()
        .par_iter()
        .filter_map(|file| {
            let default = planned(file, Settings::default().goal);
            let budget = default.minutes + 1.0;
            let timed = planned(file, Goal { minutes: Some(budget), ..Settings::default().goal });
            let line = format!(
                "{}: {:.1} min with {} undetermined; {:.1} of {budget:.1} min with {}",
                file.file_stem()?.display(),
                default.minutes,
                undetermined(&default),
                timed.minutes,
                undetermined(&timed)
            );
            println!("{line}");
            let is_worse = undetermined(&timed) > undetermined(&default) || timed.minutes > budget + 1e-9;
            is_worse.then_some(line)
        })
        .collect();
    assert!(worse.is_empty(), "{worse:#?}");
}
