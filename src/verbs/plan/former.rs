//! What an earlier `plan` left in a folder, known by the heads of its session file and setup sheet. It removes nothing itself.

use std::path::{Component, Path, PathBuf};

use fiveaxis::load::mesh_files;
use fiveaxis::report::setup_sheet;

use crate::verbs::Refusal;

/// How the session file of a plan begins; no other file does.
const MARKER: &str = "# planned by fiveaxis; ";
const SHEET: &str = "setup-sheet.html";

/// Head of a planned session file: the marker, and programs and meshes that belong to it.
pub fn head(files: &[String]) -> String {
    let mut head = format!(
        "{MARKER}a new plan in this folder replaces this file, machine.yaml, the setup sheet and these files\n"
    );
    files.iter().for_each(|file| head.push_str(&format!("# {file}\n")));
    head
}

/// Files of an earlier plan that a new one replaces or removes, relative to the folder; refuses a folder in which a new plan
/// would write over something that no plan wrote. `input` is left to [`crate::verbs::output::OutputFolder::write`].
pub fn former_files(folder: &Path, input: &Path) -> Result<Vec<PathBuf>, Refusal> {
    let session = content(&folder.join("session.yaml")).unwrap_or_default();
    let session = String::from_utf8_lossy(&session);
    let is_planned = session.starts_with(MARKER);
    let listed = |line: &str| line.strip_prefix("# ").map(PathBuf::from);
    let listed: Vec<PathBuf> = match is_planned {
        true => session.lines().skip(1).map_while(listed).collect(),
        false => Vec::new(),
    };
    let same =
        |one: &Path, other: &Path| one.canonicalize().is_ok_and(|one| other.canonicalize().is_ok_and(|o| o == one));
    let there = |name: &str| {
        let found = folder.join(name);
        (found.symlink_metadata().is_ok() && !same(&found, input)).then_some(found)
    };
    if !is_planned {
        if let Some(found) = ["session.yaml", "machine.yaml", "nc"].into_iter().find_map(there) {
            return Err(not_planned(&found));
        }
        // a plan without tests leaves a sheet alone
        let sheet = there(SHEET).filter(|sheet| {
            let text = content(sheet).unwrap_or_default();
            !text.starts_with(setup_sheet::MARKER.as_bytes())
        });
        if let Some(found) = sheet {
            return Err(not_planned(&found));
        }
    }
    let home = input.parent().unwrap_or(Path::new(""));
    for mesh in mesh_files(input)?.iter().filter(|mesh| !mesh.starts_with("../")) {
        let Some(found) = there(mesh) else { continue };
        let is_copy = content(&found).is_some_and(|old| content(&home.join(mesh)).is_some_and(|new| new == old));
        if !is_copy && !listed.iter().any(|file| file == Path::new(mesh)) {
            return Err(not_planned(&found));
        }
    }
    let programs = listed.into_iter().filter(|file| is_program(file));
    let own = is_planned.then_some(["session.yaml", "machine.yaml"]).into_iter().flatten();
    Ok(own.map(PathBuf::from).chain(programs).collect())
}

/// Content of a regular file: reading a pipe would wait for its writer.
fn content(file: &Path) -> Option<Vec<u8>> {
    file.is_file().then(|| std::fs::read(file).ok()).flatten()
}

fn not_planned(found: &Path) -> Refusal {
    format!("{} was not written by plan and is not overwritten; name another folder", found.display()).into()
}

/// nc/CONTROL/NAME: a head that somebody changed cannot name files elsewhere.
fn is_program(file: &Path) -> bool {
    let parts: Vec<Component> = file.components().collect();
    parts.len() == 3 && file.starts_with("nc") && parts.iter().all(|part| matches!(part, Component::Normal(_)))
}
