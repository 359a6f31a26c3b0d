//! Files of a plan: session, setup sheet with its pictures, programs. What is planned is `plan`'s, who may be overwritten `former`'s.

use std::path::Path;

use fiveaxis::bodies::{Bodies, Kit};
use fiveaxis::chain::{Chain, Geometry};
use fiveaxis::collision::{Instrument, Scratch, World};
use fiveaxis::load::limits::YAML_BYTES;
use fiveaxis::load::{machine_from_yaml, mesh_files, read_limited};
use fiveaxis::machine::Machine;
use fiveaxis::nc::{Dialect, dry_run_program, program, zero_words};
use fiveaxis::plan::{Plan, PlannedTest, Settings};
use fiveaxis::report::session_yaml;
use fiveaxis::report::setup_sheet::{MARKER, Outline, Sheet, View, setup_sheet};
use fiveaxis::session::{Session, Test};
use nalgebra::Vector3;

use super::former::head;
use crate::verbs::Refusal;
use crate::verbs::output::OutputFolder;

/// A plan with all that it was made from.
#[derive(Clone, Copy)]
pub struct Planned<'a> {
    pub machine: &'a Machine,
    pub bodies: &'a Bodies,
    pub kit: &'a Kit,
    pub settings: &'a Settings,
    pub plan: &'a Plan,
}

/// The program that goes through a plan without the bar.
fn dry_run_file(dialect: Dialect, ending: &str) -> String {
    format!("nc/{}/dry-run.{ending}", dialect.folder())
}

/// Session, setup sheet and programs; of a plan without tests the sheet alone, which says why.
pub fn planned_files(folder: &Path, machine_file: &Path, planned: &Planned) -> Result<OutputFolder, Refusal> {
    let Planned { machine, bodies, plan, settings, .. } = *planned;
    let mut output = OutputFolder::default();
    let dialects: Vec<(Dialect, &str)> =
        Dialect::ALL.into_iter().filter(|(dialect, _)| dialect.unknown_axis(machine).is_none()).collect();
    let programs: Vec<Vec<String>> = plan
        .tests
        .iter()
        .map(|test| {
            let name =
                |&(dialect, ending): &(Dialect, &str)| format!("nc/{}/{}.{ending}", dialect.folder(), test.test.name);
            dialects.iter().map(name).collect()
        })
        .collect();
    let dry_runs: Vec<String> = dialects.iter().map(|&(dialect, ending)| dry_run_file(dialect, ending)).collect();
    output.add("setup-sheet.html", sheet(planned, &programs, &dry_runs));
    output.known_by("setup-sheet.html", MARKER);
    if plan.tests.is_empty() {
        return Ok(output);
    }
    output.add("machine.yaml", stating_directions(machine_file, machine)?);
    let meshes = meshes(folder, machine_file, &mut output)?;
    for (dialect, _) in Dialect::ALL {
        if let Some(axis) = dialect.unknown_axis(machine) {
            eprintln!("no {} programs: the control has no axis called {axis}", dialect.folder());
        }
    }
    let zero = zero_words(machine, bodies);
    let mut started_at_s = 0.0;
    let mut tests = Vec::new();
    for (test, names) in plan.tests.iter().zip(&programs) {
        for way in test.both_ways() {
            let recording_file = Some(format!("{}.csv", way.name));
            tests.push(Test { recording_file, started_at_s, ..way });
            started_at_s += (test.minutes * 30.0).ceil();
        }
        for ((dialect, _), name) in dialects.iter().zip(names) {
            output.add(name.clone(), program(machine, test, &zero, *dialect));
        }
    }
    for (&(dialect, _), name) in dialects.iter().zip(&dry_runs) {
        output.add(name.clone(), dry_run_program(machine, plan, &zero, dialect));
    }
    let session = Session {
        name: format!("{}, planned", machine.name),
        machine_file: "machine.yaml".into(),
        machine: machine.clone(),
        spread: settings.uncertainty.spread,
        tests,
    };
    let listed: Vec<String> = programs.into_iter().flatten().chain(dry_runs).chain(meshes).collect();
    output.add("session.yaml", head(&listed) + &session_yaml(&session));
    Ok(output)
}

/// The machine file as it is read here: with the sense of the axes where an option said it.
fn stating_directions(machine_file: &Path, machine: &Machine) -> Result<String, Refusal> {
    let text = read_limited(machine_file, YAML_BYTES)?;
    let directions = machine.stated_directions()?;
    let says_so = |text: &str| machine_from_yaml(machine_file, text.into()).is_ok_and(|read| read == *machine);
    if says_so(&text) {
        return Ok(text);
    }
    let is_top_key = |line: &str| ["name:", "code:", "chain:", "axes:"].iter().any(|key| line.starts_with(key));
    let place = text.split_inclusive('\n').take_while(|line| !is_top_key(line)).map(str::len).sum();
    let (before, after) = text.split_at(place);
    let stated = format!("{before}directions: {directions}\n{after}");
    match says_so(&stated) {
        true => Ok(stated),
        false => Err(format!(
            "{}: cannot take the line 'directions: {directions}' by itself as it is written; write it into the file",
            machine_file.display()
        )
        .into()),
    }
}

/// Takes the meshes of the machine along; those beside its folder stay where the session finds them.
fn meshes(folder: &Path, machine_file: &Path, output: &mut OutputFolder) -> Result<Vec<String>, Refusal> {
    let home = machine_file.parent().unwrap_or(Path::new(""));
    let mut taken = Vec::new();
    for mesh in mesh_files(machine_file)? {
        // where the session finds it
        let target = folder.join(&mesh);
        if !mesh.starts_with("../") {
            output.add(mesh.clone(), std::fs::read(home.join(&mesh))?);
            taken.push(mesh);
        } else if !target.is_file() {
            eprintln!("{} is not there and not written: the session's machine names it", target.display());
        }
    }
    Ok(taken)
}

fn sheet(planned: &Planned, programs: &[Vec<String>], dry_runs: &[String]) -> String {
    let Planned { machine, bodies, kit, settings, plan } = *planned;
    let pictures = pictures(planned);
    setup_sheet(&Sheet { machine, bodies, kit, settings, plan, pictures: &pictures, programs, dry_runs })
}

/// Two views of every test in the middle of its arc.
fn pictures(planned: &Planned) -> Vec<[View; 2]> {
    let Planned { machine, bodies, kit, plan, .. } = *planned;
    let chain = Chain::of(machine);
    let Ok(world) = World::new(&chain, bodies) else { return Vec::new() };
    let up = -machine.gravity;
    let right = if up.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let sides = [("from the front", right), ("from the right", up.cross(&right))];
    let views = plan.tests.iter().filter_map(|test| {
        let instrument = Instrument::of(&world, machine, bodies, kit, &test.test).ok()?;
        let scene = instrument.scene(&world);
        let mut scratch = Scratch::default();
        let frames = scene.frames(&test.middle, &mut scratch).to_vec();
        Some(sides.map(|(side, right)| {
            let outlines = (0..scene.parts().len()).map(|part| Outline {
                name: scene.parts()[part].name.clone(),
                instrument: part >= world.part_count(),
                points: scene.outline(part, &frames, &right, &up),
            });
            let (balls, ways) = balls(&chain, test, &right, &up);
            View {
                side: format!("{side}, middle of the arc"),
                right: direction(&right),
                up: direction(&up),
                balls,
                ways,
                outlines: outlines.collect(),
            }
        }))
    });
    views.collect()
}

/// Positions between two rows of a turn that a picture shows.
const ROWS: usize = 90;

/// Pivot ball and spindle ball in the middle of the arc and over it, to the right and up, mm.
fn balls(
    chain: &Chain,
    test: &PlannedTest,
    right: &Vector3<f64>,
    up: &Vector3<f64>,
) -> ([[f64; 2]; 2], [Vec<[f64; 2]>; 2]) {
    let geometry = Geometry::nominal(chain);
    let Ok((pivot, spindle)) = test.test.links(chain) else { return Default::default() };
    let seen = |q: &[f64]| {
        let of = |link, at| {
            let point = geometry.point(link, at, q, None);
            [point.dot(right), point.dot(up)]
        };
        [of(pivot, &test.test.pivot.at), of(spindle, &test.test.spindle_ball.at)]
    };
    let rows = test.run.get(1..test.run.len().saturating_sub(1)).unwrap_or_default();
    let mut ways = [Vec::new(), Vec::new()];
    for pair in rows.windows(2) {
        let parts = if test.is_coupled() { 1 } else { ROWS };
        for k in 0..=parts {
            let part = k as f64 / parts as f64;
            let q: Vec<f64> = pair[0].iter().zip(&pair[1]).map(|(a, b)| a + (b - a) * part).collect();
            ways.iter_mut().zip(seen(&q)).for_each(|(way, ball)| way.push(ball));
        }
    }
    (seen(&test.middle), ways)
}

/// Name of the direction of R that is nearest: `x`, `-y`.
fn direction(of: &Vector3<f64>) -> String {
    let axis = of.iamax();
    format!("{}{}", if of[axis] < 0.0 { "-" } else { "" }, ["x", "y", "z"][axis])
}
