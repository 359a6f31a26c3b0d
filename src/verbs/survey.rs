//! `fiveaxis survey`: all serial five-axis topologies planned on one envelope, in shards, restartable; and `survey merge`.

use std::collections::HashSet;
use std::fs::{File, OpenOptions};
use std::io::{Seek, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use clap::{Args, Subcommand};
use fiveaxis::bodies::Kit;
use fiveaxis::load::{ShardFile, load_kit, load_shard, shard_title, standard_kit};
use fiveaxis::machine::StructuralCode;
use fiveaxis::plan::Settings;
use fiveaxis::report::survey::{HEADER, csv, row, survey_json, tallies};
use fiveaxis::report::survey_page::survey_page;
use fiveaxis::report::table::Table;
use fiveaxis::survey::{Outcome, Shard, codes, conditions, outcome};
use indicatif::ProgressBar;
use rayon::prelude::*;

use super::Refusal;
use super::output::{OutputFolder, print};

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
    let settings = Settings::default();
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

/// The rows of a shard on disk: what an earlier run left, and where this one goes on.
struct Rows {
    name: PathBuf,
    file: Mutex<File>,
    /// Codes whose rows are there.
    done: HashSet<String>,
}

impl Rows {
    fn open(folder: &Path, conditions: &str, shard: Shard, mine: &[&StructuralCode]) -> Result<Rows, Refusal> {
        std::fs::create_dir_all(folder).map_err(|why| format!("folder {} cannot be made: {why}", folder.display()))?;
        let name = folder.join(file_name(shard));
        let cannot = |why: std::io::Error| format!("{} cannot be written: {why}", name.display());
        let mut file =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&name).map_err(cannot)?;
        if file.try_lock().is_err() {
            return Err(format!(
                "{} is being written by another run; wait for it or choose another folder",
                name.display()
            )
            .into());
        }
        let start = format!("{}\n{HEADER}\n", shard_title(conditions, shard));
        let old = std::fs::read(&name).map_err(cannot)?;
        let mut done = HashSet::new();
        // a run stopped in its first lines leaves a piece of them
        if start.as_bytes().starts_with(&old) {
            file.set_len(0).map_err(cannot)?;
            file.write_all(start.as_bytes()).map_err(cannot)?;
        } else {
            let read = load_shard(&name, HEADER)?;
            check_same(&name, &read, conditions, shard)?;
            done = codes_of(&name, &read, mine)?;
            // a torn last row is done again
            file.set_len(read.whole_bytes).map_err(cannot)?;
        }
        file.seek(SeekFrom::End(0)).map_err(cannot)?;
        Ok(Rows { file: Mutex::new(file), name, done })
    }

    fn add(&self, outcome: &Outcome) -> Result<(), String> {
        let line = format!("{}\n", row(outcome));
        let mut file = self.file.lock().map_err(|_| "another row could not be written".to_string())?;
        file.write_all(line.as_bytes()).map_err(|why| format!("{} cannot be written: {why}", self.name.display()))
    }
}

/// Name of a shard's file.
fn file_name(shard: Shard) -> String {
    format!("shard-{}-of-{}.csv", shard.index, shard.count)
}

/// Refuses rows of another survey.
fn check_same(name: &Path, read: &ShardFile, conditions: &str, shard: Shard) -> Result<(), Refusal> {
    if read.conditions != conditions || read.shard != shard {
        return Err(format!(
            "{}: is of another survey ({}; shard {}), this one is {conditions}; shard {shard}; name another folder, or delete the file to begin anew",
            name.display(),
            read.conditions,
            read.shard
        )
        .into());
    }
    Ok(())
}

/// Codes of a shard's rows, each one of `mine` and once.
fn codes_of(name: &Path, read: &ShardFile, mine: &[&StructuralCode]) -> Result<HashSet<String>, Refusal> {
    let mut seen = HashSet::new();
    for (index, outcome) in read.outcomes.iter().enumerate() {
        let line = index + 3;
        if !mine.contains(&&outcome.code) {
            return Err(format!(
                "{}:{line}: {} is not in shard {}; delete the file and run the shard again",
                name.display(),
                outcome.code,
                read.shard
            )
            .into());
        }
        if !seen.insert(outcome.code.to_string()) {
            return Err(format!(
                "{}:{line}: {} stands twice; delete the file and run the shard again",
                name.display(),
                outcome.code
            )
            .into());
        }
    }
    Ok(seen)
}

/// Plans what is left, two cores or more at a time, a row on disk as soon as it is known.
fn plan_all(rest: &[&StructuralCode], kit: &Kit, settings: &Settings, rows: &Rows) -> Result<(), Refusal> {
    // indicatif draws on standard error, and only when that is a terminal
    let bar = ProgressBar::new((rest.len() + rows.done.len()) as u64);
    bar.set_position(rows.done.len() as u64);
    let finished = rest.par_iter().with_max_len(1).try_for_each(|code| {
        let planned = outcome(code, kit, settings).map_err(|why| format!("{code}: {why}"))?;
        rows.add(&planned)?;
        bar.inc(1);
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

/// Outcomes of all shards found in some folders, in order, and the files they stand in.
fn merged(folders: &[PathBuf]) -> Result<(Vec<Outcome>, Vec<PathBuf>), Refusal> {
    let mut files = Vec::new();
    for folder in folders {
        let entries = std::fs::read_dir(folder)
            .map_err(|why| format!("{}: cannot be read: {why}; name a folder with shards", folder.display()))?;
        let is_shard = |name: &str| name.starts_with("shard-") && name.ends_with(".csv");
        let found: Vec<PathBuf> = entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|file| file.file_name().and_then(|name| name.to_str()).is_some_and(is_shard))
            .collect();
        if found.is_empty() {
            return Err(format!(
                "{}: holds no shard; 'fiveaxis survey --shard 1/4 --out DIR' writes one",
                folder.display()
            )
            .into());
        }
        files.extend(found);
    }
    files.sort();
    files.dedup();
    let mut shards: Vec<(PathBuf, ShardFile)> = Vec::new();
    for file in &files {
        let read = load_shard(file, HEADER)?;
        if let Some((first, other)) = shards.first()
            && (other.conditions != read.conditions || other.shard.count != read.shard.count)
        {
            return Err(format!(
                "{} ({}; shard {}) and {} ({}; shard {}) are of different surveys; name folders of one survey",
                first.display(),
                other.conditions,
                other.shard,
                file.display(),
                read.conditions,
                read.shard
            )
            .into());
        }
        if let Some((first, _)) = shards.iter().find(|(_, other)| other.shard == read.shard) {
            return Err(format!(
                "shard {} is there twice: {} and {}; name one of them",
                read.shard,
                first.display(),
                file.display()
            )
            .into());
        }
        if read.torn {
            return Err(format!(
                "{}: its last row is cut off; run shard {} again, it goes on where it stopped",
                file.display(),
                read.shard
            )
            .into());
        }
        shards.push((file.clone(), read));
    }
    shards.sort_by_key(|(_, read)| read.shard);
    let Some((_, first)) = shards.first() else { return Err("no shard was named".into()) };
    let count = first.shard.count;
    let missing: Vec<String> = (1..=count)
        .filter(|index| !shards.iter().any(|(_, read)| read.shard.index == *index))
        .map(|index| index.to_string())
        .collect();
    if !missing.is_empty() {
        let many = missing.len();
        let shown = missing.into_iter().take(12).collect::<Vec<_>>().join(", ");
        return Err(format!("{many} of {count} shards are missing: {shown}; run them or name their folders").into());
    }
    let topologies = topologies_of(&first.conditions);
    let order = codes();
    let mut rows: Vec<(usize, Shard, Outcome)> = Vec::new();
    for (file, read) in shards {
        let whole = (0..topologies).filter(|&place| read.shard.holds(place)).count();
        if read.outcomes.len() != whole {
            return Err(format!(
                "{}: has {} of {whole} rows; run shard {} again, it goes on where it stopped",
                file.display(),
                read.outcomes.len(),
                read.shard
            )
            .into());
        }
        for outcome in read.outcomes {
            let place = order.iter().position(|code| *code == outcome.code);
            let place =
                place.ok_or_else(|| format!("{}: {} is no topology of the survey", file.display(), outcome.code))?;
            rows.push((place, read.shard, outcome));
        }
    }
    rows.sort_by_key(|(place, ..)| *place);
    // the list of all is dealt out to the shards in turn: a row of another shard shows unless it also stands twice
    let twice = |place: usize| place > 0 && rows[place - 1].0 == rows[place].0;
    if let Some((_, (_, shard, outcome))) =
        rows.iter().enumerate().find(|(place, (_, shard, _))| !shard.holds(*place) || twice(*place))
    {
        return Err(format!(
            "shard {shard} has {}, which is not its own or stands twice; delete its file and run it again",
            outcome.code
        )
        .into());
    }
    Ok((rows.into_iter().map(|(.., outcome)| outcome).collect(), files))
}

/// Number of topologies that the conditions of a survey state at their end.
fn topologies_of(conditions: &str) -> usize {
    conditions.trim_end_matches(" topologies").rsplit(' ').next().and_then(|count| count.parse().ok()).unwrap_or(0)
}

fn write_tables(folder: &Path, outcomes: &[Outcome], inputs: &[PathBuf]) -> Result<(), Refusal> {
    let mut output = OutputFolder::default();
    output.add("survey.csv", csv(outcomes));
    output.add("survey.html", survey_page(outcomes));
    output.write(folder, inputs)
}

fn tell(outcomes: &[Outcome], folder: &Path, json: bool) -> Result<(), Refusal> {
    if json {
        return print(&format!("{}\n", survey_json(outcomes)));
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
