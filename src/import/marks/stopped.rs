//! Whether a run stopped or changed its feed on the way: the times that the marks leave for the two directions, held against each other. It
//! knows no test and no readings.

use crate::import::likelihood::{TWO_PACES, UNEVEN, normal_density, of_any_time};

/// What the marks tell of one direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Direction {
    /// Time of the run between its marks with its standard deviation, s.
    pub run_s: f64,
    pub run_sigma_s: f64,
    /// Speed of its two marks over the programmed one with its standard deviation.
    pub pace: f64,
    pub pace_sigma: f64,
}

/// Share of captures of which a run was held, or its feed changed, on the way; half of these take longer by more than this, s, and any
/// time is possible: `c/(c + t)²`. By reason: stops of real operators were not at hand.
const STOPPED: (f64, f64) = (0.02, 0.5);
/// Standard deviation of the logarithm of two paces' ratio, where directions have paces of their own.
const PACES_APART: f64 = 0.05;

/// By how much longer the first direction ran than the second, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Longer {
    /// With its standard deviation, by the times of both runs at one pace, or each at its own, as is likelier.
    pub by_s: [f64; 2],
    /// The same where a run was held, or its feed changed, on the way.
    pub stopped_s: Option<f64>,
}

/// By how much longer the first direction ran than the second, and whether that is likelier a stop, or another feed on the way, than what the
/// rests of controls leave open: one control ramps alike in both.
pub(super) fn longer([there, back]: [Direction; 2]) -> Longer {
    let longer_s = there.run_s - back.run_s;
    let run_sigma_s = there.run_sigma_s.hypot(back.run_sigma_s);
    // directions at one pace, and each at its own
    let off = (there.pace / back.pace).ln();
    let pace_sigma = (there.pace_sigma / there.pace).hypot(back.pace_sigma / back.pace);
    let of_pace_s = 0.5 * (there.run_s + back.run_s);
    let kinds = [
        ((1.0 - TWO_PACES) * normal_density(off, pace_sigma), longer_s, run_sigma_s),
        (
            TWO_PACES * normal_density(off, pace_sigma.hypot(PACES_APART)),
            longer_s + off * of_pace_s,
            run_sigma_s.hypot(pace_sigma * of_pace_s),
        ),
    ];
    let stop = |seconds: f64| of_any_time(STOPPED, seconds.abs());
    let rests = |seconds: f64, sigma_s: f64| -> f64 {
        // both ends of both runs
        UNEVEN.iter().map(|(uneven_s, share)| share * normal_density(seconds, sigma_s.hypot(2.0 * uneven_s))).sum()
    };
    let held: f64 = kinds.iter().map(|(share, seconds, _)| share * stop(*seconds)).sum();
    let kept: f64 = kinds.iter().map(|(share, seconds, sigma_s)| share * rests(*seconds, *sigma_s)).sum();
    let (_, likelier_s, sigma_s) = if kinds[0].0 > kinds[1].0 { kinds[0] } else { kinds[1] };
    Longer { by_s: [likelier_s, sigma_s], stopped_s: (held > kept).then_some(likelier_s) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stopped_s(directions: [Direction; 2]) -> Option<f64> {
        longer(directions).stopped_s
    }

    fn direction(run_s: f64, pace: f64) -> Direction {
        Direction { run_s, run_sigma_s: 4e-3, pace, pace_sigma: 5e-4 }
    }

    #[test]
    fn a_held_run_is_told_from_rests_and_paces() {
        assert_eq!(stopped_s([direction(20.0, 1.0), direction(20.01, 1.0)]), None);
        assert_eq!(stopped_s([direction(20.0, 1.0), direction(20.06, 1.0)]), None);
        // another override in the second direction, with its marks
        assert_eq!(stopped_s([direction(20.0, 1.0), direction(20.0 / 1.02, 1.02)]), None);
        assert!(stopped_s([direction(20.0, 1.0), direction(20.4, 1.0)]).is_some_and(|s| (s + 0.4).abs() < 1e-9));
        assert!(stopped_s([direction(25.0, 1.0), direction(20.0, 1.0005)]).is_some_and(|s| (s - 5.0).abs() < 0.1));
    }
}
