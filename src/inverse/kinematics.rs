//! The tool's pose in the workpiece and how each axis moves it. Forward only.

use nalgebra::Vector3;

use crate::chain::{Branch, Chain, Composition, Geometry, MotionErrors, Pose};
use crate::machine::{AxisKind, Machine};

/// A tool in the spindle, in R with all axes at zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tool {
    /// Tip, mm.
    pub tip_mm: Vector3<f64>,
    /// From the tip into the spindle, unit length.
    pub axis: Vector3<f64>,
    /// A direction across the tool that turns with the spindle's housing, unit length.
    pub across: Vector3<f64>,
}

impl Tool {
    /// A tool with its tip at a place, along an axis from the tip into the spindle.
    pub fn new(tip_mm: Vector3<f64>, axis: Vector3<f64>) -> Tool {
        let aside = if axis.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
        Tool { tip_mm, axis, across: (aside - axis * axis.dot(&aside)).normalize() }
    }

    /// The tool of a machine, `length_mm` long from the spindle's nose; without a length it ends where the spindle ball is.
    ///
    /// A machine file that states no spindle has its nose at R's origin. `None`: the way the tool looks is not known.
    pub fn of(machine: &Machine, length_mm: Option<f64>) -> Option<Tool> {
        let looks = machine.tool_direction()?;
        let stated = machine.spindle.as_ref();
        let nose = stated.map_or_else(Vector3::zeros, |spindle| spindle.nose);
        let usual = stated.map_or(0.0, |spindle| spindle.gauge_length_mm);
        Some(Tool::new(nose + looks * length_mm.unwrap_or(usual), -looks))
    }
}

/// The tool in the workpiece's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolPose {
    /// Tip, mm.
    pub tip_mm: Vector3<f64>,
    /// From the tip into the spindle, unit length.
    pub axis: Vector3<f64>,
    /// Across the tool, unit length.
    pub across: Vector3<f64>,
}

impl ToolPose {
    /// Angle between the axes of two poses, rad.
    pub fn angle_to(&self, axis: &Vector3<f64>) -> f64 {
        self.axis.cross(axis).norm().atan2(self.axis.dot(axis))
    }
}

/// How an axis moves the tool seen from the workpiece, per unit of its position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisInWorkpiece {
    pub kind: AxisKind,
    /// Way of the tool (linear), or direction about which it turns, right-handed (rotary).
    pub direction: Vector3<f64>,
    /// A point of the line about which it turns, mm.
    pub point_mm: Vector3<f64>,
}

impl AxisInWorkpiece {
    /// Velocity of the tip.
    pub fn moves(&self, tip_mm: &Vector3<f64>) -> Vector3<f64> {
        match self.kind {
            AxisKind::Linear => self.direction,
            AxisKind::Rotary => self.direction.cross(&(tip_mm - self.point_mm)),
        }
    }

    /// Velocity of a direction fixed to the tool.
    pub fn turns(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        match self.kind {
            AxisKind::Linear => Vector3::zeros(),
            AxisKind::Rotary => self.direction.cross(direction),
        }
    }
}

/// A machine with a tool: nominal, or with the errors of its file.
#[derive(Debug, Clone)]
pub struct Kinematics<'a> {
    machine: &'a Machine,
    geometry: Geometry<'a>,
    has_component_errors: bool,
    tool: Tool,
}

impl<'a> Kinematics<'a> {
    /// The machine as drawn.
    pub fn nominal(machine: &'a Machine, chain: &'a Chain, tool: Tool) -> Kinematics<'a> {
        Kinematics { machine, geometry: Geometry::nominal(chain), has_component_errors: false, tool }
    }

    /// The machine with the location and component errors of its file.
    pub fn actual(machine: &'a Machine, chain: &'a Chain, tool: Tool) -> Kinematics<'a> {
        let geometry = Geometry::new(chain, &machine.location_errors(), Composition::Exact);
        let has_component_errors = machine.axes.iter().any(|axis| !axis.component_errors.is_empty());
        Kinematics { machine, geometry, has_component_errors, tool }
    }

    /// The machine.
    pub fn machine(&self) -> &'a Machine {
        self.machine
    }

    /// The tool.
    pub fn tool(&self) -> &Tool {
        &self.tool
    }

    /// The same machine with another tool.
    pub fn with_tool(&self, tool: Tool) -> Kinematics<'a> {
        Kinematics { tool, ..self.clone() }
    }

    /// Component errors at positions (mm, rad), by axis; `None` where there are none.
    pub fn component_errors(&self, positions: &[f64]) -> Option<Vec<[f64; 6]>> {
        self.has_component_errors.then(|| {
            let of_axis = |(axis, &q): (&crate::machine::Axis, &f64)| {
                let mut values = [0.0; 6];
                for error in &axis.component_errors {
                    values[error.component.index()] += error.form.value(q);
                }
                values
            };
            self.machine.axes.iter().zip(positions).map(of_axis).collect()
        })
    }

    /// The tool in the workpiece at positions (mm, rad, by axis index).
    pub fn pose(&self, positions: &[f64]) -> ToolPose {
        self.pose_with(positions, self.component_errors(positions).as_deref())
    }

    /// The same with given component errors.
    pub fn pose_with(&self, positions: &[f64], motion: Option<&MotionErrors>) -> ToolPose {
        let end = |branch: Branch| {
            self.geometry.chain().branch(branch).iter().fold(Pose::identity(), |pose, &axis| {
                pose.then(&self.geometry.joint_pose(axis, positions[axis], motion.map(|m| &m[axis])))
            })
        };
        self.seen_from(&end(Branch::Workpiece), &end(Branch::Tool))
    }

    /// The tool in the workpiece, and how each axis (by index) moves it.
    pub fn pose_and_axes(
        &self,
        positions: &[f64],
        motion: Option<&MotionErrors>,
        axes: &mut Vec<AxisInWorkpiece>,
    ) -> ToolPose {
        axes.clear();
        let none = AxisInWorkpiece { kind: AxisKind::Linear, direction: Vector3::zeros(), point_mm: Vector3::zeros() };
        axes.resize(positions.len(), none);
        let ends = [Branch::Workpiece, Branch::Tool].map(|branch| {
            let sense = if branch == Branch::Tool { 1.0 } else { -1.0 };
            self.geometry.chain().branch(branch).iter().fold(Pose::identity(), |carrier, &axis| {
                let pose = carrier.then(&self.geometry.joint_pose(axis, positions[axis], motion.map(|m| &m[axis])));
                let joint = self.geometry.chain().joint(axis);
                let direction = match joint.kind {
                    AxisKind::Linear => carrier.rotation * self.geometry.slide_direction(axis),
                    // a joint's own turn leaves its direction where it is
                    AxisKind::Rotary => pose.rotation * joint.direction * joint.sign,
                };
                axes[axis] = AxisInWorkpiece {
                    kind: joint.kind,
                    direction: direction * sense,
                    point_mm: pose.point(&joint.origin),
                };
                pose
            })
        });
        let back = ends[0].rotation.transpose();
        for axis in axes.iter_mut() {
            axis.direction = back * axis.direction;
            axis.point_mm = back * (axis.point_mm - ends[0].translation_mm);
        }
        self.seen_from(&ends[0], &ends[1])
    }

    fn seen_from(&self, workpiece: &Pose, tool: &Pose) -> ToolPose {
        let back = workpiece.rotation.transpose();
        ToolPose {
            tip_mm: back * (tool.point(&self.tool.tip_mm) - workpiece.translation_mm),
            axis: back * (tool.rotation * self.tool.axis),
            across: back * (tool.rotation * self.tool.across),
        }
    }
}
