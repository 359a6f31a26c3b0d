//! The text of a robot description to a machine, its solids, or the names of its meshes.

use std::path::Path;

use urdf_rs::Robot;

use super::checks::check_elements;
use super::collision;
use super::ends::{Ends, LinkChoice};
use super::mesh;
use super::places::elements;
use super::reader::Reader;
use super::tree::Tree;
use crate::bodies::Bodies;
use crate::chain::Pose;
use crate::load::checked_text::message::LoadError;
use crate::machine::Machine;

/// Reads the text of a robot description; `file` is its name in messages and its folder holds the meshes.
pub fn machine_from_urdf(file: &Path, text: &str, choice: &LinkChoice) -> Result<Machine, LoadError> {
    read(file, text, choice, |reader, name| reader.machine(name))
}

/// Collision solids of a robot description, on the links of the machine read from it.
pub fn bodies_from_urdf(file: &Path, text: &str, choice: &LinkChoice, machine: &Machine) -> Result<Bodies, LoadError> {
    read(file, text, choice, |reader, _| collision::bodies(reader, machine))
}

/// Frames of the workpiece link and the tool link in R with all joints at zero.
pub fn ends_from_urdf(file: &Path, text: &str, choice: &LinkChoice) -> Result<[Pose; 2], LoadError> {
    read(file, text, choice, |reader, _| {
        Ok([&reader.ends.workpiece_link, &reader.ends.tool_link].map(|link| {
            let placed = reader.link_frame(link);
            Pose { rotation: placed.rotation, translation_mm: placed.at_mm }
        }))
    })
}

/// Mesh files that a robot description names, relative to its folder.
pub fn mesh_names(file: &Path, text: &str) -> Result<Vec<String>, LoadError> {
    let elements = elements(file, text)?;
    let meshes = elements.iter().filter(|element| element.name == "mesh");
    let named = meshes.filter_map(|element| element.attribute("filename"));
    Ok(named.map(|name| mesh::name_beside_file(name).to_string()).collect())
}

/// Checks a robot description, lays R and hands the rest over with the robot's name.
fn read<T>(
    file: &Path,
    text: &str,
    choice: &LinkChoice,
    take: impl FnOnce(&Reader, &str) -> Result<T, LoadError>,
) -> Result<T, LoadError> {
    let elements = elements(file, text)?;
    check_elements(file, &elements)?;
    mesh::refuse_bad_meshes(file, &elements)?;
    let robot: Robot = urdf_rs::read_from_string(text).map_err(|why| {
        LoadError::file(file, format!("is no complete robot description: {}", one_line(&why.to_string())))
    })?;
    let tree = Tree::of(file, &robot, &elements)?;
    let ends = Ends::of(&tree, choice)?;
    take(&Reader { tree: &tree, elements: &elements, ends: &ends }, &robot.name)
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
