//! A fit looked at before it is believed: contradictions in the files, wrong set-ups, readings that cannot be judged. Physics is for `diagnose`.

use super::contradictions::{contradiction, copied_rows, further_contradiction};
use super::data_fault::{DataFault, RECORDER};
use super::doubts::{displaced, known_too_well, left_over, misfit, repeats_um, strained, too_few, unjudged, warnings};
use super::gross_misfit::contest;
use super::mistake_or_effect::held_against_physics;
use super::places::frames::moved;
use super::places::standing::a_little_elsewhere;
use super::quick_fit::{refit, robust_rms_mm, strain};
use super::readings::columns::{
    coordinates_held_otherwise, coordinates_in_metres, coordinates_too_fine, mistaken_columns, mistaken_gauge,
    sense_of_coordinates,
};
use super::readings::scaled::held_otherwise;
use super::small_misfit::{Misfit, Preflight};
use super::unchanging::unchanging;
use crate::chain::Chain;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::model::decimate::few_rows;
use crate::diagnose::model::linear_model::LinearModel;
use crate::diagnose::noise::noise_floor::{mean_noise_mm2, noise_floor};
use crate::effects::Context;
use crate::identify::{self, Fit, FitError, Options, Problem, Quantity, Unknown};
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
    /// The fit stands, but something beside it is so far from what the files say that nothing is claimed; the warnings say what.
    pub is_doubtful: bool,
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
            is_doubtful: false,
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
        examination.fault = mistaken_unless_sound(session, options, &examination)?;
    }
    let sound = examination.fit.as_ref().filter(|_| examination.is_sound());
    let doubts: Vec<String> = sound
        .iter()
        .flat_map(|fit| {
            left_over(session, fit)
                .into_iter()
                .chain(strained(fit))
                .chain(displaced(fit))
                .chain(unchanging(session))
                .chain(too_few(fit))
                .chain(known_too_well(session))
        })
        .collect();
    if !doubts.is_empty() {
        examination.fit.iter_mut().for_each(Fit::claim_nothing);
        examination.warnings.extend(doubts);
        examination.is_doubtful = true;
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
    let mut fault = if session.has_parts() { copied_rows(session) } else { contradiction(session) };
    if session.has_parts() && fault.is_none() {
        fault = misfit.as_ref().and_then(|_| mistaken_columns(session)).or_else(|| mistaken_gauge(session));
        fault = fault.or_else(|| coordinates_held_otherwise(session));
        // what moved puts rotations off, which tell whether coordinates are in metres
        fault = fault.or_else(|| moved(session, options, fit.as_ref()?));
        fault = fault.or_else(|| coordinates_in_metres(session, fit.as_ref()?));
        fault = fault.or_else(|| coordinates_too_fine(session, fit.as_ref()?));
    }
    if fault.is_none() && !session.has_parts() && noisy.is_none() && misfit.is_some() {
        let gross = contest(session).map(|fault| match repeats_um {
            Some(noise_um) => fault.less_what_it_leaves(noise_um),
            None => fault,
        });
        fault = gross.or_else(|| further_contradiction(session));
    }
    let mut warnings: Vec<String> = fit.iter().flat_map(warnings).collect();
    if fault.is_none() && misfit.is_none() && noisy.is_none() {
        match sense_of_readings(session) {
            Sense::Told => {}
            Sense::Open => warnings.push(SENSE_OPEN.into()),
            Sense::Perhaps(why) => warnings.push(why),
            Sense::Wrong(turned) => fault = Some(turned),
        }
        warnings.extend(sense_of_coordinates(session));
    }
    let unknown = "; no mistake that is known explains it: check machine file, ball places, bars and which recording \
                   belongs to which test";
    let unjudged = noisy.or(misfit.map(|misfit| misfit + unknown)).filter(|_| fault.is_none());
    Ok(Examination {
        fault,
        unjudged,
        warnings,
        is_doubtful: false,
        repeats_um,
        left_out_share: fit.as_ref().map_or(0.0, Fit::left_out_share),
        fit,
    })
}

/// Misfits that differ by less, as a share, say the same.
const SAME_MISFIT_SHARE: f64 = 0.05;

/// Squared offsets of balls, bars and location errors in their spreads by which one sense of the readings is told from the
/// other: five standard deviations.
const LEAST_CHI2_OF_A_SENSE: f64 = 25.0;

/// A fit of readings held in one way.
#[derive(Clone, Copy)]
struct HeldSo {
    /// Robust misfit, µm.
    left_um: f64,
    /// Squared offsets in their spreads: of balls and bars, and of bars alone.
    of_all: f64,
    of_bars: f64,
}

/// What readings held otherwise would do.
enum Sense {
    Told,
    /// Turned they would fit as well, and every error would come out with the other sign.
    Open,
    /// Bars would then have their lengths; a slide's scale may do as much where it stands.
    Perhaps(String),
    /// They fit as well with balls and bars where the session puts them.
    Wrong(DataFault),
}

/// Whether offsets of balls and bars say how the readings are held, where no residual does.
fn sense_of_readings(session: &Session) -> Sense {
    let others = held_otherwise(session);
    let of = |session: &Session| {
        let refitted = refit(&few_rows(session), None)?;
        let left_um = 1e3 * robust_rms_mm(&refitted.residual_mm);
        let squares = |of_bars: bool| -> f64 {
            let of = |unknown: &Unknown| {
                let is_bar = matches!(unknown.quantity, Quantity::Bar { .. });
                unknown.quantity.is_setup() && (is_bar || !of_bars)
            };
            let offsets = refitted.unknowns.iter().zip(&refitted.values).filter(|(unknown, _)| of(unknown));
            offsets.map(|(unknown, value)| ((value - unknown.prior_mean) / unknown.prior_sigma).powi(2)).sum()
        };
        Some(HeldSo { left_um, of_all: squares(false), of_bars: squares(true) })
    };
    let Some(now) = of(session).filter(|_| !others.is_empty()) else { return Sense::Told };
    let judged = others.into_iter().filter_map(|other| {
        let then = of(&other.session)?;
        // another zero concerns the bars alone, and brings each of them back
        let is_sign = other.kind == FaultKind::ReadingSign;
        let less = match other.kind {
            // what software took off each recording, balls make up for as well as bars
            FaultKind::ReadingSign | FaultKind::ReadingsProcessed => now.of_all - then.of_all,
            _ => now.of_bars - then.of_bars,
        };
        // with the sign turned back bars have their lengths as well: else a bar is another than stated
        let back = if is_sign { BACK_OF_SIGN } else { BACK_AGAIN };
        let is_back = then.of_bars < back * bars(&other.session) as f64;
        (is_back && then.left_um < (1.0 + SAME_MISFIT_SHARE) * now.left_um).then_some((less, then.left_um, other))
    });
    match judged.max_by(|one, other| one.0.total_cmp(&other.0)) {
        Some((less, _, other)) if less > LEAST_CHI2_OF_A_SENSE && other.kind == FaultKind::ReadingZero => {
            Sense::Perhaps(format!("bars are off in all tests as if {}", other.says))
        }
        Some((less, _, other))
            if less > LEAST_CHI2_OF_A_SENSE
                && let Some(stood) = stood_instead(session, &of, now, less) =>
        {
            Sense::Perhaps(format!("balls and bars are off as if {}, or {stood}", other.says))
        }
        Some((less, after_um, other)) if less > LEAST_CHI2_OF_A_SENSE => Sense::Wrong(DataFault {
            components: vec!["length".into()],
            before_um: now.left_um,
            after_um,
            ..DataFault::seen(other.kind, RECORDER, Vec::new(), other.says)
        }),
        Some((less, _, other)) if less > -LEAST_CHI2_OF_A_SENSE && other.kind == FaultKind::ReadingSign => Sense::Open,
        _ => Sense::Told,
    }
}

/// An axis that stood a little elsewhere, in words, if that brings balls and bars as near to their places: by squares `less`.
fn stood_instead(
    session: &Session,
    of: &impl Fn(&Session) -> Option<HeldSo>,
    now: HeldSo,
    less: f64,
) -> Option<String> {
    let every: Vec<usize> = (0..session.tests.len()).collect();
    a_little_elsewhere(session, &every, &[]).into_iter().find_map(|stood| {
        let then = of(&stood.undone)?;
        let does = now.of_all - then.of_all > less - LEAST_CHI2_OF_A_SENSE
            && then.left_um < (1.0 + SAME_MISFIT_SHARE) * now.left_um;
        does.then_some(stood.says)
    })
}

/// Mean squared offset of the bars, in their spreads, with which they are where they were stated to be: two spreads each.
const BACK_AGAIN: f64 = 4.0;

/// The same where only a sign is in question, which no other place of a bar looks like: three spreads each.
const BACK_OF_SIGN: f64 = 9.0;

/// Number of bars with a length and a zero of their own.
fn bars(session: &Session) -> usize {
    let of = &Setups::of(session).bar_of;
    of.iter().flatten().collect::<std::collections::BTreeSet<_>>().len()
}

const SENSE_OPEN: &str = "these tests do not tell the sense of the readings: with all deviations turned they fit as well, and \
    every error has the other sign; lengthen the bar by hand and look whether the reading rises";

/// A mistake behind a residual that is far above the noise floor, or an arc, direction or speed that is not its test's.
fn mistaken_unless_sound(
    session: &Session,
    options: &Options,
    examination: &Examination,
) -> Result<Option<DataFault>, FitError> {
    let Some(fit) = examination.fit.as_ref().filter(|_| !session.has_parts()) else { return Ok(None) };
    let chain = Chain::of(&session.machine);
    let setups = Setups::of(session);
    let problem = Problem::new(session, &chain, &setups, fit.unknowns.clone())?;
    let values = fit.values();
    let context = Context::of(session, &chain)?;
    let model = LinearModel::new(&context, &problem, &values, fit.kept_rows());
    let noise_um = 1e3 * mean_noise_mm2(&noise_floor(&model, &model.residual_mm)).sqrt();
    let misfit = Misfit {
        residual_um: 1e3 * fit.rms_mm,
        noise_um,
        left_out_share: examination.left_out_share,
        strain: strain(&problem, &values, 1.0),
    };
    // what gains little is for a diagnosis to find
    let mut found = Preflight::of(session).mistakes(misfit);
    found.retain(|mistake| mistake.is_plain);
    let found = held_against_physics(session, options, &model, found)?.against(None).unwrap_or(None);
    Ok(found.or_else(|| further_contradiction(session)))
}
