//! Why a method cannot be applied to a session.

use super::thesis_value::ThesisMethod;
use crate::session::MotionError;

/// Why a method cannot be applied to a session.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MethodError {
    /// The machine is not of the kind whose formulas these are.
    #[error("the thesis's formulas do not hold for {code}: {reason}; use the fit (leave --method out)")]
    Machine { code: String, reason: String },
    /// A test of the design is not in the session.
    #[error("{method} needs {wanted}; the session has {found}. Record the missing test, or leave --method out")]
    MissingTest { method: ThesisMethod, wanted: String, found: String },
    /// A test is there but cannot be used.
    #[error("test '{test}' {reason}")]
    Test { test: String, reason: String },
    #[error(transparent)]
    Motion(#[from] MotionError),
}
