//! `fiveaxis init`: writes the machine file, and says what was written and what to do next. The figures are read in `sheet` and `described`.

use std::path::{Path, PathBuf};

use fiveaxis::chain::{Chain, sense_in_words};
use fiveaxis::collision::World;
use fiveaxis::report::machine_file::machine_file;
use fiveaxis::report::meetings::meetings_json;
use fiveaxis::template::{Made, machine_of};
use serde_json::json;

use super::arguments::Arguments;
use super::described::described;
use super::sheet::sizes;
use crate::verbs::Refusal;
use crate::verbs::output::{Foreign, OutputFolder, print, print_json, write_all};

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    let (head, made) = match &arguments.urdf {
        Some(urdf) => described(arguments, urdf)?,
        None => {
            let sizes = sizes(arguments)?;
            let head = format!(
                "{} from its data sheet, by fiveaxis init. Zero: all axes at 0; R is {} mm below the spindle nose then.",
                sizes.name.replace(char::is_control, " "),
                fiveaxis::template::GAUGE_MM
            );
            (head, machine_of(&sizes)?)
        }
    };
    let Made { machine, bodies, assumed } = &made;
    let (folder, name) = place(&arguments.file)?;
    let mut output = OutputFolder::default();
    output.add(name, machine_file(&head, machine, bodies));
    write_all(vec![(folder, output)], &[], Foreign::with(arguments.force))?;
    let world = World::new(&Chain::of(machine), bodies)?;
    let mut meetings = world.meetings_at_zero(machine);
    meetings.extend(world.meetings_by_one_axis(machine));
    let zero = vec![0.0; machine.axes.len()];
    let senses: Vec<String> = (0..machine.axes.len()).map(|axis| sense_in_words(machine, axis, &zero)).collect();
    if arguments.json {
        return print_json(&json!({
            "file": arguments.file.display().to_string(),
            "code": machine.code.to_string(),
            "senses": senses,
            "assumed": assumed,
            "bodies": bodies.bodies.len(),
            "can_touch": meetings_json(machine, &meetings),
        }));
    }
    print(&told(arguments, &made, meetings.len(), &senses))
}

/// What was written, and what to do next.
fn told(arguments: &Arguments, made: &Made, meetings: usize, senses: &[String]) -> String {
    let Made { machine, bodies, assumed } = made;
    let bodies = bodies.bodies.len();
    let file = arguments.file.display();
    let mut text = format!("{file}: {} {} with {bodies} bodies\n", machine.name, machine.code);
    assumed.iter().for_each(|sentence| text.push_str(&format!("Check: {sentence}\n")));
    text.push_str("Move each axis a little in + and compare:\n");
    senses.iter().for_each(|sense| text.push_str(&format!("  {sense}\n")));
    if meetings > 0 {
        text.push_str(&format!(
            "{meetings} pairs of bodies can touch within the travels; `fiveaxis check {file}` lists them\n"
        ));
    }
    text.push_str(&format!(
        "Next: put in what stands in the way (bodies in {file}), then\n  fiveaxis check {file}\n  fiveaxis plan {file} --out setups\n"
    ));
    text
}

/// Folder and name of the file to write.
fn place(file: &Path) -> Result<(PathBuf, PathBuf), Refusal> {
    let name = file.file_name().ok_or_else(|| format!("{}: is no name of a file", file.display()))?;
    let is_yaml = file.extension().is_some_and(|extension| extension == "yaml" || extension == "yml");
    if !is_yaml {
        return Err(format!("{}: a machine file ends with .yaml", file.display()).into());
    }
    let folder = match file.parent() {
        Some(parent) if parent.as_os_str().is_empty() => Path::new(".").to_path_buf(),
        Some(parent) => parent.to_path_buf(),
        None => Path::new(".").to_path_buf(),
    };
    Ok((folder, PathBuf::from(name)))
}
