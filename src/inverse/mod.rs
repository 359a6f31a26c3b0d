//! Where the tool stands in the workpiece, and the axis positions that bring it there: any serial machine, its errors included.
//!
//! The frame of the workpiece is R at the zero position, carried by the last link of the workpiece branch. The tool is a
//! tip and a direction from the tip into the spindle (the i j k of five-axis programs).
//!
//! Three slides and two turns, in any order and inclined as they like, are solved in closed form: with component errors
//! held still the tool's direction is `d = R(k1, q1)·R(k2, q2)·d0`, which has two solutions at most (Paden and Kahan's
//! second subproblem, as in Murray, Li, Sastry, *Robotic Manipulation*, section 3.3), and the tip is linear in the slides.
//! The component errors are then those of the positions found, until nothing changes. Other chains are searched from many
//! starts.

mod kinematics;
mod search;
mod solve;
mod turns;

pub use kinematics::{AxisInWorkpiece, Kinematics, Tool, ToolPose};
pub use solve::{Inverse, InverseError, Reach, Solution, Target};
