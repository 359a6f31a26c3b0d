//! What a diagnosis says: verdict, findings, residuals before and after. It works nothing out.

use super::claims::{Proven, Verdict, tell_likeliest, temper, verdict};
use super::explanation::Explanation;
use super::location_errors::{Moved, moved, strained_beside};
use super::shares::{ShareOfReadings, shares_of_readings};
use crate::diagnose::findings::finding::Finding;
use crate::diagnose::model::linear_model::LinearModel;
use crate::diagnose::noise::noise_floor::{mean_noise_mm2, noise_left_mm};
use crate::diagnose::noise::pose_noise::{Left, Poses};
use crate::diagnose::preflight::data_fault::DataFault;
use crate::diagnose::preflight::doubts::exceeded_repeats_um;
use crate::diagnose::preflight::examine::Examination;
use crate::diagnose::preflight::small_misfit::implausible;
use crate::diagnose::selection::selected::Search;
use crate::diagnose::validation::cross_validation::CrossValidation;
use crate::diagnose::validation::detection_limits::Unseen;
use crate::diagnose::validation::hidden_shifts::HiddenShift;
use crate::diagnose::validation::leave_setup_out::LeftOutSetup;
use crate::diagnose::validation::leave_setup_out::transfers;
use crate::diagnose::validation::sign_randomisation::SignRandomisation;
use crate::diagnose::validation::sign_randomisation::placebos;
use crate::diagnose::validation::uncovering::UncoveringTest;
use crate::effects::CandidateFamily;
use crate::effects::EffectError;
use crate::identify::{Fit, FitError, TestFit, Unknown};
use crate::machine::Effect;
use crate::session::{MotionError, Session, Setups};
use crate::statistics::rms;

/// Result of a diagnosis.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    pub verdict: Verdict,
    pub findings: Vec<Finding>,
    /// A mistake in the files; findings of physics are then empty.
    pub data_fault: Option<DataFault>,
    /// Why the readings cannot be judged, where the verdict says so.
    pub unjudged: Option<String>,
    /// What to look at whatever the verdict is.
    pub warnings: Vec<String>,
    /// Readings left out as gross outliers.
    pub left_out: usize,
    /// Held-out proof of the findings.
    pub proof: Option<CrossValidation>,
    /// By finding: its gain with the sense of motion drawn at random; `None` where motion does not drive it.
    pub placebos: Vec<Option<SignRandomisation>>,
    /// By finding: how well setups left out in turn follow what the others predict.
    pub transfers: Vec<Option<LeftOutSetup>>,
    pub blind_to: Vec<Unseen>,
    /// Short tests that would show most of that, best first.
    pub uncovered_by: Vec<UncoveringTest>,
    /// What the readings are made of, the largest part first; empty where nothing was fitted.
    pub shares: Vec<ShareOfReadings>,
    pub rms_before_um: f64,
    pub rms_after_um: f64,
    /// Noise of a reading; `None` for static poses without readings to spare, whose noise nothing shows.
    pub noise_um: Option<f64>,
    /// What is left of static poses, by whether the readings of a pose share it.
    pub left: Option<Left>,
    pub location_errors: Vec<Moved>,
    pub tests: Vec<TestBeforeAfter>,
    /// What was fitted beside the findings, with the priors of the diagnosis.
    pub unknowns: Vec<Unknown>,
}

/// Residuals of one test before and after.
#[derive(Debug, Clone, PartialEq)]
pub struct TestBeforeAfter {
    pub name: String,
    pub before_mm: Vec<f64>,
    pub after_mm: Vec<f64>,
    pub kept: Vec<bool>,
}

impl TestBeforeAfter {
    /// Root mean square of kept rows, µm, before and after.
    pub fn rms_um(&self) -> (f64, f64) {
        let of = |values: &[f64]| {
            1e3 * rms(values.iter().zip(&self.kept).filter(|(_, kept)| **kept).map(|(value, _)| *value))
        };
        (of(&self.before_mm), of(&self.after_mm))
    }
}

/// Why a session cannot be diagnosed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DiagnoseError {
    #[error(transparent)]
    Fit(#[from] FitError),
    #[error(transparent)]
    Motion(#[from] MotionError),
    #[error(transparent)]
    Effect(#[from] EffectError),
}

/// Probability below which the cause of a finding is open.
const EVEN: f64 = 0.5;

/// Probability of a mistake in the files up to which numbers stay determined: they are stated with two σ.
const MOST_DOUBT: f64 = 0.05;

/// Rms of all readings that take part, before and after, µm.
fn rms_um(tests: &[TestBeforeAfter]) -> (f64, f64) {
    let pooled = |of: fn(&TestBeforeAfter) -> &[f64]| {
        let kept = tests.iter().flat_map(|test| of(test).iter().zip(&test.kept).filter(|(_, kept)| **kept));
        1e3 * rms(kept.map(|(value, _)| *value))
    };
    (pooled(|test| &test.before_mm), pooled(|test| &test.after_mm))
}

impl Diagnosis {
    /// Diagnosis of a session whose recordings cannot be true as they stand: the mistake in them, where one is known
    /// that undoes it. Nothing is fitted.
    pub fn of_implausible(session: &Session) -> Option<Diagnosis> {
        implausible(session).map(Examination::without_fit).map(Diagnosis::of_examination)
    }

    /// Diagnosis by what was told of a search, or by the mistake in the files.
    pub(crate) fn of(
        (fine, families): (&LinearModel, &[CandidateFamily]),
        setups: &Setups,
        fit: &Fit,
        search: &Search,
        (told, proof): (Explanation, Option<CrossValidation>),
        fault: Option<DataFault>,
        (blind_to, hidden): (Vec<Unseen>, &[HiddenShift]),
    ) -> Diagnosis {
        let is_static = !fine.has_sweeps();
        // a fast effect in every recording counted as noise as long as it was not known
        let noise_mm = match fault.is_none() {
            true => noise_left_mm(fine, &told.left_mm).min(told.rms_mm(fine)),
            false => mean_noise_mm2(&search.floor).sqrt(),
        };
        let shares = shares_of_readings(fine, setups, &told);
        let Explanation { columns, regression, left_mm, mut findings } = told;
        let covariance = regression.covariance();
        let mut location_errors = moved(fine, families, fit, (search, &regression, &covariance), hidden);
        let strained = (!findings.is_empty()).then(|| strained_beside(fine, fit, (&regression, &covariance))).flatten();
        // beside a mistake in the files no number is what it seems
        location_errors.iter_mut().for_each(|moved| moved.determined &= fault.is_none() && strained.is_none());
        let placebos = placebos(fine, &findings, &columns, &search.noise_after);
        let transfers = transfers(fine, setups, &findings, &columns, &search.noise_after);
        let left = is_static.then(|| Left::of(fine, &Poses::of(fine), &left_mm)).flatten();
        let found_noise_um = if is_static { left.map(|left| left.readings_um) } else { Some(1e3 * noise_mm) };
        let tests = before_and_after(fit, left_mm);
        let (rms_before_um, rms_after_um) = match &fault {
            Some(fault) if fault.after_um.is_finite() => (fault.before_um, fault.after_um),
            _ => rms_um(&tests),
        };
        tell_likeliest(&mut findings);
        let exceeded_um = exceeded_repeats_um(fine.context.session(), fit, rms_after_um);
        // what is left is neither noise nor known: it may have moved any of them
        location_errors.iter_mut().for_each(|moved| moved.determined &= exceeded_um.is_none());
        // fast physics that counted as noise is none where readings repeat far better
        let noise_um = exceeded_um.or(found_noise_um);
        let verdict = match fault {
            Some(_) => Verdict::DataFault,
            None => verdict(&fine.thresholds, &findings, rms_after_um, noise_um, proof.as_ref()),
        };
        // what puts a ball or bar where it does not stand is not explained
        let verdict =
            if verdict == Verdict::Explained && strained.is_some() { Verdict::PartlyExplained } else { verdict };
        let carries: Vec<bool> = transfers.iter().map(|one| one.as_ref().is_none_or(LeftOutSetup::is_right)).collect();
        let proven = Proven {
            verdict,
            has_sweeps: !is_static,
            rms_um: (rms_before_um, rms_after_um),
            noise_um: noise_um.unwrap_or(0.0),
            proof: proof.as_ref(),
            carries: &carries,
            other: search.other.as_ref(),
        };
        temper(&fine.thresholds, &mut findings, &proven);
        // a cause that stays open may be none of those known: what it moves is not determined
        let is_open = findings.iter().any(|finding| finding.probability < EVEN);
        location_errors.iter_mut().for_each(|moved| moved.determined &= !(is_open && moved.is_moved()));
        Diagnosis {
            verdict,
            findings,
            data_fault: fault,
            unjudged: None,
            warnings: strained.into_iter().collect(),
            left_out: fit.left_out(),
            proof,
            placebos,
            transfers,
            blind_to,
            uncovered_by: Vec::new(),
            shares,
            rms_before_um,
            rms_after_um,
            noise_um,
            left,
            location_errors,
            tests,
            unknowns: fine.problem.unknowns.clone(),
        }
    }

    /// Claims less of what was found, as a mistake in the files may be the cause with this probability.
    pub(crate) fn leave_to_a_mistake(&mut self, probability: f64) {
        if probability > MOST_DOUBT {
            self.location_errors.iter_mut().for_each(|moved| moved.determined = false);
        }
        for finding in &mut self.findings {
            finding.probability *= 1.0 - probability;
            finding.rivals.iter_mut().for_each(|(_, share)| *share *= 1.0 - probability);
        }
    }

    /// The same with a warning that stands against all location errors.
    pub(crate) fn with_nothing_determined(mut self, warning: String) -> Diagnosis {
        self.location_errors.iter_mut().for_each(|moved| moved.determined = false);
        self.warnings.push(warning);
        self
    }

    /// The same of readings that cannot be judged, for this reason: it claims nothing.
    pub(crate) fn not_to_be_judged(mut self, reason: String) -> Diagnosis {
        self.location_errors.iter_mut().for_each(|moved| moved.determined = false);
        Diagnosis { verdict: Verdict::CannotBeJudged, unjudged: Some(reason), ..self }
    }

    /// Diagnosis of a session in which a mistake was found, or whose readings cannot be judged: no physics is looked for.
    pub(crate) fn of_examination(examination: Examination) -> Diagnosis {
        let Examination { fit, fault, unjudged, warnings, repeats_um, .. } = examination;
        let as_fitted = |test: &TestFit| TestBeforeAfter {
            name: test.name.clone(),
            before_mm: test.residual_mm.clone(),
            after_mm: test.residual_mm.clone(),
            kept: test.kept.clone(),
        };
        let tests: Vec<TestBeforeAfter> = fit.iter().flat_map(|fit| &fit.tests).map(as_fitted).collect();
        let rms_um = fit.as_ref().map_or(f64::NAN, |fit| 1e3 * fit.rms_mm);
        let undone = fault.as_ref().filter(|fault| fault.after_um.is_finite());
        Diagnosis {
            verdict: if fault.is_some() { Verdict::DataFault } else { Verdict::CannotBeJudged },
            findings: Vec::new(),
            proof: None,
            placebos: Vec::new(),
            transfers: Vec::new(),
            left: None,
            blind_to: Vec::new(),
            uncovered_by: Vec::new(),
            shares: Vec::new(),
            rms_before_um: undone.map_or(rms_um, |fault| fault.before_um),
            rms_after_um: undone.map_or(rms_um, |fault| fault.after_um),
            noise_um: repeats_um,
            location_errors: Vec::new(),
            tests,
            left_out: fit.as_ref().map_or(0, Fit::left_out),
            unknowns: fit.map(|fit| fit.unknowns).unwrap_or_default(),
            unjudged,
            warnings,
            data_fault: fault,
        }
    }

    /// Whether the readings and what the files say of them may be believed.
    pub fn is_sound(&self) -> bool {
        !matches!(self.verdict, Verdict::DataFault | Verdict::CannotBeJudged)
    }

    /// Whether a location error that the findings move is nearer to the truth than before: nothing stays unexplained, and no finding
    /// failed its held-out proof.
    pub fn is_settled(&self) -> bool {
        let failed = |k: usize| self.proof.as_ref().is_some_and(|proof| proof.has_failed(k));
        let has_failed = (0..self.findings.len()).any(|k| !self.findings[k].single && failed(k));
        matches!(self.verdict, Verdict::Clean | Verdict::Explained) && !has_failed
    }

    /// Readings that took part, or were left out.
    pub fn readings(&self) -> usize {
        self.tests.iter().flat_map(|test| &test.before_mm).filter(|residual| residual.is_finite()).count()
    }

    /// All effects found, as they go into a machine file.
    pub fn effects(&self) -> Vec<Effect> {
        let with_rival = |finding: &Finding| {
            let rival = finding.near_rival();
            let of = |effect: &Effect| Effect { cannot_tell_from: rival.clone(), ..effect.clone() };
            finding.effects.iter().map(of).collect::<Vec<Effect>>()
        };
        self.findings.iter().flat_map(with_rival).collect()
    }
}

/// Residuals of every test in the fit without effects and with them.
fn before_and_after(fit: &Fit, left_mm: Vec<Vec<f64>>) -> Vec<TestBeforeAfter> {
    let told = |(test, after_mm): (&TestFit, Vec<f64>)| TestBeforeAfter {
        name: test.name.clone(),
        before_mm: test.residual_mm.clone(),
        after_mm,
        kept: test.kept.clone(),
    };
    fit.tests.iter().zip(left_mm).map(told).collect()
}
