//! `fiveaxis survey`: all serial five-axis topologies planned on one envelope, in shards, restartable; and `survey merge`.

mod merge;
mod rows;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use fiveaxis::bodies::Kit;
use fiveaxis::load::{load_kit, load_shard, standard_kit};
use fiveaxis::machine::StructuralCode;
use fiveaxis::plan::Settings;
use fiveaxis::report::survey::{HEADER, csv, survey_json};
use fiveaxis::report::survey_page::{PAGE_HEAD, survey_page};
use fiveaxis::report::table::Table;
use fiveaxis::survey::{Outcome, Shard, codes, conditions, outcome, representative, settings, tallies};
use indicatif::ProgressBar;
use rayon::prelude::*;

use super::Refusal;
use super::output::{OutputFolder, print, print_json};
use merge::merged;
use rows::Rows;

/// Arguments of `survey`.
#[derive(Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Examples:\n  fiveaxis survey --out survey                      all topologies; run it again to go on after a stop\n  fiveaxis survey --out survey --shard 3/64         one job of 64\n  fiveaxis survey merge survey --out survey         one table of all shards"
)]
pub struct Arguments {
    #[command(subcommand)]
    merge: Option<Part>,
    /// Folder for the rows and, when all are there, survey.csv and survey.html
    #[arg(long, required = true)]
    out: Option<PathBuf>,
    /// One share of the topologies, NUMBER/COUNT
    #[arg(long, default_value = "1/1")]
    shard: String,
    /// Only this topology, e.g. [wCAbYXZt] (repeatable); all of them unless given
    #[arg(long)]
    code: Vec<String>,
    /// Kit file; the common 100 mm bar with extensions unless given
    #[arg(long)]
    kit: Option<PathBuf>,
    /// JSON on standard output
    #[arg(long)]
    json: bool,
}

#[derive(Subcommand)]
enum Part {
    /// One table of all shards: fiveaxis survey merge DIR... --out DIR
    Merge(MergeArguments),
}

/// Arguments of `survey merge`.
#[derive(Args)]
struct MergeArguments {
    /// Folders with the shards of one survey
    #[arg(required = true)]
    folders: Vec<PathBuf>,
    /// Folder for survey.csv and survey.html
    #[arg(long)]
    out: PathBuf,
    /// JSON on standard output
    #[arg(long)]
    json: bool,
}

/// Runs the verb.
pub fn run(arguments: &Arguments) -> Result<(), Refusal> {
    if let Some(Part::Merge(merge)) = &arguments.merge {
        let (outcomes, files) = merged(&merge.folders)?;
        write_tables(&merge.out, &outcomes, &files)?;
        return tell(&outcomes, &merge.out, merge.json);
    }
    let shard = Shard::parse(&arguments.shard)?;
    let kit = arguments.kit.as_deref().map_or_else(standard_kit, load_kit)?;
    let all = chosen_codes(&arguments.code)?;
    // clap asks for it
    let folder = arguments.out.as_deref().unwrap_or_else(|| Path::new("."));
    let settings = settings();
    let conditions = conditions(&kit, &settings, &all);
    let mine: Vec<&StructuralCode> =
        all.iter().enumerate().filter(|(place, _)| shard.holds(*place)).map(|(_, code)| code).collect();
    let rows = Rows::open(folder, &conditions, shard, &mine)?;
    let rest: Vec<&StructuralCode> =
        mine.iter().filter(|code| !rows.done.contains(&code.to_string())).copied().collect();
    plan_all(&rest, &kit, &settings, &rows)?;
    let file = rows.name;
    let outcomes = in_order(&mine, load_shard(&file, HEADER)?.outcomes);
    if shard == Shard::WHOLE {
        write_tables(folder, &outcomes, std::slice::from_ref(&file))?;
    }
    match shard == Shard::WHOLE || arguments.json {
        true => tell(&outcomes, folder, arguments.json),
        false => print(&format!(
            "shard {shard}: {} topologies in {}\nwhen all shards are there: fiveaxis survey merge {} --out {}\n",
            outcomes.len(),
            file.display(),
            folder.display(),
            folder.display()
        )),
    }
}

/// The codes named by the user, or all; a code may stand once.
fn chosen_codes(texts: &[String]) -> Result<Vec<StructuralCode>, Refusal> {
    let known = codes();
    if texts.is_empty() {
        return Ok(known);
    }
    let mut chosen: Vec<StructuralCode> = Vec::new();
    for text in texts {
        let code = StructuralCode::parse(text)?;
        if !known.contains(&code) {
            return Err(format!(
                "--code {code} is none of the {} topologies of X, Y, Z and two of A, B, C",
                known.len()
            )
            .into());
        }
        if chosen.contains(&code) {
            return Err(format!("--code {code} stands twice; name each topology once").into());
        }
        chosen.push(code);
    }
    chosen.sort_by_key(|code| known.iter().position(|other| other == code));
    Ok(chosen)
}

/// Plans what is left, two cores or more at a time, a row on disk as soon as it is known; topologies that are one machine on
/// the envelope are planned once.
fn plan_all(rest: &[&StructuralCode], kit: &Kit, settings: &Settings, rows: &Rows) -> Result<(), Refusal> {
    // indicatif draws on standard error, and only when that is a terminal
    let bar = ProgressBar::new((rest.len() + rows.done.len()) as u64);
    bar.set_position(rows.done.len() as u64);
    let mut alike: BTreeMap<String, Vec<&StructuralCode>> = BTreeMap::new();
    rest.iter().for_each(|code| alike.entry(representative(code).to_string()).or_default().push(code));
    let alike: Vec<Vec<&StructuralCode>> = alike.into_values().collect();
    let finished = alike.par_iter().with_max_len(1).try_for_each(|codes| {
        let Some(first) = codes.first() else { return Ok(()) };
        let planned = outcome(first, kit, settings).map_err(|why| format!("{first}: {why}"))?;
        for &code in codes {
            rows.add(&Outcome { code: code.clone(), ..planned.clone() })?;
            bar.inc(1);
        }
        Ok::<(), String>(())
    });
    bar.finish_and_clear();
    finished.map_err(Refusal::from)
}

/// Outcomes in the order of the codes.
fn in_order(codes: &[&StructuralCode], mut outcomes: Vec<Outcome>) -> Vec<Outcome> {
    outcomes.sort_by_key(|outcome| codes.iter().position(|code| **code == outcome.code));
    outcomes
}

fn write_tables(folder: &Path, outcomes: &[Outcome], inputs: &[PathBuf]) -> Result<(), Refusal> {
    let mut output = OutputFolder::default();
    output.add("survey.csv", csv(outcomes));
    output.add("survey.html", survey_page(outcomes));
    output.known_by("survey.csv", HEADER);
    output.known_by("survey.html", PAGE_HEAD);
    output.write(folder, inputs)
}

fn tell(outcomes: &[Outcome], folder: &Path, json: bool) -> Result<(), Refusal> {
    if json {
        return print_json(&survey_json(outcomes));
    }
    let mut table = Table::new(&[
        "family",
        "topologies",
        "all 8 determined",
        "all visible determined",
        "from one pivot",
        "no test",
    ]);
    for tally in tallies(outcomes) {
        let cell = |count: usize| count.to_string();
        table.row(vec![
            tally.family.name().to_string(),
            cell(tally.topologies),
            cell(tally.all_determined),
            cell(tally.all_visible_determined),
            cell(tally.from_one_pivot),
            cell(tally.without_test),
        ]);
    }
    print(&format!("{}\nwritten: {}\n", table.text(), folder.join("survey.html").display()))
}
