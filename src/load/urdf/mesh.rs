//! Mesh paths of a robot description: they stay inside the file's folder and exist. Meshes are not read here.

use std::path::{Component, Path};

use super::places::Element;
use crate::load::LoadError;

/// Refuses mesh paths that leave the file's folder or name no file.
pub fn refuse_bad_meshes(file: &Path, elements: &[Element]) -> Result<(), LoadError> {
    // only solids for collisions are read; what is drawn may be missing
    let is_solid = |element: &&Element| element.name == "mesh" && is_within(elements, element, "collision");
    for mesh in elements.iter().filter(is_solid) {
        let refuse = |message: String| Err(LoadError::line(file, mesh.line, message));
        let Some(name) = mesh.attribute("filename") else {
            return refuse("a <mesh> has no filename; write filename=\"part.stl\"".into());
        };
        if let Some(reason) = leaves_folder(name_beside_file(name)) {
            return refuse(format!("mesh '{name}' {reason}; put it beside the file and name it relative to the file"));
        }
        let folder = file.parent().unwrap_or(Path::new(""));
        let path = folder.join(name_beside_file(name));
        if !path.is_file() {
            return refuse(format!(
                "mesh '{name}' is not there; put the file beside the robot description or remove the mesh"
            ));
        }
        let home = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let stays = match (path.canonicalize(), home.canonicalize()) {
            (Ok(path), Ok(home)) => path.starts_with(home),
            _ => false,
        };
        if !stays {
            return refuse(format!("mesh '{name}' is a link out of the file's folder; put a copy beside the file"));
        }
    }
    Ok(())
}

/// `package://PACKAGE/meshes/part.stl`, as CAD tools write it, is `meshes/part.stl` beside the file.
pub fn name_beside_file(name: &str) -> &str {
    let inside = name.strip_prefix("package://").and_then(|rest| rest.split_once('/')).map(|(_, rest)| rest);
    inside.unwrap_or(name).trim_start_matches("./")
}

/// Whether an element stands inside one of this name.
fn is_within(elements: &[Element], element: &Element, name: &str) -> bool {
    let mut above = element.parent;
    while let Some(parent) = above.and_then(|index| elements.get(index)) {
        if parent.name == name {
            return true;
        }
        above = parent.parent;
    }
    false
}

/// Why a path is not one below the file's folder.
fn leaves_folder(name: &str) -> Option<&'static str> {
    if name.contains("://") {
        return Some("is an address that is not looked up");
    }
    if name.contains('\\') || name.contains('&') {
        return Some("holds '\\' or '&', which are not allowed in paths here");
    }
    let inside = |part: Component| matches!(part, Component::Normal(_) | Component::CurDir);
    (name.is_empty() || !Path::new(name).components().all(inside)).then_some("leaves the file's folder")
}
