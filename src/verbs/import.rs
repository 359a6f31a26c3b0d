//! `fiveaxis import`: captures in one piece, as gauges write them, to a session with recordings.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use fiveaxis::chain::Chain;
use fiveaxis::import::{
    Began, Capture, Feeds, ImportError, Pair, Placement, Scale, SessionTimes, Stated, WhyPlanned, pairs, place_named,
    recordings, split_session,
};
use fiveaxis::load::printable::shortened;
use fiveaxis::load::{CaptureFile, CaptureHints, Moment, load_capture, load_session};
use fiveaxis::report::capture::{ImportJson, TimesOf, capture_svg, import_text, placed_json};
use fiveaxis::report::recording::path_csv;
use fiveaxis::report::{machine_yaml, session_yaml};
use fiveaxis::session::{LengthColumn, Motion, Recording, Session, Test};

use super::Refusal;
use super::output::{Foreign, OutputFolder, print, print_json, remark, session_inputs, settle, write_all};
use crate::verbs::output::ending::Ending;
use crate::verbs::output::progress::Working;

/// Arguments of `import`.
#[derive(Args)]
#[command(
    after_help = "Example: fiveaxis import examples/captures/xy-100-1.csv --session examples/captures/session.yaml --out imported"
)]
pub struct Arguments {
    /// Files as the gauge wrote them: tables with times and readings, or XML
    #[arg(required = true)]
    captures: Vec<PathBuf>,
    /// Session file that the plan wrote: its tests say what the programs did
    #[arg(long)]
    session: PathBuf,
    /// Folder for session.yaml, machine.yaml, the recordings and a picture of each capture
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// The first test that a capture holds, by name; found among all of the session unless given (one capture only)
    #[arg(long, value_name = "TEST")]
    test: Option<String>,
    /// Readings a second, for files without times
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// What readings without a unit are
    #[arg(long, value_enum)]
    unit: Option<UnitName>,
    /// Date and time when the session began, where captures state when they were recorded; that of the earliest unless given
    #[arg(long, value_name = "TIME")]
    began: Option<String>,
    /// The control, or an override, ran at another feed than programmed
    #[arg(long)]
    any_feed: bool,
    /// Replace files in the way that fiveaxis did not write; never the session's own
    #[arg(long)]
    force: bool,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum UnitName {
    /// Deviations from the bar's length, µm
    DeviationUm,
    /// Deviations from the bar's length, mm
    DeviationMm,
    /// Absolute lengths, mm
    LengthMm,
}

/// A capture with where it belongs.
struct Placed {
    file: PathBuf,
    read: CaptureFile,
    capture: Capture,
    placement: Placement,
    recordings: [(Recording, f64); 2],
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    settle(&arguments.session)?;
    let session = load_session(&arguments.session)?;
    let among = among(&session, arguments)?;
    let rate_hz = match arguments.rate {
        Some(rate) if !(rate > 0.0 && rate <= 1e6) => {
            return Err(format!("--rate {rate} is no number of readings a second from 0 to 1000000").into());
        }
        rate => rate,
    };
    let column = arguments.unit.map(|unit| match unit {
        UnitName::DeviationUm => LengthColumn::DeviationUm,
        UnitName::DeviationMm => LengthColumn::DeviationMm,
        UnitName::LengthMm => LengthColumn::LengthMm,
    });
    let began = began(arguments)?;
    if arguments.captures.iter().filter(|file| file.as_os_str() == "-").count() > 1 {
        return Err("standard input (-) is named twice, and is read once; name files".into());
    }
    let working = Working::on(format!("placing {} captures", arguments.captures.len()));
    let feeds = if arguments.any_feed { Feeds::Any } else { Feeds::Programmed };
    let read = |file: &PathBuf| load_capture(file, CaptureHints { rate_hz, column });
    let read: Vec<CaptureFile> = arguments.captures.iter().map(read).collect::<Result<_, _>>()?;
    let times = session_times(&arguments.captures, &read, began)?;
    let mut all: Vec<Placed> = Vec::new();
    for (file, read) in arguments.captures.iter().zip(read) {
        let placed = placed(&session, &among, (file, read), feeds)?;
        if let Some(other) = all.iter().find(|other| other.placement.pair == placed.placement.pair) {
            return Err(Ending::data_fault(format!(
                "{} and {} both fit test {} best; leave one of them out",
                other.file.display(),
                file.display(),
                session.tests[placed.placement.pair.tests[0]].name
            )));
        }
        all.push(placed);
    }
    let (output, json) = written(&session, &all, &times, &arguments.out)?;
    drop(working);
    let mut inputs = session_inputs(&arguments.session, &session);
    inputs.extend(arguments.captures.iter().cloned());
    write_all(vec![(arguments.out.clone(), output)], &inputs, Foreign::with(arguments.force))?;
    if arguments.json { print_json(&json) } else { print(&import_text(&json)) }
}

/// Pairs of tests that the captures may hold.
fn among(session: &Session, arguments: &Arguments) -> Result<Vec<Pair>, Refusal> {
    let all = pairs(session);
    let Some(name) = &arguments.test else {
        return if all.is_empty() { Err(ImportError::NoPair.into()) } else { Ok(all) };
    };
    if arguments.captures.len() > 1 {
        return Err("--test names the test of one capture; import several without it".into());
    }
    let first = |pair: &Pair| session.tests[pair.tests[0]].name.as_str();
    match all.iter().find(|pair| first(pair) == name) {
        Some(pair) => Ok(vec![*pair]),
        None => {
            let known: Vec<&str> = all.iter().map(first).collect();
            Err(format!("--test '{name}' begins no pair of tests (allowed: {})", known.join(", ")).into())
        }
    }
}

fn placed(
    session: &Session,
    among: &[Pair],
    (file, read): (&Path, CaptureFile),
    feeds: Feeds,
) -> Result<Placed, Refusal> {
    let capture = Capture { time_s: read.time_s.clone(), reading_mm: read.reading_mm.clone() };
    let refuse = |why: ImportError| match why {
        ImportError::Motion(_) | ImportError::Fit(_) => Refusal::from(why),
        // what was left out may be what is missing
        _ if read.not_read.is_empty() => Ending::data_fault_in(file, why.to_string()),
        _ => Ending::data_fault_in(file, format!("{why} (not read in it: {})", shown(&read.not_read))),
    };
    if read.is_latin {
        remark(format_args!("{}: is no UTF-8 text; read as Windows-1252 (Latin-1)", file.display()));
    }
    let placement = place_named(session, among, &capture, feeds, named(session, file)).map_err(refuse)?;
    let test = &session.tests[placement.pair.tests[0]];
    refuse_other_bar(test, &read, &capture).map_err(refuse)?;
    if !read.has_times {
        doubt_rows(file, &placement).map_err(refuse)?;
    }
    let bar_mm = match (read.column.is_deviation(), test.bar_length_mm) {
        (false, _) => 0.0,
        (true, Some(bar_mm)) => bar_mm,
        (true, None) => {
            return Err(format!(
                "{}: holds deviations, and test '{}' states no bar_length; add it to the session",
                file.display(),
                test.name
            )
            .into());
        }
    };
    let recordings = recordings(&placement, &capture, bar_mm, read.column);
    warn(session, file, &placement);
    Ok(Placed { file: file.to_path_buf(), read, capture, placement, recordings })
}

/// Most by which lengths may differ from the bar's, mm: twice the stroke of usual bars, for a gauge whose zero was never set.
const LENGTH_OFF_MM: f64 = 2.0;

/// Refuses lengths of another bar than that of the test.
fn refuse_other_bar(test: &Test, read: &CaptureFile, capture: &Capture) -> Result<(), ImportError> {
    let length_mm = capture.middle_mm();
    match test.bar_length_mm {
        Some(bar_mm) if !read.column.is_deviation() && (length_mm - bar_mm).abs() > LENGTH_OFF_MM => {
            Err(ImportError::OtherBar { test: test.name.clone(), length_mm, bar_mm })
        }
        _ => Ok(()),
    }
}

/// Standard deviations by which two runs of a file without times may differ: beyond, rows may be lost.
const RUNS_DIFFER_SIGMAS: f64 = 4.0;
/// Difference, s, from which on they are: three times what the rests of most controls leave open.
const ROWS_LOST_S: f64 = 0.06;

/// Says of a file without times that rows of one run may be lost, or refuses it: each lost row shifts all behind it.
fn doubt_rows(file: &Path, placement: &Placement) -> Result<(), ImportError> {
    let Some([longer_s, sigma_s]) = placement.longer_s else { return Ok(()) };
    let longer_s = longer_s.abs();
    if longer_s < RUNS_DIFFER_SIGMAS * sigma_s {
        return Ok(());
    }
    if longer_s > ROWS_LOST_S {
        return Err(ImportError::RowsLost { longer_s, sigma_s });
    }
    remark(format_args!(
        "{}: the two runs took times that differ by {longer_s:.3} s, and the file has no times: rows of one may be lost, which moves positions by as much; or the control's rests are uneven",
        file.display()
    ));
    Ok(())
}

/// Most names that a refusal lists, and the longest of them, characters.
const MOST_NAMES: usize = 8;
const LONGEST_NAME: usize = 40;

/// Names in one line, no more than [`MOST_NAMES`] of them.
fn shown(names: &[String]) -> String {
    let mut list: Vec<String> =
        names.iter().take(MOST_NAMES).map(|name| shortened(name, LONGEST_NAME).into_owned()).collect();
    if names.len() > MOST_NAMES {
        list.push(format!("{} more", names.len() - MOST_NAMES));
    }
    list.join(", ")
}

/// Distance of a pace from the programmed feed from which on it is told: what gauges' clocks and controls are off by, twice over.
const PACE_OFF: f64 = 0.02;
/// Paces of the two directions that differ by more are both told.
const PACES_APART: f64 = 2e-3;

/// The one pair whose test the name of a file holds, without the sense of its first direction; `None` where it holds several.
fn named(session: &Session, file: &Path) -> Option<Pair> {
    let stem = file.file_stem()?.to_string_lossy().to_lowercase();
    let base = |pair: &Pair| {
        let name = session.tests[pair.tests[0]].name.to_lowercase();
        ["-ccw", "-cw"].iter().find_map(|sense| name.strip_suffix(sense)).unwrap_or(&name).to_string()
    };
    // a-100-1 stands in c-a-100-1 and in a-100-12, which is another test
    let holds = |name: &str| {
        stem.match_indices(name).any(|(at, _)| {
            let is_apart = |other: Option<char>| !other.is_some_and(|other| other.is_alphanumeric() || other == '-');
            let behind = &stem[at + name.len()..];
            let behind = ["-ccw", "-cw"].iter().find_map(|sense| behind.strip_prefix(sense)).unwrap_or(behind);
            is_apart(stem[..at].chars().next_back()) && is_apart(behind.chars().next())
        })
    };
    let mut all = pairs(session).into_iter().filter(|pair| holds(&base(pair)));
    all.next().filter(|_| all.next().is_none())
}

/// Says what is odd about a placement that is believed.
fn warn(session: &Session, file: &Path, placement: &Placement) {
    let name = |pair: &Pair| session.tests[pair.tests[0]].name.as_str();
    let pace = placement.timing.pace();
    if (pace - 1.0).abs() > PACE_OFF {
        let [there, back] = placement.timing.paces;
        let paces = match (there - back).abs() > PACES_APART {
            true => format!("{there:.3} of its programmed feed there and {back:.3} back"),
            false => format!("{pace:.3} of its programmed feed"),
        };
        remark(format_args!(
            "{}: the run of {} took {paces}: an override, or the gauge's clock is off",
            file.display(),
            name(&placement.pair)
        ));
    }
    if placement.waited_s > 0.0 {
        remark(format_args!(
            "{}: between its directions lie {:.2} s more than the program of {} waits: a feed hold, or another plan's capture",
            file.display(),
            placement.waited_s,
            name(&placement.pair)
        ));
    }
    let [before_s, after_s] = placement.cut_s;
    if before_s > 0.0 || after_s > 0.0 {
        remark(format_args!(
            "{}: {before_s:.1} s at its begin and {after_s:.1} s at its end are cut off: outside of the four marks the bar did not rest (off, mounted, or moved by hand)",
            file.display()
        ));
    }
    if let Some([together_mm, each_mm]) = placement.runs_apart_mm {
        remark(format_args!(
            "{}: {:.1} µm are left of the two runs of {} together, and {:.1} µm where each is taken by itself: one of them is of another test, the bar slipped between them, or the axes err otherwise there than back",
            file.display(),
            1e3 * together_mm,
            name(&placement.pair),
            1e3 * each_mm
        ));
    }
    if let Some(other) = placement.alike {
        remark(format_args!(
            "{}: the readings fit {} as well; only the wait between the directions speaks for {}: a feed hold there would make one of the other",
            file.display(),
            name(&other),
            name(&placement.pair)
        ));
    }
    if let Some(other) = named(session, file).filter(|other| *other != placement.pair) {
        remark(format_args!(
            "{}: the file is named like {}, and its readings are those of {}; is it named rightly?",
            file.display(),
            name(&other),
            name(&placement.pair)
        ));
    }
}

/// When the session began, as the user says.
fn began(arguments: &Arguments) -> Result<Option<Moment>, Refusal> {
    let Some(text) = &arguments.began else { return Ok(None) };
    match Moment::from_text(text) {
        Some(moment) => Ok(Some(moment)),
        None => {
            Err(format!("--began '{text}' is no time (allowed: 2026-11-26 10:15:32, 26.11.2026 10:15, 10:15)").into())
        }
    }
}

/// When captures were recorded within their session. What some of them state and cannot be is told; with `--began` it is refused.
fn session_times(files: &[PathBuf], read: &[CaptureFile], began: Option<Moment>) -> Result<SessionTimes, Refusal> {
    // beside captures that state their day, one without states too little
    let states_day = read.iter().filter_map(|capture| capture.began_at).any(|moment| moment.has_day());
    let scale = if states_day { Scale::Days } else { Scale::OfDay };
    let moment_of = |read: &CaptureFile| read.began_at.filter(|moment| moment.has_day() || !states_day);
    let seconds_on = |scale: Scale, moment: Moment| match scale {
        Scale::Days => moment.seconds_since_1970(),
        Scale::OfDay => moment.seconds_of_day(),
    };
    let stated: Vec<Stated> = (read.iter())
        .map(|read| Stated {
            began_s: moment_of(read).map(|moment| seconds_on(scale, moment)),
            lasts_s: read.time_s.last().copied().unwrap_or(0.0),
        })
        .collect();
    let as_began = |began: Moment| {
        let scale = if began.has_day() { scale } else { Scale::OfDay };
        Began { seconds: seconds_on(scale, began), scale }
    };
    let times = SessionTimes::of(&stated, began.map(as_began), scale);
    let SessionTimes::Planned(why) = &times else { return Ok(times) };
    let file = |k: usize| files[k].display();
    let says = match *why {
        WhyPlanned::NoneStated => "no capture states the date and time when it was recorded".to_string(),
        WhyPlanned::OneWithout(k) => format!("{} does not state when it was recorded", file(k)),
        WhyPlanned::Overlap(one, other) => {
            format!("{} and {} were recorded at the same time, by what they state", file(one), file(other))
        }
        WhyPlanned::FarApart(one, other) => {
            format!("more than a day lies between {} and {}, by what they state", file(one), file(other))
        }
        WhyPlanned::BeforeBegin(k) => format!("{} was recorded before, by what it states", file(k)),
    };
    if began.is_some() {
        return Err(format!("--began cannot be followed: {says}; correct it or leave it out").into());
    }
    if *why != WhyPlanned::NoneStated {
        remark(format_args!("{says}: the session keeps the times of the plan; correct started_at if they were others"));
    }
    Ok(times)
}

/// All files of the folder, and what was done.
fn written(
    session: &Session,
    all: &[Placed],
    times: &SessionTimes,
    folder: &Path,
) -> Result<(OutputFolder, ImportJson), Refusal> {
    let mut output = OutputFolder::default();
    let pieces: Vec<(Placement, [(Recording, f64); 2])> =
        all.iter().map(|placed| (placed.placement.clone(), placed.recordings.clone())).collect();
    let mut split = split_session(session, &pieces, times);
    split.machine_file = "machine.yaml".into();
    let chain = Chain::of(&split.machine);
    for test in &split.tests {
        let (Some(name), Some(recording)) = (&test.recording_file, &test.recording) else { continue };
        let motion = Motion::of(&split, &chain, test)?;
        output.add(name, path_csv(&split.machine, test, &motion, &recording.length_mm, recording.column));
    }
    let mut captures = Vec::new();
    for placed in all {
        let rows = [0, 1].map(|k| placed.recordings[k].0.readings());
        let name = placed.file.display().to_string();
        let mut json = placed_json(session, name, &placed.placement, rows);
        json.spikes = placed.capture.spikes().iter().filter(|spike| **spike).count();
        json.not_read = placed.read.not_read.clone();
        output.add(format!("{}.svg", json.tests[0]), capture_svg(&json, &placed.placement));
        captures.push(json);
    }
    output.add("machine.yaml", machine_yaml(&split.machine));
    output.add("session.yaml", session_yaml(&split));
    let is_there = |name: &str| split.tests.iter().any(|test| test.name == name);
    let missing = session.tests.iter().map(|test| test.name.clone()).filter(|name| !is_there(name)).collect();
    let json = ImportJson {
        session: session.name.clone(),
        written: folder.display().to_string(),
        times: TimesOf::of(times),
        captures,
        missing,
    };
    Ok((output, json))
}
