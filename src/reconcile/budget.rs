//! How uncertain a claim's errors are together: what repeats scatter, what the bar may be off, where slides and balls stand.
//!
//! Every contribution acts on readings or balls and goes through the claim's own reduction, so that errors which share a
//! circle vary together. `V = Σ σ² s sᵀ`, s the response to a contribution of unit size, σ its standard uncertainty.

use nalgebra::{DMatrix, DVector};

use super::design::{Design, Group};
use super::error::ReconcileError;
use crate::machine::Component;
use crate::session::Claim;
use crate::units::UM_PER_MM;

/// Limits of the contributions, ±µm; within them any value is as likely, so that `σ = limit/√3` (GUM 4.3.7).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Reading of the bar over a circle, by its first harmonic: the maker's ±1.0 µm at 20 °C (thesis 2.3.1).
    pub bar_um: f64,
    /// Place to which the slides bring the spindle ball: the thesis's machine tolerance (sections 3.2, 4.3).
    pub slides_um: f64,
    /// Centre of the spindle ball in one claim: run-out held within 1 µm (thesis 4.1.3).
    pub ball_um: f64,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { bar_um: 1.0, slides_um: 1.0, ball_um: 1.0 }
    }
}

/// Standard uncertainties of one claim.
#[derive(Debug, Clone)]
pub struct Budget {
    /// Covariance of its errors, µm and arcsec.
    pub covariance: DMatrix<f64>,
    /// Share of repeatability, variance by error.
    pub repeatability: DVector<f64>,
    /// Standard deviation that circles with the scatter of the stated positions give when they are independent, by error.
    pub independent: DVector<f64>,
}

/// Standard uncertainty of a value within ± a limit.
fn rectangular(limit: f64) -> f64 {
    limit / 3f64.sqrt()
}

/// The budget of a claim.
pub fn budget(claim: &Claim, design: &Design, limits: &Limits) -> Result<Budget, ReconcileError> {
    let count = design.names.len();
    let mut covariance = DMatrix::zeros(count, count);
    let mut add = |response: DVector<f64>, sigma: f64| covariance += &response * response.transpose() * sigma.powi(2);
    let mut scatter = DMatrix::zeros(count, count);
    for (index, group) in design.groups.iter().enumerate() {
        for coordinate in 0..2 {
            let response = design.response_of_circle(index, coordinate, 1.0)?;
            let repeats = scatter_um(claim, design, group, coordinate) / reading_to_centre(group, design);
            scatter += &response * response.transpose() * repeats.powi(2);
            add(response, rectangular(limits.bar_um));
        }
    }
    for place in places(design) {
        for coordinate in 0..3 {
            add(design.response(&moved(design, &place, coordinate))?, rectangular(limits.slides_um));
        }
    }
    let all: Vec<usize> = (0..design.session.tests.len()).collect();
    for coordinate in 0..3 {
        add(design.response(&moved(design, &all, coordinate))?, rectangular(limits.ball_um));
    }
    let independent = DVector::from_fn(count, |k, _| scatter[(k, k)].sqrt());
    // a stated scatter above that of the circles stands
    for (k, value) in claim.values.iter().enumerate() {
        let stated = value.name.component.measure().to_output(value.deviation);
        scatter[(k, k)] += (stated.powi(2) - scatter[(k, k)]).max(0.0);
    }
    covariance += &scatter;
    Ok(Budget { covariance, repeatability: scatter.diagonal(), independent })
}

/// Stated scatter of the axis's position along a coordinate of the turning plane, µm: that of a circle's centre.
fn scatter_um(claim: &Claim, design: &Design, group: &Group, coordinate: usize) -> f64 {
    let axis = &design.session.machine.axes[group.axis].name;
    let along = group.plane[coordinate];
    let is_its_own = |component: Component| !component.is_angle() && component.direction_index() == along;
    let stated = claim.values.iter().find(|value| value.name.axis == *axis && is_its_own(value.name.component));
    stated.map_or(0.0, |value| value.deviation * UM_PER_MM)
}

/// By how much a wave of the readings moves the circle's centre: the slant of a cone over its radius.
fn reading_to_centre(group: &Group, design: &Design) -> f64 {
    let test = group.tests.first().and_then(|(test, _)| design.session.tests[*test].recording.as_ref());
    let length_mm = test.and_then(|recording| recording.length_mm.first().copied()).unwrap_or(1.0);
    let radius_mm = (length_mm.powi(2) - group.reach_mm.powi(2)).max(1.0).sqrt();
    length_mm / radius_mm
}

/// Tests by the place at which the slides stand, as far as circles are measured there.
pub fn places(design: &Design) -> Vec<Vec<usize>> {
    let mut places: Vec<Vec<usize>> = Vec::new();
    let tests = &design.session.tests;
    for test in design.groups.iter().flat_map(|group| &group.tests).map(|(test, _)| *test) {
        let same = |other: &&mut Vec<usize>| {
            let other = &tests[other[0]];
            let apart = |(a, b): (&Option<f64>, &Option<f64>)| (a.unwrap_or(0.0) - b.unwrap_or(0.0)).abs() > 1.0;
            let linear = design.session.machine.axes.iter().map(|axis| axis.kind == crate::machine::AxisKind::Linear);
            let mut places = tests[test].positions.iter().zip(&other.positions).zip(linear);
            !places.any(|(pair, is_linear)| is_linear && apart(pair))
        };
        match places.iter_mut().find(same) {
            Some(place) => place.push(test),
            None => places.push(vec![test]),
        }
    }
    places
}

/// The session with the spindle ball 1 µm off in some tests.
pub fn moved(design: &Design, tests: &[usize], coordinate: usize) -> crate::session::Session {
    let mut session = design.session.clone();
    tests.iter().for_each(|&test| session.tests[test].spindle_ball.at[coordinate] += 1.0 / UM_PER_MM);
    session
}
