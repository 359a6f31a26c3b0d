//! `fiveaxis history`: the sessions of one machine over months, and which of its errors moved.

use std::path::{Path, PathBuf};

use clap::Args;
use fiveaxis::diagnose::examine;
use fiveaxis::history::{Point, trend};
use fiveaxis::identify::{Options, Quantity};
use fiveaxis::load::{load_session, names_tests};
use fiveaxis::machine::{Component, Machine};
use fiveaxis::report::history::{ErrorHistory, HistoryReport, history_json, history_page, history_text};
use jiff::civil::{Date, date};

use super::Refusal;
use super::output::{Foreign, OutputFolder, print, print_json, session_inputs, settle, write_all};
use crate::verbs::options::recorded::recorded;
use crate::verbs::output::progress::Working;

/// Most sessions of a folder.
const MOST_SESSIONS: usize = 1000;

/// Arguments of `history`.
#[derive(Args)]
#[command(
    after_help = "Each session lies in a folder of its own, or is a file of its own, whose name holds its date: 2026-03-14, 2026-03-14-after-crash, 2026-03-14T09-30.\nExample: fiveaxis history sessions --out history"
)]
pub struct Arguments {
    /// Folder with the sessions
    folder: PathBuf,
    /// Write history.html (one page, opens offline) into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace files in the way that fiveaxis did not write
    #[arg(long)]
    force: bool,
    /// Print JSON instead of tables
    #[arg(long)]
    json: bool,
}

/// One session as fitted: errors by name with unit, value, sigma of the noise and whole sigma.
struct Fitted {
    machine: Machine,
    errors: Vec<(String, &'static str, f64, f64, f64)>,
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    let files = session_files(&arguments.folder)?;
    let mut inputs = Vec::new();
    let mut fits: Vec<(String, PathBuf, f64, Fitted)> = Vec::new();
    let mut left_out: Vec<String> = Vec::new();
    for (date, day, file) in files {
        let working = Working::on(format!("fitting {}", file.display()));
        let fitted = fitted(&file, &mut inputs)?;
        drop(working);
        match fitted {
            Some(fitted) => fits.push((date, file, day, fitted)),
            None => left_out
                .push(format!("{} is left out: its recordings are not to be believed, see 'diagnose'", file.display())),
        }
    }
    if let Some((_, file, _, first)) = fits.first() {
        refuse_two_machines((file, &first.machine), fits.iter().map(|(_, file, _, fitted)| (file, &fitted.machine)))?;
    }
    let (fits, open): (Vec<_>, Vec<_>) = fits.into_iter().partition(|(.., fitted)| !fitted.errors.is_empty());
    let of_none = |(_, file, ..): &(String, PathBuf, f64, Fitted)| {
        format!("{} is left out: nothing is determined by it, see 'identify' and 'diagnose'", file.display())
    };
    left_out.extend(open.iter().map(of_none));
    left_out.iter().for_each(|says| eprintln!("fiveaxis: {says}"));
    let Some((_, _, first_day, first)) = fits.first() else {
        return Err(format!("{}: no session determines anything", arguments.folder.display()).into());
    };
    let mut names: Vec<(String, &'static str)> = Vec::new();
    for (name, unit, ..) in fits.iter().flat_map(|(_, _, _, fitted)| &fitted.errors) {
        if names.iter().all(|(other, _)| other != name) {
            names.push((name.clone(), unit));
        }
    }
    let errors = names.iter().map(|(name, unit)| {
        let mut history = (Vec::new(), Vec::new());
        for (_, _, day, fitted) in &fits {
            for (_, _, value, sigma, whole) in fitted.errors.iter().filter(|(other, ..)| other == name) {
                history.0.push(Point { day: day - first_day, value: *value, sigma: *sigma });
                history.1.push(*whole);
            }
        }
        ErrorHistory { name: name.clone(), unit, trend: trend(&history.0), points: history.0, whole_sigma: history.1 }
    });
    let report = HistoryReport {
        machine: first.machine.name.clone(),
        errors: errors.collect(),
        sessions: fits.iter().map(|(date, file, ..)| (date.clone(), file.display().to_string())).collect(),
        days: fits.iter().map(|(_, _, day, _)| day - first_day).collect(),
        left_out,
    };
    if let Some(folder) = &arguments.out {
        let mut output = OutputFolder::default();
        output.add("history.html", history_page(&report));
        write_all(vec![(folder.clone(), output)], &inputs, Foreign::with(arguments.force))?;
    }
    match arguments.json {
        true => print_json(&history_json(&report)),
        false => print(&history_text(&report)),
    }
}

/// A session fitted; `None` when its recordings are not to be believed.
fn fitted(file: &Path, inputs: &mut Vec<PathBuf>) -> Result<Option<Fitted>, Refusal> {
    settle(file)?;
    let session = recorded(load_session(file)?);
    inputs.extend(session_inputs(file, &session));
    let examination = examine(&session, &Options::default()).map_err(|why| format!("{}: {why}", file.display()))?;
    let Some(fit) = examination.fit.as_ref().filter(|_| examination.is_sound()) else { return Ok(None) };
    let told = fit.unknowns.iter().zip(&fit.estimates).filter_map(|(unknown, estimate)| match unknown.quantity {
        Quantity::Location { component, .. } if estimate.determined => {
            let measure = Component::ALL[component.index()].measure();
            let unit = if component.is_angle() { "arcsec" } else { "µm" };
            let [value, noise, whole] =
                [estimate.value, estimate.sigma_noise, estimate.sigma].map(|value| measure.to_output(value));
            Some((unknown.label.clone(), unit, value, noise, whole))
        }
        _ => None,
    });
    let errors = told.collect();
    Ok(Some(Fitted { machine: session.machine, errors }))
}

/// Sessions of one machine have its name, its code and its axes.
fn refuse_two_machines<'f>(
    (file, first): (&Path, &Machine),
    others: impl Iterator<Item = (&'f PathBuf, &'f Machine)>,
) -> Result<(), Refusal> {
    for (other, machine) in others {
        let Some([of_first, of_other]) = first.told_from(machine) else { continue };
        return Err(format!(
            "{} is of the machine '{of_first}' and {} of '{of_other}': a history is of one machine; put each one's sessions into a folder of their own, or give its machine files one name and the same axes",
            file.display(),
            other.display(),
        )
        .into());
    }
    Ok(())
}

/// Session files with date and day number, by time.
fn session_files(folder: &Path) -> Result<Vec<(String, f64, PathBuf)>, Refusal> {
    let entries = std::fs::read_dir(folder).map_err(|why| {
        format!("{} cannot be read: {why}; name the folder that holds the sessions", folder.display())
    })?;
    let mut list = Vec::new();
    let mut undated = Vec::new();
    for entry in entries {
        let path = entry.map_err(|why| format!("{} cannot be read: {why}", folder.display()))?.path();
        let file = if path.is_dir() { path.join("session.yaml") } else { path.clone() };
        if path.is_dir() && !file.is_file() {
            eprintln!("fiveaxis: {} is left out: it holds no session.yaml", path.display());
            continue;
        }
        let is_yaml = file.extension().is_some_and(|extension| extension == "yaml" || extension == "yml");
        if !is_yaml || !file.is_file() || !names_tests(&file)? {
            continue;
        }
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        match date_in(&name).map_err(|date| not_in_calendar(&file, &date))? {
            Some((date, day)) => list.push((date, day, file)),
            None => undated.push(name),
        }
    }
    if let Some(name) = undated.first() {
        return Err(format!(
            "{}: the session {name} has no date in its name; call its folder or file for example 2026-03-14",
            folder.display()
        )
        .into());
    }
    if list.is_empty() || list.len() > MOST_SESSIONS {
        return Err(format!(
            "{} holds {} sessions; from 1 to {MOST_SESSIONS} are allowed, each in a folder called by its date, such as 2026-03-14/session.yaml",
            folder.display(),
            list.len()
        )
        .into());
    }
    list.sort_by(|a, b| a.1.total_cmp(&b.1).then_with(|| a.2.cmp(&b.2)));
    for days in list.windows(2).filter(|days| days[0].1 == days[1].1) {
        eprintln!(
            "fiveaxis: {} and {} are of one time, and no step is looked for between them; add the time of day to their names, for example 2026-03-14T09-30",
            days[0].2.display(),
            days[1].2.display()
        );
    }
    Ok(list)
}

fn not_in_calendar(file: &Path, date: &str) -> String {
    format!(
        "{}: {date} is no day of the calendar; years from {} to {}, months from 01 to 12 and the days that the month has are allowed, for example 2026-03-14",
        file.display(),
        YEARS.0,
        YEARS.1
    )
}

/// Years in which sessions may be: ball bars are younger.
const YEARS: (i16, i16) = (1980, 2999);

/// A date such as 2026-03-14 in a name, with the time where one follows it such as T09-30, and its number in days; an error is what
/// looks like a date and is none.
fn date_in(name: &str) -> Result<Option<(String, f64)>, String> {
    let mut wrong = None;
    for from in 0..name.len().saturating_sub(9) {
        let Some(part) = name.get(from..from + 10).filter(|part| has_shape(part, "0000-00-00")) else { continue };
        if let Some(day) = part.parse::<Date>().ok().filter(|day| (YEARS.0..=YEARS.1).contains(&day.year())) {
            return Ok(Some(match time_in(&name[from + 10..]) {
                Some([hour, minute]) => {
                    let part_of_day = (hour + minute / 60.0) / 24.0;
                    (format!("{part} {hour:02}:{minute:02}"), day_number(day) as f64 + part_of_day)
                }
                None => (part.to_string(), day_number(day) as f64),
            }));
        }
        wrong.get_or_insert_with(|| part.to_string());
    }
    wrong.map_or(Ok(None), Err)
}

/// Hour and minute such as T09-30, T09:30 or T0930 with which a text begins.
fn time_in(text: &str) -> Option<[f64; 2]> {
    let ends = |length: usize| !text.as_bytes().get(length).is_some_and(u8::is_ascii_digit);
    let shape = ["T00-00", "T00:00", "T0000"]
        .into_iter()
        .find(|shape| text.get(..shape.len()).is_some_and(|part| has_shape(part, shape)) && ends(shape.len()))?;
    let number = |from: usize| text[from..from + 2].parse::<f64>().ok();
    let [hour, minute] = [number(1)?, number(shape.len() - 2)?];
    (hour < 24.0 && minute < 60.0).then_some([hour, minute])
}

/// Whether a text has the characters of a shape, in which 0 stands for any digit.
fn has_shape(text: &str, shape: &str) -> bool {
    let is = |(byte, due): (u8, u8)| if due == b'0' { byte.is_ascii_digit() } else { byte == due };
    text.len() == shape.len() && text.bytes().zip(shape.bytes()).all(is)
}

/// Days in the Gregorian calendar since 29 February of the year 0.
fn day_number(day: Date) -> i64 {
    day.duration_since(date(0, 2, 29)).as_hours() / 24
}
