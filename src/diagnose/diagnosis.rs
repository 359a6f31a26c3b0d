//! What a diagnosis says: verdict, findings, residuals before and after. It works nothing out.

use super::blind::Blind;
use super::data_fault::DataFault;
use super::examine::Examination;
use super::finding::Finding;
use super::placebo::Placebo;
use super::pose_floor::Left;
use super::preflight;
use super::proof::Proof;
use super::transfer::Transfer;
use crate::effects::EffectError;
use crate::identify::{FitError, TestFit, Unknown, rms};
use crate::machine::Effect;
use crate::session::{MotionError, Session};
use crate::units::Measure;

/// How a session is explained.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    Clean,
    Explained,
    PartlyExplained,
    Unexplained,
    DataFault,
    CannotBeJudged,
}

impl Verdict {
    /// Words of the JSON contract.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Clean => "clean",
            Verdict::Explained => "explained",
            Verdict::PartlyExplained => "partly explained",
            Verdict::Unexplained => "unexplained",
            Verdict::DataFault => "data fault",
            Verdict::CannotBeJudged => "cannot be judged",
        }
    }
}

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
    pub proof: Option<Proof>,
    /// By finding: its gain with the sense of motion drawn at random; `None` where motion does not drive it.
    pub placebos: Vec<Option<Placebo>>,
    /// By finding: how well setups left out in turn follow what the others predict.
    pub transfers: Vec<Option<Transfer>>,
    pub blind_to: Vec<Blind>,
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

/// A location error before and after the effects were modelled, mm or rad.
#[derive(Debug, Clone, PartialEq)]
pub struct Moved {
    pub name: String,
    pub measure: Measure,
    pub before: f64,
    pub after: f64,
    pub sigma: f64,
    pub determined: bool,
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

impl Diagnosis {
    /// Diagnosis of a session whose recordings cannot be true as they stand: the mistake in them, where one is known
    /// that undoes it. Nothing is fitted.
    pub fn of_implausible(session: &Session) -> Option<Diagnosis> {
        preflight::implausible(session).map(Examination::without_fit).map(Diagnosis::of_examination)
    }

    /// Diagnosis of a session in which a mistake was found, or whose readings cannot be judged: no physics is looked for.
    pub(super) fn of_examination(examination: Examination) -> Diagnosis {
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
            rms_before_um: undone.map_or(rms_um, |fault| fault.before_um),
            rms_after_um: undone.map_or(rms_um, |fault| fault.after_um),
            noise_um: repeats_um,
            location_errors: Vec::new(),
            tests,
            left_out: fit.iter().flat_map(|fit| &fit.tests).map(|test| test.left_out.len()).sum(),
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

    /// Readings that took part, or were left out.
    pub fn readings(&self) -> usize {
        self.tests.iter().flat_map(|test| &test.before_mm).filter(|residual| residual.is_finite()).count()
    }

    /// All effects found, as they go into a machine file.
    pub fn effects(&self) -> Vec<Effect> {
        self.findings.iter().flat_map(|finding| finding.effects.iter().cloned()).collect()
    }
}
