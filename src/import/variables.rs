//! The six numbers of a timing that a search varies, in units in which they matter alike.

use super::capture::Averages;
use super::course::Course;
use super::likelihood::{Freedom, cost};
use super::timing::Timing;
use super::timing::lag::{LAG, Lag};
use super::wander::Wander;

/// A timing with its cost.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    pub timing: Timing,
    pub freedom: Freedom,
    pub wander: Wander,
    pub cost: f64,
}

impl Candidate {
    pub fn of(course: &Course, data: &Averages, timing: Timing, freedom: Freedom) -> Candidate {
        Candidate { timing, freedom, wander: data.wander, cost: cost(course, data, &timing, freedom) }
    }
}

/// Ramps of controls, s.
pub(super) const RAMPS_S: [f64; 2] = [0.005, 2.0];

/// Number of variables: two starts, mean time of a run, logarithm of the ramp, difference of the two runs' times, lag.
pub(super) const VARIABLES: usize = 6;

/// Unit of the lag, in its spreads before any reading: 9 ms.
const LAG_STEP: f64 = 0.3;

/// Parts of a run's time by which two runs differ: of a control that keeps one pace, and of one that does not.
pub(super) const DIFFERENCES: [f64; 2] = [5e-5, 5e-3];

/// Units of the variables, s but for the logarithm and the lag.
pub(super) fn units(course: &Course, data: &Averages, pace: f64) -> [f64; VARIABLES] {
    let run_s = course.run_s / pace;
    let between = DIFFERENCES[0] * run_s;
    match &data.marks {
        Some(seen) => {
            let sigma_s = seen.run_sigma_s;
            [2.0 * sigma_s[0][0], 2.0 * sigma_s[1][0], 2.0 * sigma_s[0][1], 0.5, between, LAG_STEP]
        }
        None => [0.03 * run_s, 0.03 * run_s, 0.02 * run_s, 0.5, between, LAG_STEP],
    }
}

/// Timing with its variables moved, in their units: the times of the runs are what marks tell, the paces follow from them.
pub(super) fn moved(course: &Course, timing: &Timing, units: &[f64; VARIABLES], by: &[f64; VARIABLES]) -> Timing {
    let ramp_s = (timing.ramp_s * (units[3] * by[3]).exp()).clamp(RAMPS_S[0], RAMPS_S[1]);
    let half = 0.5 * units[4] * by[4];
    let paces = [half, -half].into_iter().enumerate().map(|(direction, half)| {
        let moving_s = timing.moving_s(direction, course.run_s) + units[2] * by[2] + half;
        course.run_s / (moving_s - ramp_s).max(1e-3 * course.run_s)
    });
    let mut timing = Timing {
        start_s: [timing.start_s[0] + units[0] * by[0], timing.start_s[1] + units[1] * by[1]],
        ramp_s,
        lag_s: LAG.off(Lag(timing.lag_s), units[5] * by[5]).0,
        ..*timing
    };
    timing.paces.iter_mut().zip(paces).for_each(|(pace, moved)| *pace = moved);
    timing
}
