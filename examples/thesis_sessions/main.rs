//! Writes three ball-bar sessions of a Hermle C600U after chapters 4, 5 and 6 of the thesis, reconstructed by simulation; uses nothing of the library.

// physics that only the tests conceal
#[allow(dead_code)]
mod besides;
mod design;
mod files;
mod kinematics;
mod noise;
mod session;

use std::path::PathBuf;
use std::process::ExitCode;

const USAGE: &str = "usage: thesis_sessions --out DIR [--seed N]";

fn main() -> ExitCode {
    match arguments().and_then(|(out, seed)| write(&out, seed)) {
        Ok(count) => {
            println!("{count} files, reconstructed by simulation, not measured");
            ExitCode::SUCCESS
        }
        Err(message) => {
            eprintln!("{message}");
            ExitCode::from(2)
        }
    }
}

fn arguments() -> Result<(PathBuf, u64), String> {
    let mut out = None;
    let mut seed = files::COMMITTED_SEED;
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let value = words.next();
        match (word.as_str(), value) {
            ("--out", Some(folder)) => out = Some(PathBuf::from(folder)),
            ("--seed", Some(number)) => {
                seed = number.parse().map_err(|_| format!("--seed {number}: not a whole number\n{USAGE}"))?;
            }
            _ => return Err(format!("{word}: not understood\n{USAGE}")),
        }
    }
    let out = out.ok_or_else(|| format!("--out is missing\n{USAGE}"))?;
    Ok((out, seed))
}

fn write(out: &std::path::Path, seed: u64) -> Result<usize, String> {
    let files = files::all(seed);
    for (name, text) in &files {
        let path = out.join(name);
        let folder = path.parent().unwrap_or(out);
        std::fs::create_dir_all(folder)
            .and_then(|()| std::fs::write(&path, text))
            .map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(files.len())
}
