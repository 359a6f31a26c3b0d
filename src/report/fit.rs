//! A fit as JSON and as terminal text. The documented shape of `identify --json` is [`FitJson`].

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Serialize;

use super::table::Table;
use crate::identify::{Fit, Quantity};
use crate::machine::{Component, ErrorName, Machine};
use crate::session::Session;

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
    pub tests: Vec<TestJson>,
    pub setups: Vec<SetupJson>,
    pub cannot_tell_apart: Vec<String>,
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
    pub value_um: f64,
    pub sigma_um: f64,
}

/// Readings with a larger residual are left out of the comparable figure, mm.
const COMPARABLE_LIMIT_MM: f64 = 5.0;

/// The JSON value of a fit.
pub fn fit_json(session: &Session, fit: &Fit) -> FitJson {
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
            }),
        }
    }
    let noise = fit.noise.iter().map(|noise| noise.rms_mm().powi(2)).sum::<f64>() / fit.noise.len().max(1) as f64;
    let near =
        fit.tests.iter().flat_map(|test| &test.residual_mm).copied().filter(|value| value.abs() < COMPARABLE_LIMIT_MM);
    FitJson {
        session: session.name.clone(),
        machine: machine.name.clone(),
        code: machine.code.to_string(),
        location_errors,
        rms_um: fit.rms_mm * 1e3,
        noise_um: noise.sqrt() * 1e3,
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
        cannot_tell_apart: fit.ambiguities.iter().map(|ambiguity| ambiguity.says.clone()).collect(),
    }
}

/// What a positive location error means on the machine.
pub fn sign_in_words(machine: &Machine, axis: usize, component: Component) -> String {
    let entry = &machine.axes[axis];
    let name = ErrorName::location(component, &entry.name);
    let letter = ['x', 'y', 'z'][component.direction_index()];
    if entry.zero_position() == Some(component) {
        return format!(
            "{name} > 0: at the reading 0 the part that {} carries stands on the positive side",
            entry.name
        );
    }
    if component.is_angle() {
        let turned = ['y', 'z', 'x'][component.direction_index()];
        let towards = ['z', 'x', 'y'][component.direction_index()];
        format!(
            "{name} > 0: the line of {} is turned about {letter} (right-handed, {turned} towards {towards})",
            entry.name
        )
    } else {
        format!(
            "{name} > 0: the line of {} lies on the +{letter} side of its nominal place, seen from what carries it",
            entry.name
        )
    }
}

/// The fit for a terminal.
pub fn fit_text(session: &Session, fit: &Fit) -> String {
    let json = fit_json(session, fit);
    let mut text = String::new();
    let _ = writeln!(text, "{} on {} {}", json.session, json.machine, json.code);
    let _ = writeln!(
        text,
        "{} tests, {} readings{}; residual {:.2} µm rms, noise {:.2} µm\n",
        json.tests.len(),
        json.readings,
        if json.left_out > 0 { format!(" ({} left out as gross outliers)", json.left_out) } else { String::new() },
        json.rms_um,
        json.noise_um
    );
    let mut table = Table::new(&["error", "value", "± sigma", "unit", "to spindle ball", "from priors", "verdict"]);
    for unknown in fit.unknowns.iter().filter(|unknown| !unknown.quantity.is_setup()) {
        let error = &json.location_errors[&unknown.label];
        let verdict = match (error.determined, error.relative_to_spindle_ball) {
            (true, true) => "determined, relative to the spindle ball",
            (true, false) => "determined",
            (false, _) => "NOT determined by these recordings",
        };
        table.row(vec![
            unknown.label.clone(),
            format!("{:.2}", error.value),
            format!("{:.2}", error.sigma),
            if error.unit == "um" { "µm".into() } else { "arcsec".to_string() },
            format!("± {:.2}", error.sigma_to_spindle_ball),
            format!("{:.0} %", 100.0 * error.prior_share),
            verdict.to_string(),
        ]);
    }
    text.push_str(&table.text());
    if !json.cannot_tell_apart.is_empty() {
        text.push_str("\nCannot be told apart:\n");
        for line in &json.cannot_tell_apart {
            let _ = writeln!(text, "  • {line}");
        }
    }
    text.push_str("\nResidual per test, µm rms:\n");
    let mut line = String::new();
    for test in &json.tests {
        let item = format!(
            "{} {:.2}{}",
            test.name,
            test.rms_um,
            if test.left_out.is_empty() { String::new() } else { format!(" ({} out)", test.left_out.len()) }
        );
        if line.chars().count() + item.chars().count() > 96 {
            let _ = writeln!(text, "  {line}");
            line.clear();
        }
        if !line.is_empty() {
            line.push_str("  ");
        }
        line.push_str(&item);
    }
    let _ = writeln!(text, "  {line}");
    text
}
