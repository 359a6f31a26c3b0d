//! Collision geometry of a robot description: boxes, cylinders, spheres, capsules and meshes on the links that carry them. Visuals are not read.

use std::path::Path;

use nalgebra::{Matrix3, Vector3};

use super::checks::{child, children, numbers, shape};
use super::frames::{MM_PER_M, Placed, millimetres, quarter_turns, roll_pitch_yaw};
use super::mesh::mesh_place;
use super::places::Element;
use super::reader::Reader;
use crate::bodies::{Bodies, Body, Solid};
use crate::chain::Pose;
use crate::load::LoadError;
use crate::load::checked_text::limits::SOLIDS;
use crate::load::mesh::{MeshUse, Meshes, machine_size_mm};
use crate::machine::Machine;

/// Largest extent of a box, cylinder or sphere, m: more is a length in mm.
const MAX_SOLID_M: f64 = 50.0;

/// Solids of all links that the bed or an axis of the machine carries; what hangs on other joints stands still at zero.
pub(super) fn bodies(reader: &Reader, machine: &Machine) -> Result<Bodies, LoadError> {
    let mut bodies = Bodies::default();
    let meshes = Meshes::beside(reader.tree.file);
    let mut count = 0;
    let links = reader.elements.iter().enumerate().filter(|(_, element)| element.depth == 1 && element.name == "link");
    for (index, link) in links {
        let Some(name) = link.attribute("name") else { continue };
        let frame = reader.link_frame(name);
        let carrier = carrier(reader, machine, name);
        for (place, collision) in children(reader.elements, index, "collision") {
            let origin = origin(reader.tree.file, reader.elements, place)?;
            let at = Placed {
                rotation: frame.rotation * origin.rotation,
                at_mm: frame.at_mm + frame.rotation * origin.at_mm,
            };
            let label = collision.attribute("name").unwrap_or(name);
            let solids = geometry(reader, machine, &meshes, place)?;
            count += solids.len();
            bodies.bodies.push(Body {
                name: label.to_string(),
                link: carrier.clone(),
                solids,
                at: Pose { rotation: at.rotation, translation_mm: at.at_mm },
            });
            if let Some(message) = SOLIDS.exceeded(count) {
                return Err(LoadError::line(reader.tree.file, collision.line, message));
            }
        }
    }
    Ok(bodies)
}

/// Name by which the machine knows the link that carries a link of the description.
fn carrier(reader: &Reader, machine: &Machine, link: &str) -> String {
    let path = reader.tree.path(link).unwrap_or_default();
    let names = path.iter().rev().map(|&joint| &reader.tree.joints[joint].joint.name);
    names.filter(|name| machine.axis_index(name).is_some()).map(String::clone).next().unwrap_or_else(|| "b".into())
}

/// Pose of a collision element in its link's frame.
fn origin(file: &Path, elements: &[Element], collision: usize) -> Result<Placed, LoadError> {
    let none = Placed { rotation: Matrix3::identity(), at_mm: Vector3::zeros() };
    let Some(element) = child(elements, collision, "origin") else { return Ok(none) };
    if element.attribute("quat_xyzw").is_some() {
        return Err(LoadError::line(file, element.line, "a collision's <origin> is turned by rpy, not by quat_xyzw"));
    }
    let three = |name: &str| -> Result<[f64; 3], LoadError> {
        let Some(text) = element.attribute(name) else { return Ok([0.0; 3]) };
        let found = numbers(file, element, name, text, 3)?;
        Ok([found[0], found[1], found[2]])
    };
    let angles = quarter_turns(element.attribute("rpy").unwrap_or_default(), three("rpy")?);
    Ok(Placed { rotation: roll_pitch_yaw(angles), at_mm: Vector3::from(three("xyz")?).map(millimetres) })
}

/// Solids of a collision element; that there is a shape was checked before.
fn geometry(reader: &Reader, machine: &Machine, meshes: &Meshes, collision: usize) -> Result<Vec<Solid>, LoadError> {
    let file = reader.tree.file;
    let elements = reader.elements;
    let Some(shape) = shape(elements, collision) else { return Ok(Vec::new()) };
    let refuse = |message: String| LoadError::line(file, shape.line, message);
    // sizes in m, above zero
    let sizes = |name: &str, count: usize| -> Result<Vec<f64>, LoadError> {
        let text = shape.attribute(name).unwrap_or_default();
        let found = numbers(file, shape, name, text, count)?;
        if found.iter().any(|size| *size <= 0.0 || *size > MAX_SOLID_M) {
            return Err(refuse(format!(
                "<{}> has {name}=\"{text}\"; sizes are above zero and at most {MAX_SOLID_M} m",
                shape.name
            )));
        }
        Ok(found.into_iter().map(millimetres).collect())
    };
    Ok(match shape.name.as_str() {
        "box" => {
            let size = sizes("size", 3)?;
            vec![Solid::Box { half_mm: Vector3::new(size[0], size[1], size[2]) * 0.5 }]
        }
        "cylinder" => {
            vec![Solid::Cylinder { radius_mm: sizes("radius", 1)?[0], half_mm: 0.5 * sizes("length", 1)?[0] }]
        }
        "capsule" => vec![Solid::Capsule { radius_mm: sizes("radius", 1)?[0], half_mm: 0.5 * sizes("length", 1)?[0] }],
        "sphere" => vec![Solid::Ball { radius_mm: sizes("radius", 1)?[0] }],
        _ => {
            let scale = match shape.attribute("scale") {
                Some(text) => numbers(file, shape, "scale", text, 3)?,
                None => vec![1.0; 3],
            };
            if scale.contains(&0.0) {
                return Err(refuse("a mesh has a scale of zero; write scale=\"1 1 1\" or leave it out".into()));
            }
            let name = shape.attribute("filename").unwrap_or_default();
            let how = MeshUse {
                scale: Vector3::new(scale[0], scale[1], scale[2]) * MM_PER_M,
                machine_size_mm: machine_size_mm(machine),
                small_is_meant: shape.attribute("scale").is_some(),
                other_scale: |factor: f64| {
                    let scale: Vec<String> = scale.iter().map(|value| format!("{}", value * factor)).collect();
                    format!("write scale=\"{}\" (a robot description is in m)", scale.join(" "))
                },
            };
            let place = mesh_place(file, name);
            meshes.solids_in(&place.home, &place.name, &how).map_err(|why| refuse(why.to_string()))?
        }
    })
}
