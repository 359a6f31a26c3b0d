//! Mesh paths of a robot description: where the files are, and that they stay in the folder they belong to. Meshes are not read here.

use std::path::{Component, Path, PathBuf};

use super::places::Element;
use crate::load::LoadError;
use crate::load::checked_text::text::lies_in;

/// How many folders above the description's are looked at for a package.
const FOLDERS_ABOVE: usize = 4;
/// The folder of a package in which exporters put descriptions.
const URDF_FOLDER: &str = "urdf";

/// A mesh file: the folder that it may not leave, and its path from there.
pub struct MeshPlace {
    pub home: PathBuf,
    pub name: String,
    /// The home is what it is called, not a link to elsewhere.
    is_own: bool,
}

/// Refuses mesh paths that leave their folder or name no file.
pub fn refuse_bad_meshes(file: &Path, elements: &[Element]) -> Result<(), LoadError> {
    // only solids for collisions are read; what is drawn may be missing
    let is_solid = |element: &&Element| element.name == "mesh" && is_within(elements, element, "collision");
    for mesh in elements.iter().filter(is_solid) {
        let refuse = |message: String| Err(LoadError::line(file, mesh.line, message));
        let Some(name) = mesh.attribute("filename") else {
            return refuse("a <mesh> has no filename; write filename=\"part.stl\"".into());
        };
        let place = mesh_place(file, name);
        if let Some(reason) = leaves_folder(&place.name) {
            return refuse(format!("mesh '{name}' {reason}; put it beside the file and name it relative to the file"));
        }
        let path = place.home.join(&place.name);
        if !path.is_file() {
            return refuse(match package_of(name) {
                Some((package, _)) => format!(
                    "mesh '{name}' is not there: not below a folder '{package}' that holds the robot description or lies beside its folders, and not beside it; put the file there or remove the mesh"
                ),
                None => {
                    format!("mesh '{name}' is not there; put the file beside the robot description or remove the mesh")
                }
            });
        }
        if !place.is_own || !lies_in(&path, &[&place.home]) {
            return refuse(format!("mesh '{name}' is a link out of the file's folder; put a copy beside the file"));
        }
    }
    Ok(())
}

/// Where a mesh is: the first of its places where a file is, or else its place beside the description.
///
/// `package://NAME/REST` is REST in a folder NAME: one that holds the description, then one in the description's folder
/// or in one above; then REST beside the description. `../REST` is allowed from a folder `urdf`: REST beside that folder.
pub fn mesh_place(file: &Path, name: &str) -> MeshPlace {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let beside = || MeshPlace { home: folder.to_path_buf(), name: name_beside_file(name).to_string(), is_own: true };
    let Ok(real) = folder.canonicalize() else { return beside() };
    if let Some((package, rest)) = package_of(name) {
        let found = package_homes(&real, package).into_iter().find(|home| home.join(rest).is_file());
        return found.map_or_else(beside, |home| {
            let is_own = home.canonicalize().is_ok_and(|target| target == home);
            MeshPlace { is_own, home, name: rest.to_string() }
        });
    }
    match (name.strip_prefix("../"), real.parent()) {
        (Some(rest), Some(above)) if real.ends_with(URDF_FOLDER) => {
            MeshPlace { home: above.to_path_buf(), name: rest.to_string(), is_own: true }
        }
        _ => beside(),
    }
}

/// Folders that may be a package, in the order in which they are looked at; `folder` is the description's, links followed.
fn package_homes(folder: &Path, package: &str) -> Vec<PathBuf> {
    // the root of the file system is nobody's package
    let near = || folder.ancestors().take(1 + FOLDERS_ABOVE).filter(|above| above.parent().is_some());
    let named = near().filter(|above| above.file_name().is_some_and(|name| name == package)).map(PathBuf::from);
    named.chain(near().map(|above| above.join(package))).collect()
}

/// Package and path of `package://NAME/REST`, where both are plain.
fn package_of(name: &str) -> Option<(&str, &str)> {
    let (package, rest) = name.strip_prefix("package://")?.split_once('/')?;
    let is_plain = |part: &str| leaves_folder(part).is_none();
    let rest = rest.trim_start_matches("./");
    (is_plain(package) && package != "." && is_plain(rest)).then_some((package, rest))
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
