//! A fit looked at before it is believed: contradictions in the files, wrong set-ups, readings that cannot be judged. Physics is for `diagnose`.

use super::contradictions::{contradiction, further_contradiction};
use super::data_fault::DataFault;
use super::doubts::{left_out_share, misfit, repeats_um, unjudged, warnings};
use super::gross_misfit::contest;
use super::places::frames::{instrument_moved, mistaken_columns};
use super::quick_fit::strain;
use super::small_misfit::preflight;
use crate::chain::Chain;
use crate::diagnose::model::linear_model::LinearModel;
use crate::diagnose::noise::noise_floor::{mean_noise_mm2, noise_floor};
use crate::effects::Context;
use crate::identify::{self, Fit, FitError, Options, Problem};
use crate::session::{Session, Setups};

/// What stands against believing a fit.
#[derive(Debug, Clone)]
pub struct Examination {
    /// The fit; it claims nothing to be determined where a mistake was found or the readings cannot be judged. `None` where
    /// there is no fit at all.
    pub fit: Option<Fit>,
    /// A mistake in the files.
    pub fault: Option<DataFault>,
    /// Why the readings cannot be judged, where no mistake says it.
    pub unjudged: Option<String>,
    pub warnings: Vec<String>,
    /// Noise from row to row, µm; `None` for static poses.
    pub repeats_um: Option<f64>,
    /// Share of readings left out as gross outliers.
    pub left_out_share: f64,
}

impl Examination {
    /// Of a session that no fit was made of.
    pub(crate) fn without_fit(fault: DataFault) -> Examination {
        Examination {
            fit: None,
            fault: Some(fault),
            unjudged: None,
            warnings: Vec::new(),
            repeats_um: None,
            left_out_share: 0.0,
        }
    }

    /// Nothing stands against the fit.
    pub fn is_sound(&self) -> bool {
        self.fault.is_none() && self.unjudged.is_none()
    }

    /// Why nothing is determined, in words.
    pub fn says(&self) -> Option<&str> {
        self.fault.as_ref().map(|fault| fault.says.as_str()).or(self.unjudged.as_deref())
    }
}

/// Fits a session and looks for what stands against believing the fit.
pub fn examine(session: &Session, options: &Options) -> Result<Examination, FitError> {
    let mut examination = examined(session, options)?;
    if examination.is_sound() {
        examination.fault = mistaken_unless_sound(session, &examination)?;
    }
    if !examination.is_sound() {
        examination.fit.iter_mut().for_each(Fit::claim_nothing);
    }
    Ok(examination)
}

/// The parts that need no search: what a diagnosis asks before it looks for physics.
pub(crate) fn examined(session: &Session, options: &Options) -> Result<Examination, FitError> {
    let fit = match identify::identify(session, options) {
        Ok(fit) => Some(fit),
        Err(FitError::NoConvergence) => None,
        Err(why) => return Err(why),
    };
    let misfit = match &fit {
        Some(fit) => misfit(session, fit),
        None => Some("no place of the axes explains the readings: the fit did not converge".to_string()),
    };
    let noisy = fit.as_ref().and_then(|fit| unjudged(session, fit));
    let repeats_um = fit.as_ref().and_then(|fit| repeats_um(session, fit));
    // the mistakes known here are those of lengths between balls
    let mut fault = if session.has_parts() { None } else { contradiction(session) };
    if session.has_parts() {
        fault = match (&misfit, &fit) {
            (None, Some(fit)) => instrument_moved(session, fit),
            _ => mistaken_columns(session),
        };
    }
    if fault.is_none() && !session.has_parts() && noisy.is_none() && misfit.is_some() {
        fault = contest(session).or_else(|| further_contradiction(session));
    }
    let unknown = "; no mistake that is known explains it: check machine file, ball places, bars and which recording \
                   belongs to which test";
    let unjudged = noisy.or(misfit.map(|misfit| misfit + unknown)).filter(|_| fault.is_none());
    Ok(Examination {
        fault,
        unjudged,
        warnings: fit.as_ref().map(warnings).unwrap_or_default(),
        repeats_um,
        left_out_share: fit.as_ref().map_or(0.0, left_out_share),
        fit,
    })
}

/// A mistake behind a residual that is far above the noise floor, or an arc, direction or speed that is not its test's.
fn mistaken_unless_sound(session: &Session, examination: &Examination) -> Result<Option<DataFault>, FitError> {
    let Some(fit) = examination.fit.as_ref().filter(|_| !session.has_parts()) else { return Ok(None) };
    let chain = Chain::of(&session.machine);
    let setups = Setups::of(session);
    let problem = Problem::new(session, &chain, &setups, fit.unknowns.clone())?;
    let values = fit.values();
    let context = Context::of(session, &chain)?;
    let model = LinearModel::new(&context, &problem, &values, fit.kept_rows());
    let noise_um = 1e3 * mean_noise_mm2(&noise_floor(&model, &model.residual_mm)).sqrt();
    let strain = strain(&problem, &values, 1.0);
    let found = preflight(session, 1e3 * fit.rms_mm, noise_um, examination.left_out_share, strain);
    // the shift of one test's clock may be a slip: only a diagnosis tells
    Ok(found.filter(|fault| !fault.is_shift_of_single_tests()).or_else(|| further_contradiction(session)))
}
