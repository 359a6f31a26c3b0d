//! A fit as JSON, see docs/json.md; terminal text and HTML are made from the same value.

use std::collections::BTreeMap;

use serde::Serialize;

use super::words::{ControlJson, control_json, sign_in_words};
use crate::identify::{AxisLine, Fit, NoiseModel, Quantity};
use crate::methods::CircleFigures;
use crate::session::Session;
use crate::units::UM_PER_MM;

/// `fiveaxis identify --json`.
#[derive(Debug, Clone, Serialize)]
pub struct FitJson {
    pub session: String,
    pub machine: String,
    pub code: String,
    /// By ISO 230-1 name.
    pub location_errors: BTreeMap<String, LocationErrorJson>,
    /// Root mean square of the residuals that took part, µm.
    pub rms_um: f64,
    /// Standard deviation of one reading's noise by the fitted noise model, µm.
    pub noise_um: f64,
    /// Readings that took part and readings left out as gross outliers.
    pub readings: usize,
    pub left_out: usize,
    /// Root mean square over all readings whose residual is below 5 mm, µm.
    pub rms_below_5mm_um: f64,
    /// Parts of the noise model of sweeps, or of static poses where there is no sweep.
    pub noise: NoiseJson,
    pub tests: Vec<TestJson>,
    pub setups: Vec<SetupJson>,
    pub cannot_tell_apart: Vec<String>,
    /// The rotary axes' lines as a control needs them.
    pub control: Vec<ControlJson>,
    /// ISO 230-4 figures of the planar circles.
    pub circles: Vec<CircleFigures>,
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
    /// Standard deviation, priors included.
    pub sigma: f64,
    /// `um` or `arcsec`.
    pub unit: &'static str,
    /// The data and not a prior fix it.
    pub determined: bool,
    /// Standard deviation if the spindle ball stood exactly where the session says.
    pub sigma_to_spindle_ball: f64,
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

/// Stands for the noise of a session without tests.
static NO_NOISE: NoiseModel = NoiseModel { white_mm: 0.0, ar_mm: 0.0, ar_rho: 0.0, drift_mm: 0.0, offset_mm: 0.0 };

/// The JSON value of a fit, its axis lines and the figures of its planar circles.
pub fn fit_json(session: &Session, fit: &Fit, lines: &[AxisLine], circles: Vec<CircleFigures>) -> FitJson {
    let machine = &session.machine;
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
    let noise = fit.noise.iter().map(|noise| noise.rms_mm().powi(2)).sum::<f64>() / fit.noise.len().max(1) as f64;
    let is_sweep = |model: &&NoiseModel| model.ar_mm > 0.0;
    let sweep_noise = fit.noise.iter().find(is_sweep).or(fit.noise.first()).unwrap_or(&NO_NOISE);
    let near =
        fit.tests.iter().flat_map(|test| &test.residual_mm).copied().filter(|value| value.abs() < COMPARABLE_LIMIT_MM);
    FitJson {
        session: session.name.clone(),
        machine: machine.name.clone(),
        code: machine.code.to_string(),
        location_errors,
        rms_um: fit.rms_mm * 1e3,
        noise_um: noise.sqrt() * 1e3,
        noise: NoiseJson::of(sweep_noise),
        readings: fit.tests.iter().map(|test| test.kept.iter().filter(|kept| **kept).count()).sum(),
        left_out: fit.tests.iter().map(|test| test.left_out.len()).sum(),
        rms_below_5mm_um: crate::identify::rms(near) * 1e3,
        tests: fit
            .tests
            .iter()
            .map(|test| TestJson {
                name: test.name.clone(),
                rms_um: test.rms_mm * 1e3,
                readings: test.kept.iter().filter(|kept| **kept).count(),
                left_out: test.left_out.clone(),
            })
            .collect(),
        setups,
        cannot_tell_apart: fit.ambiguities.iter().map(|ambiguity| ambiguity.says()).collect(),
        control: lines.iter().map(|line| control_json(machine, line)).collect(),
        circles,
    }
}
