//! Branches that hang on the machine and load it, but lie on no way between workpiece and tool: another arm on the same torso. They hold no
//! positions; those stand in columns of the recordings.

use nalgebra::Vector3;

/// A branch of rotary joints on a link.
#[derive(Debug, Clone, PartialEq)]
pub struct CarriedBranch {
    /// Name for people.
    pub name: String,
    /// Axis whose link carries it; `None`: the bed.
    pub on: Option<usize>,
    /// Joints from that link outward.
    pub joints: Vec<CarriedJoint>,
}

/// A joint of such a branch; the link that it carries has its name.
#[derive(Debug, Clone, PartialEq)]
pub struct CarriedJoint {
    pub name: String,
    /// Unit vector in R at the zero position.
    pub direction: Vector3<f64>,
    /// A point on its line, mm, in R at the zero position; `None`: not stated.
    pub origin: Option<Vector3<f64>>,
    /// It counts against the right-handed sense.
    pub reversed: bool,
}

impl CarriedJoint {
    /// Column of a recording with its positions.
    pub fn channel(&self) -> String {
        format!("{}_deg", self.name)
    }
}
