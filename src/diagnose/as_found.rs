//! A session as diagnosed: effects in its machine, errors and places of balls and bars fitted beside them. It searches nothing.

use super::{DiagnoseError, Diagnosis};
use crate::chain::Chain;
use crate::identify::{self, Problem, fitted_session};
use crate::session::{Session, Setups};

/// The session whose simulation predicts its recordings.
///
/// Effects were found with first-order columns. Here they act through the exact model at the sizes found, and location
/// errors, ball places and bars are fitted once more beside them, so that what is second order in an effect does not
/// stay in the prediction.
pub fn as_found(session: &Session, diagnosis: &Diagnosis) -> Result<Session, DiagnoseError> {
    let mut explained = session.clone();
    explained.machine.effects.extend(diagnosis.effects());
    let chain = Chain::of(&explained.machine);
    let setups = Setups::of(&explained);
    let problem = Problem::new(&explained, &chain, &setups, diagnosis.unknowns.clone())?;
    let fit = identify::fit(&problem)?;
    Ok(fitted_session(&explained, &fit))
}
