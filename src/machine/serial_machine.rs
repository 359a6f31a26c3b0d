//! A serial machine: axes in the order of the structural code, with what its file says of them. It computes no positions.

use nalgebra::Vector3;

use super::axis::{Axis, AxisKind};
use super::carried::{CarriedBranch, CarriedJoint};
use super::code::StructuralCode;
use super::directions::{Directions, DirectionsDiffer, DirectionsUnstated};
use super::effect::Effect;
use super::error_name::ErrorName;
use super::linear_axes::LinearAxes;
use super::spindle::SpindleSide;

/// A serial machine: axes in the order of the structural code, workpiece first.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// Name for people.
    pub name: String,
    /// Order of the axes between workpiece and tool, with the bed's place.
    pub code: StructuralCode,
    /// Sense of the axes; a file that does not state it reads as [`Directions::Carried`].
    pub directions: Option<Directions>,
    /// Axes in the code's order, workpiece side first.
    pub axes: Vec<Axis>,
    /// Direction of gravity in the reference frame R, unit length.
    pub gravity: Vector3<f64>,
    /// Machine coordinate (G53, mm or deg) of an axis at our zero, by axis index.
    pub machine_zero: Vec<Option<f64>>,
    /// Distance from the spindle nose to the spindle ball as the file states it, mm.
    pub gauge_length_mm: Option<f64>,
    /// Where tools are clamped; a robot description does not say.
    pub spindle: Option<SpindleSide>,
    /// Extra names of links (URDF link names), each with the axis that carries it (`None`: the bed).
    pub link_names: Vec<(String, Option<usize>)>,
    /// Branches that load it and lie on no way between workpiece and tool.
    pub carried: Vec<CarriedBranch>,
    /// Physics beyond constant location errors.
    pub effects: Vec<Effect>,
    /// How far the linear axes may be from straight, square and true to scale.
    pub linear_axes: LinearAxes,
    /// What the file itself holds to be assumed, in words that setup sheets and programs repeat.
    pub caveats: Vec<String>,
}

impl Machine {
    /// The branch with a joint of this name, and its joints up to that one.
    pub fn carried_link(&self, name: &str) -> Option<(&CarriedBranch, &[CarriedJoint])> {
        self.carried.iter().find_map(|branch| {
            let last = branch.joints.iter().position(|joint| joint.name == name)?;
            Some((branch, &branch.joints[..=last]))
        })
    }

    /// A machine of these axes and nothing else: no effects, gravity along R's −z.
    pub fn plain(name: String, code: StructuralCode, directions: Directions, axes: Vec<Axis>) -> Machine {
        Machine {
            name,
            code,
            directions: Some(directions),
            gravity: -Vector3::z(),
            machine_zero: vec![None; axes.len()],
            gauge_length_mm: None,
            spindle: None,
            link_names: Vec::new(),
            carried: Vec::new(),
            effects: Vec::new(),
            linear_axes: Default::default(),
            caveats: Vec::new(),
            axes,
        }
    }

    /// The way the tool looks out of the spindle in R with all axes at zero; of a machine without a stated spindle whose
    /// Z runs along R's z that is −z (ISO 841: Z lies along the spindle), of others it is not known.
    pub fn tool_direction(&self) -> Option<Vector3<f64>> {
        let along_z = self.axis_index("Z").is_some_and(|z| self.axes[z].coordinate_direction() == Some(2));
        self.spindle.as_ref().map(|spindle| -spindle.direction).or(along_z.then(|| -Vector3::z()))
    }

    /// What a machine and another one say of themselves where that shows that they are two: names, or codes with the direction and place of
    /// every axis (mm) as machine files state them. Location errors do not count.
    pub fn told_from(&self, other: &Machine) -> Option<[String; 2]> {
        let names = [&self.name, &other.name].map(Clone::clone);
        let axes = [self, other].map(Machine::axes_in_words);
        [names, axes].into_iter().find(|[one, other]| one != other)
    }

    /// Code, and direction and place of every axis (mm).
    fn axes_in_words(&self) -> String {
        let of = |axis: &Axis| {
            let [d, o] =
                [axis.direction, axis.origin].map(|v| format!("{:.4} {:.4} {:.4}", v.x + 0.0, v.y + 0.0, v.z + 0.0));
            match axis.kind {
                AxisKind::Linear => format!("{} along {d}", axis.name),
                AxisKind::Rotary => format!("{} about {d} at {o}", axis.name),
            }
        };
        format!("{}: {}", self.code, self.axes.iter().map(of).collect::<Vec<_>>().join(", "))
    }

    /// Index of the axis with this name.
    pub fn axis_index(&self, name: &str) -> Option<usize> {
        self.axes.iter().position(|axis| axis.name == name)
    }

    /// Axes of one kind, by index in the code's order.
    pub fn axes_of(&self, kind: AxisKind) -> impl Iterator<Item = usize> + Clone + '_ {
        (0..self.axes.len()).filter(move |&axis| self.axes[axis].kind == kind)
    }

    /// Names of all axes in the code's order.
    pub fn axis_names(&self) -> Vec<&str> {
        self.axes.iter().map(|axis| axis.name.as_str()).collect()
    }

    /// The machine as drawn: without location errors, component errors and effects.
    pub fn as_drawn(&self) -> Machine {
        let mut drawn = self.clone();
        for axis in &mut drawn.axes {
            axis.location_errors = [0.0; 6];
            axis.component_errors.clear();
        }
        drawn.effects.clear();
        drawn
    }

    /// Whether an axis lies between the bed and the workpiece.
    pub fn carries_workpiece(&self, axis: usize) -> bool {
        self.code.carries_workpiece(axis)
    }

    /// Inclined rotary axes that carry the workpiece: a plan counts their errors across their lines.
    pub fn inclined_table_axes(&self) -> impl Iterator<Item = usize> + '_ {
        let is_inclined = |axis: &usize| self.axes[*axis].coordinate_direction().is_none();
        self.axes_of(AxisKind::Rotary).filter(is_inclined).filter(|&axis| self.carries_workpiece(axis))
    }

    /// The rotary axis that carries the spindle, with no slide between: the vector from its line to the spindle is the pivot length.
    pub fn spindle_axis(&self) -> Option<usize> {
        let axis = self.axis_index(self.code.tool_side.last()?)?;
        (self.axes[axis].kind == AxisKind::Rotary).then_some(axis)
    }

    /// Axes between the workpiece and the bed, as the code has them.
    pub fn table_axes(&self) -> Vec<usize> {
        (0..self.code.workpiece_side.len()).collect()
    }

    /// +1 or −1 by axis index: a positive command moves the tool over the workpiece along the axis's direction, or against it.
    pub fn tool_sign(&self, axis: usize) -> f64 {
        if self.carries_workpiece(axis) { -self.motion_sign(axis) } else { self.motion_sign(axis) }
    }

    /// +1 or −1 by axis index: a command q moves the carried part by `sign · q`, right-handed along the axis's direction.
    pub fn motion_sign(&self, axis: usize) -> f64 {
        let against = self.carries_workpiece(axis) && self.directions == Some(Directions::Iso841);
        if against != self.axes[axis].reversed { -1.0 } else { 1.0 }
    }

    /// Says the sense of the axes where the file does not state it.
    pub fn say_directions(&mut self, said: Directions) -> Result<(), DirectionsDiffer> {
        match self.directions {
            Some(in_file) if in_file != said => Err(DirectionsDiffer { in_file, said }),
            _ => {
                self.directions = Some(said);
                Ok(())
            }
        }
    }

    /// The sense of the axes, for what leaves the desk for a machine.
    pub fn stated_directions(&self) -> Result<Directions, DirectionsUnstated> {
        self.directions.ok_or(DirectionsUnstated)
    }

    /// Location errors of all axes, mm and rad, by axis index: what `chain::Geometry` takes.
    pub fn location_errors(&self) -> Vec<[f64; 6]> {
        self.axes.iter().map(|axis| axis.location_errors).collect()
    }

    /// Names of the location errors that an axis has by its kind and direction (its slots), all axes in order.
    pub fn slots(&self) -> Vec<ErrorName> {
        (0..self.axes.len()).flat_map(|index| self.axis_slots(index)).collect()
    }

    /// Slots of one axis: four for a rotary and two for a linear axis along a coordinate direction, six when inclined.
    pub fn axis_slots(&self, index: usize) -> Vec<ErrorName> {
        let axis = &self.axes[index];
        axis.slots().iter().map(|&component| ErrorName::location(component, &axis.name)).collect()
    }
}
