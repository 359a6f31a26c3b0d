//! What the errors of a machine do to the tool tip over the work volume: position and direction in the workpiece, by cause,
//! with the uncertainty of a fit.
//!
//! An error at positions q is the tool's pose by the erring machine minus that of the nominal machine at the same q, in the
//! workpiece's frame. Figures are taken over poses spread evenly over the travel of all axes, or over a part: tips in a box
//! and rotary positions over their travel, as far as the slides reach.

mod causes;
mod figures;
mod poses;
mod spread;

pub use causes::{Cause, causes};
pub use figures::{Figures, PoseError, Share, pose_errors, share};
pub use poses::{Part, VolumeError, poses};
pub use spread::{Spread, spread};
