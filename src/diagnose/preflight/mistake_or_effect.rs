//! Whether a mistake in the files explains a session, or physics of the machine, by the evidence of both. It looks for no mistake.
//!
//! The session is searched for effects as it was recorded, and as it would be without the mistake, on the same few rows. What
//! either search says of the readings is compared: log likelihood with its own noise, less what forms, amplitudes and the
//! choice among mistakes cost.

use super::data_fault::DataFault;
use super::places::ball_places::End;
use super::places::misplaced::NEARBY_MM;
use super::small_misfit::Mistake;
use crate::chain::Chain;
use crate::diagnose::cause::{Cause, LEAST_PROBABILITY};
use crate::diagnose::model::decimate::{few_rows, to_means};
use crate::diagnose::model::linear_model::LinearModel;
use crate::diagnose::model::prior_penalty::fitted_anyway;
use crate::diagnose::model::regression::Regression;
use crate::diagnose::selection::joint_fit::LEFT_OUT;
use crate::diagnose::selection::naming::cause;
use crate::diagnose::selection::search::{floors, search, search_from};
use crate::diagnose::selection::selected::{Search, SelectedEffect};
use crate::diagnose::selection::two_resolutions::at_two_resolutions;
use crate::diagnose::thresholds::Thresholds;
use crate::effects::Context;
use crate::identify::{self, FitError, Options, Problem, squareness_within};
use crate::session::{Session, Setups};
use crate::statistics::{NoiseModel, log_determinant, probability_of};
use nalgebra::{Cholesky, DMatrix};

/// Probability of all mistakes together from which one is the verdict.
const LEAST_OF_VERDICT: f64 = 1.0 / 3.0;

/// What mistakes held against physics came to.
pub(crate) struct Held {
    /// The likeliest mistake, the others as its rivals; `None` where nothing speaks for any.
    fault: Option<DataFault>,
    /// Probability of all mistakes together, physics being the rest.
    probability: f64,
    /// The first effect that physics would be.
    cause: Option<Cause>,
}

impl Held {
    fn nothing() -> Held {
        Held { fault: None, probability: 0.0, cause: None }
    }

    /// Whether a mistake is likelier than all physics.
    pub(crate) fn is_likelier_than_physics(&self) -> bool {
        self.probability >= 0.5
    }

    /// The mistake with what else may be the cause, where it is likelier than the first cause of a search for physics, which has this share
    /// of it; else what it leaves to doubt. Without such a search, than the cause that few rows told.
    pub(crate) fn against(self, physics: Option<(Cause, f64)>) -> Result<Option<DataFault>, Doubt> {
        let Held { fault: Some(fault), probability, cause } = self else { return Ok(None) };
        let (cause, share) = match physics {
            Some((cause, share)) => (Some(cause), share),
            None => (cause, 1.0),
        };
        // a verdict that is wrong more often than two times in three is none
        if probability >= (1.0 - probability) * share && probability >= LEAST_OF_VERDICT {
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

/// Mistakes held against physics and each other.
pub(crate) fn held_against_physics(
    session: &Session,
    options: &Options,
    model: &LinearModel,
    mistakes: Vec<Mistake>,
) -> Result<Held, FitError> {
    let to_means_mm = to_means(session, &model.residual_mm, &model.kept);
    let recorded = AsRecorded { few_rows: few_rows(session), to_means_mm, thresholds: model.thresholds };
    let mut weighed = Vec::new();
    let mut cause = None;
    let mut known = None;
    for mistake in mistakes {
        if let Some((log_odds, fault, other)) = weighed_against_physics(&recorded, options, mistake, &mut known)? {
            cause = cause.or(other);
            weighed.push((log_odds, fault));
        }
    }
    weighed.sort_by(|a, b| b.0.total_cmp(&a.0));
    let Some(most) = weighed.first().map(|(log_odds, _)| *log_odds) else { return Ok(Held::nothing()) };
    if most == f64::INFINITY {
        let fault = weighed.into_iter().next().map(|(_, fault)| fault);
        return Ok(Held { fault, probability: 1.0, cause: None });
    }
    // of all mistakes together, and what each is among them
    let all = most + weighed.iter().map(|(log_odds, _)| (log_odds - most).exp()).sum::<f64>().ln();
    let shares: Vec<f64> = weighed.iter().map(|(log_odds, _)| (log_odds - all).exp()).collect();
    let mut faults = weighed.into_iter().zip(&shares).map(|((_, fault), share)| fault.or_effect(*share, None));
    let fault = faults.next().map(|mut fault| {
        fault.rivals.extend(faults.map(DataFault::into_rival).filter(|rival| rival.probability > LEAST_PROBABILITY));
        fault
    });
    Ok(Held { fault, probability: probability_of(all), cause })
}

/// Log odds of a mistake against physics, the mistake, and the first effect that physics would be; `None` where nothing speaks for it.
type Weighed = Option<(f64, DataFault, Option<Cause>)>;

/// A session as it was recorded, on few rows, and what a search says of it: of the rows that several mistakes leave it is the same.
type Recorded = (Session, Explained);

/// A session as it was recorded, and what mistakes in it are held against.
struct AsRecorded {
    few_rows: Session,
    /// What the readings of these rows lack to means of all readings around them, mm.
    to_means_mm: Vec<Vec<f64>>,
    thresholds: Thresholds,
}

fn weighed_against_physics(
    as_recorded: &AsRecorded,
    options: &Options,
    mistake: Mistake,
    known: &mut Option<Recorded>,
) -> Result<Weighed, FitError> {
    let sure = |fault: DataFault| Ok(Some((f64::INFINITY, fault, None)));
    if !mistake.may_be_physics() {
        return sure(mistake.fault);
    }
    let Mistake { fault, mut undone, log_odds, is_found_place, .. } = mistake;
    let AsRecorded { few_rows, to_means_mm, thresholds } = as_recorded;
    let thresholds = *thresholds;
    let mut recorded = read_in_both(few_rows, &undone);
    if rows(&recorded) != rows(&undone) {
        return sure(fault);
    }
    averaged(&mut recorded, &mut undone, to_means_mm);
    // what has no fit is no explanation
    let put = if is_found_place { fault.tests.first().map(String::as_str) } else { None };
    let put = put.and_then(|test| Some((End::named(&fault.place)?, test)));
    let Some(corrected) = explained(&undone, options, thresholds, (None, &[]), put)? else { return Ok(None) };
    let corrected = corrected.alone;
    // one search may find what another passes over: what both may be said of is no gain of the mistake
    let is_same_machine = few_rows.machine.axes == undone.machine.axes;
    let elsewhere = if is_same_machine { &corrected.found[..] } else { &[] };
    let alone = known.take().filter(|(session, _)| *session == recorded).map(|(_, alone)| alone);
    let Some(explanations) = explained(&recorded, options, thresholds, (alone, elsewhere), None)? else {
        return sure(fault);
    };
    *known = Some((recorded, explanations.alone.clone()));
    let recorded = explanations.best();
    let gained = corrected.standing - recorded.standing;
    // as of a first effect: noise that wanders looks like much
    if recorded.cause.is_none() && gained < thresholds.accept {
        return Ok(None);
    }
    Ok(Some((gained + log_odds, fault, recorded.cause)))
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

/// Makes readings means of those around them: as recorded by what these lack, and in the scale to which undoing a mistake brought them.
/// Rows that hold other readings then, or readings changed one by one, stay as they are in both.
fn averaged(recorded: &mut Session, undone: &mut Session, to_means_mm: &[Vec<f64>]) {
    for ((recorded, undone), to_means_mm) in recorded.tests.iter_mut().zip(&mut undone.tests).zip(to_means_mm) {
        let (Some(recorded), Some(undone)) = (&mut recorded.recording, &mut undone.recording) else { continue };
        let Some(scale) = scale_of(&recorded.length_mm, &undone.length_mm) else { continue };
        let add = |lengths: &mut [f64], scale: f64| {
            lengths.iter_mut().zip(to_means_mm).for_each(|(length, lacks)| *length += scale * lacks);
        };
        add(&mut recorded.length_mm, 1.0);
        add(&mut undone.length_mm, scale);
    }
}

/// Scale of readings that are those of other ones, times a factor and moved by an offset; `None` where they are not.
fn scale_of(readings: &[f64], scaled: &[f64]) -> Option<f64> {
    let read = readings.iter().zip(scaled).filter(|(reading, scaled)| reading.is_finite() && scaled.is_finite());
    let pairs: Vec<(f64, f64)> = read.map(|(reading, scaled)| (*reading, *scaled)).collect();
    let by_reading = |one: &&(f64, f64), other: &&(f64, f64)| one.0.total_cmp(&other.0);
    let (least, most) = (pairs.iter().min_by(by_reading)?, pairs.iter().max_by(by_reading)?);
    let scale = if most.0 > least.0 { (most.1 - least.1) / (most.0 - least.0) } else { 1.0 };
    let off = |(reading, scaled): &(f64, f64)| (scaled - least.1 - scale * (reading - least.0)).abs();
    pairs.iter().all(|pair| off(pair) < ROUNDING_MM).then_some(scale)
}

/// Rounding of readings that were scaled, mm.
const ROUNDING_MM: f64 = 1e-7;

/// Rows of each test.
fn rows(session: &Session) -> Vec<usize> {
    session.tests.iter().map(|test| test.recording.as_ref().map_or(0, |recording| recording.length_mm.len())).collect()
}

/// What a search says of a session.
#[derive(Clone)]
struct Explained {
    /// Log evidence.
    standing: f64,
    /// The first effect found.
    cause: Option<Cause>,
    found: Vec<SelectedEffect>,
}

/// What a search says of a session, and what one beside effects that were found elsewhere says.
struct Explanations {
    alone: Explained,
    beside: Option<Explained>,
}

impl Explanations {
    /// The one that says more, with the cause that a search alone tells.
    fn best(self) -> Explained {
        let Explanations { alone, beside } = self;
        match beside {
            Some(beside) if beside.standing > alone.standing => {
                Explained { cause: alone.cause.or(beside.cause), ..beside }
            }
            _ => alone,
        }
    }
}

/// What a search says, unless that is known, and one beside effects that were found elsewhere, if any were. The ball at an end of the
/// test named in `put` was put where the readings want it.
fn explained(
    session: &Session,
    options: &Options,
    thresholds: Thresholds,
    (known, elsewhere): (Option<Explained>, &[SelectedEffect]),
    put: Option<(End, &str)>,
) -> Result<Option<Explanations>, FitError> {
    let known = match known {
        Some(alone) if elsewhere.is_empty() => return Ok(Some(Explanations { alone, beside: None })),
        known => known,
    };
    let chain = Chain::of(&session.machine);
    let setups = Setups::of(session);
    let mut unknowns = fitted_anyway(session, options, &setups);
    // balls that stand elsewhere in every program take up what slides that are not square leave, which is neither mistake nor effect
    unknowns.extend(squareness_within(&session.machine.linear_axes, &session.machine, &unknowns));
    let problem = Problem::new(session, &chain, &setups, unknowns)?;
    let fit = match identify::fit(&problem) {
        Ok(fit) => fit,
        Err(FitError::NoConvergence) => return Ok(None),
        Err(why) => return Err(why),
    };
    let context = Context::of(session, &chain)?;
    let mut model = LinearModel::new(&context, &problem, &fit.values(), fit.kept_rows());
    model.thresholds = thresholds;
    let explanations = at_two_resolutions(model, |resolutions, families| {
        let floors = floors(resolutions);
        let told = |found: Search| {
            let room = room_for_unknowns(resolutions.fine, &found.noise_after, put);
            let standing = found.standing(resolutions.fine) + room + LEFT_OUT * fit.left_out() as f64;
            let cause = found.found.first().map(|found| cause(&session.machine, &found.chosen, &[]));
            Explained { standing, cause, found: found.found }
        };
        let alone = known.unwrap_or_else(|| told(search(resolutions, &floors, families)));
        let beside = (!elsewhere.is_empty()).then(|| told(search_from(resolutions, &floors, families, elsewhere)));
        Explanations { alone, beside }
    });
    Ok(Some(explanations?))
}

/// Logarithm of the share of what was thought possible of location errors, balls and bars that the readings leave: a ball of its
/// own explains much because it may stand anywhere, and so may one that was put where they want it.
fn room_for_unknowns(model: &LinearModel, noise: &[NoiseModel], put: Option<(End, &str)>) -> f64 {
    let covariance = Regression::new(model, noise, &[], &model.kept).covariance();
    let of_place = put.map_or(0.0, |(end, test)| room_of_place(model.problem, &covariance, end, test));
    of_place + 0.5 * Cholesky::new(covariance).map_or(0.0, |factor| log_determinant(&factor))
}

/// What is left of the room of a ball that might have been put anywhere within [`NEARBY_MM`], over what is left of its spread: along
/// each principal direction `√((1/c) / (1 + r²(1/c − 1)))`, c its variance over that of the spread, r the two widths' ratio.
/// Directions of which the readings say nothing (c = 1) cost nothing.
fn room_of_place(problem: &Problem, covariance: &DMatrix<f64>, end: End, test: &str) -> f64 {
    let is_named = |index: &usize| problem.session.tests[*index].name == test;
    let Some(index) = (0..problem.session.tests.len()).find(is_named) else { return 0.0 };
    let setup = end.setup_of(problem.setups, index);
    let own: Vec<usize> =
        (0..problem.unknowns.len()).filter(|&k| end.is_placed_by(problem.unknowns[k].quantity, setup)).collect();
    let Some(spread_mm) = own.first().map(|&k| problem.unknowns[k].prior_sigma) else { return 0.0 };
    let ratio = (NEARBY_MM / spread_mm).powi(2);
    let shares = DMatrix::from_fn(own.len(), own.len(), |i, k| covariance[(own[i], own[k])]).symmetric_eigenvalues();
    let room = |share: f64| {
        let told = 1.0 / share.clamp(f64::MIN_POSITIVE, 1.0);
        0.5 * (told.ln() - (1.0 + ratio * (told - 1.0)).ln())
    };
    shares.iter().map(|&share| room(share)).sum()
}
