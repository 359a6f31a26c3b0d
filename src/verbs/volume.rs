//! `fiveaxis volume`: what the errors of a machine do to the tool tip over its work volume.

use std::path::PathBuf;

use clap::Args;
use fiveaxis::chain::Chain;
use fiveaxis::report::volume::{VolumeReport, volume_csv, volume_json, volume_page, volume_text};
use fiveaxis::volume::{Figures, Part, causes, pose_errors, poses, spread};

use super::Refusal;
use super::inverse::{tool_of, vector};
use super::output::{Foreign, OutputFolder, print, print_json, write_all};
use crate::verbs::options::directions::DirectionsName;
use crate::verbs::options::errors::erring_machine;
use crate::verbs::output::progress::Working;

/// Arguments of `volume`.
#[derive(Args)]
#[command(
    after_help = "Example: fiveaxis volume examples/thesis/chapter5/machine.yaml --errors examples/thesis/chapter5/session.yaml --part -100,-100,0,100,100,80 --out volume"
)]
pub struct Arguments {
    /// Machine file with bodies or a spindle; its errors count unless --errors names others
    machine: PathBuf,
    /// Errors in place of those of the machine file: a session, which is fitted, or a machine file as identify --save writes
    #[arg(long, value_name = "FILE")]
    errors: Option<PathBuf>,
    /// A part in place of the whole travel: a box in the workpiece's frame, mm: x,y,z,x,y,z of two corners
    #[arg(long, value_name = "BOX", allow_hyphen_values = true)]
    part: Option<String>,
    /// Length of the tool from the spindle's nose, mm; unless given the tip is where the spindle ball is
    #[arg(long, value_name = "MM")]
    tool_length: Option<f64>,
    /// Number of poses
    #[arg(long, default_value_t = 5000)]
    poses: usize,
    /// Sense of the axes where the machine file does not state it
    #[arg(long, value_enum)]
    directions: Option<DirectionsName>,
    /// Write volume.html (one page, opens offline) and volume.csv (every pose) into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace files in the way that fiveaxis did not write; never an input
    #[arg(long)]
    force: bool,
    /// Print JSON instead of tables
    #[arg(long)]
    json: bool,
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    if !(100..=1_000_000).contains(&arguments.poses) {
        return Err(format!("--poses {} is not between 100 and 1000000", arguments.poses).into());
    }
    let part = arguments.part.as_deref().map(part).transpose()?;
    let mut erring = erring_machine(&arguments.machine, arguments.errors.as_deref(), arguments.directions)?;
    for effect in fiveaxis::disturbances::into_component_errors(&mut erring.machine) {
        eprintln!("fiveaxis: the effect {effect} depends on more than the position of its axis and is left out");
    }
    let machine = &erring.machine;
    let tool = tool_of(machine, arguments.tool_length)?;
    let poses = poses(machine, tool, part.as_ref(), arguments.poses)
        .map_err(|why| format!("{}: {why}", arguments.machine.display()))?;
    let working = Working::on(format!("the volume of {}", machine.name));
    let chain = Chain::of(machine);
    let errors = pose_errors(machine, &chain, tool, &poses);
    let report = VolumeReport {
        machine,
        part,
        figures: Figures::of(&errors),
        causes: causes(machine, tool, &poses),
        spread: erring.fit.as_ref().map(|(_, fit)| spread(machine, fit, tool, &poses)),
        poses: &poses,
        errors: &errors,
    };
    drop(working);
    if let Some(folder) = &arguments.out {
        let mut output = OutputFolder::default();
        output.add("volume.html", volume_page(&report));
        output.add("volume.csv", volume_csv(&report));
        write_all(vec![(folder.clone(), output)], &erring.inputs, Foreign::with(arguments.force))?;
    }
    match arguments.json {
        true => print_json(&volume_json(&report)),
        false => {
            let mut text = volume_text(&report);
            if let Some(folder) = &arguments.out {
                text.push_str(&format!("\nwritten: {}\n", folder.join("volume.html").display()));
            }
            print(&text)
        }
    }
}

/// Two corners of a box.
fn part(text: &str) -> Result<Part, Refusal> {
    let refuse = || -> Refusal {
        format!("--part '{text}' is not a box; write two corners in mm, for example --part -100,-100,0,100,100,80")
            .into()
    };
    let numbers: Vec<&str> = text.split(',').collect();
    if numbers.len() != 6 {
        return Err(refuse());
    }
    let [one, other] = [&numbers[..3], &numbers[3..]].map(|corner| vector("--part", &corner.join(",")));
    let (one, other) = (one.map_err(|_| refuse())?, other.map_err(|_| refuse())?);
    let part = Part { low: one.inf(&other), high: one.sup(&other) };
    Ok(part)
}
