//! What urdf-rs lets pass and is refused here: wrong roots, words among numbers, infinities, missing parents. One element at a time.

use std::path::Path;

use super::places::Element;
use crate::load::LoadError;

/// Largest number accepted, m or rad.
pub const MAX_COORDINATE_M: f64 = 1e4;

/// Checks that urdf-rs leaves out: the root, numbers, joint types, required children.
pub fn check_elements(file: &Path, elements: &[Element]) -> Result<(), LoadError> {
    match elements.first() {
        Some(root) if root.name == "robot" => {}
        Some(root) => {
            return Err(LoadError::line(
                file,
                root.line,
                format!("the root element is <{}>; a robot description starts with <robot>", root.name),
            ));
        }
        None => return Err(LoadError::file(file, "holds no element; a robot description starts with <robot>")),
    }
    for (index, element) in elements.iter().enumerate() {
        if element.name.starts_with("xacro:") {
            return Err(LoadError::line(
                file,
                element.line,
                "holds xacro macros; expand them first: xacro FILE > out.urdf",
            ));
        }
        let counts: &[(&str, usize)] = match element.name.as_str() {
            "origin" => &[("xyz", 3), ("rpy", 3), ("quat_xyzw", 4)],
            "axis" => &[("xyz", 3)],
            "limit" => &[("lower", 1), ("upper", 1), ("effort", 1), ("velocity", 1)],
            _ => &[],
        };
        for (name, count) in counts {
            if let Some(text) = element.attribute(name) {
                numbers(file, element, name, text, *count)?;
            }
        }
        if matches!(element.name.as_str(), "collision" | "visual") && shape(elements, index).is_none() {
            return Err(LoadError::line(
                file,
                element.line,
                format!("a <{}> has no geometry; write <geometry><box size=\"…\"/></geometry>", element.name),
            ));
        }
        if element.parent.is_some_and(|parent| elements[parent].name == "geometry") {
            check_shape(file, element)?;
        }
        if element.depth == 1 && element.name == "joint" {
            check_joint(file, elements, index)?;
        }
        if element.depth == 1 && element.name == "link" && element.attribute("name").is_none() {
            return Err(LoadError::line(file, element.line, "a <link> has no name; write name=\"…\""));
        }
    }
    Ok(())
}

/// Shapes of solids with what each must state.
const SHAPES: [(&str, &[&str]); 5] = [
    ("box", &["size"]),
    ("cylinder", &["radius", "length"]),
    ("sphere", &["radius"]),
    ("capsule", &["radius", "length"]),
    ("mesh", &["filename"]),
];

fn check_shape(file: &Path, shape: &Element) -> Result<(), LoadError> {
    let refuse = |message: String| Err(LoadError::line(file, shape.line, message));
    let Some((_, attributes)) = SHAPES.iter().find(|(name, _)| *name == shape.name) else {
        let known = SHAPES.map(|(name, _)| name).join(", ");
        return refuse(format!("a <geometry> holds a <{}>; allowed are {known}", shape.name));
    };
    match attributes.iter().find(|name| shape.attribute(name).is_none()) {
        Some(name) => refuse(format!("a <{}> has no {name}; write {name}=\"…\"", shape.name)),
        None => Ok(()),
    }
}

/// Finite numbers of an attribute, all of them and no other word.
pub fn numbers(file: &Path, element: &Element, name: &str, text: &str, count: usize) -> Result<Vec<f64>, LoadError> {
    let found: Option<Vec<f64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
    let sensible = |value: &f64| match element.name.as_str() {
        // URDF 1.2 writes an absent limit as infinity
        "limit" => value.is_infinite() || value.abs() <= MAX_COORDINATE_M,
        _ => value.is_finite() && value.abs() <= MAX_COORDINATE_M,
    };
    match found {
        Some(found) if found.len() == count && found.iter().all(sensible) => Ok(found),
        _ => {
            let due = match count {
                1 => format!("one number of at most {MAX_COORDINATE_M} is due"),
                _ => format!("{count} finite numbers of at most {MAX_COORDINATE_M} are due"),
            };
            Err(LoadError::line(file, element.line, format!("<{}> has {name}=\"{text}\"; {due}", element.name)))
        }
    }
}

fn check_joint(file: &Path, elements: &[Element], index: usize) -> Result<(), LoadError> {
    let joint = &elements[index];
    let refuse = |message: String| Err(LoadError::line(file, joint.line, message));
    let Some(name) = joint.attribute("name") else { return refuse("a <joint> has no name; write name=\"…\"".into()) };
    match joint.attribute("type") {
        Some("fixed" | "revolute" | "continuous" | "prismatic") => {}
        Some(other) => {
            return refuse(format!(
                "joint '{name}' has the type '{other}'; allowed are revolute, continuous, prismatic and fixed"
            ));
        }
        None => {
            return refuse(format!(
                "joint '{name}' has no type; write type=\"revolute\", continuous, prismatic or fixed"
            ));
        }
    }
    for role in ["parent", "child"] {
        if child(elements, index, role).and_then(|element| element.attribute("link")).is_none() {
            return refuse(format!("joint '{name}' has no {role}; write <{role} link=\"…\"/>"));
        }
    }
    Ok(())
}

/// Direct children of an element with this name, with their indices.
pub fn children<'a>(
    elements: &'a [Element],
    parent: usize,
    name: &'a str,
) -> impl Iterator<Item = (usize, &'a Element)> + 'a {
    let inside = move |(_, element): &(usize, &Element)| element.depth > elements[parent].depth;
    let below = elements.iter().enumerate().skip(parent + 1).take_while(inside);
    below.filter(move |(_, element)| element.parent == Some(parent) && element.name == name)
}

/// First direct child of an element with this name.
pub fn child<'a>(elements: &'a [Element], parent: usize, name: &'a str) -> Option<&'a Element> {
    children(elements, parent, name).next().map(|(_, element)| element)
}

/// The box, cylinder, … of a collision or visual.
pub fn shape(elements: &[Element], solid: usize) -> Option<&Element> {
    let (geometry, _) = children(elements, solid, "geometry").next()?;
    elements.get(geometry + 1).filter(|element| element.parent == Some(geometry))
}
