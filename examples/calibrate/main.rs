//! Calibration: are stated probabilities, sizes and sigmas right as often as they say, and how often is a clean session accused?
//!
//! Sessions, concealed causes and noise are those of the blind trial, which shares no code with the library.
//! `cargo run --release --example calibrate -- --seeds 1,2 --sessions 60 --clean 60 --out docs/calibration.md`

#[path = "../blind_trial/case.rs"]
mod case;
#[path = "../blind_trial/designs.rs"]
mod designs;
#[path = "../blind_trial/draw.rs"]
mod draw;
#[path = "../blind_trial/effects/mod.rs"]
mod effects;
#[path = "../blind_trial/faults.rs"]
mod faults;
#[path = "../blind_trial/kinematics.rs"]
mod kinematics;
#[allow(dead_code)]
#[path = "../blind_trial/machines.rs"]
mod machines;
#[path = "../blind_trial/mounting.rs"]
mod mounting;
#[path = "../blind_trial/noise.rs"]
mod noise;
#[path = "../blind_trial/nuisance.rs"]
mod nuisance;
mod outcome;
mod page;
#[allow(dead_code)]
#[path = "../blind_trial/plan.rs"]
mod plan;
#[path = "../blind_trial/recordings.rs"]
mod recordings;
mod rules;
#[allow(dead_code)]
#[path = "../blind_trial/run.rs"]
mod run;
#[allow(dead_code)]
#[path = "../blind_trial/score.rs"]
mod score;
#[path = "../blind_trial/visibility.rs"]
mod visibility;

use case::{Wishes, make};
use clap::Parser;
use fiveaxis::diagnose::Thresholds;
use outcome::Outcome;
use score::Answer;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Diagnoses simulated sessions and compares what was stated with the truth, as a page.
#[derive(Parser)]
struct Options {
    /// Seeds of the sessions, separated by commas; those that no rule was chosen on make a proof.
    #[arg(long, value_delimiter = ',', required = true)]
    seeds: Vec<u64>,
    /// Sessions of each seed, as the blind trial draws them: clean ones, one cause, two, causes outside the catalogue.
    #[arg(long, default_value_t = 60)]
    sessions: u64,
    /// Further clean sessions of each seed.
    #[arg(long, default_value_t = 0)]
    clean: u64,
    /// Write the page here; without it to the terminal.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Every outcome as JSON lines, for a look of one's own.
    #[arg(long)]
    rows: Option<PathBuf>,
    /// Show what each number that decides earns: every session again with one rule after the other out of force.
    #[arg(long)]
    rules: bool,
    /// Only these of them, by name.
    #[arg(long, value_delimiter = ',')]
    rule: Vec<String>,
    /// Other values of numbers that decide, `name=value`; sessions are then diagnosed in this process.
    #[arg(long, value_delimiter = ',')]
    set: Vec<String>,
    /// Check this binary instead of building the crate's own.
    #[arg(long)]
    binary: Option<PathBuf>,
    /// Give up on a session after this many seconds.
    #[arg(long, default_value_t = 240)]
    patience: u64,
    /// Sessions at a time.
    #[arg(long, default_value_t = 2)]
    threads: usize,
}

fn main() -> ExitCode {
    let options = Options::parse();
    match calibrate(&options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::from(2)
        }
    }
}

/// One session to draw: its seed, its number and whether nothing is concealed in it.
type Wanted = (u64, u64, bool);

/// Clean sessions are drawn from numbers that the others never reach.
const CLEAN_FROM: u64 = 1_000_000;

fn calibrate(options: &Options) -> Result<(), String> {
    let rules = if options.rules { rules::named(&options.rule)? } else { vec![] };
    let thresholds = as_set(&options.set)?;
    let in_process = options.rules || !options.set.is_empty();
    let binary = if in_process { PathBuf::new() } else { run::own_binary(options.binary.as_deref())? };
    let scratch = std::env::temp_dir().join(format!("calibrate-{}", std::process::id()));
    let list: Vec<Wanted> = options
        .seeds
        .iter()
        .flat_map(|&seed| {
            let drawn = (0..options.sessions).map(move |index| (seed, index, false));
            drawn.chain((0..options.clean).map(move |index| (seed, CLEAN_FROM + index, true)))
        })
        .collect();
    let diagnosed = |thresholds: Option<Thresholds>| {
        let outcomes = run::each(options.threads, &list, |&wanted| {
            let outcome = outcome(&scratch, wanted, |place| match thresholds {
                Some(thresholds) => rules::diagnosed(place, thresholds),
                None => run::diagnose(&binary, place, options.patience),
            })?;
            eprintln!("{}", outcome.line());
            Ok(outcome)
        });
        outcomes.map(|mut outcomes| {
            outcomes.sort_by_key(|outcome| (outcome.seed, outcome.trial));
            outcomes
        })
    };
    // sessions are the parallel work
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build_global();
    alone.map_err(|e| e.to_string())?;
    let outcomes = diagnosed(in_process.then_some(thresholds))?;
    let mut earned = vec![];
    for rule in &rules {
        eprintln!("without {}", rule.name);
        let Some(without) = thresholds.with(rule.name, rule.off) else { continue };
        earned.push((*rule, rules::Tally::of(&diagnosed(Some(without))?)));
    }
    let _ = std::fs::remove_dir_all(&scratch);
    if let Some(path) = &options.rows {
        let lines: String = outcomes.iter().map(|o| format!("{}\n", o.json())).collect();
        std::fs::write(path, lines).map_err(|e| format!("cannot write {}: {e}", path.display()))?;
    }
    let seeds: Vec<String> = options.seeds.iter().map(u64::to_string).collect();
    let mut command = format!("--seeds {} --sessions {} --clean {}", seeds.join(","), options.sessions, options.clean);
    if options.rules {
        command += " --rules";
    }
    if !options.set.is_empty() {
        command += &format!(" --set {}", options.set.join(","));
    }
    let text = page::page(&outcomes, &earned, &command);
    match &options.out {
        Some(path) => std::fs::write(path, text).map_err(|e| format!("cannot write {}: {e}", path.display())),
        None => {
            print!("{text}");
            Ok(())
        }
    }
}

/// Draws a session, has it diagnosed and compares the answer with the truth.
fn outcome(
    scratch: &Path,
    (seed, index, clean): Wanted,
    diagnose: impl Fn(&Path) -> Answer,
) -> Result<Outcome, String> {
    let case = make(seed, index, &Wishes { clean, ..Wishes::default() });
    let place = scratch.join(format!("{seed}-{index}"));
    recordings::write(&place, &case.name, &case.plan, &case.order, &case.recordings)
        .map_err(|e| format!("cannot write {}: {e}", place.display()))?;
    let answer = diagnose(&place);
    let _ = std::fs::remove_dir_all(&place);
    Ok(Outcome::of(seed, &case.truth, &answer))
}

/// The thresholds with other values of some.
fn as_set(list: &[String]) -> Result<Thresholds, String> {
    list.iter().try_fold(Thresholds::default(), |thresholds, text| {
        let pair = text.split_once('=').and_then(|(name, value)| Some((name, value.parse().ok()?)));
        pair.and_then(|(name, value): (&str, f64)| thresholds.with(name, value))
            .ok_or_else(|| format!("--set {text}: expected name=value with the name of a number that decides"))
    })
}
