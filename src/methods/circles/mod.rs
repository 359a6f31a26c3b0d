//! Figures of planar circles of two linear axes as ball-bar users know them (ISO 230-4). No location errors are fitted.
//!
//! The *actual path* is what the ball draws in the plane: radius = reading, angle = nominal direction of the bar from
//! the pivot to the spindle ball. In the words of this project, after ISO 230-4:
//!
//! | figure | what it is here |
//! |---|---|
//! | circular deviation G | radial width of one path about its own least-squares centre, over a shorter arc than a turn the least width of all centres; one value for each direction |
//! | bi-directional circular deviation G(b) | the same of both paths together |
//! | radial deviation F | largest and smallest radius of a path minus the nominal radius; about the least-squares centre for a full turn, about the centre as set up for a shorter arc (where a fitted centre would hide deviations) |
//! | circular hysteresis H | largest difference of the two paths' radii at the same angle |
//! | mean bi-directional radial deviation D | radius of the least-squares circle of both paths minus the nominal radius |
//!
//! The standard's G is the least distance of two concentric circles that hold the path between them; like the usual
//! instruments, and as it permits, the width about the least-squares circle is given for a full turn, which is never smaller. On an arc
//! each direction's own least-squares centre may lie elsewhere, and G could exceed G(b): there the least distance itself is given.
//!
//! The parts that a path is made of come from one least-squares fit of the deviation over both directions:
//!
//! ```text
//! δ(φ) = r + a·cos φ + b·sin φ + R/2·(m₁ − m₂)·cos 2φ − R/2·γ·sin 2φ + Σ steps
//! ```
//!
//! a, b centre; m₁, m₂ scale of the two axes; γ how far the angle between their positive directions exceeds 90°. A
//! lost motion B of the first axis (its ball lags B/2 behind the command) adds `∓B/2·cos φ·sgn(velocity)`: an outward
//! step of B where the axis reverses. The two ends of an axis are fitted apart, as instruments print them.

mod deviations;
mod parts;
mod zone;

use serde::Serialize;

pub use deviations::{CircleRun, Direction};

use super::error::MethodError;
use crate::chain::Chain;
use crate::machine::{Component, ErrorName, Machine};
use crate::session::{Session, Setups, Zero};
use crate::statistics::mean;
use crate::units::{ARCSEC_PER_RAD, UM_PER_MM};

use deviations::circle_runs;
use parts::{Parts, centred, fit_parts};
use zone::least_width_mm;

/// Figures of one circle, run in one or in both directions; lengths in µm.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CircleFigures {
    /// `XY`, `YZ` or `ZX`.
    pub plane: String,
    /// Names of the tests: one or two.
    pub tests: Vec<String>,
    pub feed_mm_per_min: Option<f64>,
    /// Nominal radius.
    pub radius_mm: f64,
    pub arc_deg: f64,
    /// The arc is a full turn.
    pub full_turn: bool,
    pub ccw: Option<DirectionFigures>,
    pub cw: Option<DirectionFigures>,
    /// G(b); absent when only one direction was run.
    pub bidirectional_circular_deviation_um: Option<f64>,
    /// H.
    pub circular_hysteresis_um: Option<f64>,
    /// D; absent for a bar whose zero is free.
    pub mean_bidirectional_radial_deviation_um: Option<f64>,
    /// Centre of the path, seen from the pivot, along the plane's two letters.
    pub centre_um: [f64; 2],
    /// Radius of the fitted circle minus the nominal radius; absent for a bar whose zero is free.
    pub radius_deviation_um: Option<f64>,
    pub squareness: Squareness,
    /// Travel of the first axis over the diameter minus that of the second.
    pub scale_mismatch_um: f64,
    /// The same relative to the diameter, parts per million.
    pub scale_mismatch_ppm: f64,
    /// First and second axis of the plane.
    pub axes: Vec<AxisReversals>,
    /// What the parts above leave, reversals included.
    pub rms_um: f64,
}

/// Figures of one direction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DirectionFigures {
    pub test: String,
    /// G.
    pub circular_deviation_um: f64,
    /// F max and F min; absent for a bar whose zero is free, which tells no radius.
    pub radial_deviation_max_um: Option<f64>,
    pub radial_deviation_min_um: Option<f64>,
}

/// Squareness of the two axes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Squareness {
    /// By how much the angle between the positive directions exceeds 90°.
    pub angle_arcsec: f64,
    /// The same in µm per m.
    pub angle_um_per_m: f64,
    /// The squareness error of the machine's gauge with its sign: `EC0Y` (XY), `EA0Z` (YZ), `EB0Z` (ZX).
    pub location_error: String,
    pub location_error_arcsec: f64,
}

/// Reversals of one axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AxisReversals {
    pub axis: String,
    /// Lost motion B, both ends averaged: how far the axis is behind after a reversal; negative when it runs ahead.
    pub backlash_um: Option<f64>,
    /// B/2: distance of the actual path from the command on either side.
    pub half_gap_um: Option<f64>,
    /// The positive and the negative end as far as the arc passes them.
    pub ends: Vec<Reversal>,
}

/// One end of travel within the circle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reversal {
    /// `+X` or `-X`.
    pub end: String,
    /// Outward step of the path, as ball-bar software prints backlash.
    pub step_um: f64,
    /// Largest short deviation just after the reversal, above what all other parts explain; outward is positive.
    pub spike_um: f64,
}

/// Figures of every planar circle of a session: a run with the next one of the same circle in the other direction.
/// Arcs too short to tell the parts apart are left out: they are no circle tests.
pub fn circles(session: &Session) -> Result<Vec<CircleFigures>, MethodError> {
    let chain = Chain::of(&session.machine);
    let setups = Setups::of(session);
    let mut groups: Vec<Vec<CircleRun>> = Vec::new();
    for run in circle_runs(session, &chain)? {
        let same_circle = |other: &CircleRun| {
            setups.pivot_of[run.test] == setups.pivot_of[other.test]
                && setups.spindle_ball_of[run.test] == setups.spindle_ball_of[other.test]
                && setups.bar_of[run.test] == setups.bar_of[other.test]
                && session.tests[run.test].feed_mm_per_min == session.tests[other.test].feed_mm_per_min
                && run.same_path(other)
        };
        let partner = groups
            .iter_mut()
            .find(|group| matches!(group.as_slice(), [only] if only.direction != run.direction && same_circle(only)));
        match partner {
            Some(group) => group.push(run),
            None => groups.push(vec![run]),
        }
    }
    Ok(groups.iter().filter_map(|runs| figures(session, runs)).collect())
}

fn figures(session: &Session, runs: &[CircleRun]) -> Option<CircleFigures> {
    let machine = &session.machine;
    let first = &runs[0];
    let parts = fit_parts(runs)?;
    let one = |direction: Direction| {
        runs.iter().find(|run| run.direction == direction).map(|run| direction_figures(session, run))
    };
    let tells_radius = session.tests[first.test].zero == Zero::Calibrated;
    let both = (runs.len() == 2).then(|| centred(runs));
    let letters = first.axes.map(|axis| machine.axes[axis].name.clone());
    Some(CircleFigures {
        plane: letters.concat(),
        tests: runs.iter().map(|run| session.tests[run.test].name.clone()).collect(),
        feed_mm_per_min: session.tests[first.test].feed_mm_per_min,
        radius_mm: first.radius_mm,
        arc_deg: first.arc_rad.to_degrees(),
        full_turn: first.full_turn(),
        ccw: one(Direction::Ccw),
        cw: one(Direction::Cw),
        bidirectional_circular_deviation_um: both.as_ref().map(|_| width_mm(runs) * UM_PER_MM),
        circular_hysteresis_um: hysteresis_mm(runs).map(|hysteresis| hysteresis * UM_PER_MM),
        mean_bidirectional_radial_deviation_um: both
            .as_ref()
            .filter(|_| tells_radius)
            .map(|both| both.radius_mm * UM_PER_MM),
        centre_um: parts.centre_mm.map(|centre| centre * UM_PER_MM),
        radius_deviation_um: tells_radius.then_some(parts.radius_mm * UM_PER_MM),
        squareness: squareness(machine, first, parts.angle_rad),
        scale_mismatch_um: parts.scale_mismatch * 2.0 * first.radius_mm * UM_PER_MM,
        scale_mismatch_ppm: parts.scale_mismatch * 1e6,
        axes: reversals(letters, &parts),
        rms_um: parts.rms_mm * UM_PER_MM,
    })
}

/// Radial width of paths, mm.
fn width_mm(runs: &[CircleRun]) -> f64 {
    if runs.iter().all(CircleRun::full_turn) { centred(runs).width_mm() } else { least_width_mm(runs) }
}

fn direction_figures(session: &Session, run: &CircleRun) -> DirectionFigures {
    let about_centre = centred(std::slice::from_ref(run));
    let radial: Vec<f64> = match run.full_turn() {
        true => about_centre.deviation_mm.iter().map(|deviation| deviation + about_centre.radius_mm).collect(),
        false => run.deviation_mm.clone(),
    };
    let tells_radius = session.tests[run.test].zero == Zero::Calibrated;
    let furthest = |pick: fn(f64, f64) -> f64| radial.iter().copied().reduce(pick).filter(|_| tells_radius);
    DirectionFigures {
        test: session.tests[run.test].name.clone(),
        circular_deviation_um: width_mm(std::slice::from_ref(run)) * UM_PER_MM,
        radial_deviation_max_um: furthest(f64::max).map(|deviation| deviation * UM_PER_MM),
        radial_deviation_min_um: furthest(f64::min).map(|deviation| deviation * UM_PER_MM),
    }
}

/// Largest difference of the two directions' radii at the same angle, mm.
fn hysteresis_mm(runs: &[CircleRun]) -> Option<f64> {
    let [there, back] = runs else { return None };
    let differences = |own: &CircleRun, other: &CircleRun| -> Vec<f64> {
        let at = |(&angle, deviation): (&f64, &f64)| Some((deviation - other.deviation_at(angle)?).abs());
        own.angle_rad.iter().zip(&own.deviation_mm).filter_map(at).collect()
    };
    // at the angles of both: which was listed first says nothing
    [differences(there, back), differences(back, there)].into_iter().flatten().reduce(f64::max)
}

/// Sign with which the gauge's squareness error opens the angle between the plane's positive directions.
///
/// `EC0Y` turns Y away from X and `EA0Z` turns Z away from Y; `EB0Z` turns Z towards X.
fn squareness(machine: &Machine, run: &CircleRun, angle_rad: f64) -> Squareness {
    let (component, axis, sign) = match run.third {
        0 => (Component::EA, run.axes[1], 1.0),
        1 => (Component::EB, run.axes[0], -1.0),
        _ => (Component::EC, run.axes[1], 1.0),
    };
    let angle_arcsec = angle_rad * ARCSEC_PER_RAD;
    Squareness {
        angle_arcsec,
        angle_um_per_m: angle_rad * 1e6,
        location_error: ErrorName::location(component, &machine.axes[axis].name).to_string(),
        location_error_arcsec: sign * angle_arcsec,
    }
}

fn reversals(letters: [String; 2], parts: &Parts) -> Vec<AxisReversals> {
    let of_axis = |(index, letter): (usize, String)| {
        let ends: Vec<_> = parts.ends.iter().filter(|end| end.axis == index).collect();
        let backlash_um = mean(ends.iter().map(|end| end.step_mm)).map(|step_mm| step_mm * UM_PER_MM);
        AxisReversals {
            backlash_um,
            half_gap_um: backlash_um.map(|backlash| backlash / 2.0),
            ends: ends
                .iter()
                .map(|end| Reversal {
                    end: format!("{}{letter}", if end.positive { '+' } else { '-' }),
                    step_um: end.step_mm * UM_PER_MM,
                    spike_um: end.spike_mm * UM_PER_MM,
                })
                .collect(),
            axis: letter,
        }
    };
    letters.into_iter().enumerate().map(of_axis).collect()
}
