//! What instruments read of a chain: one contract, one file per kind. It holds no rows, reads no files and fits nothing.
//!
//! Every reading is a row of numbers. Each number `y` pulls on the chain with one wrench `(f, c)`: where the target moves against
//! the instrument by a small shift δ of its point and a small turn ε, `δy = f·δ + c·ε`. A length pulls with a unit force along the bar, a
//! coordinate with a unit force along an axis of the instrument, a rotation with a couple. Derivatives with respect to any
//! error of any joint follow from the wrench alone ([`crate::chain::Geometry::pulled`]); what a kind adds is its value, its wrench, the names
//! of its columns and what is unknown of instrument and target.

mod contract;
mod displacement;
mod locate;
mod point;
mod pose;
mod rotation;
mod same_point;
mod scalar;

pub use contract::{At, Kind, Mount, NOISE_CLASSES, Part, Reading};
pub use locate::{Located, Sighting, Target, locate};
pub use point::coordinate;
pub use pose::{LEVER_MM, euler_xyz, quaternion, rotation_of_euler_xyz, rotation_of_quaternion, turn};
pub use rotation::{nearest_rotation, rotation};
pub use scalar::{Mounted, Scalar};
