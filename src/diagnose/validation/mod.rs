//! What stands for or against findings: held-out readings, randomised signs, set-ups left out, and what the design cannot show.

pub(crate) mod cross_validation;
pub(crate) mod detection_limits;
pub(crate) mod hidden_shifts;
pub(crate) mod leave_setup_out;
pub(crate) mod linear_axes;
pub(crate) mod sign_randomisation;
pub(crate) mod uncovering;
