//! Why no plan was made.

use super::method::MethodError;
use crate::plan::reach::out_of_reach::OutOfReach;

/// Why the spindle's index does not help.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum IndexError {
    #[error("--index-spindle: the machine file has no 'spindle'; add its link, nose and direction")]
    NoSpindle,
    #[error(
        "--index-spindle: with all axes at zero the spindle points along ({x:.4}, {y:.4}, {z:.4}), none of R's directions; a session states the index about x, y or z only"
    )]
    Inclined { x: f64, y: f64, z: f64 },
}

/// Why no plan was made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlanError {
    #[error("{0}")]
    Bodies(String),
    #[error("{0}")]
    Method(#[from] MethodError),
    #[error("{0}")]
    Index(#[from] IndexError),
    #[error("{0}")]
    OutOfReach(#[from] OutOfReach),
}
