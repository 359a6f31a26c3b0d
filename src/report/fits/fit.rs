//! A fit as JSON, see docs/json.md; terminal text and HTML are made from the same value.

use crate::statistics::NoiseModel;
use std::collections::BTreeMap;

use serde::Serialize;

use crate::diagnose::{DataFault, Examination, Rival};
use crate::identify::{AxisLine, Fit, Quantity, TestFit, TurnedSense};
use crate::machine::{Directions, Machine};
use crate::methods::CircleFigures;
use crate::report::wording::linear_axes::{LinearAxesJson, linear_axes_json};
use crate::report::wording::sense_words::{SenseJson, senses_json};
use crate::report::wording::words::{ControlJson, control_json, sign_in_words};
use crate::session::Session;
use crate::units::UM_PER_MM;

/// `fiveaxis identify --json`.
#[derive(Debug, Clone, Serialize)]
pub struct FitJson {
    pub session: String,
    pub machine: String,
    pub code: String,
    /// What the linear axes were taken to be; null without linear axes.
    pub linear_axes: Option<LinearAxesJson>,
    /// `fits`, `data fault` or `cannot be judged`; unless it fits nothing is determined.
    pub verdict: &'static str,
    /// Why it does not fit; null where it does.
    pub reason: Option<String>,
    /// The mistake in the files that explains the misfit; null where none is known.
    pub mistake: Option<MistakeJson>,
    /// What to look at although the fit stands.
    pub warnings: Vec<String>,
    /// By ISO 230-1 name.
    pub location_errors: BTreeMap<String, LocationErrorJson>,
    /// Root mean square of the residuals that took part, µm.
    pub rms_um: f64,
    /// Standard deviation of one reading's noise by the fitted noise model, µm.
    pub noise_um: f64,
    /// Readings that took part and readings left out as gross outliers.
    pub readings: usize,
    pub left_out: usize,
    pub left_out_share: f64,
    /// Noise of readings from row to row, whatever the model, µm; null for static poses.
    pub repeats_um: Option<f64>,
    /// Root mean square over all readings whose residual is below 5 mm, µm.
    pub rms_below_5mm_um: f64,
    /// Parts of the noise model of sweeps, or of static poses where there is no sweep.
    pub noise: NoiseJson,
    pub tests: Vec<TestJson>,
    pub setups: Vec<SetupJson>,
    pub cannot_tell_apart: Vec<String>,
    /// Sense of the axes as the machine file or an option states it.
    pub directions: Option<&'static str>,
    /// Why no numbers for a control are given.
    pub control_withheld: Option<String>,
    /// The rotary axes' lines as a control needs them; none where the sense of the axes is not stated.
    pub control: Vec<ControlJson>,
    /// Axes that the tests move, and whether the recordings tell their sense.
    pub senses: Vec<SenseJson>,
    /// ISO 230-4 figures of the planar circles.
    pub circles: Vec<CircleFigures>,
}

/// A mistake in the files, with those that the recordings cannot tell from it.
#[derive(Debug, Clone, Serialize)]
pub struct MistakeJson {
    pub effect: &'static str,
    pub place: String,
    pub components: Vec<String>,
    pub tests: Vec<String>,
    pub says: String,
    pub probability: f64,
    pub cannot_tell_from: Vec<RivalMistakeJson>,
}

/// A mistake that leaves the same.
#[derive(Debug, Clone, Serialize)]
pub struct RivalMistakeJson {
    pub effect: &'static str,
    pub place: String,
    pub says: String,
    pub probability: f64,
}

impl MistakeJson {
    fn of(fault: &DataFault) -> MistakeJson {
        let rival = |rival: &Rival| RivalMistakeJson {
            effect: rival.kind.name(),
            place: rival.place.clone(),
            says: rival.says.clone(),
            probability: rival.probability,
        };
        MistakeJson {
            effect: fault.kind.name(),
            place: fault.place.clone(),
            components: fault.components.clone(),
            tests: fault.tests.clone(),
            says: fault.says.clone(),
            probability: fault.probability,
            cannot_tell_from: fault.rivals.iter().map(rival).collect(),
        }
    }
}

impl FitJson {
    /// The same with what stands against believing the fit.
    pub fn examined(mut self, examination: &Examination) -> FitJson {
        self.verdict = match (&examination.fault, &examination.unjudged) {
            (Some(_), _) => "data fault",
            (None, Some(_)) => "cannot be judged",
            (None, None) if examination.is_doubtful => "doubtful",
            (None, None) => "fits",
        };
        self.reason = examination.says().map(str::to_string);
        self.mistake = examination.fault.as_ref().map(MistakeJson::of);
        self.warnings.extend(examination.warnings.iter().cloned());
        self.repeats_um = examination.repeats_um;
        self
    }
}

/// The noise model of a reading.
#[derive(Debug, Clone, Serialize)]
pub struct NoiseJson {
    pub white_um: f64,
    /// Standard deviation of the first-order autoregressive part.
    pub ar_um: f64,
    /// Its correlation from one sample to the next.
    pub ar_rho: f64,
    /// Standard deviation of the random walk at the end of a trace.
    pub drift_um: f64,
}

impl NoiseJson {
    fn of(noise: &NoiseModel) -> NoiseJson {
        NoiseJson {
            white_um: noise.white_mm * UM_PER_MM,
            ar_um: noise.ar_mm * UM_PER_MM,
            ar_rho: noise.ar_rho,
            drift_um: noise.drift_mm * UM_PER_MM,
        }
    }
}

/// One location error.
#[derive(Debug, Clone, Serialize)]
pub struct LocationErrorJson {
    pub value: f64,
    /// Standard deviation, priors and the budget of the linear axes included.
    pub sigma: f64,
    /// `um` or `arcsec`.
    pub unit: &'static str,
    /// The data and not a prior fix it.
    pub determined: bool,
    /// Standard deviation if the spindle ball stood exactly where the session says.
    pub sigma_to_spindle_ball: f64,
    /// Standard deviation if the linear axes were exact too: what noise leaves.
    pub sigma_noise: f64,
    /// Known only relative to the place of the spindle ball.
    pub relative_to_spindle_ball: bool,
    /// Share of the variance that comes from priors (spindle balls held), 0 to 1; the rest comes from the data.
    pub prior_share: f64,
    /// Share of the variance that comes from the spreads of pivots, spindle balls and bars, 0 to 1.
    pub setup_share: f64,
    /// What a positive value means on the machine.
    pub sign: String,
}

/// One test.
#[derive(Debug, Clone, Serialize)]
pub struct TestJson {
    pub name: String,
    pub rms_um: f64,
    pub readings: usize,
    /// Rows (from 0) left out as gross outliers.
    pub left_out: Vec<usize>,
}

/// One setup quantity.
#[derive(Debug, Clone, Serialize)]
pub struct SetupJson {
    pub name: String,
    /// Estimate minus what the session states.
    pub value_um: f64,
    pub sigma_um: f64,
    /// Standard deviation before the fit.
    pub spread_um: f64,
}

/// Readings with a larger residual are left out of the comparable figure, mm.
const COMPARABLE_LIMIT_MM: f64 = 5.0;

/// Zeros set by hand that no reading tells, in words.
fn untold_zeros(fit: &Fit) -> Vec<String> {
    fit.untold_zeros()
        .map(|(unknown, estimate)| {
            format!(
                "the {} is known to ± {:.1} µm by the spread of the balls alone: no test tells how long the bar is; a sweep whose length depends on the axis's place, or a calibrated zero, would",
                unknown.label,
                unknown.measure.to_output(estimate.sigma)
            )
        })
        .collect()
}

/// Location errors by name, and what else was estimated: positions of the balls and lengths of the bar.
fn estimates_json(machine: &Machine, fit: &Fit) -> (BTreeMap<String, LocationErrorJson>, Vec<SetupJson>) {
    let mut location_errors = BTreeMap::new();
    let mut setups = Vec::new();
    for (unknown, estimate) in fit.unknowns.iter().zip(&fit.estimates) {
        let out = |value: f64| unknown.measure.to_output(value);
        match unknown.quantity {
            Quantity::Location { axis, component } => {
                location_errors.insert(
                    unknown.label.clone(),
                    LocationErrorJson {
                        value: out(estimate.value),
                        sigma: out(estimate.sigma),
                        unit: unknown.measure.output_unit(),
                        determined: estimate.determined,
                        sigma_to_spindle_ball: out(estimate.sigma_to_spindle_ball),
                        sigma_noise: out(estimate.sigma_noise),
                        relative_to_spindle_ball: estimate.relative_to_spindle_ball,
                        prior_share: estimate.prior_share,
                        setup_share: estimate.setup_share,
                        sign: sign_in_words(machine, axis, component),
                    },
                );
            }
            _ => setups.push(SetupJson {
                name: unknown.label.clone(),
                value_um: out(estimate.value),
                sigma_um: out(estimate.sigma),
                spread_um: out(unknown.prior_sigma),
            }),
        }
    }
    (location_errors, setups)
}

/// What remains of a test.
fn test_json(test: &TestFit) -> TestJson {
    TestJson {
        name: test.name.clone(),
        rms_um: test.rms_mm * 1e3,
        readings: test.readings(),
        left_out: test.left_out.clone(),
    }
}

/// The JSON value of a fit, its axis lines, what it says of senses, and the figures of its planar circles.
pub fn fit_json(
    session: &Session,
    fit: &Fit,
    lines: &[AxisLine],
    senses: &[TurnedSense],
    circles: Vec<CircleFigures>,
) -> FitJson {
    let machine = &session.machine;
    let (location_errors, setups) = estimates_json(machine, fit);
    FitJson {
        verdict: "fits",
        reason: None,
        mistake: None,
        warnings: untold_zeros(fit),
        left_out_share: fit.left_out_share(),
        repeats_um: None,
        session: session.name.clone(),
        machine: machine.name.clone(),
        code: machine.code.to_string(),
        linear_axes: linear_axes_json(machine),
        location_errors,
        rms_um: fit.rms_mm * 1e3,
        noise_um: fit.noise_mm() * 1e3,
        noise: NoiseJson::of(fit.sweep_noise().unwrap_or(&NoiseModel::white(0.0))),
        readings: fit.readings(),
        left_out: fit.left_out(),
        rms_below_5mm_um: fit.rms_below_mm(COMPARABLE_LIMIT_MM) * 1e3,
        tests: fit.tests.iter().map(test_json).collect(),
        setups,
        cannot_tell_apart: fit.ambiguities.iter().map(|ambiguity| ambiguity.says()).collect(),
        directions: machine.directions.map(Directions::name),
        control_withheld: machine.stated_directions().err().map(|why| why.to_string()),
        control: match machine.directions {
            Some(_) => lines.iter().map(|line| control_json(machine, line)).collect(),
            None => Vec::new(),
        },
        senses: senses_json(session, fit, senses),
        circles,
    }
}
