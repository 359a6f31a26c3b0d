//! The verb itself: machine and kit are read, tests planned, files written, results printed.

use fiveaxis::load::{load_kit, load_machine_and_bodies, standard_kit};
use fiveaxis::plan::plan_with_advice;
use fiveaxis::report::meetings::{can_touch_note, meetings_json, touching_json};
use fiveaxis::report::plan::{plan_json, plan_text};
use serde_json::json;

use super::arguments::Arguments;
use super::files::{Planned, planned_files};
use super::former::former_files;
use super::settings::settings;
use crate::verbs::options::directions::say;
use crate::verbs::output::ending::Ending;
use crate::verbs::output::{print, print_json, settle};
use crate::verbs::{Refusal, solids};

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    let (mut machine, bodies) = load_machine_and_bodies(&arguments.machine)?;
    say(&mut machine, arguments.directions, &arguments.machine.display().to_string())?;
    if arguments.out.is_some() {
        machine.stated_directions().map_err(|why| format!("{}: {why}", arguments.machine.display()))?;
    }
    solids::require(&arguments.machine, &machine, &bodies)?;
    let world = solids::world(&arguments.machine, &machine, &bodies)?;
    let can_touch = world.meetings_by_one_axis(&machine);
    let kit = arguments.kit.as_deref().map_or_else(standard_kit, load_kit)?;
    let settings = settings(arguments, &machine)?;
    let former = match &arguments.out {
        Some(folder) => {
            settle(&folder.join("session.yaml"))?;
            former_files(folder, &arguments.machine)?
        }
        None => Vec::new(),
    };
    let plan = plan_with_advice(&machine, &bodies, &kit, &settings)?;
    if let Some(folder) = &arguments.out {
        let planned = Planned { machine: &machine, bodies: &bodies, kit: &kit, settings: &settings, plan: &plan };
        let mut output = planned_files(folder, &arguments.machine, &planned)?;
        output.replace(former);
        output.write(folder, std::slice::from_ref(&arguments.machine))?;
    }
    if arguments.json {
        let mut value = plan_json(&plan, &machine);
        value["touching"] = json!(touching_json(&world.touching));
        value["can_touch"] = json!(meetings_json(&machine, &can_touch));
        print_json(&value)?;
    } else {
        print(&plan_text(&plan, &machine, &settings))?;
        if let Some(note) = can_touch_note(&machine, &can_touch) {
            println!("\n{note}");
        }
    }
    // where there is nothing to determine no test is missing
    match plan.tests.is_empty() && !plan.goal_reached {
        true => Err(Ending::without_plan(arguments.json)),
        false => Ok(()),
    }
}
