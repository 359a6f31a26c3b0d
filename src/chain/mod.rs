//! The compiled kinematic chain: who carries whom and about which line. Immutable; holds no error values and no positions.

mod batch;
mod column;
mod columns;
mod geometry;
pub(crate) mod lanes;
mod link;
mod lower;
mod poses;
mod sense;
mod sensitivity;
mod structure;
mod trig;

pub use batch::Bar;
pub use column::Column;
pub use columns::Derivatives;
pub use geometry::{Composition, Geometry, MotionErrors, Pose};
pub use link::{Branch, LinkId};
pub use poses::Poses;
pub use sense::{View, sense_in_words};
pub use sensitivity::{Sensitivity, Way, Wrench};
pub use structure::{Chain, Joint};
pub use trig::{LARGEST_ANGLE_RAD, sines_and_cosines};
