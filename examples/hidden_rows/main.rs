//! Predicts rows of real recordings that no fit has seen: a fourth of the rows is hidden in blocks, the rest is fitted and diagnosed,
//! the hidden rows are predicted; then the next fourth. Writes the table of docs/real.md.
//!
//! `cargo run --release --example hidden_rows -- [SET…] [--data FOLDER] [--shares 4]`; rows that are not part of the project are
//! looked for in `../shared/real`, sets whose rows are not there are skipped and said.

mod rows;
mod sets;

use std::path::PathBuf;
use std::time::Instant;

use rows::{Hidden, Scored, rms, scored};
use sets::{SETS, Set};

/// Parts of the rows of which one is hidden.
const SHARES: usize = 4;

fn main() {
    let mut names: Vec<String> = Vec::new();
    let (mut data, mut shares) = (PathBuf::from("../shared/real"), SHARES);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--data" => data = arguments.next().map(PathBuf::from).expect("a folder"),
            "--shares" => {
                let number = arguments.next().and_then(|text| text.parse().ok());
                shares = number.filter(|number| (1..=SHARES).contains(number)).expect("a number from 1 to 4");
            }
            _ => names.push(argument),
        }
    }
    let chosen: Vec<&Set> =
        SETS.iter().filter(|set| names.is_empty() || names.iter().any(|name| set.name == name)).collect();
    for name in names.iter().filter(|name| SETS.iter().all(|set| set.name != name.as_str())) {
        let known: Vec<&str> = SETS.iter().map(|set| set.name).collect();
        println!("no set '{name}'; there are {}", known.join(", "));
    }
    println!("| set | readings | geometry | with findings | by hand | s | findings of the first part |");
    println!("|---|---|---|---|---|---|---|");
    for set in chosen {
        match set.session(&data) {
            Some(session) => {
                let from = Instant::now();
                let parts: Vec<Scored> = (0..shares)
                    .map(|part| scored(&session, &Hidden { part, parts: SHARES, block: set.block }))
                    .collect();
                let seconds = from.elapsed().as_secs_f64() / shares as f64;
                line(set, &parts, seconds);
            }
            None => println!("| {} | its rows are not there: skipped | | | | | |", set.name),
        }
    }
}

/// One row of the table.
fn line(set: &Set, parts: &[Scored], seconds: f64) {
    let rms = |of: fn(&Scored) -> &Vec<f64>| rms(&parts.iter().flat_map(of).copied().collect::<Vec<f64>>());
    let found: Vec<&str> = parts.first().map_or_else(Vec::new, |part| part.found.iter().map(String::as_str).collect());
    println!(
        "| {} | {} | {:.3} | {:.3} | {} | {seconds:.0} | {} |",
        set.name,
        parts.first().map_or(0, |part| part.readings),
        rms(|part| &part.geometry_mm2),
        rms(|part| &part.found_mm2),
        set.by_hand_mm,
        found.join("; ")
    );
}
