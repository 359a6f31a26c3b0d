//! Blind trial: conceals causes in sessions of its own making, lets the built binary diagnose them, then opens the truth.
//!
//! Shares no code with the library: kinematics, physics in the time domain, noise and visibility are its own.
//! `cargo run --release --example blind_trial -- --seed 1 --trials 100`

mod case;
mod designs;
mod draw;
mod effects;
mod faults;
mod kinematics;
mod machines;
mod mounting;
mod noise;
mod nuisance;
mod plan;
mod recordings;
mod run;
mod score;
mod tally;
mod visibility;

use case::{Case, Wishes, make};
use clap::Parser;
use run::{diagnose, each, own_binary};
use score::Score;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Conceals causes in simulated sessions, runs `fiveaxis diagnose` on each and scores the answers.
#[derive(Parser)]
struct Options {
    /// Any number; the same one makes the same sessions.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How many sessions.
    #[arg(long, default_value_t = 100)]
    trials: u64,
    /// First session, to make a single one again: `--first 17 --trials 1` is case-017.
    #[arg(long, default_value_t = 1)]
    first: u64,
    /// Keep the folders here, with the truth in `truth/` beside them.
    #[arg(long)]
    keep: Option<PathBuf>,
    /// Conceal only this effect (a name of the answer contract, or of a stranger: unknown-clamp, …).
    #[arg(long)]
    only: Option<String>,
    /// Only this design: full, bidirectional, synchronous, planar, thesis4, mixed.
    #[arg(long)]
    design: Option<String>,
    /// Only this machine's structural code.
    #[arg(long)]
    code: Option<String>,
    /// Conceal nothing.
    #[arg(long)]
    clean: bool,
    /// Score sessions that exist: DIR/case-NNN with DIR/truth/case-NNN.json.
    #[arg(long)]
    folder: Option<PathBuf>,
    /// Make the sessions and stop; needs --keep.
    #[arg(long)]
    generate_only: bool,
    /// Score this binary instead of building the crate's own.
    #[arg(long)]
    binary: Option<PathBuf>,
    /// Rows of every recording relative to the usual number.
    #[arg(long)]
    density: Option<f64>,
    /// Give up on a session after this many seconds.
    #[arg(long, default_value_t = 120)]
    patience: u64,
    /// Sessions at a time.
    #[arg(long, default_value_t = 2)]
    threads: usize,
}

fn main() -> ExitCode {
    let options = Options::parse();
    match trial(&options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::from(2)
        }
    }
}

fn trial(options: &Options) -> Result<(), String> {
    check(options)?;
    let scratch = std::env::temp_dir().join(format!("blind-trial-{}", std::process::id()));
    let folder = options.keep.clone().unwrap_or_else(|| scratch.clone());
    let binary = if options.generate_only { PathBuf::new() } else { own_binary(options.binary.as_deref())? };
    let there = options.folder.as_deref().map(sessions_in).transpose()?;
    let indices: Vec<u64> = match &there {
        Some(there) => (0..there.len() as u64).collect(),
        None => (options.first - 1..options.first - 1 + options.trials).collect(),
    };
    let scores = each(options.threads, &indices, |&index| match &there {
        Some(there) => existing(options, &there[index as usize], &binary).map(Some),
        None => session(options, &folder, &binary, index),
    });
    if options.keep.is_none() {
        let _ = std::fs::remove_dir_all(&scratch);
    }
    let mut scores: Vec<Score> = scores?.into_iter().flatten().collect();
    scores.sort_by(|a, b| a.case.cmp(&b.case));
    if options.generate_only {
        println!("{} sessions in {}", options.trials, folder.display());
    } else {
        let whose = match &options.folder {
            Some(folder) => folder.display().to_string(),
            None => format!("--seed {}", options.seed),
        };
        println!("Blind trial, {whose}, {} sessions", scores.len());
        tally::print(&scores);
        tally::failures(&scores, &whose, options.keep.as_deref().or(options.folder.as_deref()));
    }
    Ok(())
}

fn check(options: &Options) -> Result<(), String> {
    if options.generate_only && options.keep.is_none() {
        return Err("--generate-only makes sessions to keep: say where with --keep DIR".into());
    }
    if options.first == 0 {
        return Err("--first counts from 1".into());
    }
    let designs: Vec<&str> = designs::DESIGNS.iter().map(|d| d.0).collect();
    let mut effects: Vec<&str> = effects::KINDS.iter().map(|k| k.0).collect();
    effects.extend(faults::FAULTS);
    let codes = machines::codes();
    for (given, allowed, option) in [
        (&options.design, &designs, "--design"),
        (&options.only, &effects, "--only"),
        (&options.code, &codes, "--code"),
    ] {
        if let Some(given) = given
            && !allowed.contains(&given.as_str())
        {
            return Err(format!("{option} {given}: not known; choose one of {}", allowed.join(", ")));
        }
    }
    Ok(())
}

/// Makes one session, has it diagnosed and scores the answer; the truth is written only afterwards.
fn session(options: &Options, folder: &Path, binary: &Path, index: u64) -> Result<Option<Score>, String> {
    let wishes = Wishes {
        effect: options.only.clone(),
        design: options.design.clone(),
        clean: options.clean,
        density: options.density,
        code: options.code.clone(),
    };
    let case = make(options.seed, index, &wishes);
    let place = folder.join(&case.name);
    recordings::write(&place, &case.name, &case.plan, &case.order, &case.recordings)
        .map_err(|e| format!("cannot write {}: {e}", place.display()))?;
    if options.generate_only {
        open_truth(folder, &case)?;
        eprintln!("{} {}", case.name, headline(&case));
        return Ok(None);
    }
    let answer = diagnose(binary, &place, options.patience);
    let score = score::score(&case.truth, &answer);
    eprintln!(
        "{} {} → {} {} ({:.1} s)",
        case.name,
        headline(&case),
        score.stated,
        if tally::failed(&score) { "✗" } else { "✓" },
        score.seconds
    );
    if options.keep.is_some() {
        open_truth(folder, &case)?;
        if let Some(json) = &answer.json {
            let path = folder.join("truth").join(format!("{}.answer.json", case.name));
            std::fs::write(&path, format!("{json:#}\n"))
                .map_err(|e| format!("cannot write {}: {e}", path.display()))?;
        }
    } else {
        let _ = std::fs::remove_dir_all(&place);
    }
    Ok(Some(score))
}

/// Sessions of a folder with the truth about each.
fn sessions_in(folder: &Path) -> Result<Vec<(PathBuf, PathBuf)>, String> {
    let list = std::fs::read_dir(folder).map_err(|e| format!("cannot read {}: {e}", folder.display()))?;
    let mut found: Vec<(PathBuf, PathBuf)> = list
        .filter_map(|entry| entry.ok().map(|e| e.path()))
        .filter(|path| path.join("session.yaml").is_file())
        .map(|path| {
            let name = path.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned());
            let beside = folder.join("truth").join(format!("{name}.json"));
            let within = path.join("truth.json");
            (path, if within.is_file() { within } else { beside })
        })
        .collect();
    found.sort();
    if found.is_empty() {
        return Err(format!("no sessions in {}: expected folders with a session.yaml", folder.display()));
    }
    Ok(found)
}

/// Diagnoses a session that exists, then reads its truth and scores.
fn existing(options: &Options, (place, truth): &(PathBuf, PathBuf), binary: &Path) -> Result<Score, String> {
    let answer = diagnose(binary, place, options.patience);
    let text = std::fs::read_to_string(truth).map_err(|e| format!("cannot read {}: {e}", truth.display()))?;
    let truth = serde_json::from_str(&text).map_err(|e| format!("{}: {e}", truth.display()))?;
    let mut score = score::score(&score::in_contract_words(truth), &answer);
    score.case = place.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned());
    let mark = if tally::failed(&score) { "✗" } else { "✓" };
    eprintln!("{} {} → {} {mark} ({:.1} s)", score.case, score.effect, score.stated, score.seconds);
    Ok(score)
}

fn headline(case: &Case) -> String {
    let effects = case.truth["effects"].as_array().map(Vec::as_slice).unwrap_or_default();
    let said: Vec<String> = effects
        .iter()
        .map(|e| {
            let visible = e["visible_over_noise"].as_f64().map_or(String::new(), |v| format!(" {v:.2}×"));
            format!("{}@{}{visible}", e["id"].as_str().unwrap_or(""), e["place"].as_str().unwrap_or(""))
        })
        .collect();
    let said = if said.is_empty() { "clean".into() } else { said.join(" + ") };
    format!("{} {}: {said}", case.plan.machine.code, case.plan.design)
}

/// Writes the truth outside the folder of the session.
fn open_truth(folder: &Path, case: &Case) -> Result<(), String> {
    let place = folder.join("truth");
    std::fs::create_dir_all(&place).map_err(|e| format!("cannot make {}: {e}", place.display()))?;
    let path = place.join(format!("{}.json", case.name));
    std::fs::write(&path, format!("{:#}\n", case.truth)).map_err(|e| format!("cannot write {}: {e}", path.display()))
}
