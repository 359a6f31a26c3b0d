//! `fiveaxis compensate`: a program corrected for the errors of a machine.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use clap::Args;
use fiveaxis::chain::Chain;
use fiveaxis::compensate::{Compensator, Coordinates, LETTERS, LONGEST_LINE, OFFSET_NAMES, OffsetTable, Settings};
use fiveaxis::disturbances::{into_component_errors_within, positions_seen, steps_seen, take_remembered};
use fiveaxis::identify::{DeterminedError, DeterminedErrors};
use fiveaxis::load::LoadError;
use fiveaxis::machine::{Component, Effect, ErrorName};
use fiveaxis::report::compensate::{summary_json, summary_text};
use fiveaxis::report::found::{along_the_program, ends_of_tables, open_causes};
use fiveaxis::units::ARCSEC_PER_RAD;

use super::Refusal;
use super::output::{Foreign, StreamedFile, print, print_json};
use crate::verbs::options::directions::DirectionsName;
use crate::verbs::options::errors::{ErringMachine, erring_machine};
use crate::verbs::output::progress::Working;

/// Arguments of `compensate`.
#[derive(Args)]
#[command(
    after_help = "Moves become blocks after which the machine with its errors follows the path of the machine without; everything else stays byte for byte. What is not understood is refused with its line, or with --mark left as it is with a comment.\nExample: fiveaxis compensate part.ngc machine.yaml --errors session.yaml --offset G54:X=0,Y=0,Z=0 --tool 1=120 --out part-corrected.ngc"
)]
pub struct Arguments {
    /// Program in G-code; - is standard input
    program: PathBuf,
    /// Machine file; its errors are corrected unless --errors names others
    machine: PathBuf,
    /// Errors in place of those of the machine file: a session, which is fitted, or a machine file as identify --save writes
    #[arg(long, value_name = "FILE")]
    errors: Option<PathBuf>,
    /// File for the corrected program
    #[arg(long)]
    out: PathBuf,
    /// X, Y, Z of the whole program are the tool tip in the workpiece (else only after G43.4)
    #[arg(long)]
    rtcp: bool,
    /// How near the tip stays to its path, µm
    #[arg(long, value_name = "UM", default_value_t = 0.08)]
    tolerance: f64,
    /// How near the tool stays to its direction between the ends of blocks, arcsec
    #[arg(long, value_name = "ARCSEC", default_value_t = 0.008)]
    direction_tolerance: f64,
    /// Work offset, machine coordinates in mm and deg: G54:X=-10,Y=5,Z=-200; axes that are not named have 0
    #[arg(long, value_name = "OFFSET", allow_hyphen_values = true)]
    offset: Vec<String>,
    /// Length of a tool from the spindle's nose, mm: 1=120.5
    #[arg(long, value_name = "NUMBER=MM")]
    tool: Vec<String>,
    /// Length of the tool while no tool length is in force, mm; the machine file's gauge length unless given
    #[arg(long, value_name = "MM")]
    tool_length: Option<f64>,
    /// Modes that hold when the program begins: "G21 G90 G94 G17 G54 G49"
    #[arg(long, default_value = "")]
    initial: String,
    /// Decimals of lengths (mm) and angles (deg) in words
    #[arg(long, value_name = "MM,DEG", default_value = "6,6")]
    decimals: String,
    /// Arcs become straight blocks: for controls that take no rotary axis in G2 and G3
    #[arg(long)]
    straight: bool,
    /// Blocks that cannot be corrected stay as they are with a comment before them; else they end the run
    #[arg(long)]
    mark: bool,
    /// Sense of the axes where the machine file does not state it
    #[arg(long, value_enum)]
    directions: Option<DirectionsName>,
    /// Replace a file of the same name; never an input
    #[arg(long)]
    force: bool,
    /// Print JSON instead of words
    #[arg(long)]
    json: bool,
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    let settings = settings(arguments)?;
    let mut erring = erring_machine(&arguments.machine, arguments.errors.as_deref(), arguments.directions)?;
    erring.machine.stated_directions().map_err(|why| format!("{}: {why}", arguments.machine.display()))?;
    leave_out_undetermined(&mut erring);
    let session = erring.fit.as_ref().map(|(session, _)| session);
    let (seen, steps) = session.map_or_else(Default::default, |session| (positions_seen(session), steps_seen(session)));
    let found = erring.machine.effects.clone();
    let remembered = take_remembered(&mut erring.machine, &steps);
    let taken = into_component_errors_within(&mut erring.machine, &seen);
    let taken_out: Vec<Effect> = found.into_iter().filter(|one| !erring.machine.effects.contains(one)).collect();
    let mut notes = open_causes(&erring.machine, &taken_out);
    notes.extend(along_the_program(&erring.machine, &remembered));
    notes.extend(ends_of_tables(&erring.machine, &taken.ends));
    for effect in &taken.left {
        eprintln!(
            "fiveaxis: the effect {effect} depends on more than the position and the way of its axis and stays in the machine"
        );
    }
    let has_errors = !remembered.is_empty()
        || erring.machine.axes.iter().any(|axis| axis.location_errors != [0.0; 6] || !axis.component_errors.is_empty());
    if !has_errors {
        return Err(format!(
            "{} states no errors, so that there is nothing to correct; name a session or a fitted machine with --errors",
            arguments.machine.display()
        )
        .into());
    }
    let chain = Chain::of(&erring.machine);
    let mut compensator = Compensator::new(&erring.machine, &chain, settings)
        .map_err(|why| format!("{}: {why}", arguments.machine.display()))?
        .with_remembered(remembered);
    let mut inputs = erring.inputs.clone();
    inputs.push(arguments.program.clone());
    let reader = opened(&arguments.program)?;
    let mut out = StreamedFile::begin(&arguments.out, &inputs, Foreign::with(arguments.force))?;
    let working = Working::on(format!("correcting {}", arguments.program.display()));
    copy_corrected(&arguments.program, reader, &mut compensator, &mut out)?;
    out.finish()?;
    drop(working);
    let summary = compensator.summary();
    let file = arguments.out.display().to_string();
    match arguments.json {
        true => {
            notes.iter().for_each(|note| eprintln!("fiveaxis: {note}"));
            print_json(&summary_json(&erring.machine, summary, &file))
        }
        false => {
            let notes: String = notes.iter().map(|note| format!("note: {note}\n")).collect();
            print(&(summary_text(&erring.machine, summary, &file) + &notes))
        }
    }
}

/// Of a session's errors those that its readings determine are corrected in full: values of the others mean little.
fn leave_out_undetermined(erring: &mut ErringMachine) {
    let Some((_, fit)) = &erring.fit else { return };
    let determined = DeterminedErrors::of(fit);
    determined.put_into(&mut erring.machine);
    let name = |error: &DeterminedError| {
        ErrorName::location(Component::ALL[error.component], &erring.machine.axes[error.axis].name).to_string()
    };
    let names: Vec<String> = determined.partial().map(name).collect();
    if !names.is_empty() {
        eprintln!(
            "fiveaxis: the readings leave {} uncertain by more than 10 µm or 10 arcsec: what they do not determine is corrected in part; identify says which tests would determine it",
            names.join(", ")
        );
    }
}

/// Line by line: no more than one is held.
fn copy_corrected(
    file: &Path,
    mut reader: Box<dyn BufRead>,
    compensator: &mut Compensator,
    out: &mut StreamedFile,
) -> Result<(), Refusal> {
    let (mut line, mut text) = (Vec::new(), Vec::new());
    loop {
        line.clear();
        let most = LONGEST_LINE as u64 + 2;
        let read = reader.by_ref().take(most).read_until(b'\n', &mut line);
        if read.map_err(|why| format!("{} cannot be read: {why}", file.display()))? == 0 {
            return Ok(());
        }
        text.clear();
        compensator
            .line(&line, &mut text)
            .map_err(|why| LoadError::line(file, usize::try_from(why.line).unwrap_or(usize::MAX), why.reason))?;
        out.write(&text)?;
    }
}

/// The program's file.
fn opened(file: &Path) -> Result<Box<dyn BufRead>, Refusal> {
    if file == Path::new("-") {
        return Ok(Box::new(BufReader::with_capacity(1 << 16, std::io::stdin())));
    }
    let cannot = |message: String| -> Refusal { LoadError::file(file, message).into() };
    let metadata =
        std::fs::metadata(file).map_err(|why| cannot(format!("cannot be read: {why}; check its name and folder")))?;
    if !metadata.is_file() {
        return Err(cannot("is no plain file; name a program".into()));
    }
    let opened = File::open(file).map_err(|why| cannot(format!("cannot be opened: {why}")))?;
    Ok(Box::new(BufReader::with_capacity(1 << 16, opened)))
}

fn settings(arguments: &Arguments) -> Result<Settings, Refusal> {
    let between = |option: &str, value: f64, least: f64, most: f64| -> Result<f64, Refusal> {
        match value >= least && value <= most {
            true => Ok(value),
            false => Err(format!("{option} {value} is not between {least} and {most}").into()),
        }
    };
    let decimals: Vec<usize> = arguments.decimals.split(',').filter_map(|part| part.trim().parse().ok()).collect();
    let decimals = match decimals.as_slice() {
        &[mm, deg] if (3..=9).contains(&mm) && (3..=9).contains(&deg) => [mm, deg],
        _ => {
            return Err(format!(
                "--decimals '{}' is not two numbers from 3 to 9; write for example 5,6",
                arguments.decimals
            )
            .into());
        }
    };
    Ok(Settings {
        coordinates: if arguments.rtcp { Coordinates::Workpiece } else { Coordinates::Axes },
        tolerance_mm: between("--tolerance", arguments.tolerance, 0.01, 1000.0)? * 1e-3,
        tolerance_rad: between("--direction-tolerance", arguments.direction_tolerance, 0.001, 3600.0)? / ARCSEC_PER_RAD,
        offsets: offsets(&arguments.offset)?,
        tools: arguments.tool.iter().map(|text| tool(text)).collect::<Result<_, _>>()?,
        tool_length_mm: arguments
            .tool_length
            .map(|length| between("--tool-length", length, 0.0, 10_000.0))
            .transpose()?,
        initial: arguments.initial.clone(),
        mark: arguments.mark,
        decimals,
        keeps_arcs: !arguments.straight,
    })
}

/// `G54:X=-10,Y=5`.
fn offsets(texts: &[String]) -> Result<OffsetTable, Refusal> {
    let mut table: OffsetTable = [None; 9];
    for text in texts {
        let refuse = |why: &str| -> Refusal {
            format!("--offset '{text}' {why}; write for example --offset G54:X=-10,Y=5,Z=-200").into()
        };
        let (name, values) = text.split_once(':').ok_or_else(|| refuse("has no colon after its name"))?;
        let system = OFFSET_NAMES.iter().position(|other| other.eq_ignore_ascii_case(name.trim()));
        let system = system.ok_or_else(|| refuse("names none of G54 to G59.3"))?;
        let mut offsets = [0.0; 9];
        for part in values.split(',').map(str::trim).filter(|part| !part.is_empty()) {
            let (letter, value) = part.split_once('=').ok_or_else(|| refuse("has a part without ="))?;
            let letter = letter.trim().to_ascii_uppercase();
            let place = LETTERS
                .iter()
                .position(|other| letter.as_bytes() == [*other])
                .ok_or_else(|| refuse("names none of X Y Z A B C U V W"))?;
            let value = value.trim().parse::<f64>().ok().filter(|value| value.abs() <= 1e6);
            offsets[place] = value.ok_or_else(|| refuse("has a value that is no number"))?;
        }
        if table[system].replace(offsets).is_some() {
            return Err(refuse("stands twice"));
        }
    }
    Ok(table)
}

/// `1=120.5`.
fn tool(text: &str) -> Result<(u32, f64), Refusal> {
    let parsed = text.split_once('=').and_then(|(number, length)| {
        Some((
            number.trim().parse().ok()?,
            length.trim().parse::<f64>().ok().filter(|mm| (0.0..=10_000.0).contains(mm))?,
        ))
    });
    parsed.ok_or_else(|| {
        format!("--tool '{text}' is not a number and a length in mm; write for example --tool 1=120.5").into()
    })
}
