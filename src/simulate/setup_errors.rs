//! Placement errors of balls and reading errors of bars, by test: none, given, or drawn from the stated spreads.

use nalgebra::Vector3;
use rand_distr::{Distribution, StandardNormal};

use super::instrument::stream;
use crate::session::{Session, Setup, Setups, Zero};

/// How far from the bar's length a zero set by hand lies, standard deviation in mm: the bar goes on at some place of its
/// stroke, and most of the stroke must stay free for the test.
const SET_BY_HAND_MM: f64 = 0.2;

/// What stands elsewhere than the session says, by test in its order.
#[derive(Debug, Clone, PartialEq)]
pub struct SetupErrors {
    /// Displacement of the pivot ball on its link, mm.
    pub pivot_mm: Vec<Vector3<f64>>,
    /// Displacement of the spindle ball on its link, mm.
    pub spindle_mm: Vec<Vector3<f64>>,
    /// Reading minus distance, beside the stated bar error, mm.
    pub bar_mm: Vec<f64>,
}

impl SetupErrors {
    /// Everything where the session says.
    pub fn none(session: &Session) -> SetupErrors {
        let tests = session.tests.len();
        SetupErrors {
            pivot_mm: vec![Vector3::zeros(); tests],
            spindle_mm: vec![Vector3::zeros(); tests],
            bar_mm: vec![0.0; tests],
        }
    }

    /// Normal draws with the stated spreads; tests that share a setup share its error. Places that are looked for by the readings stay
    /// where they are, and axes of instruments and targets as they are turned.
    pub fn drawn(session: &Session, seed: u64) -> SetupErrors {
        let setups = Setups::of(session);
        let mut random = stream(seed, 0);
        let mut draw = |sigma: f64| -> f64 { sigma * Distribution::<f64>::sample(&StandardNormal, &mut random) };
        // of a place that is looked for the spread is that of the search
        let spread_mm = |setup: &Setup| if setup.is_looked_for() { 0.0 } else { setup.spread_mm };
        let pivots: Vec<Vector3<f64>> =
            setups.pivots.iter().map(|setup| Vector3::from_fn(|_, _| draw(spread_mm(setup)))).collect();
        let balls: Vec<Vector3<f64>> =
            setups.spindle_balls.iter().map(|setup| Vector3::from_fn(|_, _| draw(spread_mm(setup)))).collect();
        let bar_sigma = |setup: &Setup| match setup.zero {
            Zero::Calibrated => setup.spread_mm,
            Zero::Free => SET_BY_HAND_MM,
        };
        let bars: Vec<f64> = setups.bars.iter().map(|setup| draw(bar_sigma(setup))).collect();
        SetupErrors {
            pivot_mm: setups.pivot_of.iter().map(|&index| pivots[index]).collect(),
            spindle_mm: (session.tests.iter().enumerate())
                .map(|(test, of)| match (setups.second_pivot_of[test], balls.get(setups.spindle_ball_of[test])) {
                    // the other end of a known distance of two sockets
                    (Some(second), _) => pivots[second],
                    (None, Some(ball)) => Vector3::from_fn(|k, _| of.spindle_ball.sign(k) * ball[k]),
                    (None, None) => Vector3::zeros(),
                })
                .collect(),
            bar_mm: setups.bar_of.iter().map(|bar| bar.map_or(0.0, |index| bars[index])).collect(),
        }
    }
}
