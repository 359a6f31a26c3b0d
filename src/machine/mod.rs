//! The machine as its file describes it: structural code, axes, error values. It computes no positions; `chain` does.

mod axis;
mod carried;
mod code;
mod component;
mod directions;
mod effect;
mod effect_names;
mod error_name;
mod linear_axes;
mod serial_machine;
mod spindle;
mod squareness;

pub(crate) use axis::letter_axis;
pub use axis::{Axis, AxisKind};
pub use carried::{CarriedBranch, CarriedJoint};
pub(crate) use code::refuse_axis_name;
pub use code::{CodeError, StructuralCode};
pub use component::{ComponentError, ComponentForm, Harmonic};
pub use directions::{Directions, DirectionsDiffer, DirectionsUnstated};
pub use effect::{Effect, Outlet, ParameterValue, Place, Size};
pub use error_name::{Component, ErrorName, ErrorNameError};
pub use linear_axes::{LinearAxes, LinearClass};
pub use serial_machine::Machine;
pub use spindle::SpindleSide;
pub(crate) use squareness::is_by_choice_of_r;
pub use squareness::squareness;
