//! Why claims cannot be compared.

use crate::methods::MethodError;
use crate::session::MotionError;
use crate::simulate::SimulateError;

/// Why claims cannot be compared.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ReconcileError {
    #[error("one result alone cannot disagree; name two or more files")]
    One,
    #[error("'{claim}': {reason}")]
    Design { claim: String, reason: String },
    #[error(
        "'{first}' is of the machine '{first_machine}' and '{claim}' of '{machine}': results of one machine are compared; give its machine files one name and the same axes"
    )]
    TwoMachines { first: String, first_machine: String, claim: String, machine: String },
    #[error("{method} does not tell {error}; state what the method gives, or method: fit")]
    NotOfTheMethod { error: String, method: String },
    #[error("no error is stated by two of the results; there is nothing to compare")]
    NothingInCommon,
    #[error("the uncertainties of the stated errors are not independent enough to compare; state fewer errors")]
    Covariance,
    #[error(transparent)]
    Method(#[from] MethodError),
    #[error(transparent)]
    Motion(#[from] MotionError),
    #[error(transparent)]
    Simulate(#[from] SimulateError),
}
