//! `fiveaxis init`: a machine file from the figures of a data sheet, given as options or asked for on a terminal.

use std::io::{BufRead, IsTerminal, Write};
use std::path::{Path, PathBuf};

use fiveaxis::chain::{Chain, sense_in_words};
use fiveaxis::collision::World;
use fiveaxis::machine::{Directions, Machine, StructuralCode};
use fiveaxis::report::machine_file::machine_file;
use fiveaxis::report::meetings::meetings_json;
use fiveaxis::template::{Sizes, machine_of};
use serde_json::json;

use super::arguments::{Arguments, number, table_size};
use super::described::described;
use crate::verbs::Refusal;
use crate::verbs::output::{Foreign, OutputFolder, print, print_json, write_all};

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    let (head, machine, bodies) = match &arguments.urdf {
        Some(urdf) => described(arguments, urdf)?,
        None => {
            let sizes = sizes(arguments)?;
            let (machine, bodies) = machine_of(&sizes)?;
            let head = format!(
                "{} from its data sheet, by fiveaxis init. Zero: all axes at 0; R is {} mm below the spindle nose then.",
                sizes.name.replace(char::is_control, " "),
                fiveaxis::template::GAUGE_MM
            );
            (head, machine, bodies)
        }
    };
    let (folder, name) = place(&arguments.file)?;
    let mut output = OutputFolder::default();
    output.add(name, machine_file(&head, &machine, &bodies));
    write_all(vec![(folder, output)], &[], Foreign::with(arguments.force))?;
    let world = World::new(&Chain::of(&machine), &bodies)?;
    let mut meetings = world.meetings_at_zero(&machine);
    meetings.extend(world.meetings_by_one_axis(&machine));
    let zero = vec![0.0; machine.axes.len()];
    let tool = bodies.tool_direction(&machine);
    let senses: Vec<String> =
        (0..machine.axes.len()).map(|axis| sense_in_words(&machine, axis, &zero, tool.as_ref())).collect();
    if arguments.json {
        return print_json(&json!({
            "file": arguments.file.display().to_string(),
            "code": machine.code.to_string(),
            "senses": senses,
            "bodies": bodies.bodies.len(),
            "can_touch": meetings_json(&machine, &meetings),
        }));
    }
    print(&told(arguments, &machine, bodies.bodies.len(), meetings.len(), &senses))
}

/// What was written, and what to do next.
fn told(arguments: &Arguments, machine: &Machine, bodies: usize, meetings: usize, senses: &[String]) -> String {
    let file = arguments.file.display();
    let mut text = format!("{file}: {} {} with {bodies} bodies\n", machine.name, machine.code);
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

/// The data sheet: options first, questions for what is missing on a terminal.
fn sizes(arguments: &Arguments) -> Result<Sizes, Refusal> {
    let ask = Asker { asks: std::io::stdin().is_terminal() && std::io::stderr().is_terminal() && !arguments.json };
    let code = match (&arguments.code, arguments.kind) {
        (Some(code), _) => code.clone(),
        (None, Some(kind)) => kind.code().to_string(),
        (None, None) => ask.for_text(
            "--code",
            "What carries what, from workpiece w over bed b to tool t (table-table [wCAYbXZt], table-head [wCXbYZBt], head-head [wXbYZCAt])",
            Some("[wCAYbXZt]"),
        )?,
    };
    let code = StructuralCode::parse(&code).map_err(|why| format!("--code: {why}"))?;
    let or_ask = |given: &Option<String>, option: &str, question: &str| match given {
        Some(text) => Ok(text.clone()),
        None => ask.for_text(option, question, None),
    };
    let travels = numbers(
        &or_ask(&arguments.travels, "--travels", "Travels of X, Y, Z in mm, e.g. 650,520,475")?,
        ',',
        "--travels",
    )?;
    let &[x, y, z] = travels.as_slice() else {
        return Err(format!("--travels has {} numbers; three are wanted, for X, Y and Z in mm", travels.len()).into());
    };
    let nose = or_ask(
        &arguments.nose_to_table,
        "--nose-to-table",
        "Distance from spindle nose to table top in mm, smallest..largest",
    )?;
    let table = or_ask(&arguments.table, "--table", "Table in mm: diameter, or width x depth")?;
    let turns = |side: &[String]| side.iter().any(|name| matches!(name.as_str(), "A" | "B"));
    let tilt_above_table = match arguments.tilt_above_table {
        Some(height) => height,
        None if turns(&code.workpiece_side) => {
            ask.for_number("--tilt-above-table", "Tilting axis above the table top in mm (below: negative)")?
        }
        None => 0.0,
    };
    let pivot_above_nose = match arguments.pivot_to_nose {
        Some(height) => height,
        None if turns(&code.tool_side) => {
            ask.for_number("--pivot-to-nose", "From the spindle nose up to the tilting axis of the head in mm")?
        }
        None => 0.0,
    };
    let ranges = arguments.range.iter().map(|text| named_range(text)).collect::<Result<Vec<_>, Refusal>>()?;
    if let Some((name, _)) = ranges.iter().find(|(name, _)| !code.axis_names().any(|axis| axis == name)) {
        return Err(format!("--range: {code} has no axis '{name}'").into());
    }
    let directions = match arguments.directions {
        Some(said) => said.directions(),
        None => match ask
            .for_text(
                "--directions",
                "What does + do: iso841 (tool moves in + relative to the workpiece) or carried",
                Some("iso841"),
            )?
            .as_str()
        {
            "iso841" => Directions::Iso841,
            "carried" => Directions::Carried,
            other => return Err(format!("--directions '{other}' is not known; allowed are iso841 and carried").into()),
        },
    };
    Ok(Sizes {
        name: arguments.name.clone().unwrap_or_else(|| format!("Machine {code}")),
        nose_to_table: range(&nose, "--nose-to-table")?,
        table: table_size(&table)?,
        travels: [x, y, z],
        ranges,
        tilt_above_table,
        pivot_above_nose,
        housing: arguments.housing,
        has_angle_plate: arguments.angle_plate,
        directions,
        code,
    })
}

fn numbers(text: &str, separator: char, option: &str) -> Result<Vec<f64>, Refusal> {
    text.split(separator).map(|part| number(part, option)).collect()
}

/// `FROM..TO`, the lower end first.
fn range(text: &str, option: &str) -> Result<(f64, f64), Refusal> {
    let (from, to) = text
        .split_once("..")
        .ok_or_else(|| format!("{option}: '{text}' is no range; write FROM..TO, e.g. 110..585"))?;
    let (from, to) = (number(from, option)?, number(to, option)?);
    if from >= to {
        return Err(format!("{option}: {from}..{to} runs backwards; the lower end stands first").into());
    }
    Ok((from, to))
}

fn named_range(text: &str) -> Result<(String, (f64, f64)), Refusal> {
    let (name, ends) = text
        .split_once('=')
        .ok_or_else(|| format!("--range: '{text}' is not understood; write AXIS=FROM..TO, e.g. A=-120..30"))?;
    let (from, to) = range(ends, "--range")?;
    if from < -3600.0 || to > 3600.0 || from > 0.0 || to < 0.0 {
        return Err(format!("--range: {name}={from}..{to} deg; a range holds 0 and lies within -3600..3600").into());
    }
    Ok((name.trim().to_string(), (from, to)))
}

/// Questions for what the options leave open.
struct Asker {
    /// Someone sits at a terminal.
    asks: bool,
}

impl Asker {
    fn for_text(&self, option: &str, question: &str, usual: Option<&str>) -> Result<String, Refusal> {
        if !self.asks {
            return Err(format!("{option} is missing: {question}").into());
        }
        let mut terminal = std::io::stderr().lock();
        let offer = usual.map(|usual| format!(" [{usual}]")).unwrap_or_default();
        write!(terminal, "{question}{offer}: ").and_then(|()| terminal.flush())?;
        let mut answer = String::new();
        std::io::stdin().lock().read_line(&mut answer)?;
        match (answer.trim(), usual) {
            ("", Some(usual)) => Ok(usual.to_string()),
            ("", None) => Err(format!("{option} is missing: {question}").into()),
            (answer, _) => Ok(answer.to_string()),
        }
    }

    fn for_number(&self, option: &str, question: &str) -> Result<f64, Refusal> {
        number(&self.for_text(option, question, None)?, option)
    }
}
