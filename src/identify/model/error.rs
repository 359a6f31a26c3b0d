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
    #[error(
        "the session has no recording; record its tests first, or let 'fiveaxis simulate' write some into the session's own folder (--out)"
    )]
    NoRecording,
    #[error("the fit did not converge; check ball places, bar lengths and the signs of the axes in the session")]
    NoConvergence,
    #[error("only {readings} readings for {unknowns} unknowns; record more or free fewer errors")]
    TooFew { readings: usize, unknowns: usize },
}
