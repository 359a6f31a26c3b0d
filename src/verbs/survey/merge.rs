//! Shards of one survey put together: every shard there, once, whole and of the same conditions. It writes nothing.

use std::path::{Path, PathBuf};

use fiveaxis::load::{ShardFile, load_shard};
use fiveaxis::report::survey::HEADER;
use fiveaxis::survey::{Outcome, Shard, codes};

use crate::verbs::Refusal;

/// Outcomes of all shards found in some folders, in order, and the files they stand in.
pub fn merged(folders: &[PathBuf]) -> Result<(Vec<Outcome>, Vec<PathBuf>), Refusal> {
    let files = shard_files(folders)?;
    let mut shards: Vec<(PathBuf, ShardFile)> = Vec::new();
    for file in &files {
        let read = load_shard(file, HEADER)?;
        check_fits(file, &read, &shards)?;
        shards.push((file.clone(), read));
    }
    shards.sort_by_key(|(_, read)| read.shard);
    check_all_there(&shards)?;
    Ok((in_order(shards)?, files))
}

/// Files of shards in the folders.
fn shard_files(folders: &[PathBuf]) -> Result<Vec<PathBuf>, Refusal> {
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
    Ok(files)
}

/// Refuses a shard of another survey, one that is there already, and one that is cut off.
fn check_fits(file: &Path, read: &ShardFile, shards: &[(PathBuf, ShardFile)]) -> Result<(), Refusal> {
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
    Ok(())
}

/// Refuses what is not all shards with all their rows.
fn check_all_there(shards: &[(PathBuf, ShardFile)]) -> Result<(), Refusal> {
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
    }
    Ok(())
}

/// Rows of all shards in the order of the codes; a row that is not its shard's is refused.
fn in_order(shards: Vec<(PathBuf, ShardFile)>) -> Result<Vec<Outcome>, Refusal> {
    let order = codes();
    let mut rows: Vec<(usize, Shard, Outcome)> = Vec::new();
    for (file, read) in shards {
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
    Ok(rows.into_iter().map(|(.., outcome)| outcome).collect())
}

/// Number of topologies that the conditions of a survey state at their end.
fn topologies_of(conditions: &str) -> usize {
    conditions.trim_end_matches(" topologies").rsplit(' ').next().and_then(|count| count.parse().ok()).unwrap_or(0)
}
