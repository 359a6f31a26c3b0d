//! `fiveaxis check`: validates a machine or session file and shows chain, axes, error slots and link transforms.

use std::path::{Path, PathBuf};

use clap::Args;
use fiveaxis::bodies::Bodies;
use fiveaxis::chain::{Chain, Composition, Geometry, sense_in_words};
use fiveaxis::collision::{Meeting, World};
use fiveaxis::load::{LinkChoice, load_machine_and_bodies_with_links, load_session, names_tests, positions_from_text};
use fiveaxis::machine::{Directions, Machine};
use fiveaxis::report::check::{
    LinkPose, MovingAxis, Placement, Senses, SessionCheck, TestCheck, check_json, check_text,
};
use fiveaxis::report::meetings::BodyPairs;
use fiveaxis::session::{Session, Setups};
use fiveaxis::simulate::{component_errors_of, simulate};

use super::Refusal;
use super::output::{print, print_json, settle};
use super::solids;

/// Arguments of `check`.
#[derive(Args)]
#[command(after_help = "Example: fiveaxis check machines/hermle-c600u.yaml --at \"A=30,C=-45\"")]
pub struct Arguments {
    /// Machine file (YAML or URDF) or session file
    file: PathBuf,
    /// Positions for a second set of link transforms, mm and degrees: "A=30,C=-45"; other axes stand at zero
    #[arg(long, allow_hyphen_values = true)]
    at: Option<String>,
    /// Print JSON instead of tables
    #[arg(long)]
    json: bool,
    /// URDF: the link that is the bed (default: the root link)
    #[arg(long)]
    root_link: Option<String>,
    /// URDF: the link that carries the pivot (default: found by name)
    #[arg(long)]
    workpiece_link: Option<String>,
    /// URDF: the link that carries the spindle ball (default: found by name)
    #[arg(long)]
    tool_link: Option<String>,
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    let links = LinkChoice {
        root: arguments.root_link.clone(),
        workpiece: arguments.workpiece_link.clone(),
        tool: arguments.tool_link.clone(),
    };
    settle(&arguments.file)?;
    let (machine, session, pairs) = if names_tests(&arguments.file)? {
        if !links.is_empty() {
            return Err(format!(
                "{}: is a session; it names links itself, with root_link, workpiece_link and tool_link",
                arguments.file.display()
            )
            .into());
        }
        let session = load_session(&arguments.file)?;
        (session.machine.clone(), Some(session_check(&session)?), None)
    } else {
        // solids, mounts and the spindle stand in the same file and are validated with it
        let (machine, bodies) = load_machine_and_bodies_with_links(&arguments.file, &links)?;
        let pairs = body_pairs(&arguments.file, &machine, &bodies)?;
        (machine, None, pairs)
    };
    let mut placements = vec![placement(&machine, vec![0.0; machine.axes.len()])];
    if let Some(at) = &arguments.at {
        placements.push(placement(&machine, positions_from_text(at, &machine)?));
    }
    let senses = senses(&machine);
    if arguments.json {
        let value = check_json(&machine, &senses, &placements, session.as_ref(), pairs.as_ref());
        print_json(&value)
    } else {
        print(&check_text(&machine, &senses, &placements, session.as_ref(), pairs.as_ref()))
    }
}

/// Every axis's sense in words with all axes at zero; both readings where the file states none.
fn senses(machine: &Machine) -> Senses {
    let zero = vec![0.0; machine.axes.len()];
    let of = |directions: Directions| {
        let machine = Machine { directions: Some(directions), ..machine.clone() };
        (0..machine.axes.len()).map(|axis| sense_in_words(&machine, axis, &zero)).collect()
    };
    match machine.directions {
        Some(directions) => Senses { as_read: of(directions), else_iso841: Vec::new() },
        None => Senses { as_read: of(Directions::Carried), else_iso841: of(Directions::Iso841) },
    }
}

/// Which bodies touch and can meet. Nothing is planned or cleared with the bodies of a URDF, whose neighbours overlap as a rule.
fn body_pairs(file: &Path, machine: &Machine, bodies: &Bodies) -> Result<Option<BodyPairs>, Refusal> {
    if bodies.bodies.is_empty() || solids::is_urdf(file) {
        return Ok(None);
    }
    let world = World::new(&Chain::of(machine), bodies)?;
    let at_zero = world.meetings_at_zero(machine);
    let elsewhere = |found: Vec<Meeting>| -> Vec<Meeting> {
        let new = |meeting: &Meeting| at_zero.iter().all(|known| known.pair != meeting.pair);
        found.into_iter().filter(new).collect()
    };
    Ok(Some(BodyPairs {
        touching: world.touching.clone(),
        by_one_axis: elsewhere(world.meetings_by_one_axis(machine)),
        by_several_axes: elsewhere(world.meetings_by_several_axes(machine)),
        at_zero,
    }))
}

/// Poses of every link, nominal and with the errors of the file.
fn placement(machine: &Machine, positions: Vec<f64>) -> Placement {
    let chain = Chain::of(machine);
    let nominal = Geometry::nominal(&chain);
    let actual = Geometry::new(&chain, &machine.location_errors(), Composition::Exact);
    let motion = component_errors_of(machine, &positions);
    let links = chain
        .links()
        .into_iter()
        .map(|(name, link)| LinkPose {
            name: name.to_string(),
            nominal: nominal.pose(link, &positions, None),
            with_errors: actual.pose(link, &positions, Some(&motion)),
        })
        .collect();
    Placement { positions, links }
}

/// What stands in a session, test by test, against the machine file's own prediction.
fn session_check(session: &Session) -> Result<SessionCheck, Refusal> {
    let traces = simulate(session, Composition::Exact)?;
    let setups = Setups::of(session);
    let tests = session
        .tests
        .iter()
        .zip(&traces)
        .map(|(test, trace)| {
            let readings = test.recording.as_ref().map(|recording| recording.length_mm.as_slice());
            let mut off: Vec<f64> = readings
                .unwrap_or_default()
                .iter()
                .zip(&trace.length_mm)
                .map(|(reading, predicted)| reading - predicted)
                .filter(|off| off.is_finite())
                .collect();
            off.sort_by(f64::total_cmp);
            let moving = trace
                .motion
                .moving
                .iter()
                .map(|&axis| {
                    let column = (0..trace.motion.rows()).map(|row| trace.motion.row(row)[axis]);
                    let (lowest, highest) =
                        column.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), q| (a.min(q), b.max(q)));
                    MovingAxis { axis, lowest, highest }
                })
                .collect();
            TestCheck {
                name: test.name.clone(),
                rows: trace.length_mm.len(),
                readings: off.len(),
                moving,
                bar_length_mm: test.bar_length_mm,
                median_off_mm: off.get(off.len() / 2).copied(),
            }
        })
        .collect();
    Ok(SessionCheck {
        name: session.name.clone(),
        tests,
        pivots: setups.pivots.into_iter().map(|setup| setup.label).collect(),
        spindle_balls: setups.spindle_balls.into_iter().map(|setup| setup.label).collect(),
        bars: setups.bars.into_iter().map(|setup| setup.label).collect(),
    })
}
