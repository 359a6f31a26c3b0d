//! Robot descriptions (URDF) to a [`Machine`]: metres to mm, fixed joints folded, the code read off the joint tree. Solids are in `collision`.

mod checks;
mod collision;
mod ends;
mod mesh;
mod places;
mod tree;

use std::path::Path;

use nalgebra::{Matrix3, Vector3};
use urdf_rs::{JointType, Robot};

use super::limits::AXES;
use super::message::LoadError;
use crate::bodies::Bodies;
use crate::machine::{Axis, AxisKind, Directions, Machine, StructuralCode, refuse_axis_name};
use checks::{MAX_COORDINATE_M, check_elements, child};
use ends::Ends;
use places::{Element, elements};
use tree::{Branchlet, Tree};

pub use ends::LinkChoice;

/// Millimetres in a metre.
const MM_PER_M: f64 = 1000.0;
/// Lengths are kept to a picometre: 0.07 m is 70 mm and not 70.00000000000001.
const GRAINS_PER_MM: f64 = 1e9;
/// Components of a direction below this are rounding of rotation matrices.
const DIRECTION_ROUNDING: f64 = 1e-12;

/// Reads the text of a robot description; `file` is its name in messages and its folder holds the meshes.
pub fn machine_from_urdf(file: &Path, text: &str, choice: &LinkChoice) -> Result<Machine, LoadError> {
    read(file, text, choice, |reader, name| reader.machine(name))
}

/// Collision solids of a robot description, on the links of the machine read from it.
pub fn bodies_from_urdf(file: &Path, text: &str, choice: &LinkChoice, machine: &Machine) -> Result<Bodies, LoadError> {
    read(file, text, choice, |reader, _| collision::bodies(reader, machine))
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

/// Pose of a link in R with all joints at zero.
#[derive(Clone, Copy)]
struct Placed {
    rotation: Matrix3<f64>,
    at_mm: Vector3<f64>,
}

struct Reader<'a> {
    tree: &'a Tree<'a>,
    elements: &'a [Element],
    ends: &'a Ends,
}

impl Reader<'_> {
    fn machine(&self, name: &str) -> Result<Machine, LoadError> {
        let tree = self.tree;
        let moving =
            |path: &[usize]| -> Vec<usize> { path.iter().copied().filter(|&j| tree.joints[j].moves()).collect() };
        let (mut workpiece, tool) = (moving(&self.ends.workpiece), moving(&self.ends.tool));
        if let Some(&shared) = workpiece.iter().find(|joint| tool.contains(joint)) {
            let joint = &tree.joints[shared];
            return Err(LoadError::line(
                tree.file,
                joint.element.line,
                format!(
                    "joint '{}' carries both the workpiece link '{}' and the tool link '{}'; name other links or another root",
                    joint.joint.name, self.ends.workpiece_link, self.ends.tool_link
                ),
            ));
        }
        workpiece.reverse();
        let order: Vec<usize> = workpiece.iter().chain(&tool).copied().collect();
        if order.is_empty() || order.len() > AXES.most {
            return Err(LoadError::file(
                tree.file,
                format!(
                    "{} moving joints lie between '{}' and '{}'; 1 to {} are allowed, name other links",
                    order.len(),
                    self.ends.workpiece_link,
                    self.ends.tool_link,
                    AXES.most
                ),
            ));
        }
        let axes = order.iter().map(|&joint| self.axis(joint)).collect::<Result<Vec<Axis>, _>>()?;
        let names = |joints: &[usize]| joints.iter().map(|&j| tree.joints[j].joint.name.clone()).collect();
        Ok(Machine {
            name: if name.is_empty() { "robot".into() } else { name.to_string() },
            code: StructuralCode { workpiece_side: names(&workpiece), tool_side: names(&tool) },
            // a joint's axis is that of the child's right-handed motion relative to its parent
            directions: Some(Directions::Carried),
            machine_zero: vec![None; axes.len()],
            gravity: -Vector3::z(),
            gauge_length_mm: None,
            link_names: self.link_names(&order, &axes)?,
            carried: Vec::new(),
            effects: Vec::new(),
            linear_axes: Default::default(),
            caveats: Vec::new(),
            axes,
        })
    }

    fn axis(&self, index: usize) -> Result<Axis, LoadError> {
        let entry = &self.tree.joints[index];
        let joint = entry.joint;
        let refuse = |message: String| LoadError::line(self.tree.file, entry.element.line, message);
        if child(self.elements, entry.index_in_file, "mimic").is_some() {
            return Err(refuse(format!(
                "joint '{}' mimics another and lies between workpiece and tool; only joints that move by themselves are allowed there",
                joint.name
            )));
        }
        if let Some(reason) = refuse_axis_name(&joint.name) {
            return Err(refuse(reason));
        }
        let kind = match joint.joint_type {
            JointType::Prismatic => AxisKind::Linear,
            _ => AxisKind::Rotary,
        };
        let placed = self.placed(index)?;
        let stated = Vector3::from(*joint.axis.xyz);
        let direction = (placed.rotation * stated).try_normalize(1e-6).ok_or_else(|| {
            refuse(format!("joint '{}' has an axis of no length; give a direction such as xyz=\"0 0 1\"", joint.name))
        })?;
        let direction = direction.map(|part| if part.abs() < DIRECTION_ROUNDING { 0.0 } else { part }).normalize();
        Ok(Axis {
            name: joint.name.clone(),
            kind,
            direction,
            origin: placed.at_mm,
            range: self.range(entry, kind)?,
            reversed: false,
            location_errors: [0.0; 6],
            component_errors: Vec::new(),
        })
    }

    fn range(&self, entry: &Branchlet, kind: AxisKind) -> Result<Option<(f64, f64)>, LoadError> {
        let stated = child(self.elements, entry.index_in_file, "limit");
        let limit = &entry.joint.limit;
        let Some(element) = stated.filter(|_| entry.joint.joint_type != JointType::Continuous) else { return Ok(None) };
        if limit.lower.is_infinite() || limit.upper.is_infinite() {
            return Ok(None);
        }
        if limit.lower >= limit.upper {
            return Err(LoadError::line(
                self.tree.file,
                element.line,
                format!(
                    "joint '{}' has the range {} … {}, upside down or empty; lower is below upper",
                    entry.joint.name, limit.lower, limit.upper
                ),
            ));
        }
        let inside = |value: f64| match kind {
            AxisKind::Linear => millimetres(value),
            AxisKind::Rotary => whole_degrees(value),
        };
        Ok(Some((inside(limit.lower), inside(limit.upper))))
    }

    /// Pose of a joint's frame in R (the bed's frame) with all joints at zero.
    fn placed(&self, joint: usize) -> Result<Placed, LoadError> {
        let placed = self.link_frame(&self.tree.joints[joint].joint.child.link);
        if placed.at_mm.amax() > MAX_COORDINATE_M * MM_PER_M {
            let entry = &self.tree.joints[joint];
            return Err(LoadError::line(
                self.tree.file,
                entry.element.line,
                format!(
                    "joint '{}' lies farther than {MAX_COORDINATE_M} m from the bed; lengths are in m",
                    entry.joint.name
                ),
            ));
        }
        Ok(placed)
    }

    /// Pose of a link's frame in R with all joints at zero.
    fn link_frame(&self, link: &str) -> Placed {
        let path = self.tree.path(link).unwrap_or_default();
        match path.strip_prefix(&self.ends.below_bed[..]) {
            Some(above_bed) => self.along(above_bed),
            // beside or below the bed: down to the root and up again
            None => {
                let (bed, placed) = (self.along(&self.ends.below_bed), self.along(&path));
                Placed {
                    rotation: bed.rotation.tr_mul(&placed.rotation),
                    at_mm: bed.rotation.tr_mul(&(placed.at_mm - bed.at_mm)).map(grain),
                }
            }
        }
    }

    /// Pose at the end of some joints in the frame before the first, all at zero.
    fn along(&self, joints: &[usize]) -> Placed {
        let mut placed = Placed { rotation: Matrix3::identity(), at_mm: Vector3::zeros() };
        for &index in joints {
            let entry = &self.tree.joints[index];
            let origin = &entry.joint.origin;
            let texts = child(self.elements, entry.index_in_file, "origin");
            let rpy_text = texts.and_then(|element| element.attribute("rpy")).unwrap_or_default();
            let angles = quarter_turns(rpy_text, *origin.rpy);
            placed.at_mm += placed.rotation * Vector3::from(*origin.xyz).map(millimetres);
            placed.rotation *= roll_pitch_yaw(angles);
        }
        placed.at_mm = placed.at_mm.map(grain);
        placed
    }

    /// Every link that the bed or an axis of the chain carries.
    fn link_names(&self, order: &[usize], axes: &[Axis]) -> Result<Vec<(String, Option<usize>)>, LoadError> {
        let mut names = Vec::new();
        for &link in &self.tree.links {
            let path = self.tree.path(link).unwrap_or_default();
            let moving: Vec<usize> = path.into_iter().filter(|&joint| self.tree.joints[joint].moves()).collect();
            if moving.iter().any(|joint| !order.contains(joint)) {
                // behind a joint that belongs to neither branch, such as a gripper's finger
                continue;
            }
            let carrier = moving.last().and_then(|joint| order.iter().position(|other| other == joint));
            let same_name = axes.iter().position(|axis| axis.name == link);
            match same_name {
                None if ["b", "w", "t"].contains(&link) => {}
                None => names.push((link.to_string(), carrier)),
                Some(_) if same_name == carrier => {}
                Some(_) => {
                    return Err(LoadError::file(
                        self.tree.file,
                        format!("link '{link}' has the name of a joint that does not carry it; rename one of them"),
                    ));
                }
            }
        }
        Ok(names)
    }
}

fn millimetres(metres: f64) -> f64 {
    grain(metres * MM_PER_M)
}

fn grain(length_mm: f64) -> f64 {
    (length_mm * GRAINS_PER_MM).round() / GRAINS_PER_MM
}

/// Ends of a range are kept to 1e-7 degrees: ten printed decimals of a radian mean 165° and not 165.000000002°.
fn whole_degrees(angle_rad: f64) -> f64 {
    const PER_DEGREE: f64 = 1e7;
    ((angle_rad.to_degrees() * PER_DEGREE).round() / PER_DEGREE).to_radians()
}

/// `R = Rz(yaw)·Ry(pitch)·Rx(roll)`, the URDF's fixed-axis order.
fn roll_pitch_yaw([roll, pitch, yaw]: [f64; 3]) -> Matrix3<f64> {
    *nalgebra::Rotation3::from_euler_angles(roll, pitch, yaw).matrix()
}

/// Angles that are a multiple of 45° rounded to their printed decimals are taken as that multiple.
///
/// Files print 1.5708 for a quarter turn; taken literally the axis would lean by 0.76 arcsec and count as inclined.
fn quarter_turns(text: &str, angles: [f64; 3]) -> [f64; 3] {
    let words: Vec<&str> = text.split_whitespace().collect();
    let mut taken = angles;
    for (angle, word) in taken.iter_mut().zip(words) {
        let decimals = word.split_once('.').map_or(0, |(_, digits)| digits.len());
        let is_plain = !word.contains(['e', 'E']);
        let eighth = std::f64::consts::FRAC_PI_4;
        let multiple = (*angle / eighth).round() * eighth;
        if is_plain && decimals >= 2 && (*angle - multiple).abs() <= 0.5000001 * 10f64.powi(-(decimals.min(17) as i32))
        {
            *angle = multiple;
        }
    }
    taken
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounded_quarter_turns_are_quarter_turns() {
        let taken = |text: &str| {
            let angles: Vec<f64> = text.split(' ').map(|word| word.parse().unwrap()).collect();
            quarter_turns(text, [angles[0], angles[1], angles[2]])
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        assert_eq!(taken("1.5708 0.785398 0.1"), [quarter, quarter / 2.0, 0.1]);
        assert_eq!(taken("1.571 1.5709 3.14"), [quarter, 1.5709, 2.0 * quarter]);
        assert_eq!(millimetres(0.07), 70.0);
        assert_eq!(millimetres(0.302), 302.0);
    }
}
