//! Finds the physics that a fit left out: where, what, how much, how sure. It simulates through the same effects as every other room.
//!
//! To first order every effect adds columns `∂L/∂outlet · function` to the linear model of a fit. The search whitens
//! data and columns by the noise, projects out location errors, ball places and bars with their priors, and asks which
//! few blocks of columns the evidence demands; what is accepted joins the model and the question is asked again.

mod cause;
mod fault_kind;
mod findings;
mod model;
mod noise;
mod preflight;
mod selection;
mod thresholds;
mod validation;
mod verdict;

pub use cause::Cause;
pub(crate) use cause::MOST_RIVALS;
pub use fault_kind::FaultKind;
pub use findings::finding::{Finding, NextTest, RangeFound, SizeFound};
pub(crate) use findings::grouping::ONE_JUMP_S;
pub use model::long_recordings::{Averaged, MOST_ROWS, lean};
pub use noise::pose_noise::Left;
pub use preflight::data_fault::{DataFault, Rival};
pub use preflight::examine::{Examination, examine};
pub use thresholds::{Threshold, Thresholds};
pub use validation::cross_validation::CrossValidation;
pub(crate) use validation::detection_limits::AXIS_SENSE;
pub use validation::detection_limits::Unseen;
pub use validation::leave_setup_out::LeftOutSetup;
pub use validation::sign_randomisation::SignRandomisation;
pub use validation::uncovering::UncoveringTest;
pub use verdict::claims::Verdict;
pub use verdict::diagnosed_session::as_found;
pub use verdict::diagnosis::{DiagnoseError, Diagnosis, TestBeforeAfter};
pub(crate) use verdict::location_errors::MOVED_SIGMAS;
pub use verdict::location_errors::{HangsOn, Moved};
pub use verdict::shares::{ShareOfReadings, Source};

// Parts of the search that only `tests/diagnose_parts.rs` uses, beside this room: it compares each with what it stands for.
pub use model::last_shape::LastShape;
pub use model::linear_model::{Column, LinearModel, Term};
pub use model::regression::{Accepted, Regression};
pub use model::whitened::WhitenedData;
pub use noise::noise_floor::noise_floor;
pub use selection::screening::candidates::{families, terms};
pub use validation::cross_validation::{CHUNK_S, held_out_rows};

use self::findings::proposals::Layout;
use self::findings::standing::Standing;
use self::model::prior_penalty::{WIDER_SETUPS, fitted_anyway};
use self::noise::noise_floor::mean_noise_mm2;
use self::preflight::contradictions::further_contradiction;
use self::preflight::doubts::{displaced, known_too_well, strained, too_few};
use self::preflight::examine::examined;
use self::preflight::mistake_or_effect::{Doubt, Held, held_against_physics};
use self::preflight::quick_fit::strain;
use self::preflight::small_misfit::{Misfit, Preflight};
use self::preflight::unchanging::unchanging;
use self::selection::hidden_outliers::without_hidden_outliers;
use self::selection::joint_fit::mean_square;
use self::selection::naming::cause as named;
use self::selection::search::{floors, nothing, search_cleanly};
use self::selection::selected::{Resolutions, Search};
use self::selection::two_resolutions::at_two_resolutions;
use self::validation::detection_limits::{unseen_causes, unseen_senses};
use self::validation::hidden_shifts::hidden_shifts;
use self::validation::linear_axes::leave_to_linear_axes;
use self::validation::uncovering::uncovering_tests;
use self::verdict::explanation::explain;
use self::verdict::shift_of_one_test::shift_of_one_test;
use crate::chain::Chain;
use crate::effects::{CandidateFamily, Context};
use crate::identify::{self, Fit, Options, Problem};
use crate::session::{Session, Setups};

/// Diagnoses a session.
pub fn diagnose(session: &Session, options: &Options) -> Result<Diagnosis, DiagnoseError> {
    diagnose_with(session, options, Thresholds::default())
}

/// The same with other numbers that decide: to see what each of them earns.
pub fn diagnose_with(session: &Session, options: &Options, thresholds: Thresholds) -> Result<Diagnosis, DiagnoseError> {
    let examination = examined(session, options)?;
    if !examination.is_sound() {
        return Ok(Diagnosis::of_examination(examination));
    }
    let chain = Chain::of(&session.machine);
    let setups = Setups::of(session);
    let problem = Problem::new(session, &chain, &setups, fitted_anyway(session, options, &setups))?;
    let fit = identify::fit(&problem)?;
    let context = Context::of(session, &chain)?;
    let mut fine = LinearModel::new(&context, &problem, &fit.values(), fit.kept_rows());
    fine.thresholds = thresholds;
    let stated_mm = examination.fit.as_ref().map_or(0.0, |fit| fit.rms_mm);
    let examined = Examined { setups: &setups, preflight: &Preflight::of(session), stated_mm };
    let diagnosis = diagnosed(fine, options, examined, fit, Outliers::MayHide)?;
    let warnings = [examination.warnings, diagnosis.warnings].concat();
    let diagnosis = Diagnosis { warnings, ..diagnosis };
    // where nothing was found, nothing else explains what a ball or bar makes up for, or that too little changes
    let doubt = match diagnosis.verdict {
        Verdict::DataFault => None,
        Verdict::Clean => examination
            .fit
            .as_ref()
            .and_then(|fit| strained(fit).or_else(|| displaced(fit)).or_else(|| too_few(fit)))
            .or_else(|| unchanging(session)),
        _ => examination.fit.as_ref().and_then(too_few).or_else(|| unchanging(session)),
    };
    let doubt = doubt.or_else(|| known_too_well(session).filter(|_| diagnosis.verdict != Verdict::DataFault));
    Ok(match doubt {
        None => diagnosis,
        Some(reason) if diagnosis.verdict == Verdict::Clean => diagnosis.not_to_be_judged(reason),
        Some(warning) => diagnosis.with_nothing_determined(warning),
    })
}

/// What is known of a session before physics is looked for.
#[derive(Clone, Copy)]
struct Examined<'s> {
    setups: &'s Setups,
    preflight: &'s Preflight<'s>,
    /// Rms that a fit with the spreads as stated leaves, mm.
    stated_mm: f64,
}

/// Whether outliers may hide under what is found.
#[derive(Clone, Copy, PartialEq)]
enum Outliers {
    MayHide,
    /// Those that did were left out.
    LeftOut,
}

/// Diagnoses what a fit leaves of a session.
fn diagnosed(
    fine: LinearModel,
    options: &Options,
    examined: Examined<'_>,
    fit: Fit,
    outliers: Outliers,
) -> Result<Diagnosis, DiagnoseError> {
    at_two_resolutions(fine, |resolutions, families| searched(resolutions, families, options, examined, fit, outliers))?
}

/// The cause of the first effect that a search found, with its share of what that may be.
fn first_cause(fine: &LinearModel, families: &[CandidateFamily], search: &Search) -> Option<(Cause, f64)> {
    let first = search.found.first()?;
    let share = Standing::of(fine, families, first).probability;
    Some((named(fine.context.machine(), &first.chosen, &[]), share))
}

/// The mistake to tell, where physics would have its likeliest cause with its share, and the doubt that is left where none is told.
fn told_of(held: Held, physics: Option<(Cause, f64)>, session: &Session) -> (Option<DataFault>, Option<Doubt>) {
    let is_surer = held.is_likelier_than_physics();
    match held.against(physics) {
        Ok(told) if is_surer => (told, None),
        Ok(told) => (further_contradiction(session).or(told), None),
        Err(doubt) => (further_contradiction(session), Some(doubt)),
    }
}

fn searched(
    resolutions: &Resolutions,
    families: &[CandidateFamily],
    options: &Options,
    examined: Examined<'_>,
    fit: Fit,
    outliers: Outliers,
) -> Result<Diagnosis, DiagnoseError> {
    let Resolutions { fine, coarse, .. } = *resolutions;
    let (problem, session, values) = (fine.problem, fine.context.session(), fit.values());
    let floors = floors(resolutions);
    let noise_um = 1e3 * mean_noise_mm2(&floors[0]).sqrt();

    let misfit = Misfit {
        // what wider spreads take up may be a mistake as well
        residual_um: 1e3 * fit.rms_mm.max(examined.stated_mm),
        noise_um,
        left_out_share: fit.left_out_share(),
        strain: strain(problem, &values, WIDER_SETUPS),
    };
    // the mistakes known here are those of lengths between balls
    let is_of_lengths = !session.has_parts();
    let mut contested = if is_of_lengths { examined.preflight.mistakes(misfit) } else { Vec::new() };
    let certain = match contested.first() {
        None if !is_of_lengths => None,
        Some(mistake) if !mistake.may_be_physics() => Some(mistake.fault.clone()),
        Some(mistake) if mistake.is_plain => None,
        _ => further_contradiction(session),
    };
    let cleaner = |left_mm: &[Vec<f64>]| match outliers {
        Outliers::MayHide => without_hidden_outliers(problem, &fit, left_mm),
        Outliers::LeftOut => None,
    };
    let search = match certain {
        Some(_) => Ok(nothing(fine, &floors[0])),
        None => search_cleanly(resolutions, &floors, families, cleaner),
    };
    let mut search = match search {
        Ok(search) => search,
        Err(cleaner) => {
            let fine = fine.with_rows(cleaner.kept_rows());
            return diagnosed(fine, options, examined, *cleaner, Outliers::LeftOut);
        }
    };
    let left_um = (1e3 * mean_square(fine, &search.residual_mm).sqrt()).max(fine.thresholds.explained * noise_um);
    contested.retain(|mistake| certain.is_none() && mistake.leaves_as_little(left_um));
    let (fault, doubt) = match contested.is_empty() {
        false => {
            let physics = first_cause(fine, families, &search);
            let held = held_against_physics(session, options, fine, contested)?;
            told_of(held, physics, session)
        }
        true => (certain, None),
    };
    let fault = fault.or_else(|| shift_of_one_test(&search));
    if fault.is_some() {
        search = nothing(fine, &floors[0]);
    }

    let mut warnings = leave_to_linear_axes(fine, &mut search);
    let layout =
        Layout { session: coarse.context.session(), problem, values: &values, kept: &coarse.kept, noise: &floors[1] };
    let explanation = explain(resolutions, &floors, families, &mut search, &layout, fault.is_some());
    // a wrong sense makes all numbers wrong: it stands first
    let mut blind_to = unseen_senses(session, &fit)?;
    let regression = Regression::new(coarse, &floors[1], &[], &coarse.kept);
    let hidden = unseen_causes(coarse, families, |columns| regression.information(columns));
    let shifts = hidden_shifts(&regression, &hidden, blind_to.len());
    blind_to.extend(hidden.into_iter().filter(|hidden| hidden.matters).map(|hidden| hidden.unseen));
    let uncovered_by = uncovering_tests(&layout, &blind_to);
    let mut diagnosis =
        Diagnosis::of((fine, families), examined.setups, &fit, &search, explanation, fault, (blind_to, &shifts));
    if let Some(doubt) = doubt.filter(|_| !diagnosis.findings.is_empty()) {
        diagnosis.leave_to_a_mistake(doubt.probability);
        warnings.push(doubt.warning());
    }
    warnings.append(&mut diagnosis.warnings);
    Ok(Diagnosis { uncovered_by, warnings, ..diagnosis })
}
