//! Where readings that scatter unevenly come from when no form explains them: the place whose motion would make them scatter as they do. No form, no fit.
//!
//! An irregular motion s at an outlet adds the variance `(g·s)²` to a reading, g the outlet's gain: which outlet's gains go with the
//! scatter of the residuals says where it acts (stick-slip, chatter, a loose part), though not how it runs.

use crate::diagnose::cause::{Cause, LEAST_PROBABILITY, MOST_RIVALS};
use crate::statistics::{NoiseModel, mean, rms};
use nalgebra::{Matrix3, Vector3};

use crate::diagnose::findings::finding::{Finding, SizeFound};
use crate::diagnose::findings::forming::loudest;
use crate::diagnose::model::linear_model::{Column, LinearModel, display};
use crate::diagnose::model::regression::Accepted;
use crate::diagnose::noise::noise_floor::mean_noise_mm2;
use crate::diagnose::selection::naming::{component_name, unit};
use crate::effects::{Driver, UNKNOWN};
use crate::machine::{Outlet, Place};

/// Neighbouring readings that count as one.
const READINGS_COUNTED_AS_ONE: f64 = 10.0;
/// Log odds by which a place must stand above readings that scatter equally everywhere.
const LOCATED: f64 = 20.0;
/// Log odds against a ball that is loose, beside slides and joints that do not run evenly.
const LOOSE_BALL: f64 = 3.0;
/// Variances that are tried: from a tenth of the noise upwards, by this factor, and between the best one's neighbours in so many
/// steps to either side.
const STEP: f64 = 1.3;
const STEPS: i32 = 45;
const FINER: i32 = 10;
/// How far from its place a slide or joint that sticks may stand, µm or arcsec.
const STANDS_OFF: f64 = 10.0;
/// Share of what a sweep shows below which a direction is hardly seen.
const HARDLY_SHOWN: f64 = 1e-3;

/// One place with the scatter that its motion explains.
struct ScatterAt {
    place: Place,
    outlet: Outlet,
    /// Over readings that scatter equally everywhere.
    log_odds: f64,
    /// Rms of its motion, library units.
    rms: f64,
    readings: f64,
}

/// Residuals by test without what a ball that stands off its place would leave: a slide that sticks stands elsewhere each
/// time, and how far a sweep scatters says where it moves only without that.
fn within_sweeps(model: &LinearModel, residual_mm: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let gains = [0, 1, 2].map(|k| model.gains(&Outlet::SpindleBall(k)));
    let within = |test: usize| {
        let direction = |row: usize| Vector3::from_fn(|k, _| gains[k][test].get(row).copied().unwrap_or(0.0));
        let residual = &residual_mm[test];
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for row in (0..residual.len()).filter(|&row| model.kept[test][row]) {
            let u = direction(row);
            normal += u * u.transpose();
            right += u * residual[row];
        }
        // a direction that the sweep hardly shows is left as it is
        normal += Matrix3::identity() * HARDLY_SHOWN * normal.trace();
        let offset = normal.try_inverse().map_or(Vector3::zeros(), |inverse| inverse * right);
        residual.iter().enumerate().map(|(row, value)| value - direction(row).dot(&offset)).collect()
    };
    (0..model.tests()).map(within).collect()
}

/// Places by how well an irregular motion there accounts for the scatter of residuals within sweeps, best first; `None`
/// where they scatter equally everywhere.
fn places(model: &LinearModel, residual_mm: &[Vec<f64>], noise: &[NoiseModel]) -> Option<Vec<ScatterAt>> {
    let machine = model.context.machine();
    let axes = (0..machine.axes.len()).map(|axis| (Place::Axis(axis), Outlet::own(machine, axis)));
    let balls = (0..3).map(|k| (Place::SpindleBall, Outlet::SpindleBall(k)));
    let alone = scatter_explained(model, residual_mm, noise, |_, _| 1.0)?;
    let mut places: Vec<ScatterAt> = axes
        .chain(balls)
        .filter_map(|(place, outlet)| {
            let gains = model.gains(&outlet);
            let gain = |test: usize, row: usize| match acts(model, place, test) {
                true => gains[test].get(row).copied().unwrap_or(0.0),
                false => 0.0,
            };
            let (log_likelihood, rms, readings) = scatter_explained(model, residual_mm, noise, gain)?;
            let rarity = if place == Place::SpindleBall { LOOSE_BALL } else { 0.0 };
            Some(ScatterAt { place, outlet, log_odds: log_likelihood - alone.0 - rarity, rms, readings })
        })
        .collect();
    places.sort_by(|a, b| b.log_odds.total_cmp(&a.log_odds));
    places.first().is_some_and(|best| best.log_odds > LOCATED).then_some(places)
}

/// Whether a place can move in a test: a slide or joint in motion, a ball always.
fn acts(model: &LinearModel, place: Place, test: usize) -> bool {
    place.axis().is_none_or(|axis| model.context.motion(test).moving.contains(&axis))
}

/// Scatter that is left at the place of a finding.
pub struct LeftScatter {
    /// Its rms beyond noise over the finding's own.
    pub share: f64,
    /// It is at the axis that drives the place of the finding.
    pub is_driving: bool,
}

/// How far readings scatter beyond noise where a finding is; `None` where another place makes them scatter. It says that something
/// happens at the place which the form does not tell.
///
/// A slide that sticks and slips also leaves the ball where it should not be while it stands: both places are looked at.
pub fn left_scatter(
    model: &LinearModel,
    residual_mm: &[Vec<f64>],
    noise: &[NoiseModel],
    finding: &Finding,
) -> Option<LeftScatter> {
    let machine = model.context.machine();
    let residual_mm = &within_sweeps(model, residual_mm);
    let places = places(model, residual_mm, noise).unwrap_or_default();
    // a joint that tips as a slide reverses tells of that slide
    let driving = finding.range.as_ref().map(|range| range.axis.as_str());
    let is_here = |name: &str| name == finding.cause.place || Some(name) == driving;
    let here = places.iter().take(2).filter(|at| is_here(at.place.name(machine)));
    let beyond_noise = |at: &ScatterAt| {
        let noise_um = 1e3 * mean_noise_mm2(noise).sqrt();
        let left_um = most_scattered(model, residual_mm, at).1;
        (left_um.powi(2) - noise_um.powi(2)).max(0.0).sqrt()
    };
    let (at, beyond_um) = here.map(|at| (at, beyond_noise(at))).max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(LeftScatter {
        share: beyond_um / finding.rms_um.max(f64::MIN_POSITIVE),
        is_driving: at.place.name(machine) != finding.cause.place,
    })
}

/// Places at which an axis stands or runs in each test, as columns of their own: what sticks stops elsewhere each time. None for
/// other places.
pub fn standing(model: &LinearModel, place: &str) -> Vec<Accepted> {
    let machine = model.context.machine();
    let Some(axis) = machine.axis_index(place) else { return Vec::new() };
    let outlet = Outlet::own(machine, axis);
    let per_unit = 1.0 / display(outlet.measure(machine));
    let gains = model.gains(&outlet);
    let alone = |test: usize| {
        let mut by_test = vec![Vec::new(); model.tests()];
        by_test[test] = gains[test].iter().map(|gain| gain * per_unit).collect();
        Accepted { column: Column::new(by_test), prior: STANDS_OFF }
    };
    (0..model.tests()).filter(|&test| !gains[test].is_empty()).map(alone).collect()
}

/// The place of an irregular motion, as a finding; `None` where the residuals scatter equally everywhere.
pub fn irregular(model: &LinearModel, residual_mm: &[Vec<f64>], noise: &[NoiseModel]) -> Option<Finding> {
    let machine = model.context.machine();
    let residual_mm = &within_sweeps(model, residual_mm);
    let places = places(model, residual_mm, noise)?;
    let best = places.first()?;
    let weight = |other: &ScatterAt| (other.log_odds - best.log_odds).exp();
    let total: f64 = places.iter().map(weight).sum();
    let cause = |at: &ScatterAt| Cause {
        effect: UNKNOWN.name.into(),
        driver: Driver::Time,
        place: at.place.name(machine).to_string(),
        components: vec![component_name(machine, &at.outlet)],
    };
    let mut rivals: Vec<(Cause, f64)> =
        places.iter().skip(1).map(|other| (cause(other), weight(other) / total)).collect();
    rivals.retain(|(_, probability)| *probability >= LEAST_PROBABILITY);
    rivals.truncate(MOST_RIVALS);
    let measure = best.outlet.measure(machine);
    let value = best.rms * display(measure);
    let (tests, rms_um) = most_scattered(model, residual_mm, best);
    Some(Finding {
        cause: cause(best),
        effects: Vec::new(),
        size: SizeFound {
            value,
            sigma: value / (2.0 * best.readings / READINGS_COUNTED_AS_ONE).sqrt(),
            unit: unit(measure),
            meaning: "rms of an irregular motion".into(),
        },
        tests,
        range: None,
        probability: 1.0 / total,
        rivals,
        gain: best.log_odds,
        single: false,
        columns: Vec::new(),
        next_test: None,
        rms_um,
    })
}

/// Log likelihood of the residuals with a motion of the most likely size behind these gains, its rms, and how many readings it reaches.
fn scatter_explained(
    model: &LinearModel,
    residual_mm: &[Vec<f64>],
    noise: &[NoiseModel],
    gain: impl Fn(usize, usize) -> f64,
) -> Option<(f64, f64, f64)> {
    // by reading: square of the gain, variance of the noise, square of the residual
    let mut readings: Vec<(f64, f64, f64)> = Vec::new();
    for test in 0..model.tests() {
        let noise_mm2 = noise[test].rms_mm().powi(2);
        let rows = (0..residual_mm[test].len()).filter(|&row| model.kept[test][row]);
        readings.extend(rows.map(|row| (gain(test, row).powi(2), noise_mm2, residual_mm[test][row].powi(2))));
    }
    let reached = readings.iter().filter(|(gain, ..)| *gain > 0.0).count() as f64;
    let gains: f64 = readings.iter().map(|(gain, ..)| gain).sum::<f64>() / reached;
    let noise_mm2 = mean(readings.iter().map(|(_, noise, _)| *noise)).unwrap_or(f64::NAN);
    if !(gains > 0.0 && noise_mm2 > 0.0) {
        return None;
    }
    let likelihood = |square: f64| {
        let sum: f64 = readings
            .iter()
            .map(|(gain, noise, residual)| {
                let variance = noise + gain * square;
                (variance / noise_mm2).ln() + residual / variance
            })
            .sum();
        -0.5 * sum / READINGS_COUNTED_AS_ONE
    };
    let at = |step: f64| {
        let square = 0.1 * noise_mm2 / gains * STEP.powf(step);
        (likelihood(square), step, square.sqrt())
    };
    let best = |steps: &mut dyn Iterator<Item = f64>| steps.map(at).max_by(|a, b| a.0.total_cmp(&b.0));
    let coarse = best(&mut (0..STEPS).map(f64::from))?.1;
    let (likelihood, _, rms) = best(&mut (-FINER..=FINER).map(|k| coarse + f64::from(k) / f64::from(FINER)))?;
    Some((likelihood, rms, reached))
}

/// Tests that it reaches, the loudest first, and the rms of their residuals, µm.
fn most_scattered(model: &LinearModel, residual_mm: &[Vec<f64>], best: &ScatterAt) -> (Vec<String>, f64) {
    let gains = model.gains(&best.outlet);
    let tests =
        (0..model.tests()).filter(|&test| !gains[test].is_empty() && acts(model, best.place, test)).map(|test| {
            let kept = residual_mm[test].iter().zip(&model.kept[test]).filter(|(_, kept)| **kept);
            (test, 1e3 * rms(kept.map(|(value, _)| *value)))
        });
    loudest(model, tests.collect())
}
