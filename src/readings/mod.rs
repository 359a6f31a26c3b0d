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

pub(crate) use contract::NOISE_CLASSES;
pub use contract::{At, Kind, Mount, Part, Reading};
pub(crate) use locate::locate;
pub use locate::{Located, Sighting, Target};
pub use point::coordinate;
pub use pose::{LEVER_MM, quaternion, turn};
pub(crate) use pose::{euler_xyz, rotation_of_euler_xyz, rotation_of_quaternion};
pub(crate) use rotation::nearest_rotation;
pub use rotation::rotation;
pub use scalar::{Mounted, Scalar};
