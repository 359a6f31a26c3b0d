//! What the readings as a whole say, and how much may be claimed of each cause then. It finds nothing.

use crate::diagnose::cause::Cause;
use crate::diagnose::findings::finding::{Finding, SizeFound};
use crate::diagnose::selection::selected::OtherSet;
use crate::diagnose::thresholds::Thresholds;
use crate::diagnose::validation::cross_validation::{CrossValidation, HeldOut};
use crate::effects::{DESCRIBED_BY_CURVE, DESCRIBED_BY_NAME, Signature, UNKNOWN, is_a};

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

/// Jumps of one session beyond which they may be something that comes and goes.
const MOST_JUMPS: usize = 2;

/// The verdict on a session whose files are sound.
pub(crate) fn verdict(
    thresholds: &Thresholds,
    findings: &[Finding],
    rms_after_um: f64,
    noise_um: Option<f64>,
    proof: Option<&CrossValidation>,
) -> Verdict {
    if findings.is_empty() {
        return if noise_um.is_some_and(|noise_um| rms_after_um > thresholds.surely_more * noise_um) {
            Verdict::Unexplained
        } else {
            Verdict::Clean
        };
    }
    if findings.iter().all(|finding| is_a(&finding.cause.effect, Signature::FreeCurve)) {
        return Verdict::Unexplained;
    }
    // where no noise is known nothing shows that all is explained
    let is_noise = noise_um.is_some_and(|noise_um| rms_after_um <= thresholds.explained * noise_um);
    // forms that bend to the readings predict others badly
    let predicts = findings.iter().any(Finding::escapes)
        || proof.is_none_or(|proof| proof.after_um <= thresholds.predicted * rms_after_um);
    match is_noise && predicts {
        true => Verdict::Explained,
        false => Verdict::PartlyExplained,
    }
}

/// Tells a finding by the free curve of which more may be claimed than of its name: where it acts, and how much of the readings it is.
pub(crate) fn tell_likeliest(findings: &mut [Finding]) {
    for finding in findings {
        let Some((rival, share)) = finding.rivals.first_mut() else { continue };
        if rival.effect != UNKNOWN.name || claimed(rival, *share) <= claimed(&finding.cause, finding.probability) {
            continue;
        }
        std::mem::swap(rival, &mut finding.cause);
        std::mem::swap(share, &mut finding.probability);
        finding.size = SizeFound {
            value: finding.rms_um,
            sigma: UNKNOWN.form_error * finding.rms_um,
            unit: "um",
            meaning: "rms of what it adds to the readings".into(),
        };
    }
}

/// What may be claimed of a cause with a probability among the candidates.
fn claimed(cause: &Cause, probability: f64) -> f64 {
    probability
        * match is_a(&cause.effect, Signature::FreeCurve) {
            true => DESCRIBED_BY_CURVE,
            false => DESCRIBED_BY_NAME,
        }
}

/// What is known of findings beside what each gains.
pub(crate) struct Proven<'p> {
    pub(crate) verdict: Verdict,
    pub(crate) has_sweeps: bool,
    /// Rms of all readings without and with the findings, µm.
    pub(crate) rms_um: (f64, f64),
    /// What of it is noise, µm; 0 where none is known.
    pub(crate) noise_um: f64,
    pub(crate) proof: Option<&'p CrossValidation>,
    /// Of each finding, whether it holds in the tests it was not learnt from.
    pub(crate) carries: &'p [bool],
    /// The set that was not taken.
    pub(crate) other: Option<&'p OtherSet>,
}

impl Proven<'_> {
    /// Most that may be claimed of the first finding by what it predicts: a form that bends to the readings which it is fitted to, and
    /// takes most of that off no others, is the right one no more often than it predicts.
    fn most_predicted(&self, thresholds: &Thresholds, first: &Finding) -> f64 {
        let proof = self.proof.filter(|_| !first.escapes());
        let share = proof.and_then(|proof| proof.carried_over(self.rms_um, self.noise_um));
        // no less than where no fold confirms anything
        let least = HeldOut::default().most_probable();
        share.filter(|share| *share < thresholds.explains_most).map_or(1.0, |share| share.max(least))
    }
}

/// Claims no more of each cause than is proven, and leaves a part to causes that no candidate describes.
pub(crate) fn temper(thresholds: &Thresholds, findings: &mut [Finding], proven: &Proven) {
    let Proven { verdict, has_sweeps, proof, carries, other, .. } = *proven;
    if let Some(first) = findings.first_mut() {
        first.probability = first.probability.min(proven.most_predicted(thresholds, first));
    }
    let goes_back: Vec<bool> =
        findings.iter().map(|one| findings.iter().any(|other| one.is_undone_by(other))).collect();
    let jumps = findings.iter().filter(|finding| finding.single).count();
    for (index, finding) in findings.iter_mut().enumerate() {
        let held_out = proof.and_then(|proof| proof.findings.get(index)).filter(|_| !finding.single);
        finding.probability = finding.probability.min(held_out.map_or(1.0, HeldOut::most_probable));
        let is_weak = has_sweeps && finding.gain < thresholds.sure_of_form;
        let may_be_no_jump = goes_back[index] || finding.single && jumps > MOST_JUMPS;
        let is_open = verdict != Verdict::Explained || is_weak || may_be_no_jump || !carries[index];
        if is_open {
            finding.probability = finding.probability.min(thresholds.unproven);
        }
        let stands = 1.0 - other.map_or(0.0, OtherSet::probability);
        finding.probability = stands * claimed(&finding.cause, finding.probability);
        finding.rivals.iter_mut().for_each(|(rival, probability)| *probability = stands * claimed(rival, *probability));
    }
}
