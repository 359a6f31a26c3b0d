//! `fiveaxis simulate`: the recordings that a session would give, one CSV per test.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use fiveaxis::chain::Composition;
use fiveaxis::load::{load_instrument, load_session, recording_from_csv};
use fiveaxis::report::recording::{parts_csv, recording_csv, with_columns_of};
use fiveaxis::report::simulation::{simulation_json, simulation_text};
use fiveaxis::session::{LengthColumn, Session, Test};
use fiveaxis::simulate::{Instrument, SetupErrors, Trace, simulate_with};

use super::Refusal;
use super::output::{Foreign, OutputFolder, print, print_json, session_inputs, settle, write_all};
use crate::verbs::options::recorded::tell_scatter;
use crate::verbs::output::progress::Working;

/// Arguments of `simulate`.
#[derive(Args)]
#[command(
    after_help = "Example: fiveaxis simulate examples/thesis/chapter5/session.yaml --out traces --instrument default --draw-setups --seed 7"
)]
pub struct Arguments {
    /// Session file
    session: PathBuf,
    /// Folder for the recordings
    #[arg(long)]
    out: PathBuf,
    /// How error rotations are composed
    #[arg(long, value_enum, default_value_t = CompositionName::Exact)]
    composition: CompositionName,
    /// A real gauge: 'default' or an instrument file; without it readings are exact to 1e-10 mm
    #[arg(long, value_name = "FILE")]
    instrument: Option<String>,
    /// Draw errors of pivots, spindle balls and bars from the session's spreads
    #[arg(long)]
    draw_setups: bool,
    /// Seed of all that is drawn
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// What the recordings hold; as the session's own recordings, or absolute lengths, unless given
    #[arg(long, value_enum)]
    readings: Option<ReadingsName>,
    /// Replace files in the way that fiveaxis did not write; never the session's own
    #[arg(long)]
    force: bool,
    /// Print a summary as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum CompositionName {
    /// Exact rotation matrices
    Exact,
    /// The thesis's product of small-angle matrices
    FirstOrder,
}

#[derive(Clone, Copy, ValueEnum)]
enum ReadingsName {
    /// Absolute ball-to-ball lengths, length_mm
    Length,
    /// Readings minus the bar's calibrated length, deviation_um
    DeviationUm,
    /// The same in mm, deviation_mm
    DeviationMm,
}

/// Column for a test's readings.
fn column_of(asked: Option<ReadingsName>, test: &Test) -> Result<LengthColumn, Refusal> {
    let column = match asked {
        None => test.recording.as_ref().map_or(LengthColumn::LengthMm, |recording| recording.column),
        Some(ReadingsName::Length) => LengthColumn::LengthMm,
        Some(ReadingsName::DeviationUm) => LengthColumn::DeviationUm,
        Some(ReadingsName::DeviationMm) => LengthColumn::DeviationMm,
    };
    match column.is_deviation() && test.bar_length_mm.is_none() {
        true => Err(format!(
            "test '{}' states no bar_length, from which deviations are counted; add it or ask for --readings length",
            test.name
        )
        .into()),
        false => Ok(column),
    }
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    settle(&arguments.session)?;
    let session = load_session(&arguments.session)?;
    tell_scatter(&session);
    let instrument = match arguments.instrument.as_deref() {
        None => None,
        Some("default") => Some(Instrument::default()),
        Some(file) => Some(load_instrument(Path::new(file))?),
    };
    let composition = match arguments.composition {
        CompositionName::Exact => Composition::Exact,
        CompositionName::FirstOrder => Composition::FirstOrder,
    };
    let setup = match arguments.draw_setups {
        true => SetupErrors::drawn(&session, arguments.seed),
        false => SetupErrors::none(&session),
    };
    let working = Working::on(format!("simulating {}", session.name));
    let mut traces = simulate_with(&session, composition, &setup)?;
    if let Some(instrument) = &instrument {
        traces = instrument.read(&session, traces, arguments.seed)?;
    }
    let mut output = OutputFolder::default();
    // by test the file that holds its readings; those of one reading follow each other in one file
    let mut files: Vec<Option<String>> = Vec::new();
    let mut sightings: Vec<(String, String)> = Vec::new();
    for (index, (test, trace)) in session.tests.iter().zip(&traces).enumerate() {
        check_times(test, trace)?;
        if let Some(part) = test.reading.part() {
            if part.leads() {
                let name = test.recording_file.clone().unwrap_or_else(|| format!("{}.csv", part.of));
                files.push(Some(name.clone()));
                // the numbers of a reading follow each other
                let own = &traces[index..index + part.kind.scalars().len()];
                let numbers: Vec<&[f64]> = own.iter().map(|trace| trace.length_mm.as_slice()).collect();
                let text = parts_csv(&session.machine, test, part, &trace.motion, &numbers);
                // several instruments may stand in one file, each with its columns
                match sightings.iter_mut().find(|(other, _)| *other == name) {
                    Some((_, together)) => {
                        *together = with_columns_of(together, &text, &part.columns)
                            .ok_or_else(|| format!("test '{}' and another one are read into {name}, of other rows or columns; give one a file of its own", part.of))?;
                    }
                    None => sightings.push((name, text)),
                }
            } else {
                // what is stated of two sockets is in no file
                let before = files.last().cloned().flatten();
                files.push(before.filter(|_| !test.reading.is_gap()));
            }
            continue;
        }
        let name = test.recording_file.clone().unwrap_or_else(|| format!("{}.csv", test.name));
        let column = column_of(arguments.readings, test)?;
        let text = recording_csv(&session.machine, test, &trace.motion, &trace.length_mm, column);
        check_readable(&arguments.out.join(&name), &text, &session, test)?;
        files.push(Some(name.clone()));
        output.add(name, text);
    }
    sightings.into_iter().for_each(|(name, text)| output.add(name, text));
    let sets = vec![(arguments.out.clone(), output)];
    write_all(sets, &session_inputs(&arguments.session, &session), Foreign::with(arguments.force))?;
    drop(working);
    if arguments.json {
        print_json(&simulation_json(&session, (&traces, &files), &setup))
    } else {
        print(&simulation_text(&session, (&traces, &files), &arguments.out.display().to_string()))
    }
}

/// Refuses times that no verb would read, before anything is written.
fn check_times(test: &Test, trace: &Trace) -> Result<(), Refusal> {
    let time_s = trace.motion.time_s.as_deref().filter(|_| test.recording.is_none());
    let Some(row) = time_s.and_then(|time| time.windows(2).position(|pair| pair[1] <= pair[0])) else { return Ok(()) };
    let ball = if test.reading.part().is_some() { "target" } else { "ball" };
    Err(format!(
        "test '{}': neither a {ball} nor a slide moves from row {} to row {}, so that the feed gives no time between them; place a \
         {ball} off the axis that turns, or give a recording with the positions. Nothing is written",
        test.stated_name(),
        row + 1,
        row + 2
    )
    .into())
}

/// Refuses a recording that no verb would read, before anything is written.
fn check_readable(file: &Path, text: &str, session: &Session, test: &Test) -> Result<(), Refusal> {
    recording_from_csv(file, text, &session.machine, test.bar_length_mm).map(|_| ()).map_err(|why| {
        format!("test '{}' would give a recording that is refused, so nothing is written: {why}", test.name).into()
    })
}
