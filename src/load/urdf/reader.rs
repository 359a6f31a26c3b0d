//! Joints and links of a robot description to a machine: order, axes, ranges, names of links. Solids are in `collision`.

use nalgebra::{Matrix3, Vector3};
use urdf_rs::JointType;

use super::checks::{MAX_COORDINATE_M, child};
use super::ends::Ends;
use super::frames::{MM_PER_M, Placed, grain, millimetres, quarter_turns, roll_pitch_yaw, whole_degrees};
use super::places::Element;
use super::tree::{Branchlet, Tree};
use crate::load::checked_text::limits::AXES;
use crate::load::checked_text::message::LoadError;
use crate::machine::{Axis, AxisKind, Directions, Machine, StructuralCode, refuse_axis_name};

/// Components of a direction below this are rounding of rotation matrices.
const DIRECTION_ROUNDING: f64 = 1e-12;

/// A robot description laid out in R.
pub(super) struct Reader<'a> {
    pub tree: &'a Tree<'a>,
    pub elements: &'a [Element],
    pub ends: &'a Ends,
}

impl Reader<'_> {
    pub fn machine(&self, name: &str) -> Result<Machine, LoadError> {
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
            spindle: None,
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
    pub fn link_frame(&self, link: &str) -> Placed {
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
