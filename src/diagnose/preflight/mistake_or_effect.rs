//! Whether a mistake in the files explains a session, or physics of the machine, by the evidence of both. It looks for no mistake.
//!
//! The session is searched for effects as it was recorded, and as it would be without the mistake, on the same few rows. What
//! either search says of the readings is compared: log likelihood with its own noise, less what forms, amplitudes and the
//! choice among mistakes cost.

use super::data_fault::DataFault;
use super::small_misfit::Mistake;
use crate::chain::Chain;
use crate::diagnose::cause::{Cause, LEAST_PROBABILITY};
use crate::diagnose::model::decimate::few_rows;
use crate::diagnose::model::linear_model::LinearModel;
use crate::diagnose::model::prior_penalty::fitted_anyway;
use crate::diagnose::model::regression::Regression;
use crate::diagnose::selection::naming::cause;
use crate::diagnose::selection::search::{floors, search, search_from};
use crate::diagnose::selection::selected::{Search, SelectedEffect};
use crate::diagnose::selection::two_resolutions::at_two_resolutions;
use crate::diagnose::thresholds::Thresholds;
use crate::effects::Context;
use crate::identify::{self, FitError, Options, Problem};
use crate::session::{Session, Setups};
use crate::statistics::{NoiseModel, log_determinant, probability_of};
use nalgebra::Cholesky;

/// Log likelihood of a reading that a fit leaves out as gross, less the constant of normal densities in mm: one in two hundred
/// is, and then it lies anywhere within a millimetre (−5.3 + 0.9).
const LEFT_OUT: f64 = -4.4;

/// What a mistake held against physics came to.
pub(crate) struct Held {
    /// The mistake; `None` where nothing speaks for it.
    fault: Option<DataFault>,
    /// Its probability, physics being the rest.
    probability: f64,
    /// The first effect that physics would be.
    cause: Option<Cause>,
}

impl Held {
    fn sure(fault: Option<DataFault>) -> Held {
        let probability = if fault.is_some() { 1.0 } else { 0.0 };
        Held { fault, probability, cause: None }
    }

    /// Whether the mistake is likelier than all physics.
    pub(crate) fn is_likelier_than_physics(&self) -> bool {
        self.probability >= 0.5
    }

    /// The mistake with what else may be the cause, where it is likelier than a cause that has this share of physics; else what it leaves
    /// to doubt.
    pub(crate) fn against(self, share: f64) -> Result<Option<DataFault>, Doubt> {
        let Held { fault: Some(fault), probability, cause } = self else { return Ok(None) };
        if probability >= (1.0 - probability) * share {
            return Ok(Some(fault.or_effect(probability, cause.map(|cause| (cause, share)))));
        }
        let is_worth_a_word = probability >= LEAST_PROBABILITY && cause.is_some();
        if is_worth_a_word { Err(Doubt { probability, says: fault.says }) } else { Ok(None) }
    }
}

/// A mistake in the files that is less likely than physics.
pub(crate) struct Doubt {
    pub(crate) probability: f64,
    says: String,
}

impl Doubt {
    /// In words, with what to do.
    pub(crate) fn warning(&self) -> String {
        format!("a mistake in the files may be the cause instead ({:.0} %): {}", 100.0 * self.probability, self.says)
    }
}

/// A mistake held against physics.
pub(crate) fn held_against_physics(
    session: &Session,
    options: &Options,
    thresholds: Thresholds,
    mistake: Mistake,
) -> Result<Held, FitError> {
    if !mistake.may_be_physics() {
        return Ok(Held::sure(Some(mistake.fault)));
    }
    let Mistake { fault, undone, log_odds, .. } = mistake;
    let recorded = read_in_both(&few_rows(session), &undone);
    if rows(&recorded) != rows(&undone) {
        return Ok(Held::sure(Some(fault)));
    }
    // what has no fit is no explanation
    let Some(corrected) = explained(&undone, options, thresholds, &[])? else { return Ok(Held::sure(None)) };
    // one search may find what another passes over: what both may be said of is no gain of the mistake
    let is_same_machine = session.machine.axes == undone.machine.axes;
    let elsewhere = if is_same_machine { &corrected.found[..] } else { &[] };
    let recorded = explained(&recorded, options, thresholds, elsewhere)?;
    let Some(recorded) = recorded else { return Ok(Held::sure(Some(fault))) };
    let gained = corrected.standing - recorded.standing;
    // as of a first effect: noise that wanders looks like much
    if recorded.cause.is_none() && gained < thresholds.accept {
        return Ok(Held::sure(None));
    }
    let probability = probability_of(gained + log_odds);
    Ok(Held { fault: Some(fault), probability, cause: recorded.cause })
}

/// The session with the readings that another one has as well.
fn read_in_both(session: &Session, other: &Session) -> Session {
    let mut both = session.clone();
    for (test, other) in both.tests.iter_mut().zip(&other.tests) {
        let (Some(recording), Some(other)) = (&mut test.recording, &other.recording) else { continue };
        for (length, other) in recording.length_mm.iter_mut().zip(&other.length_mm) {
            if !other.is_finite() {
                *length = f64::NAN;
            }
        }
    }
    both
}

/// Rows of each test.
fn rows(session: &Session) -> Vec<usize> {
    session.tests.iter().map(|test| test.recording.as_ref().map_or(0, |recording| recording.length_mm.len())).collect()
}

/// What a search says of a session.
struct Explained {
    /// Log evidence.
    standing: f64,
    /// The first effect found.
    cause: Option<Cause>,
    found: Vec<SelectedEffect>,
}

/// What a search says, or one beside effects that were found elsewhere where that says more.
fn explained(
    session: &Session,
    options: &Options,
    thresholds: Thresholds,
    elsewhere: &[SelectedEffect],
) -> Result<Option<Explained>, FitError> {
    let chain = Chain::of(&session.machine);
    let setups = Setups::of(session);
    let problem = Problem::new(session, &chain, &setups, fitted_anyway(session, options, &setups))?;
    let fit = match identify::fit(&problem) {
        Ok(fit) => fit,
        Err(FitError::NoConvergence) => return Ok(None),
        Err(why) => return Err(why),
    };
    let context = Context::of(session, &chain)?;
    let mut model = LinearModel::new(&context, &problem, &fit.values(), fit.kept_rows());
    model.thresholds = thresholds;
    let explained = at_two_resolutions(model, |resolutions, families| {
        let floors = floors(resolutions);
        let own = search(resolutions, &floors, families);
        let others = (!elsewhere.is_empty()).then(|| search_from(resolutions, &floors, families, elsewhere));
        let standing = |found: &Search| {
            let room = room_for_unknowns(resolutions.fine, &found.noise_after);
            found.standing(resolutions.fine) + room + LEFT_OUT * fit.left_out() as f64
        };
        let sets = std::iter::once(own).chain(others).map(|set| (standing(&set), set));
        let (standing, found) = sets.reduce(|best, next| if next.0 > best.0 { next } else { best })?;
        let cause = found.found.first().map(|found| cause(&session.machine, &found.chosen, &[]));
        Some(Explained { standing, cause, found: found.found })
    });
    Ok(explained?)
}

/// Logarithm of the share of what was thought possible of location errors, balls and bars that the readings leave: a ball of its
/// own explains much because it may stand anywhere.
fn room_for_unknowns(model: &LinearModel, noise: &[NoiseModel]) -> f64 {
    let covariance = Regression::new(model, noise, &[], &model.kept).covariance();
    0.5 * Cholesky::new(covariance).map_or(0.0, |factor| log_determinant(&factor))
}
