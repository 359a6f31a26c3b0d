//! Why a fit was not possible.

use crate::effects::EffectError;
use crate::session::MotionError;

/// Why a fit was not possible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FitError {
    #[error(transparent)]
    Motion(#[from] MotionError),
    #[error(transparent)]
    Effect(#[from] EffectError),
    #[error("the session has no recording; record its tests first, or use 'fiveaxis simulate' to make some")]
    NoRecording,
    #[error("the fit did not converge; check ball places, bar lengths and the signs of the axes in the session")]
    NoConvergence,
    #[error(
        "test '{test}' has component errors or effects, which a fit of constant errors leaves out; use the general fit"
    )]
    NotConstant { test: String },
    #[error("errors of the linear axes are left out by a fit of constant errors; use the general fit")]
    LinearAxes,
    #[error("the recordings do not determine {unknown}, alone or beside the unknowns before it; give it a prior")]
    Undetermined { unknown: String },
    #[error("only {readings} readings for {unknowns} unknowns; record more or free fewer errors")]
    TooFew { readings: usize, unknowns: usize },
}
