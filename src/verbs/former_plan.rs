//! What an earlier `plan` left in a folder, known by the head of its session file. It removes nothing itself.

use std::path::{Component, Path, PathBuf};

use super::Refusal;

/// How the session file of a plan begins; no other file does.
const MARKER: &str = "# planned by fiveaxis; ";

/// Head of a planned session file: the marker and the programs that belong to it.
pub fn head(programs: &[String]) -> String {
    let mut head = format!("{MARKER}a new plan in this folder replaces this file, machine.yaml and the programs\n");
    programs.iter().for_each(|program| head.push_str(&format!("# {program}\n")));
    head
}

/// Files of an earlier plan, relative to the folder; refuses a folder with such files that no plan wrote. `input` is left
/// to [`super::output::OutputFolder::write`].
pub fn former_files(folder: &Path, input: &Path) -> Result<Vec<PathBuf>, Refusal> {
    let session = std::fs::read(folder.join("session.yaml")).unwrap_or_default();
    let session = String::from_utf8_lossy(&session);
    if session.starts_with(MARKER) {
        let listed = session.lines().skip(1).map_while(|line| line.strip_prefix("# "));
        let programs = listed.map(PathBuf::from).filter(|file| is_program(file));
        return Ok(["session.yaml", "machine.yaml"].map(PathBuf::from).into_iter().chain(programs).collect());
    }
    for name in ["session.yaml", "machine.yaml", "nc"] {
        let found = folder.join(name);
        let is_input = found.canonicalize().is_ok_and(|found| input.canonicalize().is_ok_and(|input| input == found));
        if found.symlink_metadata().is_ok() && !is_input {
            return Err(format!(
                "{} was not written by plan and is not overwritten; name another folder",
                found.display()
            )
            .into());
        }
    }
    Ok(Vec::new())
}

/// nc/CONTROL/NAME: a head that somebody changed cannot name files elsewhere.
fn is_program(file: &Path) -> bool {
    let parts: Vec<Component> = file.components().collect();
    parts.len() == 3 && file.starts_with("nc") && parts.iter().all(|part| matches!(part, Component::Normal(_)))
}
